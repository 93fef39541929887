#include "diagnosis/rollout/per_flight.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "config/toml.hpp"
#include "gustlab/effect.hpp"
#include "util/parallel.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr double rollout_s = 0.5;
constexpr double step_share =
    0.1;  // of a parameter's natural size: far above rounding, small for what is nearly linear
constexpr double prior = step_share * step_share;  // 1/variance of a change, in steps, when it is of natural size

// every number of an effect: its value, and its natural size on this vehicle
class Numbers final : public ParameterVisitor {
 public:
  explicit Numbers(const VehicleModel& vehicle) : vehicle_(vehicle) {}

  void number(std::string_view name, double& value, const ParameterInfo& info) override {
    const double scale = info.scale == Scale::weight ? vehicle_.weight_N() : 1.0;
    found.push_back({std::string(name), value, info.natural * scale});
  }
  void integer(std::string_view, std::int64_t&, const ParameterInfo&) override {}
  void flag(std::string_view, bool&, const ParameterInfo&) override {}
  void text(std::string_view, std::string&, const ParameterInfo&) override {}
  void numbers(std::string_view, std::vector<double>&, const ParameterInfo&) override {}
  void texts(std::string_view, std::vector<std::string>&, const ParameterInfo&) override {}
  void vector(std::string_view, Vector3&, const ParameterInfo&) override {}

  struct Found {
    std::string name;
    double value, natural;
  };
  std::vector<Found> found;

 private:
  const VehicleModel& vehicle_;
};

struct Segment {
  std::size_t first, last;  // rows
};

std::vector<Segment> find_segments(const RecordedMotion& motion, double pose_delay_s) {
  std::vector<Segment> segments;
  for (std::size_t row = 0; row < motion.rows();) {
    const std::size_t last = motion.nearest(motion.time_s(row) + rollout_s);
    const bool good = motion.can_start(row) && motion.complete(last) && motion.stretch(last) == motion.stretch(row) &&
                      motion.time_s(motion.stretch(row)) <= motion.time_s(row) - pose_delay_s + 1e-9 &&
                      motion.time_s(last) - motion.time_s(row) > 0.5 * rollout_s;
    if (good) segments.push_back({row, last});
    row = good ? last : row + 1;
  }
  return segments;
}

}  // namespace

PerFlightFit::PerFlightFit(const Recording& recording, const std::vector<EffectSpec>& effects,
                           const std::vector<RotorArray>& rotor_speeds, bool wanted, int jobs)
    : specs_(effects) {
  if (wanted) find_parameters(recording.vehicle);
  const auto count = static_cast<Eigen::Index>(parameters_.size());
  change_.emplace_back(Eigen::VectorXd::Zero(count));
  if (count == 0) return;

  const RecordedMotion& motion = recording.motion;
  const bool by_velocity = motion.has_velocity();
  const double least_variance = 2.0 * std::pow(motion.noise()[by_velocity ? 1 : 0], 2) + 1e-12;
  // sums over the rollouts so far, of their ends as linear functions of the values: slope · change = aim
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(count, count);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(count);
  double square = 0.0;
  int used = 0;
  for (const Segment& segment : find_segments(motion, Rollout(recording, specs_).pose_delay_s())) {
    // about the values that the rollouts before say: as they are, and each moved
    const Eigen::VectorXd about = change_.back();
    std::vector<Vector3> end(static_cast<std::size_t>(count) + 1);
    std::vector<char> finite(end.size());
    parallel_for(count + 1, jobs, [&](std::int64_t task) {
      const auto t = static_cast<std::size_t>(task);
      Eigen::VectorXd moved = about;
      if (task > 0) moved[task - 1] += 1.0;
      Rollout rollout(recording, with(moved));
      rollout.begin(rollout.start(segment.first), rotor_speeds);
      Measured seen;
      finite[t] = rollout.run_to(motion.time_s(segment.last), seen);
      end[t] = by_velocity ? seen.velocity_W_mps : seen.position_W_m;
    });
    end_row_.push_back(segment.last);
    change_.push_back(about);
    if (std::find(finite.begin(), finite.end(), 0) != finite.end()) continue;
    Eigen::Matrix3Xd slope(3, count);
    for (Eigen::Index p = 0; p < count; ++p) slope.col(p) = end[static_cast<std::size_t>(p) + 1] - end[0];
    const Vector3 aim = (by_velocity ? motion.velocity_W_mps(segment.last) : motion.position_W_m(segment.last)) -
                        end[0] + slope * about;
    gram += slope.transpose() * slope;
    right += slope.transpose() * aim;
    square += aim.squaredNorm();
    ++used;
    // what the rollouts leave beside values within their natural size: the variance v for which
    // aimᵀ (v I + slope slopeᵀ / prior)⁻¹ aim is what chance gives, the number of its rows
    double variance = square / (3.0 * used);
    for (int repeat = 0; repeat < 10; ++repeat) {
      const Eigen::MatrixXd precise = gram + variance * prior * Eigen::MatrixXd::Identity(count, count);
      change_.back() = precise.ldlt().solve(right);
      variance = std::max(least_variance, (square - right.dot(change_.back())) / (3.0 * used));
    }
  }
}

void PerFlightFit::find_parameters(const VehicleModel& vehicle) {
  for (std::size_t e = 0; e < specs_.size(); ++e) {
    const EffectRow* row = find_effect(specs_[e].type);
    if (!row->per_flight || !row->is_predictable()) continue;
    const std::unique_ptr<Effect> effect = row->make();
    config::read_parameters(specs_[e], *effect);
    Numbers numbers(vehicle);
    effect->visit(numbers);
    specs_[e].values.clear();
    specs_[e].value_where.clear();
    for (const auto& [name, value, natural] : numbers.found) {
      parameters_.push_back({e, specs_[e].values.size(), value, step_share * natural});
      specs_[e].values.emplace_back(name, config::shortest(value));
    }
  }
}

std::vector<EffectSpec> PerFlightFit::with(const Eigen::VectorXd& change) const {
  std::vector<EffectSpec> result = specs_;
  for (std::size_t p = 0; p < parameters_.size(); ++p) {
    const Parameter& parameter = parameters_[p];
    result[parameter.effect].values[parameter.value].second =
        config::shortest(parameter.start + change[static_cast<Eigen::Index>(p)] * parameter.step);
  }
  return result;
}

std::size_t PerFlightFit::known_by(std::size_t row) const {
  return static_cast<std::size_t>(std::upper_bound(end_row_.begin(), end_row_.end(), row) - end_row_.begin());
}

std::vector<EffectSpec> PerFlightFit::effects(std::size_t rollouts) const { return with(change_[rollouts]); }

}  // namespace gustlab::diagnosis
