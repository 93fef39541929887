#include "diagnosis/model/linear_model.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "diagnosis/model/propagation.hpp"
#include "diagnosis/model/speed_comparison.hpp"
#include "util/parallel.hpp"

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
// slow part is taken out with the weights that a local slope of the rates has: of slope Σ w i y_i / Σ w i², where y sums up the
// accelerations, that of the jth is the sum of w i from j on.
std::vector<Vector3> angular_acceleration(const FlightData& flight, const std::vector<Vector3>& modelled) {
  const double half_s = rate_half_window_s(flight);
  const auto half = static_cast<std::ptrdiff_t>(std::floor(half_s / flight.sample_s));
  const auto size = static_cast<std::ptrdiff_t>(modelled.size());
  std::vector<double> weight(static_cast<std::size_t>(half) + 1, 0.0);
  double beyond = 0.0;
  for (std::size_t i = weight.size(); i-- > 0;) {
    const double own = tricube(static_cast<double>(i) * flight.sample_s / half_s) * static_cast<double>(i);
    weight[i] = beyond + 0.5 * own;
    beyond += own;
  }
  std::vector<Vector3> result(modelled.size());
  for (std::ptrdiff_t k = 0; k < size; ++k) {
    Vector3 sum = Vector3::Zero();
    double weights = 0.0;
    for (std::ptrdiff_t j = std::max<std::ptrdiff_t>(0, k - half); j <= std::min(size - 1, k + half); ++j) {
      const double w = weight[static_cast<std::size_t>(std::abs(j - k))];
      sum += w * modelled[static_cast<std::size_t>(j)];
      weights += w;
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

// accelerations at mid-interval and what the sensors say, of the model or of one that is perturbed
struct Evaluation {
  std::vector<Acceleration> acceleration;
  std::vector<Vector12> y;
};

// accelerations per unit of a column, per sample: a slung load, a lower speed limit, commands that nothing predicts
struct History {
  int column;
  std::function<SpatialAcceleration(std::size_t)> acceleration;
};

// One flight, linearised at given values.
class Lineariser {
 public:
  Lineariser(const FlightData& flight, int flight_index, const Catalogue& catalogue, const Eigen::VectorXd& value,
             LinearFlight& out)
      : flight_(flight),
        index_(flight_index),
        catalogue_(catalogue),
        value_(value),
        out_(out),
        forces_(force_model(flight, catalogue, value, flight_index, -1)),
        rotors_(rotor_history(flight, forces_)),
        count_(static_cast<std::size_t>(rotors_.substeps)),
        with_force_(std::any_of(flight.samples.begin(), flight.samples.end(),
                                [](const Sample& s) { return (s.channels & has_force) != 0; })) {
    const std::size_t n = flight.samples.size();
    need_F_ = out.F.size() != n;
    out.center_of_mass_B_m = forces_.vehicle().center_of_mass_B_m;
    out.torque_known = !flight.collective_only;
    out.forces_alone =
        flight.collective_only && std::none_of(flight.samples.begin(), flight.samples.end(), [](const Sample& s) {
          return (s.channels & (has_position | has_velocity | has_attitude)) != 0;
        });
    out.F.resize(n), out.b.resize(n), out.interval_s.resize(n), out.starts.resize(n), out.measured.resize(n);
    out.y.resize(n), out.R_WB.resize(n), out.force_rows.resize(n);
    for (std::size_t k = 0; k < n; ++k) x_.push_back(center_of_mass(flight.motion[k], out.center_of_mass_B_m));
  }

  // `wanted`: columns to differentiate; none: those that are there stay
  void run(const std::vector<int>* wanted, int jobs) {
    feel();
    Evaluator evaluate{forces_, {}, {}};
    for (std::size_t k = 0; k < x_.size(); ++k) {
      predict(evaluate, k);
      observe(evaluate, k);
    }
    find_histories();
    take_histories_in();
    if (wanted) differentiate(*wanted, jobs);
  }

 private:
  double time_s(std::size_t k) const { return flight_.samples[k].time_s - flight_.start_s; }
  const RotorArray* speed(std::size_t k) const { return &rotors_.mean[k * count_]; }
  const RotorArray* rise(std::size_t k) const { return &rotors_.acceleration[k * count_]; }

  // What the accelerometer feels and how the body turns: one that is away from the middle feels that, and a late gyro shows how
  // it turned.
  void feel() {
    const std::size_t n = x_.size();
    const bool quick_rotation = (with_force_ || flight_.late.rate_s > 0.0) && out_.torque_known;
    angular_acceleration_.resize(n), force_.assign(n, Vector3::Zero());
    Evaluator evaluate{forces_, {}, {}};
    for (std::size_t k = 0; k < n; ++k) {
      Vector3 modelled = angular_acceleration_[k] = flight_.motion[k].angular_acceleration_B_radps2;
      if (quick_rotation || with_force_)
        force_[k] =
            evaluate.specific_force(x_[k], time_s(k), flight_.samples[k].voltage_V, rotors_.at_sample[k], modelled);
      if (quick_rotation) angular_acceleration_[k] = modelled;
    }
    if (quick_rotation) angular_acceleration_ = angular_acceleration(flight_, angular_acceleration_);
    shown_ = shown_late(flight_, force_);
  }

  // the next sample, and how it depends on this one
  void predict(Evaluator& evaluate, std::size_t k) {
    const Sample& sample = flight_.samples[k];
    const bool last = k + 1 == x_.size() || flight_.samples[k + 1].starts_segment;
    const double interval_s = last ? flight_.sample_s : flight_.samples[k + 1].time_s - sample.time_s;
    out_.interval_s[k] = interval_s;
    out_.starts[k] = sample.starts_segment || sample.saturated;
    out_.R_WB[k] = x_[k].attitude.toRotationMatrix();
    const auto run = [&](const Point& from) {
      return propagate(evaluate, from, time_s(k), interval_s, sample.voltage_V, rotors_.substeps, speed(k), rise(k));
    };
    const Point next = run(x_[k]);
    out_.b[k] = last ? Vector12::Zero() : (out_.torque_known ? next : turned_as_recorded(next, k)).minus(x_[k + 1]);
    for (int i = 0; need_F_ && i < error_size; ++i)
      out_.F[k].col(i) = run(x_[k].plus(i, step_of(i))).minus(next) / step_of(i);
  }

  // Of torques that nobody knows: the body turns by the mean of its recorded rates. With that of this sample alone attitudes would come half an
  // interval early, and a pose would seem late by as much.
  Point turned_as_recorded(Point next, std::size_t k) const {
    next.attitude = x_[k].attitude * exp_rotation(0.5 * out_.interval_s[k] * (x_[k].rate + x_[k + 1].rate));
    return next;
  }

  // what the sensors say beyond what the model says, and how an accelerometer depends on the motion
  void observe(Evaluator& evaluate, std::size_t k) {
    const Sample& sample = flight_.samples[k];
    const unsigned c = sample.channels;
    out_.measured[k] << Eigen::Vector3i::Constant((c & (has_position | has_velocity)) != 0).cast<bool>(),
        Eigen::Vector3i::Constant((c & has_attitude) != 0).cast<bool>(),
        Eigen::Vector3i::Constant((c & has_rate) != 0).cast<bool>(),
        Eigen::Vector3i::Constant((c & has_force) != 0).cast<bool>();
    Vector3 modelled;
    for (int i = 0; with_force_ && need_F_ && i < 9; ++i)
      out_.force_rows[k].col(i) = (evaluate.specific_force(x_[k].plus(i + 3, step_of(i + 3)), time_s(k),
                                                           sample.voltage_V, rotors_.at_sample[k], modelled) -
                                   force_[k]) /
                                  step_of(i + 3);
    out_.y[k] = innovation(sample, predict_sensors(forces_, flight_, k, x_[k], shown_[k], angular_acceleration_[k]));
  }

  // finite-difference steps of the error state
  static double step_of(int i) { return i / 3 % 2 == 0 ? 1e-4 : 1e-3; }

  void find_histories() {
    const auto add = [&](ColumnFrom column, bool suspected,
                         std::function<SpatialAcceleration(std::size_t)> acceleration) {
      const int g = catalogue_.find(column);
      if (!suspected || g < 0) return;
      histories_.push_back({catalogue_.group(g).columns.front(), std::move(acceleration)});
    };
    add(ColumnFrom::swing, !flight_.load_force_W_mps2.empty(), [&](std::size_t k) {
      SpatialAcceleration acceleration;
      acceleration << flight_.load_force_W_mps2[k] / forces_.vehicle().mass_kg, Vector3::Zero();
      return acceleration;
    });
    add(ColumnFrom::speed_limit, !flight_.limit_change.empty(), [&](std::size_t k) { return flight_.limit_change[k]; });
    for (int c = 0; c < catalogue_.size() && out_.torque_known; ++c) {
      const Column& column = catalogue_.column(c);
      if (column.flight != index_ || !column.of_torque_trim()) continue;
      histories_.push_back({c, [axis = column.parameter - torque_trim](std::size_t) {
                              return SpatialAcceleration(SpatialAcceleration::Unit(3 + axis));
                            }});
    }
    for (int c = 0; c < catalogue_.size() && !flight_.command_innovation.empty(); ++c) {
      const Column& column = catalogue_.column(c);
      if (!column.of_command_innovation() && !column.of_loop_between()) continue;
      const int p = column.parameter - command_innovation_of;
      histories_.push_back({c, [&, p, between = column.of_loop_between()](std::size_t k) {
                              SpatialAcceleration acceleration = SpatialAcceleration::Zero();
                              if (between) acceleration[3 + p % 2] = flight_.command_innovation[k][p];
                              else if (p % 4 < 3) acceleration[3 + p % 4] = flight_.command_innovation[k][p];
                              else acceleration.head<3>() = flight_.command_innovation[k][p] * out_.R_WB[k].col(2);
                              return acceleration;
                            }});
    }
  }

  // histories at their values are part of the model
  void take_histories_in() {
    for (const History& history : histories_) {
      if (value_[history.column] == 0.0) continue;
      const std::vector<Vector3> shown = shown_of(history, value_[history.column]);
      for (std::size_t k = 0; k < x_.size(); ++k) {
        const SpatialAcceleration acceleration = value_[history.column] * history.acceleration(k);
        if (!out_.b[k].isZero(0.0)) out_.add_moved_by(acceleration, k, out_.b[k]);
        out_.y[k].tail<3>() -= shown[k];
      }
    }
  }

  // what the accelerometer shows of a history of this size
  std::vector<Vector3> shown_of(const History& history, double size) const {
    std::vector<Vector3> now(x_.size());
    for (std::size_t k = 0; k < now.size(); ++k) now[k] = felt(size * history.acceleration(k), out_.R_WB[k]);
    return shown_late(flight_, now);
  }

  // where the vehicle is halfway to the next sample
  std::vector<Point> middles() const {
    std::vector<Point> middle = x_;
    for (std::size_t k = 0; k + 1 < x_.size(); ++k)
      if (!flight_.samples[k + 1].starts_segment) middle[k] = halfway(x_[k], x_[k + 1]);
    return middle;
  }

  // speeds and accelerations of the rotors to the next sample
  struct Means {
    std::vector<RotorArray> speed, acceleration;
  };
  Means means_of(const RotorHistory& history) const {
    Means means;
    for (std::size_t k = 0; k < x_.size(); ++k) {
      means.speed.push_back(mean_of(&history.mean[k * count_], history.substeps));
      means.acceleration.push_back(mean_of(&history.acceleration[k * count_], history.substeps));
    }
    return means;
  }

  // the same evaluation for the model and for every perturbed one
  Evaluation evaluate(const ForceModel& model, const RotorHistory& history, const Means& means, bool sensors) const {
    const std::size_t n = x_.size();
    Evaluation result;
    result.acceleration.resize(n), result.y.resize(sensors ? n : 0);
    Evaluator at{model, {}, {}};
    std::vector<Vector3> felt_now(n, Vector3::Zero());
    for (std::size_t k = 0; k < n; ++k) {
      const Sample& sample = flight_.samples[k];
      result.acceleration[k] =
          at(middle_[k], time_s(k) + 0.5 * out_.interval_s[k], sample.voltage_V, means.speed[k], means.acceleration[k]);
      Vector3 modelled;
      if (with_force_)
        felt_now[k] = at.specific_force(x_[k], time_s(k), sample.voltage_V, history.at_sample[k], modelled);
    }
    if (!sensors) return result;
    felt_now = shown_late(flight_, felt_now);
    for (std::size_t k = 0; k < n; ++k)
      result.y[k] = innovation(flight_.samples[k],
                               predict_sensors(model, flight_, k, x_[k], felt_now[k], angular_acceleration_[k]));
    return result;
  }

  void differentiate(const std::vector<int>& wanted, int jobs) {
    const std::size_t n = x_.size();
    out_.columns.clear(), out_.sensed.clear();
    for (const int c : wanted) {
      const Column& column = catalogue_.column(c);
      if (column.flight >= 0 && column.flight != index_) continue;
      if (changes_sensors(column)) out_.sensed.push_back(std::ssize(out_.columns));
      out_.columns.push_back(c);
    }
    const auto width = static_cast<Eigen::Index>(out_.columns.size());
    assign_zero(out_.acceleration_by, n, width), assign_zero(out_.felt_by, n, width);
    assign_zero(out_.sensed_by, n, std::ssize(out_.sensed));
    middle_ = middles();
    means_ = means_of(rotors_);
    base_ = evaluate(forces_, rotors_, means_, true);
    parallel_for(width, jobs, [&](std::int64_t j) {
      const int c = out_.columns[static_cast<std::size_t>(j)];
      const Column& column = catalogue_.column(c);
      const auto history =
          std::find_if(histories_.begin(), histories_.end(), [c](const History& h) { return h.column == c; });
      if (history != histories_.end()) push_column(j, column, *history);
      if (column.group >= 0) {
        if (!catalogue_.group(column.group).row->is_history()) perturb(j, c);
        return;
      }
      for (std::size_t k = 0; k < n && column.parameter < torque_trim; ++k) {
        const int row = 6 + column.parameter;
        (row < first_force_row ? out_.sensed_by[k](row, sensed_at(j)) : out_.felt_by[k](row - first_force_row, j)) =
            column.natural;
      }
    });
  }

  template <class Changes>
  static void assign_zero(Changes& changes, std::size_t samples, Eigen::Index width) {
    using Matrix = typename Changes::value_type;
    changes.assign(samples, Matrix::Zero(Matrix::RowsAtCompileTime, width));
  }

  // forces change what an accelerometer shows, and no other sensor
  bool changes_sensors(const Column& column) const {
    if (column.group < 0) return 6 + column.parameter < first_force_row;
    const Place place = catalogue_.group(column.group).row->place;
    return place == Place::body || place == Place::measurement;
  }

  // of column j among those that change sensors
  Eigen::Index sensed_at(Eigen::Index j) const {
    return std::ranges::lower_bound(out_.sensed, j) - out_.sensed.begin();
  }

  void push_column(Eigen::Index j, const Column& column, const History& history) {
    const std::vector<Vector3> shown = shown_of(history, column.natural);
    for (std::size_t k = 0; k < x_.size(); ++k) {
      out_.acceleration_by[k].col(j) = column.natural * history.acceleration(k);
      out_.felt_by[k].col(j) = shown[k];
    }
  }

  // column j by perturbing the forward model in parameter c
  void perturb(Eigen::Index j, int c) {
    const Column& column = catalogue_.column(c);
    const EffectRow& row = *catalogue_.group(column.group).row;
    Eigen::VectorXd to = value_;
    // forces alone see rotors at the samples (where no mean of rows is taken), and quick ones are there already: a lag as long as a
    // substep is tried
    const bool at_sample_alone = out_.forces_alone && !flight_.read_slower && row.latency == Latency::lag;
    const double step =
        std::max(1e-3 * column.natural, at_sample_alone ? flight_.sample_s / flight_.substeps - value_[c] : 0.0);
    to[c] += step;
    const Evaluation* reference = &base_;
    Evaluation companion;
    if (const int drag = catalogue_.find(Airflow::drag); row.air == Airflow::wind && drag >= 0 && !dragged()) {
      // a wind is felt only with a drag: at no drag it is tried with one of natural size
      const int d = catalogue_.group(drag).columns.front();
      Eigen::VectorXd from = value_;
      from[d] = to[d] = catalogue_.column(d).natural;
      companion = evaluate(force_model(flight_, catalogue_, from, index_, -1), rotors_, means_, true);
      reference = &companion;
    }
    const ForceModel model = force_model(flight_, catalogue_, to, index_, column.group);
    const bool sensors = with_force_ || changes_sensors(column);
    const auto moved_by_commands = [&] {
      const RotorHistory history = rotor_history(flight_, model);
      return evaluate(model, history, means_of(history), sensors);
    };
    const Evaluation moved =
        row.place == Place::actuation ? moved_by_commands() : evaluate(model, rotors_, means_, sensors);
    const double unit = column.natural / step;
    const Eigen::Index sensed = changes_sensors(column) ? sensed_at(j) : -1;
    for (std::size_t k = 0; k < x_.size(); ++k) {
      SpatialAcceleration acceleration;
      acceleration << moved.acceleration[k].linear_W_mps2 - reference->acceleration[k].linear_W_mps2,
          moved.acceleration[k].angular_B_radps2 - reference->acceleration[k].angular_B_radps2;
      out_.acceleration_by[k].col(j) = unit * acceleration;
      if (!sensors) continue;
      const Vector12 shown = (reference->y[k] - moved.y[k]) * unit;
      out_.felt_by[k].col(j) = shown.tail<3>();
      if (sensed >= 0) out_.sensed_by[k].col(sensed) = shown.head<first_force_row>();
    }
  }

  bool dragged() const {
    return std::any_of(catalogue_.groups().begin(), catalogue_.groups().end(), [&](const Group& group) {
      return group.row->air == Airflow::drag &&
             std::any_of(group.columns.begin(), group.columns.end(), [&](int c) { return value_[c] != 0.0; });
    });
  }

  const FlightData& flight_;
  const int index_;
  const Catalogue& catalogue_;
  const Eigen::VectorXd& value_;
  LinearFlight& out_;
  const ForceModel forces_;
  const RotorHistory rotors_;
  const std::size_t count_;  // substeps of a sample
  const bool with_force_;    // some sample has an accelerometer
  bool need_F_ = false;
  std::vector<Point> x_, middle_;
  Means means_;
  std::vector<Vector3> angular_acceleration_, force_, shown_;
  std::vector<History> histories_;
  Evaluation base_;
};

}  // namespace

std::vector<std::vector<SpatialAcceleration>> limit_changes(const FlightData& flight, int flight_index,
                                                            const Catalogue& catalogue, const Eigen::VectorXd& value,
                                                            const std::vector<double>& limits_radps) {
  const ForceModel free = force_model(flight, catalogue, value, flight_index, -1);
  const auto before = mid_interval(flight, free, rotor_history(flight, free));
  FlightData limited = flight;
  std::vector<std::vector<SpatialAcceleration>> changes;
  for (const double limit_radps : limits_radps) {
    limited.vehicle.max_speed_radps = limit_radps;
    const ForceModel bound = force_model(limited, catalogue, value, flight_index, -1);
    const auto after = mid_interval(limited, bound, rotor_history(limited, bound));
    std::vector<SpatialAcceleration>& change = changes.emplace_back(before.size());
    for (std::size_t k = 0; k < change.size(); ++k)
      change[k] << after[k].linear_W_mps2 - before[k].linear_W_mps2,
          after[k].angular_B_radps2 - before[k].angular_B_radps2;
  }
  return changes;
}

void linearise(const FlightData& flight, int flight_index, const Catalogue& catalogue, const Eigen::VectorXd& value,
               const std::vector<int>& wanted, LinearFlight& out, int jobs) {
  Lineariser(flight, flight_index, catalogue, value, out).run(&wanted, jobs);
  compare_speeds(flight, flight_index, catalogue, value, out);
}

void predict_again(const FlightData& flight, int flight_index, const Catalogue& catalogue, const Eigen::VectorXd& value,
                   LinearFlight& out) {
  Lineariser(flight, flight_index, catalogue, value, out).run(nullptr, 1);
  compare_speeds_again(flight, flight_index, catalogue, value, out);
}

}  // namespace gustlab::diagnosis
