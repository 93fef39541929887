#include "diagnosis/output/habit.hpp"

#include <ceres/evaluation_callback.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/sized_cost_function.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>

#include "config/toml.hpp"
#include "diagnosis/estimation/least_squares.hpp"
#include "diagnosis/output/explain.hpp"
#include "diagnosis/result/decisions.hpp"
#include "diagnosis/rollout/replay.hpp"
#include "diagnosis/rollout/verify.hpp"
#include "util/parallel.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr double ahead_s = 0.5, between_starts_s = 0.41;
constexpr int checks = 5;  // body rates along a window that are compared
constexpr double slowest_sample_s = 0.05;
constexpr int term_count = 8, unknowns = 3 * term_count;
constexpr double usual_size = 1.0 / 3.0;  // an error this share of what holding leaves counts in full

struct Window {
  const FlightData* flight = nullptr;
  std::size_t first = 0;
  std::array<std::size_t, checks> check{};
};

using Terms = Eigen::Matrix<double, term_count, 1>;
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
    const Vector3 angular_acceleration = habit.transpose() * terms_of(R, velocity, rate),
                  middle = rate + 0.5 * dt * angular_acceleration;
    const double angle = 0.5 * dt * middle.norm();
    const Matrix3 half =
        angle > 1e-12 ? Eigen::AngleAxisd(angle, middle.normalized()).toRotationMatrix() : Matrix3(Matrix3::Identity());
    const Vector3 force = 0.5 * (specific_force_B(motion[k]) + specific_force_B(motion[k + 1]));
    R = R * half;
    velocity += dt * (R * force - weight);
    R = R * half;
    rate += dt * angular_acceleration;
  }
  return result;
}

using Missed = Eigen::Matrix<double, 3 * checks, 1>;
using Slopes = Eigen::Matrix<double, 3 * checks, unknowns, Eigen::RowMajor>;

// A window and what is missed there with the habit that was asked for last, in the flight's own unit.
struct HabitRollout {
  Window window;
  double unit_radps = 1.0;
  Missed missed = Missed::Zero();
  Slopes slopes = Slopes::Zero();
};

// Rollouts of all flights, flown anew on several cores before the solver reads them.
class Rollouts final : public ceres::EvaluationCallback {
 public:
  // `habit`: what the solver moves.
  Rollouts(const std::vector<FlightData>& flights, const Habit& habit, int jobs) : habit_(habit), jobs_(jobs) {
    Terms squares = Terms::Constant(1e-12);
    double count = 0.0;
    for (const FlightData& flight : flights) {
      const std::vector<Window> windows = windows_of(flight);
      double sum = 1e-12;
      for (const Window& w : windows) {
        const Motion &from = flight.motion[w.first], &to = flight.motion[w.check.back()];
        sum += (to.body_rate_B_radps - from.body_rate_B_radps).squaredNorm();
        squares +=
            terms_of(from.attitude_WB.toRotationMatrix(), from.velocity_W_mps, from.body_rate_B_radps).cwiseAbs2();
      }
      // what holding leaves of it
      const double size = static_cast<double>(std::max<std::size_t>(1, windows.size()));
      for (const Window& w : windows)
        rollouts_.push_back({.window = w, .unit_radps = usual_size * std::sqrt(sum / size)});
      count += static_cast<double>(windows.size());
    }
    scale_ = (squares / std::max(1.0, count)).cwiseSqrt();
  }

  const std::vector<HabitRollout>& rollouts() const { return rollouts_; }

  void PrepareForEvaluation(bool with_slopes, bool moved) override {
    if (!moved && !with_slopes) return;
    const std::int64_t parts = (std::ssize(rollouts_) + per_part - 1) / per_part;
    parallel_for(parts, jobs_, [&](std::int64_t part) {
      const auto end = std::min(rollouts_.size(), static_cast<std::size_t>((part + 1) * per_part));
      for (auto i = static_cast<std::size_t>(part * per_part); i < end; ++i) fly(rollouts_[i], with_slopes);
    });
  }

 private:
  static constexpr std::int64_t per_part = 32;

  void fly(HabitRollout& r, bool with_slopes) const {
    r.missed = missed(r.window, habit_) / r.unit_radps;
    for (int j = 0; with_slopes && j < unknowns; ++j) {
      Habit moved = habit_;
      const double delta = 1e-4 / scale_[j % term_count];
      moved(j % term_count, j / term_count) += delta;
      r.slopes.col(j) = (missed(r.window, moved) / r.unit_radps - r.missed) / delta;
    }
  }

  const Habit& habit_;
  int jobs_;
  std::vector<HabitRollout> rollouts_;
  Terms scale_;  // typical sizes of the terms
};

// One check of a rollout that was flown: body rates, over the unit.
class Check final : public ceres::SizedCostFunction<3, unknowns> {
 public:
  Check(const HabitRollout& rollout, int check) : rollout_(rollout), row_(3 * check) {}

  bool Evaluate(double const* const*, double* residuals, double** jacobians) const override {
    Eigen::Map<Vector3> missed(residuals);
    missed = rollout_.missed.segment<3>(row_);
    if (!missed.allFinite()) return false;
    if (!jacobians || !jacobians[0]) return true;
    Eigen::Map<Eigen::Matrix<double, 3, unknowns, Eigen::RowMajor>> slopes(jacobians[0]);
    slopes = rollout_.slopes.middleRows<3>(row_);
    return slopes.allFinite();
  }

 private:
  const HabitRollout& rollout_;
  int row_;
};

}  // namespace

// Least squares over whole rollouts; large errors count less: cost √(1 + r²) of each body rate, in every flight's own unit.
Habit fit_habit(const std::vector<FlightData>& flights, int jobs) {
  Habit habit = Habit::Zero();
  for (int axis = 0; axis < 3; ++axis) habit(axis, axis) = -5.0;
  Rollouts flown(flights, habit, jobs);
  ceres::SoftLOneLoss loss(1.0);
  ceres::Problem::Options shared;
  shared.evaluation_callback = &flown;
  shared.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(shared);
  for (const HabitRollout& rollout : flown.rollouts())
    for (int i = 0; i < checks; ++i) problem.AddResidualBlock(new Check(rollout, i), &loss, habit.data());
  ceres::Solver::Summary summary;
  ceres::Solve(few_unknowns({.damping = 1e-2, .settled = 1e-4, .most_steps = 16}), &problem, &summary);
  return habit;
}

void offer_habit(const Session& session, const std::vector<FlightLog>& holdout, int jobs, Diagnosis& out) {
  const std::vector<FlightData>& flights = session.flights_as_logged();
  if (out.fit.is_null() || flights.front().sample_s > slowest_sample_s) return;
  const double held = half_a_second_ahead(out.fit, "body_rate_radps", "hold"),
               physics = half_a_second_ahead(out.fit, "body_rate_radps", "after");
  if (!(physics > held)) return;

  const Habit habit = fit_habit(flights, jobs);
  const std::string_view effect = first_effect([](const EffectRow& row) { return row.replay_only; }).name;
  std::string toml = fmt::format(
      "\n[[effect]]  # not physics: how it turned under the controller that flew it; for rollouts on its "
      "recordings\ntype = \"{}\"\n",
      effect);
  constexpr std::array<const char*, 3> axis = {"roll", "pitch", "yaw"};
  for (int a = 0; a < 3; ++a) {
    std::vector<std::string> numbers;
    for (int i = 0; i < term_count; ++i) numbers.push_back(config::shortest(habit(i, a)));
    toml += fmt::format("{} = [{}]\n", axis[static_cast<std::size_t>(a)], fmt::join(numbers, ", "));
  }
  config::Table found = config::Table::parse(augmented_toml(out) + toml, "augmented.toml");
  Verification with = verify(holdout, session.vehicle(), config::read_effects(found), jobs);
  for (const std::string_view name : fit_quantity_names)
    if (half_a_second_ahead(with.fit, name, "after") >= half_a_second_ahead(out.fit, name, "after"))
      return;  // what the log lacks is no number
  const double predicted = half_a_second_ahead(with.fit, "body_rate_radps", "after");
  if (!(predicted < decisions::habit_better * held)) return;
  out.habit = {
      {"effect", effect},
      {"says",
       fmt::format(
           "half a second ahead the body rate is predicted within {:.2g} rad/s by the recorded actuators, within "
           "{:.2g} by keeping it as it is, and within {:.2g} by the habit of the loop that was recorded; the "
           "habit is no physics, and true of no other loop",
           physics, held, predicted)},
      {"fit", nlohmann::ordered_json::object()}};
  for (const std::string_view name : fit_quantity_names)
    out.habit["fit"][std::string(name)] = with.fit.at(std::string(name)).at("after");
  out.residual_toml += toml;
}

}  // namespace gustlab::diagnosis
