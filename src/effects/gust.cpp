// gust: a random force from outside: an Ornstein–Uhlenbeck process and a sinusoid, in bursts, limited in size and in rate.
//
// The paper's wind (arXiv 2603.08863, "Wind disturbance injection"): dg = θ(μ − g) dt + σ dW by Euler–Maruyama;
// F_raw = mean + amplitude sin(2π f t + phase) + g while t mod (T_on + T_off) < T_on; otherwise noise and sinusoid are zero
// and g decays to μ at rate θ. Then ‖F‖ is clamped, then ‖ΔF‖ per second. sigma = σ/√(2θ), correlation_time = 1/θ.
// `strength` multiplies all of it, limits too. A fixed gust is the same in every run, whatever its seed; a run may begin anywhere in the
// first `start_spread` seconds of it, as flights do that an operator starts beside a simulation that runs.
// The process has its own clock and is held between ticks; its increments are a function of the tick alone. The torque is
// a second process of the same times, about the centre of mass in body axes.
#include <algorithm>
#include <cmath>

#include "effects/effects.hpp"
#include "gustlab/errors.hpp"
#include "util/three.hpp"

namespace gustlab {

namespace {

class Gust final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.number(
        "sigma_xy", sigma_xy_N_,
        {.unit = "N",
         .help = "standard deviation of the random force in x and in y, of the process without pauses and limits",
         .min = 0.0,
         .natural = 0.05,
         .scale = Scale::weight});
    visitor.number("sigma_z", sigma_z_N_,
                   {.unit = "N",
                    .help = "standard deviation of the random force in z, of the process without pauses and limits",
                    .min = 0.0,
                    .natural = 0.05,
                    .scale = Scale::weight});
    visitor.number("correlation_time", correlation_time_s_,
                   {.unit = "s", .help = "of the random force, 1/θ", .min = 0.1, .natural = 1.0});
    visitor.number("line_amplitude", line_amplitude_N_,
                   {.unit = "N", .help = "of the sinusoid", .natural = 0.05, .scale = Scale::weight});
    visitor.number("line_frequency", line_frequency_radps_,
                   {.unit = "rad/s", .help = "of the sinusoid, 2πf", .min = 0.0, .natural = 1.0});

    const auto extra = [&visitor](std::string_view name, double& value, std::string_view unit, std::string_view help,
                                  double min = -std::numeric_limits<double>::infinity()) {
      visitor.number(name, value, {.unit = unit, .help = help, .min = min, .natural = 0.0});
    };
    extra("strength", strength_, "-", "multiplies every force and torque, limits and their rates too; 0: still air",
          0.0);
    visitor.text("realisation", realisation_,
                 {.help = "seeded: every replicate has its own gust; fixed: all runs have the same"});
    extra("start_spread", start_spread_s_, "s",
          "fixed: a run begins anywhere in the first of so many seconds, drawn per run", 0.0);
    extra("on_s", on_s_, "s", "length of a burst", 1e-3);
    extra("off_s", off_s_, "s", "length of the pause between bursts; 0: none", 0.0);
    visitor.flag("random_phase", random_phase_, {.help = "schedule and sinusoid start anywhere, drawn per run"});
    extra("limit_N", limit_N_, "N", "largest force; 0: no limit", 0.0);
    extra("rate_limit_Nps", rate_limit_Nps_, "N/s", "fastest change of the force; 0: no limit", 0.0);
    extra("mean_x", mean_W_N_.x(), "N", "mean force toward world x, in pauses too");
    extra("mean_y", mean_W_N_.y(), "N", "mean force toward world y, in pauses too");
    extra("mean_z", mean_W_N_.z(), "N", "mean force toward world z, in pauses too");
    extra("drift_x", drift_W_N_.x(), "N", "μ: what the random force in x returns to");
    extra("drift_y", drift_W_N_.y(), "N", "μ: what the random force in y returns to");
    extra("drift_z", drift_W_N_.z(), "N", "μ: what the random force in z returns to");
    extra("phase", phase_rad_, "rad", "by which the sinusoid in y leads that in x");
    visitor.vector("sigma_factor", sigma_factor_, {.help = "multiplies sigma_xy, sigma_xy, sigma_z", .natural = 0.0});
    visitor.vector("line_factor", line_factor_, {.help = "multiplies line_amplitude per axis", .natural = 0.0});
    extra("torque_sigma_xy", torque_sigma_xy_Nm_, "N m", "standard deviation of a random roll and pitch torque", 0.0);
    extra("torque_sigma_z", torque_sigma_z_Nm_, "N m", "standard deviation of a random yaw torque", 0.0);
    extra("torque_limit_Nm", torque_limit_Nm_, "N m", "largest torque; 0: no limit", 0.0);
    extra("torque_rate_limit_Nmps", torque_rate_limit_Nmps_, "N m/s", "fastest change of the torque; 0: no limit", 0.0);
    extra("rate_Hz", rate_Hz_, "Hz", "the gust's own clock", 10.0);
  }

  void prepare(const VehicleModel&, double, const RandomStream& stream) override {
    if (realisation_ != "seeded" && realisation_ != "fixed")
      throw ParameterError("realisation", "realisation = \"" + realisation_ +
                                              "\" is unknown (which gusts runs meet); use seeded or fixed");
    const bool fixed = realisation_ == "fixed";
    if (start_spread_s_ > 0.0 && !fixed)
      throw ParameterError("start_spread",
                           "start_spread needs realisation = \"fixed\" (a seeded gust has no common start)");
    stream_ = fixed ? RandomStream(0, 1, "fixed gust") : stream;
    const auto draw = stream_.uniform4(0, phase_lane);
    schedule_offset_s_ = random_phase_ ? draw[0] * (on_s_ + off_s_) : 0.0;
    line_phase_rad_ = random_phase_ ? draw[1] * 2.0 * pi : 0.0;
    first_tick_ = std::floor(stream.uniform4(0, start_lane)[0] * start_spread_s_ * rate_Hz_);
    const Vector3 sigma_N(sigma_xy_N_, sigma_xy_N_, sigma_z_N_);
    force_ = {strength_ * sigma_N.cwiseProduct(sigma_factor_), strength_ * drift_W_N_, strength_ * limit_N_,
              strength_ * rate_limit_Nps_};
    torque_ = {strength_ * Vector3(torque_sigma_xy_Nm_, torque_sigma_xy_Nm_, torque_sigma_z_Nm_), Vector3::Zero(),
               strength_ * torque_limit_Nm_, strength_ * torque_rate_limit_Nmps_};
  }

  int state_size() const override { return 2 + 4 * 3; }

  void reset_state(std::span<double> state) const override {
    std::fill(state.begin(), state.end(), 0.0);
    part(state, random_force) = force_.drift;
    emit(state, 0.0);
    while (state[1] < first_tick_) next_tick(state);
  }

  void advance(const Flow&, const RotorSet&, const Wrench&, double step_s, std::span<double> state) const override {
    double& steps = state[0];
    steps += 1.0;
    // a tick that falls on the end of this step is due, whatever rounding says
    const double due = first_tick_ + std::floor(steps * step_s * rate_Hz_ + 1e-6);
    while (state[1] < due) next_tick(state);
  }

  void wrench(const Flow& flow, const RotorSet&, std::span<const double> state, Wrench& total) const override {
    const Vector3 force_W_N = part(state, applied_force), torque_B_Nm = part(state, applied_torque);
    if (!force_W_N.isZero(0.0)) total.force_B_N = Three(total.force_B_N) + rotated_back(flow.R_WB, force_W_N);
    if (!torque_B_Nm.isZero(0.0)) total.torque_B_Nm += torque_B_Nm;
  }

 private:
  // one vector process: N and N/s, or N m and N m/s
  struct Process {
    Vector3 sigma = Vector3::Zero(), drift = Vector3::Zero();
    double limit = 0.0, rate_limit = 0.0;
  };
  // where the state's vectors begin; before them are steps and ticks
  enum Part : std::size_t { random_force = 2, applied_force = 5, random_torque = 8, applied_torque = 11 };
  static constexpr std::uint32_t force_lane = 0, torque_lane = 1, phase_lane = 2, start_lane = 3;

  static Eigen::Map<Vector3> part(std::span<double> state, Part begin) {
    return Eigen::Map<Vector3>(state.data() + begin);
  }
  static Eigen::Map<const Vector3> part(std::span<const double> state, Part begin) {
    return Eigen::Map<const Vector3>(state.data() + begin);
  }

  bool is_on(double time_s) const {
    // ticks on a boundary belong to what begins there
    return std::fmod(time_s + schedule_offset_s_ + 1e-9, on_s_ + off_s_) < on_s_;
  }

  void next_tick(std::span<double> state) const {
    double& tick = state[1];
    const bool on = is_on(tick / rate_Hz_);
    const auto counter = static_cast<std::uint64_t>(tick);
    part(state, random_force) = next(part(state, random_force), force_, on, stream_.normal4(counter, force_lane));
    if (!torque_.sigma.isZero(0.0))
      part(state, random_torque) = next(part(state, random_torque), torque_, on, stream_.normal4(counter, torque_lane));
    tick += 1.0;
    emit(state, tick / rate_Hz_);
  }

  // Euler–Maruyama over one tick, with σ = sigma √(2θ)
  Vector3 next(const Vector3& g, const Process& process, bool on, const std::array<double, 4>& normal) const {
    const double share = 1.0 / (rate_Hz_ * correlation_time_s_);
    Vector3 result = g + share * (process.drift - g);
    if (on) result += std::sqrt(2.0 * share) * process.sigma.cwiseProduct(Vector3(normal[0], normal[1], normal[2]));
    return result;
  }

  Vector3 limited(Vector3 raw, const Vector3& before, const Process& process) const {
    if (process.limit > 0.0 && raw.norm() > process.limit) raw *= process.limit / raw.norm();
    const Vector3 change = raw - before;
    const double most = process.rate_limit / rate_Hz_;
    return most > 0.0 && change.norm() > most ? Vector3(before + change * (most / change.norm())) : raw;
  }

  // what the tick at this time applies until the next
  void emit(std::span<double> state, double time_s) const {
    Vector3 raw = strength_ * mean_W_N_ + part(state, random_force);
    if (is_on(time_s)) {
      const double angle = line_frequency_radps_ * time_s + line_phase_rad_;
      const Vector3 line(std::sin(angle), std::sin(angle + phase_rad_), std::sin(angle));
      raw += strength_ * line_amplitude_N_ * line_factor_.cwiseProduct(line);
    }
    part(state, applied_force) = limited(raw, part(state, applied_force), force_);
    part(state, applied_torque) = limited(part(state, random_torque), part(state, applied_torque), torque_);
  }

  double sigma_xy_N_ = 0.0, sigma_z_N_ = 0.0, correlation_time_s_ = 1.0;
  double line_amplitude_N_ = 0.0, line_frequency_radps_ = 1.0, phase_rad_ = 0.0;
  double strength_ = 1.0;
  std::string realisation_ = "seeded";
  double start_spread_s_ = 0.0;
  double on_s_ = 1.0, off_s_ = 0.0;
  bool random_phase_ = false;
  double limit_N_ = 0.0, rate_limit_Nps_ = 0.0;
  Vector3 mean_W_N_ = Vector3::Zero(), drift_W_N_ = Vector3::Zero();
  Vector3 sigma_factor_ = Vector3::Ones(), line_factor_{1.0, 1.0, 0.0};
  double torque_sigma_xy_Nm_ = 0.0, torque_sigma_z_Nm_ = 0.0, torque_limit_Nm_ = 0.0, torque_rate_limit_Nmps_ = 0.0;
  double rate_Hz_ = 50.0;

  RandomStream stream_;
  Process force_, torque_;
  double schedule_offset_s_ = 0.0, line_phase_rad_ = 0.0, first_tick_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_gust() { return std::make_unique<Gust>(); }

}  // namespace gustlab
