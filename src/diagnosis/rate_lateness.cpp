#include "diagnosis/rate_lateness.hpp"

#include "diagnosis/session.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr double surely = 100.0;                    // χ²
constexpr double least_s = 0.0005, most_s = 0.02;   // a filter's

}  // namespace

double rate_lateness_s(const std::vector<FlightData>& flights, const VehicleModel& vehicle, int jobs) {
  Session session(flights, vehicle, jobs);
  session.linearise(session.value(), {});
  constexpr Eigen::Index late = 3;   // after three biases
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(late + 2, late + 2);
  for (std::size_t f = 0; f < flights.size(); ++f) {
    LinearFlight free = session.linear()[f];
    free.torque_known = false;
    free.columns = {0, 1, 2, 3};
    for (std::size_t k = 0; k < free.size(); ++k) {
      free.B[k].setZero(12, late + 1);
      free.D[k].setZero(12, late + 1);
      free.D[k].block<3, 3>(6, 0).setIdentity();
      free.D[k].block<3, 1>(6, late) = -session.flights()[f].motion[k].angular_acceleration_B_radps2;
    }
    const Whitened w = whiten(session.flights()[f], free, session.noise);
    Eigen::MatrixXd own = Eigen::MatrixXd::Zero(late + 2, late + 2);
    for (Eigen::Index r = 0; r < w.rows.rows(); ++r)
      if (w.warm[static_cast<std::size_t>(r)]) own += w.rows.row(r).transpose() * w.rows.row(r);
    // every flight has its own biases
    gram += project_out(own, {0, 1, 2});
  }
  const double square = gram(late, late), product = gram(late, late + 1);
  if (square <= 0.0 || product * product / square < surely) return 0.0;
  const double late_s = product / square;
  return late_s > least_s && late_s < most_s ? late_s : 0.0;
}

}  // namespace gustlab::diagnosis
