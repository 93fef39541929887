#include "diagnosis/model/propagation.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace gustlab::diagnosis {

namespace {

// the recorded past of commands, for delays
struct RecordedPast final : Actuation::Past {
  const CommandRecord* record = nullptr;
  double from_s = 0.0, step_s = 0.0;
  double more_radps = 0.0;  // than was recorded
  void command(double age_s, RotorArray& speed) const override {
    speed = record->mean(from_s - age_s, from_s - age_s + step_s);
    for (double& command : speed) command += more_radps;
  }
};

}  // namespace

Point propagate(Evaluator& evaluate, Point x, double time_s, double interval_s, double voltage_V, int substeps,
                const RotorArray* speed, const RotorArray* acceleration) {
  const double h = interval_s / substeps;
  for (int s = 0; s < substeps; ++s, time_s += h) {
    const Acceleration a = evaluate(x, time_s, voltage_V, speed[s], acceleration[s]);
    Point middle;
    middle.position = x.position + 0.5 * h * x.velocity;
    middle.velocity = x.velocity + 0.5 * h * a.linear_W_mps2;
    middle.attitude = x.attitude * exp_rotation(0.5 * h * x.rate);
    middle.rate = x.rate + 0.5 * h * a.angular_B_radps2;
    const Acceleration m = evaluate(middle, time_s + 0.5 * h, voltage_V, speed[s], acceleration[s]);
    x.position += h * middle.velocity;
    x.velocity += h * m.linear_W_mps2;
    x.attitude = (x.attitude * exp_rotation(h * middle.rate)).normalized();
    x.rate += h * m.angular_B_radps2;
  }
  return x;
}

ForceModel force_model(const FlightData& flight, const Catalogue& catalogue, const Eigen::VectorXd& value, int index,
                       int also) {
  ForceModel forces(flight.vehicle, catalogue.effects(value, index, also));
  forces.set_speed_is_measured(!flight.measured_speed.empty());
  forces.prepare(flight.sample_s / flight.substeps, 0, 0);
  return forces;
}

namespace {

// How rotors answer the commands of a flight, step by step.
class Answer {
 public:
  Answer(const FlightData& flight, const ForceModel& forces) : flight_(flight), forces_(forces) {
    past_.record = &flight.commands;
    step_.past = &past_;
  }
  // how fast they turn at a time before which commands are known for a while
  RotorArray speed_at(double time_s, double voltage_V) {
    const double h = spin_up_s / steps;
    RotorArray speed = flight_.commands.mean(time_s - spin_up_s, time_s - spin_up_s + h);
    for (int s = 0; s < steps; ++s) speed = over(time_s + (s - steps) * h, h, voltage_V, speed).end_speed_radps;
    return speed;
  }
  // over a step that begins at a speed; the command that rotors follow then is `more_radps` than was recorded
  const Actuation& over(double time_s, double step_s, double voltage_V, const RotorArray& speed,
                        double more_radps = 0.0) {
    past_.from_s = time_s;
    past_.step_s = step_s;
    past_.more_radps = more_radps;
    step_.time_s = time_s - flight_.start_s;
    step_.step_s = step_s;
    step_.voltage_V = voltage_V;
    past_.command(0.0, step_.command_radps);
    step_.start_speed_radps = speed;
    forces_.actuate(step_);
    return step_;
  }

 private:
  static constexpr int steps = 60;
  const FlightData& flight_;
  const ForceModel& forces_;
  RecordedPast past_;
  Actuation step_;
};

// `forces`: what commands do; none: as it was measured
RotorHistory history_of(const FlightData& flight, const ForceModel* forces) {
  RotorHistory history;
  const std::size_t n = flight.samples.size();
  history.substeps = flight.substeps;
  const auto count = static_cast<std::size_t>(history.substeps);
  history.mean.resize(n * count);
  history.acceleration.resize(n * count);
  history.at_sample.resize(n);
  std::optional<Answer> answer;
  if (forces) answer.emplace(flight, *forces);
  RotorArray speed{};
  for (std::size_t k = 0; k < n; ++k) {
    const Sample& sample = flight.samples[k];
    const double interval_s = k + 1 < n && !flight.samples[k + 1].starts_segment
                                  ? flight.samples[k + 1].time_s - sample.time_s
                                  : flight.sample_s;
    const double h = interval_s / history.substeps;
    if (sample.starts_segment)
      speed = answer ? answer->speed_at(sample.time_s, sample.voltage_V)
                     : flight.measured_speed.mean(sample.time_s, sample.time_s + h);
    history.at_sample[k] = speed;
    for (std::size_t s = 0; s < count; ++s) {
      const double t = sample.time_s + static_cast<double>(s) * h;
      RotorArray& mean = history.mean[k * count + s];
      RotorArray& rise = history.acceleration[k * count + s];
      const RotorArray before = speed;
      if (answer) {
        const Actuation& step = answer->over(t, h, sample.voltage_V, speed);
        mean = step.mean_speed_radps;
        speed = step.end_speed_radps;
        for (std::size_t i = 0; i < max_rotors; ++i) rise[i] = (speed[i] - before[i]) / h;
        continue;
      }
      const CommandRecord& record = flight.measured_speed;
      const RotorArray ahead = record.mean(t + 0.5 * h, t + 1.5 * h), behind = record.mean(t - 0.5 * h, t + 0.5 * h);
      mean = (flight.jumping_speed.empty() ? record : flight.jumping_speed).mean(t, t + h);
      for (std::size_t i = 0; i < max_rotors; ++i) rise[i] = (ahead[i] - behind[i]) / h;
      speed = ahead;
    }
  }
  // a sample that is the mean of a group of rows saw the mean speed of that time, not the speed at its middle
  if (flight.read_slower) {
    const std::size_t half = std::max<std::size_t>(1, count / 2);
    for (std::size_t k = 1; k < n; ++k) {
      if (flight.samples[k].starts_segment) continue;
      history.at_sample[k] = {};
      for (std::size_t s = k * count - half; s < k * count + half; ++s)
        for (std::size_t i = 0; i < max_rotors; ++i)
          history.at_sample[k][i] += history.mean[s][i] / static_cast<double>(2 * half);
    }
  }
  return history;
}

}  // namespace

RotorHistory rotor_history(const FlightData& flight, const ForceModel& forces) {
  if (!flight.estimated.mean.empty()) return flight.estimated;
  return flight.measured_speed.empty() ? commanded_history(flight, forces) : measured_history(flight);
}

RotorHistory measured_history(const FlightData& flight) { return history_of(flight, nullptr); }

RotorHistory commanded_history(const FlightData& flight, const ForceModel& forces) {
  return history_of(flight, &forces);
}

namespace {

// The rotors' speeds from one row to the next.
struct Way {
  std::vector<RotorArray> mean;  // per substep
  RotorArray end{};
};

// with a command that rises by so much more from the row to the next
Way way_of(Answer& answer, const Sample& row, double interval_s, int substeps, RotorArray speed, double rise_radps) {
  constexpr int parts = 4;  // of a substep
  Way way;
  const int steps = substeps * parts;
  for (int s = 0; s < steps; ++s) {
    if (s % parts == 0) way.mean.emplace_back();
    const Actuation& step = answer.over(row.time_s + s * interval_s / steps, interval_s / steps, row.voltage_V, speed,
                                        rise_radps * (s + 0.5) / steps);
    for (std::size_t i = 0; i < max_rotors; ++i) way.mean.back()[i] += step.mean_speed_radps[i] / parts;
    speed = step.end_speed_radps;
  }
  way.end = speed;
  return way;
}

}  // namespace

RotorHistory history_between_rows(const FlightData& flight, const ForceModel& forces) {
  const double trial_radps = 0.01 * flight.vehicle.hover_speed_radps();
  const auto measured = [&flight](double time_s) {
    constexpr double instant_s = 1e-6;
    return flight.measured_speed.mean(time_s - instant_s, time_s + instant_s);
  };
  RotorHistory history;
  history.substeps = flight.substeps;
  Answer answer(flight, forces);
  for (std::size_t k = 0; k < flight.samples.size(); ++k) {
    const Sample& row = flight.samples[k];
    const double interval_s =
        k + 1 < flight.samples.size() ? flight.samples[k + 1].time_s - row.time_s : flight.sample_s;
    const RotorArray from = measured(row.time_s), to = measured(row.time_s + interval_s);
    const Way logged = way_of(answer, row, interval_s, flight.substeps, from, 0.0),
              risen = way_of(answer, row, interval_s, flight.substeps, from, trial_radps);
    for (std::size_t s = 0; s < logged.mean.size(); ++s) {
      RotorArray& mean = history.mean.emplace_back(logged.mean[s]);
      for (std::size_t i = 0; i < max_rotors; ++i) {
        const double missing = to[i] - logged.end[i], answered = risen.end[i] - logged.end[i];
        if (answered > 0.0) mean[i] += missing / answered * (risen.mean[s][i] - logged.mean[s][i]);
      }
    }
  }
  return history;
}

}  // namespace gustlab::diagnosis
