#include "diagnosis/output/habit.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Cholesky>
#include <array>
#include <cmath>

#include "config/toml.hpp"
#include "diagnosis/output/explain.hpp"
#include "diagnosis/rollout/replay.hpp"
#include "diagnosis/rollout/verify.hpp"
#include "util/parallel.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr double ahead_s = 0.5, between_starts_s = 0.41;
constexpr int checks = 5;  // body rates along a window that are compared
constexpr double slowest_sample_s = 0.05;
constexpr int terms = 8, unknowns = 3 * terms, most_steps = 8, most_attempts = 6;
constexpr double usual_size = 1.0 / 3.0;  // an error this share of what holding leaves counts in full
constexpr double clearly_better = 0.9;

struct Window {
  const FlightData* flight = nullptr;
  std::size_t first = 0;
  std::array<std::size_t, checks> check{};
};

using Terms = Eigen::Matrix<double, terms, 1>;
Terms terms_of(const Matrix3& R_WB, const Vector3& velocity_W_mps, const Vector3& rate_B_radps) {
  const Vector3 velocity = R_WB.transpose() * velocity_W_mps;
  Terms t;
  t << rate_B_radps, R_WB(2, 0), R_WB(2, 1), velocity.x(), velocity.y(), 1.0;
  return t;
}

std::vector<Window> windows_of(const FlightData& flight) {
  std::vector<Window> windows;
  const auto last = static_cast<std::size_t>(std::lround(ahead_s / flight.sample_s));
  const auto stride = static_cast<std::size_t>(std::max(1L, std::lround(between_starts_s / flight.sample_s)));
  std::size_t unbroken = 0;  // samples since the last gap
  for (std::size_t k = 0, next = 0; k < flight.samples.size(); ++k) {
    unbroken = flight.samples[k].starts_segment ? 0 : unbroken + 1;
    if (unbroken < last || k < next) continue;
    Window w{&flight, k - last, {}};
    for (std::size_t i = 0; i < checks; ++i) w.check[i] = w.first + last * (i + 1) / checks;
    windows.push_back(w);
    next = k + stride;
  }
  return windows;
}

// body rates less the recorded ones at the checks
Eigen::Matrix<double, 3 * checks, 1> missed(const Window& window, const Habit& habit) {
  const std::vector<Motion>& motion = window.flight->motion;
  const Vector3 weight = window.flight->vehicle.gravity_mps2 * Vector3::UnitZ();
  const auto specific_force_B = [&](const Motion& m) -> Vector3 {
    return m.attitude_WB.conjugate() * (m.acceleration_W_mps2 + weight);
  };
  Eigen::Matrix<double, 3 * checks, 1> result;
  Matrix3 R = motion[window.first].attitude_WB.toRotationMatrix();
  Vector3 velocity = motion[window.first].velocity_W_mps, rate = motion[window.first].body_rate_B_radps;
  int at = 0;
  for (std::size_t k = window.first; at < checks; ++k) {
    if (k == window.check[static_cast<std::size_t>(at)]) {
      result.segment<3>(3 * at++) = rate - motion[k].body_rate_B_radps;
      if (at == checks) break;
    }
    const double dt = window.flight->samples[k + 1].time_s - window.flight->samples[k].time_s;
    const Vector3 turning = habit.transpose() * terms_of(R, velocity, rate), middle = rate + 0.5 * dt * turning;
    const double angle = 0.5 * dt * middle.norm();
    const Matrix3 half =
        angle > 1e-12 ? Eigen::AngleAxisd(angle, middle.normalized()).toRotationMatrix() : Matrix3(Matrix3::Identity());
    const Vector3 force = 0.5 * (specific_force_B(motion[k]) + specific_force_B(motion[k + 1]));
    R = R * half;
    velocity += dt * (R * force - weight);
    R = R * half;
    rate += dt * turning;
  }
  return result;
}

}  // namespace

Habit fit_habit(const std::vector<FlightData>& flights, int jobs) {
  // every flight in the unit of what holding leaves of it
  std::vector<std::vector<Window>> windows;
  std::vector<double> unit;
  Terms squares = Terms::Constant(1e-12);
  for (const FlightData& flight : flights) {
    windows.push_back(windows_of(flight));
    double sum = 1e-12;
    for (const Window& w : windows.back()) {
      const Motion &from = flight.motion[w.first], &to = flight.motion[w.check.back()];
      sum += (to.body_rate_B_radps - from.body_rate_B_radps).squaredNorm();
      squares += terms_of(from.attitude_WB.toRotationMatrix(), from.velocity_W_mps, from.body_rate_B_radps).cwiseAbs2();
    }
    unit.push_back(usual_size * std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, windows.back().size()))));
  }
  double count = 0.0;
  for (const auto& list : windows) count += static_cast<double>(list.size());
  const Terms scale = (squares / std::max(1.0, count)).cwiseSqrt();

  using Normal = Eigen::Matrix<double, unknowns, unknowns>;
  using Right = Eigen::Matrix<double, unknowns, 1>;
  struct Sums {
    Normal normal = Normal::Zero();
    Right right = Right::Zero();
    double cost = 0.0;
  };
  // large errors count less: cost √(1 + r²) of each body rate
  const auto sums = [&](const Habit& habit, bool with_slopes) {
    std::vector<Sums> of_flight(flights.size());
    parallel_for(std::ssize(flights), jobs, [&](std::int64_t f) {
      Sums& s = of_flight[static_cast<std::size_t>(f)];
      for (const Window& window : windows[static_cast<std::size_t>(f)]) {
        const auto here = missed(window, habit);
        Eigen::Matrix<double, 3 * checks, unknowns> J;
        if (with_slopes)
          for (int j = 0; j < unknowns; ++j) {
            Habit moved = habit;
            const double delta = 1e-4 / scale[j % terms];
            moved(j % terms, j / terms) += delta;
            J.col(j) = (missed(window, moved) - here) / delta;
          }
        for (int i = 0; i < checks; ++i) {
          const double size = here.segment<3>(3 * i).norm() / unit[static_cast<std::size_t>(f)],
                       weight = 1.0 / std::sqrt(1.0 + size * size);
          s.cost += std::sqrt(1.0 + size * size) - 1.0;
          if (!with_slopes) continue;
          const double w = weight / (unit[static_cast<std::size_t>(f)] * unit[static_cast<std::size_t>(f)]);
          s.normal += w * J.middleRows<3>(3 * i).transpose() * J.middleRows<3>(3 * i);
          s.right -= w * J.middleRows<3>(3 * i).transpose() * here.segment<3>(3 * i);
        }
      }
    });
    Sums all;
    for (const Sums& s : of_flight) all.normal += s.normal, all.right += s.right, all.cost += s.cost;
    return all;
  };
  Habit habit = Habit::Zero();
  for (int axis = 0; axis < 3; ++axis) habit(axis, axis) = -5.0;
  double damping = 1e-2;
  for (int step = 0; step < most_steps; ++step) {
    const Sums here = sums(habit, true);
    bool better = false;
    double least = here.cost;
    for (int attempt = 0; attempt < most_attempts && !better; ++attempt) {
      Normal damped = here.normal;
      damped.diagonal() *= 1.0 + damping;
      damped.diagonal().array() += 1e-12 * here.normal.diagonal().maxCoeff();
      const Right move = damped.ldlt().solve(here.right);
      const Habit trial = habit + Eigen::Map<const Habit>(move.data());
      least = sums(trial, false).cost;
      better = std::isfinite(least) && least < here.cost;
      damping *= better ? 0.2 : 5.0;
      if (better) habit = trial;
    }
    if (!better || least > here.cost * (1.0 - 1e-4)) break;
  }
  return habit;
}

void offer_habit(const Session& session, const std::vector<FlightLog>& holdout, int jobs, Diagnosis& out) {
  const std::vector<FlightData>& flights = session.flights_as_logged();
  if (out.fit.is_null() || flights.front().sample_s > slowest_sample_s) return;
  const double held = half_a_second_ahead(out.fit, "body_rate_radps", "hold"),
               physics = half_a_second_ahead(out.fit, "body_rate_radps", "after");
  if (!(physics > held)) return;

  const Habit habit = fit_habit(flights, jobs);
  std::string toml =
      "\n[[effect]]  # not physics: how it turned under the controller that flew it; for rollouts on its "
      "recordings\ntype = \"recorded_loop\"\n";
  constexpr std::array<const char*, 3> axis = {"roll", "pitch", "yaw"};
  for (int a = 0; a < 3; ++a) {
    std::vector<std::string> numbers;
    for (int i = 0; i < terms; ++i) numbers.push_back(config::shortest(habit(i, a)));
    toml += fmt::format("{} = [{}]\n", axis[static_cast<std::size_t>(a)], fmt::join(numbers, ", "));
  }
  config::Table found = config::Table::parse(augmented_toml(out) + toml, "augmented.toml");
  Verification with = verify(holdout, session.vehicle(), config::read_effects(found), jobs);
  for (const std::string_view name : fit_quantity_names)
    if (half_a_second_ahead(with.fit, name, "after") >= half_a_second_ahead(out.fit, name, "after"))
      return;  // what the log lacks is no number
  const double foretold = half_a_second_ahead(with.fit, "body_rate_radps", "after");
  if (!(foretold < clearly_better * held)) return;
  out.habit = {
      {"effect", "recorded_loop"},
      {"says", fmt::format("half a second ahead the recorded actuators foretell the body rate to {:.2g} rad/s, holding "
                           "it to {:.2g}, and the habit of "
                           "the loop that was recorded to {:.2g}; the habit is no physics, and true of no other loop",
                           physics, held, foretold)},
      {"fit", nlohmann::ordered_json::object()}};
  for (const std::string_view name : fit_quantity_names)
    out.habit["fit"][std::string(name)] = with.fit.at(std::string(name)).at("after");
  out.residual_toml += toml;
}

}  // namespace gustlab::diagnosis
