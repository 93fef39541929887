// Torques that are told over a while alone: windows of a linearised flight, their noise, and a centre of mass found by them.
#include "diagnosis/estimation/mean_torques.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "diagnosis/estimation/gram.hpp"
#include "diagnosis/estimation/session.hpp"
#include "support/flight_data.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace mean_torques_test {

constexpr double sample_s = 0.01, duration_s = 20.0;

// A flight in hover whose rotors push as `share` says, of the hover thrust; +1 and −1 in turn is added, times `jitter`.
FlightData hover(const VehicleModel& vehicle, const std::array<double, 4>& share, double jitter) {
  return test::flight_of(
      vehicle, duration_s, sample_s, [](double) { return Motion{}; },
      [&](double t) {
        RotorArray speed{};
        const double sign = std::lround(t / sample_s) % 2 == 0 ? 1.0 : -1.0;
        for (std::size_t i = 0; i < share.size(); ++i)
          speed[i] = vehicle.hover_speed_radps() * std::sqrt(share[i] + (i < 2 ? sign : -sign) * jitter);
        return speed;
      });
}

// forces by the total, torques over a while by each rotor
FlightData with_total_alone(const FlightData& each, const FlightData& total) {
  FlightData flight = total;
  flight.collective_only = true;
  auto beside = std::make_shared<FlightData>(each);
  beside->collective_only = true;
  flight.each_rotor = beside;
  return flight;
}

Session session_of(const VehicleModel& vehicle, const std::array<double, 4>& share, double jitter) {
  return Session({with_total_alone(hover(vehicle, share, jitter), hover(vehicle, {1.0, 1.0, 1.0, 1.0}, 0.0))}, vehicle,
                 1);
}

TEST(MeanTorques, AreOneWindowInTwoSeconds) {
  const VehicleModel vehicle = test::crazyflie();
  Session session = session_of(vehicle, {1.0, 1.0, 1.0, 1.0}, 0.0);
  session.linearise(session.value(), session.all_columns());
  const LinearFlight& flight = session.linear().front();
  ASSERT_NEAR(static_cast<double>(flight.mean_acceleration.size()), 0.5 * duration_s, 1.0);
  for (std::size_t w = 1; w < flight.mean_acceleration.size(); ++w)
    EXPECT_NEAR(flight.window_s[w] - flight.window_s[w - 1], 2.0, 0.011);
  for (const Vector3& rest : flight.mean_acceleration) EXPECT_NEAR(rest.norm(), 0.0, 1e-6);
}

// by hand: thrust on one side times the arm over the moment of inertia
TEST(MeanTorques, OfRotorsThatPushUnequallyAreMissingInTheMotion) {
  const VehicleModel vehicle = test::crazyflie();
  Session session = session_of(vehicle, {1.02, 1.02, 0.98, 0.98}, 0.1);
  session.linearise(session.value(), session.all_columns());
  Vector3 torque = Vector3::Zero();
  for (int i = 0; i < 4; ++i)
    torque += vehicle.rotors[static_cast<std::size_t>(i)].position_B_m.cross(
        Vector3(0.0, 0.0, (i < 2 ? 1.02 : 0.98) * 0.25 * vehicle.weight_N()));
  const Vector3 expected = -(vehicle.inertia_B_kgm2.inverse() * torque);
  ASSERT_GT(expected.head<2>().norm(), 1.0);
  // what the first command left in the rotors is in the first window
  const std::vector<Vector3>& mean = session.linear().front().mean_acceleration;
  for (std::size_t w = 1; w < mean.size(); ++w)
    EXPECT_NEAR((mean[w] - expected).head<2>().norm(), 0.0, 0.02 * expected.norm());
}

TEST(MeanTorques, TellAShiftedCentreOfMassAndNoScale) {
  const VehicleModel vehicle = test::crazyflie();
  // 0.5 mm in x and y would take this much more of the rotors on that side
  Session session = session_of(vehicle, {1.02, 1.0, 0.98, 1.0}, 0.1);
  session.noise.mean_torque = 1.0;
  session.linearise(session.value(), session.all_columns());
  const Catalogue& catalogue = session.catalogue();
  const LinearFlight& flight = session.linear().front();
  const auto seen = [&](const char* effect) {
    double squares = 0.0;
    for (std::size_t j = 0; j < flight.columns.size(); ++j) {
      const int g = catalogue.column(flight.columns[j]).group;
      if (g != catalogue.find(effect)) continue;
      for (const auto& by : flight.mean_acceleration_by) squares += by.col(static_cast<Eigen::Index>(j)).squaredNorm();
    }
    return squares;
  };
  EXPECT_GT(seen("center_of_mass"), 1.0);
  EXPECT_GT(seen("rotor_loss#2"), 1.0);
  EXPECT_EQ(seen("thrust_scale"), 0.0);
  EXPECT_EQ(seen("mass"), 0.0);
  // what only fast torques show is no candidate
  EXPECT_LT(catalogue.find("inertia"), 0);

  const int group = catalogue.find("center_of_mass");
  const Fit fit = solve(session.grams().total(), session.with_biases({group}));
  const Vector3 arm = vehicle.rotors[0].position_B_m;
  const auto& columns = catalogue.group(group).columns;
  for (int axis = 0; axis < 2; ++axis) {
    const double natural = catalogue.column(columns[static_cast<std::size_t>(axis)]).natural;
    EXPECT_NEAR(fit.coefficient[axis] * natural, 2.0 * 0.02 * arm[axis] / 4.0, 0.05 * 0.02 * std::abs(arm[axis]))
        << axis;
  }
}

LinearFlight with_means(const std::vector<Vector3>& means) {
  LinearFlight flight;
  flight.mean_acceleration = means;
  for (std::size_t w = 0; w < means.size(); ++w)
    flight.window_s.push_back(2.0 * static_cast<double>(w)), flight.mean_acceleration_by.emplace_back(3, 0);
  return flight;
}

// what lasts and is not explained is noise as well, and so is what differs from window to window
TEST(MeanTorqueVariance, IsTheMeanSquareOrWhatNeighboursDiffer) {
  EXPECT_NEAR(mean_torque_variance({with_means({{2.0, 2.0, 9.0}, {2.0, 2.0, 9.0}, {2.0, 2.0, 9.0}})}), 4.0, 1e-12);
  EXPECT_NEAR(mean_torque_variance({with_means({{1.0, -1.0, 0.0}, {-1.0, 1.0, 0.0}, {1.0, -1.0, 0.0}})}), 2.0, 1e-12);
  EXPECT_EQ(mean_torque_variance({LinearFlight{}}), 0.0);
}

TEST(MeanTorques, AreWhitenedByTheirNoise) {
  const LinearFlight flight = with_means({{1.0, 2.0, 3.0}, {4.0, 5.0, 6.0}});
  const Whitened rows = whiten_mean_torques(flight, 4.0);
  ASSERT_EQ(rows.rows.rows(), 4);
  EXPECT_DOUBLE_EQ(rows.rows(1, 0), 1.0);
  EXPECT_DOUBLE_EQ(rows.rows(3, 0), 2.5);
  EXPECT_NEAR(rows.minus_two_log_likelihood, 4.0 * std::log(4.0) + (1 + 4 + 16 + 25) / 4.0, 1e-12);
  EXPECT_EQ(whiten_mean_torques(flight, 0.0).rows.size(), 0);
}

}  // namespace mean_torques_test
}  // namespace gustlab::diagnosis
