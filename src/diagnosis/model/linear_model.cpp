#include "diagnosis/model/linear_model.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "diagnosis/model/propagation.hpp"
#include "diagnosis/model/speed_comparison.hpp"

namespace gustlab::diagnosis {

namespace {

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
    state.attitude_WB = motion->attitude_WB * exp_rotation(d * motion->body_rate_B_radps +
                                                           0.5 * d * d * motion->angular_acceleration_B_radps2);
    state.body_rate_B_radps = motion->body_rate_B_radps + d * motion->angular_acceleration_B_radps2;
    return state;
  }
};

// what the sensors of the model say at a sample
Measured predict_sensors(const ForceModel& forces, const FlightData& flight, std::size_t k, const Point& x,
                         const Vector3& specific_force, const Vector3& angular_acceleration) {
  const double time_s = flight.samples[k].time_s - flight.start_s;
  const Matrix3 R = x.attitude.toRotationMatrix();
  const Vector3& arm = forces.vehicle().center_of_mass_B_m;
  Measured m;
  m.position_W_m = x.position - R * arm;
  m.velocity_W_mps = x.velocity - R * x.rate.cross(arm);
  m.attitude_WB = x.attitude;
  m.body_rate_B_radps = x.rate - flight.late.rate_s * angular_acceleration;
  m.specific_force_B_mps2 = specific_force;
  SmoothedPast past;
  Motion origin = flight.motion[k];
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

// The body's angular acceleration at every sample: slowly as the smoothed rates say it, quickly as the model says it, whose own
// slow part is taken out with the weights that a local slope of the rates has.
std::vector<Vector3> angular_acceleration(const FlightData& flight, const std::vector<Vector3>& modelled) {
  const auto half = static_cast<std::ptrdiff_t>(std::floor(rate_half_window_s(flight) / flight.sample_s));
  const auto size = static_cast<std::ptrdiff_t>(modelled.size());
  std::vector<Vector3> result(modelled.size());
  for (std::ptrdiff_t k = 0; k < size; ++k) {
    Vector3 sum = Vector3::Zero();
    double weights = 0.0;
    for (std::ptrdiff_t j = std::max<std::ptrdiff_t>(0, k - half); j <= std::min(size - 1, k + half); ++j) {
      const double weight = 1.0 - static_cast<double>((j - k) * (j - k)) / static_cast<double>(half * (half + 1));
      sum += weight * modelled[static_cast<std::size_t>(j)];
      weights += weight;
    }
    const auto at = static_cast<std::size_t>(k);
    result[at] = flight.motion[at].angular_acceleration_B_radps2 + modelled[at] - sum / weights;
  }
  return result;
}

// what an accelerometer behind its filter shows of the force on it
std::vector<Vector3> shown_late(const FlightData& flight, const std::vector<Vector3>& force) {
  if (flight.late.force_s == 0.0) return force;
  std::vector<Vector3> shown = force;
  for (std::size_t k = 0; k < force.size(); ++k) {
    const double felt_s = flight.samples[k].time_s - flight.late.force_s;
    std::size_t j = k;
    while (j > 0 && !flight.samples[j].starts_segment && flight.samples[j].time_s > felt_s) --j;
    if (j == k || flight.samples[j].time_s > felt_s) continue;
    const double part = (felt_s - flight.samples[j].time_s) / (flight.samples[j + 1].time_s - flight.samples[j].time_s);
    shown[k] = (1.0 - part) * force[j] + part * force[j + 1];
  }
  return shown;
}

// accelerations at mid-interval along a flight
std::vector<Acceleration> mid_interval(const FlightData& flight, const ForceModel& forces,
                                       const RotorHistory& history) {
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

std::vector<std::vector<Push>> limit_changes(const FlightData& flight, int flight_index, const Catalogue& catalogue,
                                             const Eigen::VectorXd& value, const std::vector<double>& limits_radps) {
  const ForceModel free = force_model(flight, catalogue, value, flight_index, -1);
  const auto before = mid_interval(flight, free, rotor_history(flight, free));
  FlightData limited = flight;
  std::vector<std::vector<Push>> changes;
  for (const double limit_radps : limits_radps) {
    limited.vehicle.max_speed_radps = limit_radps;
    const ForceModel bound = force_model(limited, catalogue, value, flight_index, -1);
    const auto after = mid_interval(limited, bound, rotor_history(limited, bound));
    std::vector<Push>& change = changes.emplace_back(before.size());
    for (std::size_t k = 0; k < change.size(); ++k)
      change[k] << after[k].linear_W_mps2 - before[k].linear_W_mps2,
          after[k].angular_B_radps2 - before[k].angular_B_radps2;
  }
  return changes;
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
  out.forces_alone =
      flight.collective_only && std::none_of(flight.samples.begin(), flight.samples.end(), [](const Sample& s) {
        return (s.channels & (has_position | has_velocity | has_attitude)) != 0;
      });
  out.F.resize(n), out.b.resize(n), out.interval_s.resize(n), out.starts.resize(n), out.measured.resize(n);
  out.y.resize(n), out.R_WB.resize(n), out.force_rows.resize(n);

  std::vector<Point> x(n);
  for (std::size_t k = 0; k < n; ++k) x[k] = center_of_mass(flight.motion[k], arm);
  Evaluator evaluate{forces, {}, {}};

  // an accelerometer away from the middle feels how the body turns, and a late gyro tells how it turned
  const bool quick_turning = (with_force || flight.late.rate_s > 0.0) && out.torque_known;
  std::vector<Vector3> turning(n), force(n, Vector3::Zero());
  for (std::size_t k = 0; k < n; ++k) {
    Vector3 modelled = turning[k] = flight.motion[k].angular_acceleration_B_radps2;
    if (quick_turning || with_force)
      force[k] = evaluate.specific_force(x[k], flight.samples[k].time_s - flight.start_s, flight.samples[k].voltage_V,
                                         rotors.at_sample[k], rotors.acceleration[k * count], modelled);
    if (quick_turning) turning[k] = modelled;
  }
  if (quick_turning) turning = angular_acceleration(flight, turning);
  const std::vector<Vector3> shown = shown_late(flight, force);

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
    Vector3 modelled;
    if (with_force && need_F)
      for (int i = 0; i < 9; ++i) {
        const double step = steps[static_cast<std::size_t>(i / 3 + 1)];
        out.force_rows[k].col(i) = (evaluate.specific_force(x[k].plus(i + 3, step), t, sample.voltage_V,
                                                            rotors.at_sample[k], rise[0], modelled) -
                                    force[k]) /
                                   step;
      }
    out.y[k] = innovation(sample, predict_sensors(forces, flight, k, x[k], shown[k], turning[k]));
  }

  // a slung load, a lower speed limit and unforetold commands are histories: accelerations per unit of a column
  struct History {
    int column;
    std::function<Push(std::size_t)> push;
  };
  std::vector<History> histories;
  const auto add_history = [&](std::string_view name, bool suspected, std::function<Push(std::size_t)> push) {
    const int g = catalogue.find(name);
    if (!suspected || g < 0 || catalogue.groups()[static_cast<std::size_t>(g)].columns.empty()) return;
    histories.push_back({catalogue.groups()[static_cast<std::size_t>(g)].columns.front(), std::move(push)});
  };
  add_history("slung_load", !flight.load_force_W_mps2.empty(), [&](std::size_t k) {
    Push push;
    push << flight.load_force_W_mps2[k] / forces.vehicle().mass_kg, Vector3::Zero();
    return push;
  });
  add_history("saturation", !flight.limit_change.empty(), [&](std::size_t k) { return flight.limit_change[k]; });
  for (int c = 0; c < catalogue.size() && !flight.surprise.empty(); ++c) {
    const Column& column = catalogue.columns()[static_cast<std::size_t>(c)];
    if (!column.of_surprise()) continue;
    const int p = column.parameter - command_surprise_of;
    histories.push_back({c, [&, p](std::size_t k) {
                           Push push = Push::Zero();
                           if (p % 4 < 3) push[3 + p % 4] = flight.surprise[k][p];
                           else push.head<3>() = flight.surprise[k][p] * out.R_WB[k].col(2);
                           return push;
                         }});
  }
  for (const History& history : histories)
    for (std::size_t k = 0; k < n && value[history.column] != 0.0; ++k) {
      const Push push = value[history.column] * history.push(k);
      if (!out.b[k].isZero(0.0)) out.b[k] += moved_by(push, out.interval_s[k]);
      out.y[k].tail<3>() -= felt(push, out.R_WB[k]);
    }

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
  const auto evaluate_all = [&](const ForceModel& model, const RotorHistory& history, bool sensors, Column0& result) {
    Evaluator at{model, {}, {}};
    result.acceleration.resize(n), result.y.resize(sensors ? n : 0);
    std::vector<Vector3> felt_now(n, Vector3::Zero());
    for (std::size_t k = 0; k < n; ++k) {
      const Sample& sample = flight.samples[k];
      const std::size_t k1 = k + 1 < n && !flight.samples[k + 1].starts_segment ? k + 1 : k;
      Point middle = x[k];
      middle.position = 0.5 * (x[k].position + x[k1].position);
      middle.velocity = 0.5 * (x[k].velocity + x[k1].velocity);
      middle.attitude = x[k].attitude.slerp(0.5, x[k1].attitude);
      middle.rate = 0.5 * (x[k].rate + x[k1].rate);
      const double t = sample.time_s - flight.start_s;
      result.acceleration[k] =
          at(middle, t + 0.5 * out.interval_s[k], sample.voltage_V, mean_of(&history.mean[k * count], history.substeps),
             mean_of(&history.acceleration[k * count], history.substeps));
      Vector3 modelled;
      if (with_force)
        felt_now[k] = at.specific_force(x[k], t, sample.voltage_V, history.at_sample[k],
                                        history.acceleration[k * count], modelled);
    }
    if (!sensors) return;
    felt_now = shown_late(flight, felt_now);
    for (std::size_t k = 0; k < n; ++k)
      result.y[k] = innovation(flight.samples[k], predict_sensors(model, flight, k, x[k], felt_now[k], turning[k]));
  };
  Column0 base, moved;
  evaluate_all(forces, rotors, true, base);
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
    const auto history =
        std::find_if(histories.begin(), histories.end(), [c](const History& h) { return h.column == c; });
    if (history != histories.end())
      for (std::size_t k = 0; k < n; ++k) {
        const Push push = column.natural * history->push(k);
        out.B[k].col(j) = moved_by(push, out.interval_s[k]);
        out.D[k].col(j).tail<3>() = felt(push, out.R_WB[k]);
      }
    if (column.group < 0) {
      for (std::size_t k = 0; k < n && column.parameter < torque_trim; ++k)
        out.D[k](6 + column.parameter, j) = column.natural;
      continue;
    }
    const Group& group = catalogue.groups()[static_cast<std::size_t>(column.group)];
    if (is_history(group.row->name)) continue;
    Eigen::VectorXd from = value, to = value;
    // forces alone see rotors at the samples (where no mean of rows is taken), and quick ones are there already: a lag as long as a substep is tried
    const bool at_sample_alone = out.forces_alone && !flight.read_slower && group.row->name == "motor_lag";
    const double step =
        std::max(1e-3 * column.natural, at_sample_alone ? flight.sample_s / flight.substeps - value[c] : 0.0);
    to[c] += step;
    const Column0* reference = &base;
    Column0 companion;
    if (group.row->name == "steady_wind" && drag >= 0 && strength(drag) + strength(area) == 0.0) {
      const int d = catalogue.groups()[static_cast<std::size_t>(drag)].columns.front();
      from[d] = to[d] = catalogue.columns()[static_cast<std::size_t>(d)].natural;
      const ForceModel model = force_model(flight, catalogue, from, flight_index, -1);
      evaluate_all(model, rotors, true, companion);
      reference = &companion;
    }
    const ForceModel model = force_model(flight, catalogue, to, flight_index, column.group);
    const Place place = group.row->place;
    // forces alone change what an accelerometer shows, and no other sensor
    const bool sensors = with_force || place == Place::body || place == Place::measurement;
    evaluate_all(model, place == Place::actuation ? rotor_history(flight, model) : rotors, sensors, moved);
    for (std::size_t k = 0; k < n; ++k) {
      const double unit = column.natural / step;
      Push push;
      push << moved.acceleration[k].linear_W_mps2 - reference->acceleration[k].linear_W_mps2,
          moved.acceleration[k].angular_B_radps2 - reference->acceleration[k].angular_B_radps2;
      out.B[k].col(j) = moved_by(unit * push, out.interval_s[k]);
      if (sensors) out.D[k].col(j) = (reference->y[k] - moved.y[k]) * unit;
    }
  }
  compare_speeds(flight, flight_index, catalogue, value, out);
}

}  // namespace gustlab::diagnosis
