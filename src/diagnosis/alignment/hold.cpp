#include "diagnosis/alignment/hold.hpp"

#include <algorithm>
#include <array>

#include "diagnosis/estimation/session.hpp"
#include "diagnosis/model/command_innovation.hpp"
#include "diagnosis/model/row_acceleration.hpp"
#include "diagnosis/recording/rotor_answer.hpp"
#include "diagnosis/result/decisions.hpp"
#include "util/parallel.hpp"

namespace gustlab::diagnosis {

namespace {

// Without those whose likeliest value is not allowed: no vehicle answers before it is asked.
std::vector<int> causal_columns(const Session& session, const Eigen::MatrixXd& total, const std::vector<int>& columns) {
  const Fit fit = solve(total, columns, 1e-4);
  std::vector<int> causal;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const Column& column = session.catalogue().column(columns[i]);
    const bool way = column.group >= 0 && session.catalogue().group(column.group).row->place == Place::actuation;
    const double moved = fit.coefficient[static_cast<Eigen::Index>(i)] * column.natural;
    if (!way || column.admits(session.value()[columns[i]] + moved)) causal.push_back(columns[i]);
  }
  return causal;
}

// −2 log likelihood of the flights beside all that there may be
double misfit(Session session) {
  const std::vector<int>& columns = session.all_columns();
  Eigen::VectorXd value = session.value();
  double misfit = 0.0;
  // linearised once, the wrong reading may promise more beside a large effect than it keeps
  constexpr int linearisations = 3;
  for (int i = 0; i < linearisations; ++i) {
    session.linearise(value, columns);
    session.learn_noise(6, columns);
    const Eigen::MatrixXd total = session.grams().total();
    const std::vector<int> causal = causal_columns(session, total, columns);
    const Fit fit = solve(total, causal, 1e-4);
    misfit = session.misfit(causal, fit.coefficient);
    for (std::size_t c = 0; c < causal.size(); ++c)
      value[causal[c]] += fit.coefficient[static_cast<Eigen::Index>(c)] * session.catalogue().column(causal[c]).natural;
    session.catalogue().clamp(value);
  }
  return misfit;
}

// share of the variance of roll and pitch acceleration from row to row, the mean of both
double left_by_rotors(const std::vector<FlightData>& flights) {
  std::vector<std::vector<Eigen::Vector4d>> rotors;
  for (const FlightData& flight : flights) rotors.push_back(rotor_acceleration(flight));
  const auto [roll, pitch] = acceleration_left(flights, rotors, 0.0);
  return 0.5 * (roll.share + pitch.share);
}

}  // namespace

bool speeds_jump(const std::function<std::vector<FlightData>(bool jump)>& read) {
  const std::vector<FlightData> jumping = read(true);
  if (std::ranges::any_of(jumping, [](const FlightData& f) { return f.jumping_speed.empty(); })) return false;
  return left_by_rotors(jumping) < decisions::left_by_jumps * left_by_rotors(read(false));
}

bool speeds_follow(const std::vector<FlightData>& flights) {
  if (std::ranges::any_of(flights, [](const FlightData& f) {
        return f.measured_speed.empty() || f.measured_speed.time_s() != f.commands.time_s();
      }))
    return false;
  const RotorAnswer answer(flights.front().vehicle);
  const auto left_when = [&](std::size_t rows_late) {
    double left = 0.0, moved = 0.0;
    for (const FlightData& flight : flights) {
      const std::vector<double>& time_s = flight.commands.time_s();
      const auto &commanded = flight.commands.speed_radps(), &measured = flight.measured_speed.speed_radps();
      for (std::size_t k = rows_late; k + 1 < measured.size(); ++k) {
        const RotorArray next = answer.after(time_s[k + 1] - time_s[k], measured[k], commanded[k - rows_late]);
        for (std::size_t i = 0; i < static_cast<std::size_t>(flight.vehicle.rotor_count); ++i) {
          left += std::pow(measured[k + 1][i] - next[i], 2);
          moved += std::pow(measured[k + 1][i] - measured[k][i], 2);
        }
      }
    }
    return moved > 0.0 ? left / moved : 1.0;
  };
  constexpr std::size_t most_rows_late = 50;
  for (std::size_t rows_late = 0; rows_late < most_rows_late; ++rows_late)
    if (left_when(rows_late) < decisions::left_by_answers) return true;
  return false;
}

bool linear_is_likelier(const VehicleModel& vehicle, int jobs,
                        const std::function<std::vector<FlightData>(bool linear)>& read) {
  std::array<double, 2> of{};
  parallel_for(2, jobs, [&](std::int64_t linear) {
    of[static_cast<std::size_t>(linear)] = misfit(Session(read(linear == 1), vehicle, jobs));
  });
  return of[1] < of[0];
}

}  // namespace gustlab::diagnosis
