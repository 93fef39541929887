// fans: turbulent air from fans on a circle, each blowing toward its centre; drag and lift feel it.
//
// Along the axis of a free jet the speed falls as 1/(s + s0), s from the fan, and across it as exp(−(r/b)²) with b in
// proportion to s + s0 (Pope, Turbulent Flows, 2000, section 5.1). The speeds at the centre and at a distance from it give
// s0. Turbulence is isotropic, in proportion to the mean speed, and a sum of cosines of random phase whose frequencies are
// drawn from the Lorentzian that goes with an exponential correlation (Kraichnan, Physics of Fluids 13, 1970): a
// function of time alone, so nothing has to be remembered. Swirl and what the vehicle does to the air are left out.
#include <array>
#include <cmath>

#include "effects/effects.hpp"

namespace gustlab {

namespace {

class Fans final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    const auto number = [&visitor](std::string_view name, double& value, std::string_view unit, std::string_view help,
                                   double min) {
      visitor.number(name, value, {.unit = unit, .help = help, .min = min, .natural = 0.0});
    };
    visitor.integer("count", count_,
                    {.help = "fans, evenly around the centre, the first at world x", .min = 1, .max = most_fans});
    number("distance_m", distance_m_, "m", "of each fan from the centre", 0.1);
    visitor.vector("center_m", center_W_m_, {.unit = "m", .help = "where their axes meet", .natural = 0.0});
    number("center_speed_mps", center_speed_mps_, "m/s", "of each jet at the centre", 0.0);
    number("edge_speed_mps", edge_speed_mps_, "m/s", "of each jet nearer to its fan, at edge_m", 0.0);
    number("edge_m", edge_m_, "m", "distance of that point from the centre", 0.01);
    number("width_m", width_m_, "m", "half width of a jet at the centre, 1/e", 0.01);
    number("turbulence", turbulence_, "-",
           "standard deviation of each component of the air's velocity, of the mean speed", 0.0);
    number("correlation_time", correlation_time_s_, "s", "of the turbulence", 0.01);
  }

  void prepare(const VehicleModel&, double, const RandomStream& stream) override {
    // v(s) = c/(s + s0) through both speeds; a jet that is not faster near its fan does not fall at all
    const double near_m = distance_m_ - edge_m_;
    offset_m_ = edge_speed_mps_ > center_speed_mps_ ? (center_speed_mps_ * distance_m_ - edge_speed_mps_ * near_m) /
                                                          (edge_speed_mps_ - center_speed_mps_)
                                                    : 1e9;
    offset_m_ = std::max(offset_m_, 0.1);
    for (std::size_t k = 0; k < modes_.size(); ++k) {
      const auto draw = stream.uniform4(k);
      // quantile of the Lorentzian, cut where a vehicle no longer follows
      modes_[k] = {std::min(std::tan(0.5 * pi * draw[0]) / correlation_time_s_, 60.0), 2.0 * pi * draw[1]};
    }
  }

  void on_rotor(Flow& flow, RotorSet&) const override {
    if (center_speed_mps_ == 0.0) return;
    Vector3 wind_W_mps = Vector3::Zero();
    const Vector3 place = flow.position_W_m - center_W_m_;
    for (std::size_t fan = 0; fan < static_cast<std::size_t>(count_); ++fan) {
      const double angle = 2.0 * pi * static_cast<double>(fan) / static_cast<double>(count_);
      const Vector3 outward(std::cos(angle), std::sin(angle), 0.0);
      const double along_m = distance_m_ - outward.dot(place);
      if (along_m <= 0.0) continue;
      const double spread = (distance_m_ + offset_m_) / (along_m + offset_m_);
      const double across = (place - outward.dot(place) * outward).norm() * spread / width_m_;
      const double speed_mps = center_speed_mps_ * spread * std::exp(-across * across);
      wind_W_mps += speed_mps * (turbulence_ * fluctuation(fan, flow.time_s) - outward);
    }
    flow.air_velocity_B_mps -= flow.R_WB.transpose() * wind_W_mps;
  }

 private:
  struct Mode {
    double frequency_radps, phase_rad;
  };
  static constexpr std::int64_t most_fans = 8;
  static constexpr std::size_t modes_per_component = 12;

  // unit variance in each component
  Vector3 fluctuation(std::size_t fan, double time_s) const {
    Vector3 sum = Vector3::Zero();
    const Mode* mode = &modes_[fan * 3 * modes_per_component];
    for (int axis = 0; axis < 3; ++axis)
      for (std::size_t k = 0; k < modes_per_component; ++k, ++mode)
        sum[axis] += std::cos(mode->frequency_radps * time_s + mode->phase_rad);
    return std::sqrt(2.0 / modes_per_component) * sum;
  }

  std::int64_t count_ = 4;
  double distance_m_ = 2.0, center_speed_mps_ = 0.0, edge_speed_mps_ = 0.0, edge_m_ = 1.0, width_m_ = 0.5;
  Vector3 center_W_m_ = Vector3::Zero();
  double turbulence_ = 0.3, correlation_time_s_ = 0.5;

  double offset_m_ = 1.0;  // s0
  std::array<Mode, static_cast<std::size_t>(most_fans) * 3 * modes_per_component> modes_{};
};

}  // namespace

std::unique_ptr<Effect> make_fans() { return std::make_unique<Fans>(); }

}  // namespace gustlab
