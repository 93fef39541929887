#include "diagnosis/per_flight.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "config/toml.hpp"
#include "gustlab/effect.hpp"
#include "util/parallel.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr double rollout_s = 0.5;
constexpr double step_share = 0.1;  // of a parameter's natural size: far above rounding, small for what is nearly linear

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

// one rollout: what it leaves, and how that changes with each parameter
struct Segment {
  std::size_t first, last;
  Vector3 residual = Vector3::Zero();
  Eigen::Matrix3Xd slope;
};

std::vector<Segment> find_segments(const RecordedMotion& motion, double pose_delay_s) {
  std::vector<Segment> segments;
  for (std::size_t row = 0; row < motion.rows();) {
    const std::size_t last = motion.nearest(motion.time_s(row) + rollout_s);
    const bool good = motion.can_start(row) && motion.complete(last) && motion.stretch(last) == motion.stretch(row) &&
                      motion.time_s(motion.stretch(row)) <= motion.time_s(row) - pose_delay_s + 1e-9 &&
                      motion.time_s(last) - motion.time_s(row) > 0.5 * rollout_s;
    if (good) segments.push_back({row, last, Vector3::Zero(), {}});
    row = good ? last : row + 1;
  }
  return segments;
}

}  // namespace

PerFlightFit::PerFlightFit(const Recording& recording, const std::vector<EffectSpec>& effects,
                           const std::vector<RotorArray>& rotor_speeds, bool wanted, int jobs)
    : specs_(effects) {
  for (std::size_t e = 0; wanted && e < specs_.size(); ++e) {
    const EffectRow* row = find_effect(specs_[e].type);
    if (!row->per_flight || !is_predictable(*row)) continue;
    const std::unique_ptr<Effect> effect = row->make();
    config::read_parameters(specs_[e], *effect);
    Numbers numbers(recording.vehicle);
    effect->visit(numbers);
    specs_[e].values.clear();
    specs_[e].value_where.clear();
    for (const auto& [name, value, natural] : numbers.found) {
      parameters_.push_back({e, specs_[e].values.size(), value, step_share * natural});
      specs_[e].values.emplace_back(name, config::shortest(value));
    }
  }
  const auto count = static_cast<Eigen::Index>(parameters_.size());
  change_.emplace_back(Eigen::VectorXd::Zero(count));
  if (count == 0) return;

  const RecordedMotion& motion = recording.motion;
  std::vector<Segment> segments = find_segments(motion, Rollout(recording, specs_).pose_delay_s());
  const bool by_velocity = motion.has_velocity();
  for (Segment& segment : segments) segment.slope = Eigen::Matrix3Xd::Zero(3, count);
  // one task per model: as it is, and with each parameter moved
  std::vector<std::vector<Vector3>> ends(static_cast<std::size_t>(count) + 1, std::vector<Vector3>(segments.size(), Vector3::Zero()));
  parallel_for(count + 1, jobs, [&](std::int64_t task) {
    Eigen::VectorXd moved = Eigen::VectorXd::Zero(count);
    if (task > 0) moved[task - 1] = 1.0;
    Rollout rollout(recording, with(moved));
    for (std::size_t s = 0; s < segments.size(); ++s) {
      rollout.begin(rollout.start(segments[s].first), rotor_speeds);
      Measured seen;
      if (rollout.run_to(motion.time_s(segments[s].last), seen))
        ends[static_cast<std::size_t>(task)][s] = by_velocity ? seen.velocity_W_mps : seen.position_W_m;
    }
  });
  Eigen::MatrixXd gram;
  Eigen::VectorXd right = Eigen::VectorXd::Zero(count);
  for (std::size_t s = 0; s < segments.size(); ++s) {
    Segment& segment = segments[s];
    const Vector3 recorded = by_velocity ? motion.velocity_W_mps(segment.last) : motion.position_W_m(segment.last);
    segment.residual = recorded - ends[0][s];
    for (Eigen::Index p = 0; p < count; ++p) segment.slope.col(p) = ends[static_cast<std::size_t>(p) + 1][s] - ends[0][s];
    const Eigen::MatrixXd information = segment.slope.transpose() * segment.slope;
    // the model's own values count as one rollout; a parameter without any effect stays
    if (s == 0) gram = Eigen::VectorXd(information.diagonal().array() + 1e-12).asDiagonal();
    gram += information;
    right += segment.slope.transpose() * segment.residual;
    end_row_.push_back(segment.last);
    change_.emplace_back(gram.ldlt().solve(right));
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
