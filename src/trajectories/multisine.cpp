// multisine: p = c + r(t) Σ a (f₁/f_k) sin(2π f_k t + φ_k) per axis, with Schroeder's phases, which keep the peaks low.
//
// Amplitudes fall as 1/f, so that every line moves equally fast. Schroeder, IEEE Trans. Inf. Theory 16(1) 1970.
#include "gustlab/errors.hpp"
#include "trajectories/jet.hpp"
#include "trajectories/trajectories.hpp"

namespace gustlab {

namespace {

class Multisine final : public Trajectory {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.vector("amplitude_m", amplitude_W_m_, {.unit = "m", .help = "amplitude of the first line of each axis"});
    visitor.numbers(names[0], frequencies_hz_[0], {.unit = "Hz", .help = "lines along x"});
    visitor.numbers(names[1], frequencies_hz_[1], {.unit = "Hz", .help = "lines along y"});
    visitor.numbers(names[2], frequencies_hz_[2], {.unit = "Hz", .help = "lines along z"});
    visitor.vector("center_m", center_W_m_, {.unit = "m", .help = "mean position"});
    visitor.number("ramp_s", ramp_s_, {.unit = "s", .help = "time until the full amplitude", .min = 0.0, .max = 1e3});
    visitor.number("yaw_amplitude_rad", yaw_amplitude_rad_,
                   {.unit = "rad", .help = "heading swing", .min = 0.0, .max = pi});
    visitor.number("yaw_frequency_hz", yaw_frequency_hz_,
                   {.unit = "Hz", .help = "of the heading swing", .min = 0.0, .max = 10.0});
  }

  void prepare() override {
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (const double line : frequencies_hz_[axis])
        if (!(line > 0.0 && line <= 50.0))
          throw ParameterError(names[axis], "a frequency is out of range (lines are between 0 and 50 Hz); remove it");
  }

  Reference at(double time_s) const override {
    const Jet ramp = smooth_step(time_s, ramp_s_);
    Reference reference =
        reference_of(center_W_m_.x() + ramp * axis(0, time_s), center_W_m_.y() + ramp * axis(1, time_s),
                     center_W_m_.z() + ramp * axis(2, time_s), 0.0);
    const Jet yaw = ramp * (yaw_amplitude_rad_ * sine_cosine(2.0 * pi * yaw_frequency_hz_ * Jet::time(time_s)).sine);
    reference.yaw_rad = yaw.derivative(0);
    reference.yaw_rate_radps = yaw.derivative(1);
    return reference;
  }

 private:
  static constexpr std::array<std::string_view, 3> names{"frequencies_x_hz", "frequencies_y_hz", "frequencies_z_hz"};

  Jet axis(int k, double time_s) const {
    const std::vector<double>& lines = frequencies_hz_[static_cast<std::size_t>(k)];
    Jet sum;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const double phase = -pi * static_cast<double>(i * (i + 1)) / static_cast<double>(lines.size());
      const Jet angle = 2.0 * pi * lines[i] * Jet::time(time_s) + Jet(phase);
      sum = sum + (amplitude_W_m_[k] * lines.front() / lines[i]) * sine_cosine(angle).sine;
    }
    return sum;
  }

  Vector3 amplitude_W_m_{0.35, 0.35, 0.2};
  // lines that no two axes share, none a multiple of another axis's
  std::array<std::vector<double>, 3> frequencies_hz_{
      {{0.10, 0.23, 0.41, 0.73}, {0.13, 0.29, 0.47, 0.79}, {0.17, 0.31, 0.53, 0.89}}};
  Vector3 center_W_m_{0.0, 0.0, 1.5};
  double ramp_s_ = 2.0;
  double yaw_amplitude_rad_ = 0.0;
  double yaw_frequency_hz_ = 0.11;
};

}  // namespace

std::unique_ptr<Trajectory> make_multisine() { return std::make_unique<Multisine>(); }

}  // namespace gustlab
