#include "diagnosis/linear_model.hpp"

#include <cmath>

namespace gustlab::diagnosis {

namespace {

Quaternion exp_rotation(const Vector3& turn) {
  const double angle = turn.norm();
  return angle > 0.0 ? Quaternion(Eigen::AngleAxisd(angle, turn / angle)) : Quaternion::Identity();
}

// small rotation from a to b, in the axes of a
Vector3 log_rotation(const Quaternion& a, const Quaternion& b) {
  const Quaternion d = a.conjugate() * b;
  return (d.w() < 0.0 ? -2.0 : 2.0) * d.vec();
}

// motion of the centre of mass
struct Point {
  Vector3 position, velocity;
  Quaternion attitude;
  Vector3 rate;

  Point plus(int i, double step) const {
    Point moved = *this;
    if (i < 3) moved.position[i] += step;
    else if (i < 6) moved.velocity[i - 3] += step;
    else if (i < 9) moved.attitude = attitude * exp_rotation(step * Vector3::Unit(i - 6));
    else moved.rate[i - 9] += step;
    return moved;
  }
  Vector12 minus(const Point& other) const {
    Vector12 e;
    e << position - other.position, velocity - other.velocity, log_rotation(other.attitude, attitude), rate - other.rate;
    return e;
  }
};

Point center_of_mass(const Motion& motion, const Vector3& arm) {
  const Matrix3 R = motion.attitude_WB.toRotationMatrix();
  return {motion.position_W_m + R * arm, motion.velocity_W_mps + R * motion.body_rate_B_radps.cross(arm),
          motion.attitude_WB, motion.body_rate_B_radps};
}

// the force model at a point of the flight
struct Evaluator {
  const ForceModel& forces;
  Flow flow;
  RotorSet rotors;

  Acceleration operator()(const Point& x, double time_s, double voltage_V, const RotorArray& speed,
                          const RotorArray& acceleration) {
    prepare(x, time_s, voltage_V, speed, acceleration);
    return forces.acceleration(flow, forces.wrench(flow, rotors, {}));
  }
  Vector3 specific_force(const Point& x, double time_s, double voltage_V, const RotorArray& speed,
                         const RotorArray& acceleration, Vector3& angular_acceleration) {
    prepare(x, time_s, voltage_V, speed, acceleration);
    const Wrench wrench = forces.wrench(flow, rotors, {});
    angular_acceleration = forces.acceleration(flow, wrench).angular_B_radps2;
    return forces.specific_force_at_origin(flow, wrench, angular_acceleration);
  }

 private:
  void prepare(const Point& x, double time_s, double voltage_V, const RotorArray& speed, const RotorArray& acceleration) {
    VehicleState state;
    state.time_s = time_s;
    state.attitude_WB = x.attitude;
    state.body_rate_B_radps = x.rate;
    const Matrix3 R = x.attitude.toRotationMatrix();
    const Vector3& arm = forces.vehicle().center_of_mass_B_m;
    state.position_W_m = x.position - R * arm;
    state.velocity_W_mps = x.velocity - R * x.rate.cross(arm);
    flow = forces.flow(state, voltage_V);
    forces.rotors(speed, acceleration, flow, rotors);
  }
};

// the plant's motion over one sample interval: midpoint rule in substeps, rotor speeds held at their means
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

// the recorded past of commands, for delays
struct RecordedPast final : Actuation::Past {
  const CommandRecord* record = nullptr;
  double from_s = 0.0, step_s = 0.0;
  void command(double age_s, RotorArray& speed) const override {
    speed = record->mean(from_s - age_s, from_s - age_s + step_s);
  }
};

// the smoothed past of a sample, for late sensors
struct SmoothedPast final : MeasurementContext::Past {
  const Motion* motion = nullptr;
  double time_s = 0.0;
  VehicleState at(double t) const override {
    const double d = t - time_s;
    VehicleState state;
    state.time_s = t;
    state.position_W_m = motion->position_W_m + d * motion->velocity_W_mps + 0.5 * d * d * motion->acceleration_W_mps2;
    state.velocity_W_mps = motion->velocity_W_mps + d * motion->acceleration_W_mps2;
    state.attitude_WB = motion->attitude_WB *
                        exp_rotation(d * motion->body_rate_B_radps + 0.5 * d * d * motion->angular_acceleration_B_radps2);
    state.body_rate_B_radps = motion->body_rate_B_radps + d * motion->angular_acceleration_B_radps2;
    return state;
  }
};

// what the sensors of the model say at a sample
Measured predict_sensors(const ForceModel& forces, const Motion& motion, const Point& x, double time_s,
                         const Vector3& specific_force, const Vector3& angular_acceleration) {
  const Matrix3 R = x.attitude.toRotationMatrix();
  const Vector3& arm = forces.vehicle().center_of_mass_B_m;
  Measured m;
  m.position_W_m = x.position - R * arm;
  m.velocity_W_mps = x.velocity - R * x.rate.cross(arm);
  m.attitude_WB = x.attitude;
  m.body_rate_B_radps = x.rate;
  m.specific_force_B_mps2 = specific_force;
  SmoothedPast past;
  Motion origin = motion;
  origin.position_W_m = m.position_W_m;
  origin.velocity_W_mps = m.velocity_W_mps;
  past.motion = &origin;
  past.time_s = time_s;
  MeasurementContext context;
  context.time_s = time_s;
  context.angular_acceleration_B_radps2 = angular_acceleration;
  context.past = &past;
  forces.measure(context, m);
  return m;
}

// measured ⊟ predicted; positions are replaced by velocities where only those were measured
Vector12 innovation(const Sample& sample, const Measured& m) {
  Vector12 y;
  y << sample.position_W_m - m.position_W_m, log_rotation(m.attitude_WB, sample.attitude_WB),
      sample.body_rate_B_radps - m.body_rate_B_radps, sample.specific_force_B_mps2 - m.specific_force_B_mps2;
  if (!(sample.channels & has_position) && (sample.channels & has_velocity))
    y.head<3>() = sample.velocity_W_mps - m.velocity_W_mps;
  return y;
}

RotorArray mean_of(const RotorArray* values, int count) {
  RotorArray mean{};
  for (int s = 0; s < count; ++s)
    for (std::size_t i = 0; i < max_rotors; ++i) mean[i] += values[s][i] / count;
  return mean;
}

ForceModel force_model(const FlightData& flight, const Catalogue& catalogue, const Eigen::VectorXd& value, int index,
                       int also) {
  ForceModel forces(flight.vehicle, catalogue.effects(value, index, also));
  forces.set_speed_is_measured(!flight.measured_speed.empty());
  forces.prepare(flight.sample_s / std::max(1.0, std::ceil(flight.sample_s / 0.0025 - 1e-9)), 0, 0);
  return forces;
}

// accelerations at mid-interval along a flight
std::vector<Acceleration> mid_interval(const FlightData& flight, const ForceModel& forces, const RotorHistory& history) {
  std::vector<Acceleration> result(flight.samples.size());
  const auto count = static_cast<std::size_t>(history.substeps);
  Evaluator at{forces, {}, {}};
  for (std::size_t k = 0; k < result.size(); ++k)
    result[k] = at(center_of_mass(flight.motion[k], forces.vehicle().center_of_mass_B_m),
                   flight.samples[k].time_s - flight.start_s, flight.samples[k].voltage_V,
                   mean_of(&history.mean[k * count], history.substeps),
                   mean_of(&history.acceleration[k * count], history.substeps));
  return result;
}

}  // namespace

std::vector<Eigen::Matrix<double, 6, 1>> limit_change(const FlightData& flight, int flight_index, const Catalogue& catalogue,
                                                      const Eigen::VectorXd& value, double limit_radps) {
  FlightData limited;
  limited = flight;
  limited.vehicle.max_speed_radps = limit_radps;
  const ForceModel free = force_model(flight, catalogue, value, flight_index, -1);
  const ForceModel bound = force_model(limited, catalogue, value, flight_index, -1);
  const auto before = mid_interval(flight, free, rotor_history(flight, free));
  const auto after = mid_interval(limited, bound, rotor_history(limited, bound));
  std::vector<Eigen::Matrix<double, 6, 1>> change(before.size());
  for (std::size_t k = 0; k < change.size(); ++k)
    change[k] << after[k].linear_W_mps2 - before[k].linear_W_mps2, after[k].angular_B_radps2 - before[k].angular_B_radps2;
  return change;
}

RotorHistory rotor_history(const FlightData& flight, const ForceModel& forces) {
  RotorHistory history;
  const std::size_t n = flight.samples.size();
  history.substeps = static_cast<int>(std::max(1.0, std::ceil(flight.sample_s / 0.0025 - 1e-9)));
  const auto count = static_cast<std::size_t>(history.substeps);
  history.mean.resize(n * count);
  history.acceleration.resize(n * count);
  history.at_sample.resize(n);
  const bool measured = !flight.measured_speed.empty();
  const CommandRecord& record = measured ? flight.measured_speed : flight.commands;

  RecordedPast past;
  past.record = &record;
  Actuation actuation;
  actuation.past = &past;
  RotorArray speed{};
  for (std::size_t k = 0; k < n; ++k) {
    const double interval_s =
        k + 1 < n && !flight.samples[k + 1].starts_segment ? flight.samples[k + 1].time_s - flight.samples[k].time_s
                                                           : flight.sample_s;
    const double h = interval_s / history.substeps;
    if (flight.samples[k].starts_segment) speed = record.mean(flight.samples[k].time_s, flight.samples[k].time_s + h);
    history.at_sample[k] = speed;
    for (std::size_t s = 0; s < count; ++s) {
      const double t = flight.samples[k].time_s + static_cast<double>(s) * h;
      const RotorArray command = record.mean(t, t + h);
      RotorArray& mean = history.mean[k * count + s];
      RotorArray& rise = history.acceleration[k * count + s];
      if (measured) {
        const RotorArray ahead = record.mean(t + 0.5 * h, t + 1.5 * h), behind = record.mean(t - 0.5 * h, t + 0.5 * h);
        mean = command;
        for (std::size_t i = 0; i < max_rotors; ++i) rise[i] = (ahead[i] - behind[i]) / h;
        speed = ahead;
        continue;
      }
      past.from_s = t;
      past.step_s = h;
      actuation.time_s = t - flight.start_s;
      actuation.step_s = h;
      actuation.voltage_V = flight.samples[k].voltage_V;
      actuation.command_radps = command;
      actuation.start_speed_radps = speed;
      forces.actuate(actuation);
      mean = actuation.mean_speed_radps;
      for (std::size_t i = 0; i < max_rotors; ++i) rise[i] = (actuation.end_speed_radps[i] - speed[i]) / h;
      speed = actuation.end_speed_radps;
    }
  }
  return history;
}

void linearise(const FlightData& flight, int flight_index, const Catalogue& catalogue, const Eigen::VectorXd& value,
               const std::vector<int>& wanted, LinearFlight& out) {
  const std::size_t n = flight.samples.size();
  const ForceModel forces = force_model(flight, catalogue, value, flight_index, -1);
  const RotorHistory rotors = rotor_history(flight, forces);
  const auto count = static_cast<std::size_t>(rotors.substeps);
  const Vector3 arm = forces.vehicle().center_of_mass_B_m;
  const bool need_F = out.F.size() != n;
  const bool with_force = n > 0 && std::any_of(flight.samples.begin(), flight.samples.end(),
                                               [](const Sample& s) { return (s.channels & has_force) != 0; });
  out.center_of_mass_B_m = arm;
  out.torque_known = !flight.collective_only;
  out.F.resize(n), out.b.resize(n), out.interval_s.resize(n), out.starts.resize(n), out.measured.resize(n);
  out.y.resize(n), out.R_WB.resize(n), out.force_rows.resize(n);

  std::vector<Point> x(n);
  for (std::size_t k = 0; k < n; ++k) x[k] = center_of_mass(flight.motion[k], arm);
  Evaluator evaluate{forces, {}, {}};

  // finite-difference steps of the error state
  constexpr std::array<double, 4> steps = {1e-4, 1e-3, 1e-4, 1e-3};
  for (std::size_t k = 0; k < n; ++k) {
    const Sample& sample = flight.samples[k];
    const bool last = k + 1 == n || flight.samples[k + 1].starts_segment;
    const double interval_s = last ? flight.sample_s : flight.samples[k + 1].time_s - sample.time_s;
    const double t = sample.time_s - flight.start_s;
    const RotorArray* speed = &rotors.mean[k * count];
    const RotorArray* rise = &rotors.acceleration[k * count];
    out.interval_s[k] = interval_s;
    out.starts[k] = sample.starts_segment || sample.saturated;
    out.R_WB[k] = x[k].attitude.toRotationMatrix();
    const auto run = [&](const Point& from) {
      return propagate(evaluate, from, t, interval_s, sample.voltage_V, rotors.substeps, speed, rise);
    };
    const Point next = run(x[k]);
    out.b[k] = last ? Vector12::Zero() : next.minus(x[k + 1]);
    if (need_F)
      for (int i = 0; i < error_size; ++i) {
        const double step = steps[static_cast<std::size_t>(i / 3)];
        out.F[k].col(i) = run(x[k].plus(i, step)).minus(next) / step;
      }

    // sensors
    const unsigned c = sample.channels;
    out.measured[k] << Eigen::Vector3i::Constant((c & (has_position | has_velocity)) != 0).cast<bool>(),
        Eigen::Vector3i::Constant((c & has_attitude) != 0).cast<bool>(),
        Eigen::Vector3i::Constant((c & has_rate) != 0).cast<bool>(),
        Eigen::Vector3i::Constant((c & has_force) != 0).cast<bool>();
    Vector3 angular = flight.motion[k].angular_acceleration_B_radps2, modelled;
    Vector3 force = Vector3::Zero();
    if (with_force) {
      force = evaluate.specific_force(x[k], t, sample.voltage_V, rotors.at_sample[k], rise[0], modelled);
      if (need_F)
        for (int i = 0; i < 9; ++i) {
          const double step = steps[static_cast<std::size_t>(i / 3 + 1)];
          out.force_rows[k].col(i) = (evaluate.specific_force(x[k].plus(i + 3, step), t, sample.voltage_V,
                                                              rotors.at_sample[k], rise[0], modelled) - force) / step;
        }
    }
    out.y[k] = innovation(sample, predict_sensors(forces, flight.motion[k], x[k], t, force, angular));
  }

  // a slung load is a force history
  const int load = catalogue.find("slung_load");
  const int load_column = load >= 0 && !flight.load_force_W_mps2.empty()
                              ? catalogue.groups()[static_cast<std::size_t>(load)].columns.front() : -1;
  const auto load_push = [&](std::size_t k) {
    const double dt = out.interval_s[k];
    const Vector3 a = flight.load_force_W_mps2[k] / forces.vehicle().mass_kg;
    Vector12 push;
    push << 0.5 * dt * dt * a, dt * a, Vector3::Zero(), Vector3::Zero();
    return push;
  };
  if (load_column >= 0 && value[load_column] != 0.0)
    for (std::size_t k = 0; k < n; ++k)
      if (!out.b[k].isZero(0.0)) out.b[k] += value[load_column] * load_push(k);

  // so is a lower speed limit
  const int limit = catalogue.find("saturation");
  const auto limit_push = [&](std::size_t k) {
    const double dt = out.interval_s[k];
    const Vector3 linear = flight.limit_change[k].head<3>(), angular = flight.limit_change[k].tail<3>();
    Vector12 push;
    push << 0.5 * dt * dt * linear, dt * linear, 0.5 * dt * dt * angular, dt * angular;
    return push;
  };
  const double limited = limit >= 0 && !flight.limit_change.empty() && !catalogue.groups()[static_cast<std::size_t>(limit)].columns.empty()
                             ? value[catalogue.groups()[static_cast<std::size_t>(limit)].columns.front()] : 0.0;
  if (limited != 0.0)
    for (std::size_t k = 0; k < n; ++k)
      if (!out.b[k].isZero(0.0)) out.b[k] += limited * limit_push(k);

  // columns: those wanted that act in this flight
  out.columns.clear();
  for (const int c : wanted) {
    const Column& column = catalogue.columns()[static_cast<std::size_t>(c)];
    if (column.flight < 0 || column.flight == flight_index) out.columns.push_back(c);
  }
  const auto width = static_cast<Eigen::Index>(out.columns.size());
  out.B.assign(n, Eigen::Matrix<double, 12, Eigen::Dynamic>::Zero(12, width));
  out.D.assign(n, Eigen::Matrix<double, 12, Eigen::Dynamic>::Zero(12, width));

  // the same evaluation for the base and for every perturbed model: accelerations at mid-interval, and the sensors
  struct Column0 {
    std::vector<Acceleration> acceleration;
    std::vector<Vector12> y;
  };
  const auto evaluate_all = [&](const ForceModel& model, const RotorHistory& history, Column0& result) {
    Evaluator at{model, {}, {}};
    result.acceleration.resize(n), result.y.resize(n);
    for (std::size_t k = 0; k < n; ++k) {
      const Sample& sample = flight.samples[k];
      const std::size_t k1 = k + 1 < n && !flight.samples[k + 1].starts_segment ? k + 1 : k;
      Point middle = x[k];
      middle.position = 0.5 * (x[k].position + x[k1].position);
      middle.velocity = 0.5 * (x[k].velocity + x[k1].velocity);
      middle.attitude = x[k].attitude.slerp(0.5, x[k1].attitude);
      middle.rate = 0.5 * (x[k].rate + x[k1].rate);
      const double t = sample.time_s - flight.start_s;
      result.acceleration[k] = at(middle, t + 0.5 * out.interval_s[k], sample.voltage_V,
                                  mean_of(&history.mean[k * count], history.substeps),
                                  mean_of(&history.acceleration[k * count], history.substeps));
      Vector3 modelled, force = Vector3::Zero();
      if (with_force)
        force = at.specific_force(x[k], t, sample.voltage_V, history.at_sample[k], history.acceleration[k * count], modelled);
      result.y[k] = innovation(sample, predict_sensors(model, flight.motion[k], x[k], t, force,
                                                       flight.motion[k].angular_acceleration_B_radps2));
    }
  };
  Column0 base, moved;
  evaluate_all(forces, rotors, base);
  // a wind is felt only with a drag: at no drag it is tried with one of natural size
  const int drag = catalogue.find("rotor_drag"), area = catalogue.find("quadratic_drag");
  const auto strength = [&](int group) {
    double sum = 0.0;
    if (group >= 0)
      for (const int c : catalogue.groups()[static_cast<std::size_t>(group)].columns) sum += std::abs(value[c]);
    return sum;
  };
  for (Eigen::Index j = 0; j < width; ++j) {
    const int c = out.columns[static_cast<std::size_t>(j)];
    const Column& column = catalogue.columns()[static_cast<std::size_t>(c)];
    if (column.group < 0) {
      for (std::size_t k = 0; k < n; ++k) out.D[k](6 + column.parameter, j) = column.natural;
      continue;
    }
    const Group& group = catalogue.groups()[static_cast<std::size_t>(column.group)];
    if (group.row->name == "saturation") {
      for (std::size_t k = 0; k < flight.limit_change.size(); ++k) out.B[k].col(j) = limit_push(k);
      continue;
    }
    if (group.row->name == "slung_load") {
      if (c == load_column)
        for (std::size_t k = 0; k < n; ++k) out.B[k].col(j) = column.natural * load_push(k);
      continue;
    }
    Eigen::VectorXd from = value, to = value;
    const double step = 1e-3 * column.natural;
    to[c] += step;
    const Column0* reference = &base;
    Column0 companion;
    if (group.row->name == "steady_wind" && drag >= 0 && strength(drag) + strength(area) == 0.0) {
      const int d = catalogue.groups()[static_cast<std::size_t>(drag)].columns.front();
      from[d] = to[d] = catalogue.columns()[static_cast<std::size_t>(d)].natural;
      const ForceModel model = force_model(flight, catalogue, from, flight_index, -1);
      evaluate_all(model, rotors, companion);
      reference = &companion;
    }
    const ForceModel model = force_model(flight, catalogue, to, flight_index, column.group);
    const bool moves_rotors = group.row->place == Place::actuation;
    evaluate_all(model, moves_rotors ? rotor_history(flight, model) : rotors, moved);
    for (std::size_t k = 0; k < n; ++k) {
      const double dt = out.interval_s[k], unit = column.natural / step;
      const Vector3 linear = (moved.acceleration[k].linear_W_mps2 - reference->acceleration[k].linear_W_mps2) * unit;
      const Vector3 angular = (moved.acceleration[k].angular_B_radps2 - reference->acceleration[k].angular_B_radps2) * unit;
      out.B[k].col(j) << 0.5 * dt * dt * linear, dt * linear, 0.5 * dt * dt * angular, dt * angular;
      out.D[k].col(j) = (reference->y[k] - moved.y[k]) * unit;
    }
  }
}

}  // namespace gustlab::diagnosis
