#include "diagnosis/estimation/shooting.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>

#include "diagnosis/model/command_innovation.hpp"
#include "diagnosis/model/propagation.hpp"
#include "util/parallel.hpp"
#include "util/quantiles.hpp"

namespace gustlab::diagnosis {

namespace {

// Columns that were filtered differently do not agree: a velocity is not quite the derivative of its position. Of the two the
// faster one is predicted, where it was recorded: velocity (else position), body rate (else attitude).
constexpr int rows_per_horizon = 6;
constexpr auto window_rows = static_cast<Eigen::Index>(shooting_horizon_s.size()) * rows_per_horizon;

Eigen::Index torque_row(Eigen::Index horizon, int axis) { return horizon * rows_per_horizon + 3 + axis; }

// an effect this many times its natural size is not yet absurd
constexpr double loose_prior = 20.0;
// standard deviations beyond which a window counts no more; share of each row's noise that is its own
constexpr double clearly_lost = 3.0, own_share = 0.05;

struct Window {
  std::size_t start;
  std::array<std::size_t, shooting_horizon_s.size()> at;
};

std::vector<Window> windows_of(const FlightData& flight, double spacing_s) {
  std::vector<Window> windows;
  const auto length = static_cast<std::size_t>(std::lround(shooting_horizon_s.back() / flight.sample_s));
  const auto spacing = static_cast<std::size_t>(std::lround(spacing_s / flight.sample_s));
  for (std::size_t k = length; k + 2 * length < flight.samples.size(); k += spacing) {
    bool whole = true;
    for (std::size_t j = k + 1; j <= k + length; ++j)
      whole = whole && !flight.samples[j].starts_segment && !flight.samples[j].saturated;
    if (!whole) continue;
    Window w{k, {}};
    for (std::size_t h = 0; h < w.at.size(); ++h)
      w.at[h] =
          k + std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(shooting_horizon_s[h] / flight.sample_s)));
    windows.push_back(w);
  }
  return windows;
}

// a flight as the nuisances and sensor effects of the moment read it
struct Reading {
  FlightData flight;
  Vector3 trim_B_radps2 = Vector3::Zero();

  Reading(const FlightData& recorded, int index, const Catalogue& catalogue, const Eigen::VectorXd& value)
      : flight(recorded) {
    smooth_motion(flight, catalogue.sensor_correction(value, index));
    trim(index, catalogue, value);
  }
  // From another reading, whose motion is smoothed anew only where sensor effects differ.
  Reading(const Reading& other, const FlightData& recorded, int index, const Catalogue& catalogue,
          const Eigen::VectorXd& value)
      : flight(other.flight) {
    flight.commands = recorded.commands;
    flight.measured_speed = recorded.measured_speed;
    const SensorCorrection correction = catalogue.sensor_correction(value, index);
    if (correction != flight.corrected) smooth_motion(flight, correction);
    trim(index, catalogue, value);
  }

 private:
  void trim(int index, const Catalogue& catalogue, const Eigen::VectorXd& value) {
    double clock_s = 0.0, smoothing_s2 = 0.0;
    for (int c = 0; c < catalogue.size(); ++c) {
      const Column& column = catalogue.column(c);
      if (column.group >= 0 || column.flight != index || column.parameter < torque_trim) continue;
      if (column.parameter == command_clock) clock_s = value[c];
      else if (column.parameter == command_smoothing) smoothing_s2 = value[c];
      else trim_B_radps2[column.parameter - torque_trim] = value[c];
    }
    for (CommandRecord* record : {&flight.commands, &flight.measured_speed})
      record->delay(clock_s), record->smooth(smoothing_s2);
  }
};

// What is predicted over one sample interval of a window, at its middle: forces see the recorded attitude, torques the recorded velocity.
struct Stride {
  std::size_t sample;
  double interval_s;
  Point moves, turns;
};

// Measured ⊟ predicted at every horizon of every window. `strides`: the intervals that led there, of all windows in turn.
Eigen::MatrixXd residuals(const Reading& reading, const ForceModel& forces, const RotorHistory& rotors,
                          const std::vector<Window>& windows, int jobs = 1, std::vector<Stride>* strides = nullptr) {
  const FlightData& flight = reading.flight;
  Eigen::MatrixXd out(window_rows, static_cast<Eigen::Index>(windows.size()));
  const auto count = static_cast<std::size_t>(rotors.substeps);
  const Vector3 arm = forces.vehicle().center_of_mass_B_m;
  const std::size_t length = windows.empty() ? 0 : windows.front().at.back() - windows.front().start;
  if (strides) strides->resize(windows.size() * length);
  parallel_for(std::ssize(windows), jobs, [&](std::int64_t w) {
    const Window& window = windows[static_cast<std::size_t>(w)];
    Evaluator evaluate{forces, {}, {}, reading.trim_B_radps2};
    // a smoothed record is nearer the truth than half a second of open loop: forces see the recorded attitude, torques
    // the recorded velocity, and neither is charged with the other's errors
    Point moves = center_of_mass(flight.motion[window.start], arm), turns = moves;
    std::size_t k = window.start;
    for (std::size_t h = 0; h < window.at.size(); ++h) {
      for (; k < window.at[h]; ++k) {
        const Sample& sample = flight.samples[k];
        const double interval_s = flight.samples[k + 1].time_s - sample.time_s;
        const auto run = [&](const Point& from) {
          return propagate(evaluate, from, sample.time_s - flight.start_s, interval_s, sample.voltage_V,
                           rotors.substeps, &rotors.mean[k * count], &rotors.acceleration[k * count]);
        };
        const Point recorded = center_of_mass(flight.motion[k + 1], arm), moved = run(moves), turned = run(turns);
        if (strides)
          (*strides)[static_cast<std::size_t>(w) * length + k - window.start] = {k, interval_s, halfway(moves, moved),
                                                                                 halfway(turns, turned)};
        moves = {moved.position, moved.velocity, recorded.attitude, recorded.rate};
        turns = {recorded.position, recorded.velocity, turned.attitude, turned.rate};
      }
      const Vector12 missed = center_of_mass(flight.motion[k], arm)
                                  .minus(Point{moves.position, moves.velocity, turns.attitude, turns.rate});
      const unsigned seen = flight.samples[k].channels;
      out.block<rows_per_horizon, 1>(static_cast<Eigen::Index>(h) * rows_per_horizon, w)
          << missed.segment<3>(seen & has_velocity ? 3 : 0),
          // commands that say nothing of torques predict no turn
          flight.collective_only ? Vector3::Zero() : Vector3(missed.segment<3>(seen & has_rate ? 9 : 6));
    }
  });
  return out;
}

// accelerations of a model along the strides: of the centre of mass where it moves, of the body where it turns
std::vector<Acceleration> accelerations(const std::vector<Stride>& strides, const FlightData& flight,
                                        const ForceModel& forces, const RotorHistory& rotors) {
  std::vector<Acceleration> result;
  result.reserve(strides.size());
  const auto count = static_cast<std::size_t>(rotors.substeps);
  Evaluator evaluate{forces, {}, {}};
  for (const Stride& stride : strides) {
    const double time_s = flight.samples[stride.sample].time_s - flight.start_s + 0.5 * stride.interval_s;
    const double voltage_V = flight.samples[stride.sample].voltage_V;
    const RotorArray speed = mean_of(&rotors.mean[stride.sample * count], rotors.substeps);
    const RotorArray rise = mean_of(&rotors.acceleration[stride.sample * count], rotors.substeps);
    result.push_back({evaluate(stride.moves, time_s, voltage_V, speed, rise).linear_W_mps2,
                      flight.collective_only
                          ? Vector3::Zero()
                          : evaluate(stride.turns, time_s, voltage_V, speed, rise).angular_B_radps2});
  }
  return result;
}

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix3x6 = Eigen::Matrix<double, 3, 6>;

// How accelerations along a stride depend on where it is: the linear one on position and velocity, the angular one on attitude and rate.
struct Slopes {
  Matrix3x6 moves = Matrix3x6::Zero(), turns = Matrix3x6::Zero();
};

std::vector<Slopes> slopes_along(const std::vector<Stride>& strides, const FlightData& flight, const ForceModel& forces,
                                 const RotorHistory& rotors, const std::vector<Acceleration>& base) {
  std::vector<Slopes> slopes(strides.size());
  constexpr double step = 1e-4;
  for (int i = 0; i < 6; ++i) {
    std::vector<Stride> beside = strides;
    for (Stride& stride : beside)
      stride.moves = stride.moves.plus(i, step), stride.turns = stride.turns.plus(i + 6, step);
    const auto moved = accelerations(beside, flight, forces, rotors);
    for (std::size_t j = 0; j < slopes.size(); ++j) {
      slopes[j].moves.col(i) = (moved[j].linear_W_mps2 - base[j].linear_W_mps2) / step;
      slopes[j].turns.col(i) = (moved[j].angular_B_radps2 - base[j].angular_B_radps2) / step;
    }
  }
  return slopes;
}

// How much the predictions of every window change by small accelerations along its strides: rows as in `residuals`, to first order (the
// variational equation of both motions, midpoint rule).
class Variation {
 public:
  Variation(const FlightData& flight, const ForceModel& forces, const RotorHistory& rotors,
            const std::vector<Window>& windows, const std::vector<Stride>& strides)
      : flight_(flight),
        windows_(windows),
        strides_(strides),
        base_(accelerations(strides, flight, forces, rotors)),
        slopes_(slopes_along(strides, flight, forces, rotors, base_)) {}

  // of accelerations that another model has instead, per `step`
  Eigen::MatrixXd by(const ForceModel& forces, const RotorHistory& rotors, double step) const {
    std::vector<Acceleration> change = accelerations(strides_, flight_, forces, rotors);
    for (std::size_t j = 0; j < change.size(); ++j) {
      change[j].linear_W_mps2 = (change[j].linear_W_mps2 - base_[j].linear_W_mps2) / step;
      change[j].angular_B_radps2 = (change[j].angular_B_radps2 - base_[j].angular_B_radps2) / step;
    }
    return by(change);
  }

  Eigen::MatrixXd by(const std::vector<Acceleration>& change) const {
    Eigen::MatrixXd out(window_rows, static_cast<Eigen::Index>(windows_.size()));
    std::size_t j = 0;
    for (std::size_t w = 0; w < windows_.size(); ++w) {
      Vector6 moves = Vector6::Zero(), turns = Vector6::Zero();
      std::size_t k = windows_[w].start;
      for (std::size_t h = 0; h < windows_[w].at.size(); ++h) {
        for (; k < windows_[w].at[h]; ++k, ++j) advance(change[j], j, moves, turns);
        const unsigned seen = flight_.samples[k].channels;
        out.block<rows_per_horizon, 1>(static_cast<Eigen::Index>(h) * rows_per_horizon, static_cast<Eigen::Index>(w))
            << moves.segment<3>(seen & has_velocity ? 3 : 0),
            flight_.collective_only ? Vector3::Zero() : Vector3(turns.segment<3>(seen & has_rate ? 3 : 0));
      }
    }
    return out;
  }

 private:
  // the changes of position and velocity and those of attitude (in the axes of the body) and rate over stride j
  void advance(const Acceleration& change, std::size_t j, Vector6& moves, Vector6& turns) const {
    const double h = strides_[j].interval_s;
    const Vector3& rate = strides_[j].turns.rate;
    const auto move = [&](const Vector6& x) {
      Vector6 d;
      d << x.tail<3>(), slopes_[j].moves * x + change.linear_W_mps2;
      return d;
    };
    const auto turn = [&](const Vector6& x) {
      Vector6 d;
      d << x.tail<3>() - rate.cross(x.head<3>()), slopes_[j].turns * x + change.angular_B_radps2;
      return d;
    };
    moves += h * move(moves + 0.5 * h * move(moves));
    turns += h * turn(turns + 0.5 * h * turn(turns));
  }

  const FlightData& flight_;
  const std::vector<Window>& windows_;
  const std::vector<Stride>& strides_;
  const std::vector<Acceleration> base_;
  const std::vector<Slopes> slopes_;
};

// Histories come from scans; a lever shows in an accelerometer only. A gyroscope's scale is told by the attitude (sensor_windows): predictions
// would be best if it read nothing at all.
bool has_no_prediction(const EffectRow& row) {
  return row.is_history() || row.asks(Need::accelerometer) || row.corrects == Corrects::rate_scale;
}

// a flight at one value, and what every window of it misses there
struct Shot {
  std::vector<Window> windows;
  Reading reading;
  ForceModel forces;
  RotorHistory rotors;
  std::vector<Stride> strides;
  Eigen::MatrixXd missed;  // one column per window

  Shot(const FlightData& flight, int index, const Catalogue& catalogue, const Eigen::VectorXd& value, double spacing_s,
       int jobs)
      : windows(windows_of(flight, spacing_s)),
        reading(flight, index, catalogue, value),
        forces(force_model(reading.flight, catalogue, value, index, -1)),
        rotors(rotor_history(reading.flight, forces)),
        missed(residuals(reading, forces, rotors, windows, jobs, &strides)) {}
};

// how the predictions of a shot depend on one column of the catalogue
class Differentiator {
 public:
  Differentiator(const Shot& shot, const FlightData& recorded, int index, const Catalogue& catalogue,
                 const Eigen::VectorXd& value)
      : shot_(shot),
        recorded_(recorded),
        index_(index),
        catalogue_(catalogue),
        value_(value),
        variation_(shot.reading.flight, shot.forces, shot.rotors, shot.windows, shot.strides) {}

  // rows × windows, per natural size; none: predictions do not depend on it
  std::optional<Eigen::MatrixXd> operator()(int c) const {
    const Column& column = catalogue_.column(c);
    const double step = 1e-3 * column.natural;
    Eigen::VectorXd to = value_;
    to[c] += step;
    if (column.group < 0) return of_nuisance(column, to, step);
    const EffectRow& row = *catalogue_.group(column.group).row;
    if (has_no_prediction(row)) return std::nullopt;
    // what moves the record itself is predicted anew
    if (row.place == Place::measurement) return anew(read_at(to), shot_.forces, column, step);
    const FlightData& flight = shot_.reading.flight;
    const ForceModel model = force_model(flight, catalogue_, to, index_, column.group);
    if (model.vehicle().center_of_mass_B_m != shot_.forces.vehicle().center_of_mass_B_m)
      return anew(shot_.reading, model, column, step);
    const RotorHistory moved = row.place == Place::actuation ? rotor_history(flight, model) : RotorHistory{};
    return column.natural * variation_.by(model, row.place == Place::actuation ? moved : shot_.rotors, step);
  }

 private:
  std::optional<Eigen::MatrixXd> of_nuisance(const Column& column, const Eigen::VectorXd& to, double step) const {
    if (column.parameter >= command_clock)
      return column.natural * variation_.by(shot_.forces, rotor_history(read_at(to).flight, shot_.forces), step);
    if (column.parameter >= torque_trim)
      return variation_.by(std::vector<Acceleration>(
          shot_.strides.size(), {Vector3::Zero(), column.natural * Vector3::Unit(column.parameter - torque_trim)}));
    if (column.parameter >= force_bias) return std::nullopt;
    return anew(read_at(to), shot_.forces, column, step);
  }

  Reading read_at(const Eigen::VectorXd& to) const { return {shot_.reading, recorded_, index_, catalogue_, to}; }

  Eigen::MatrixXd anew(const Reading& reading, const ForceModel& forces, const Column& column, double step) const {
    return (shot_.missed - residuals(reading, forces, shot_.rotors, shot_.windows)) * (column.natural / step);
  }

  const Shot& shot_;
  const FlightData& recorded_;
  const int index_;
  const Catalogue& catalogue_;
  const Eigen::VectorXd& value_;
  const Variation variation_;
};

}  // namespace

void shoot_again(const FlightData& flight, int flight_index, const Catalogue& catalogue, const Eigen::VectorXd& value,
                 double spacing_s, ShotFlight& shot, int jobs) {
  const Shot again(flight, flight_index, catalogue, value, spacing_s, jobs);
  for (std::size_t w = 0; w < again.windows.size(); ++w)
    shot.window[w].rightCols<1>() = again.missed.col(static_cast<Eigen::Index>(w));
}

ShotFlight shoot(const FlightData& flight, int flight_index, const Catalogue& catalogue, const Eigen::VectorXd& value,
                 const std::vector<int>& wanted, double spacing_s, int jobs) {
  ShotFlight shot;
  const Shot base(flight, flight_index, catalogue, value, spacing_s, jobs);
  for (const int c : wanted) {
    const Column& column = catalogue.column(c);
    if (column.flight < 0 || column.flight == flight_index) shot.columns.push_back(c);
  }
  const auto width = static_cast<Eigen::Index>(shot.columns.size()) + 1;
  shot.window.assign(base.windows.size(), Eigen::MatrixXd::Zero(window_rows, width));
  for (std::size_t w = 0; w < base.windows.size(); ++w) {
    const Window& window = base.windows[w];
    shot.time_s.push_back(flight.samples[window.start].time_s);
    shot.sample.push_back({window.start});
    std::copy(window.at.begin(), window.at.end(), shot.sample.back().begin() + 1);
    shot.window[w].col(width - 1) = base.missed.col(static_cast<Eigen::Index>(w));
  }
  const Differentiator differentiate(base, flight, flight_index, catalogue, value);
  parallel_for(width - 1, jobs, [&](std::int64_t j) {
    const auto column = differentiate(shot.columns[static_cast<std::size_t>(j)]);
    for (std::size_t w = 0; column && w < shot.window.size(); ++w)
      shot.window[w].col(j) = column->col(static_cast<Eigen::Index>(w));
  });
  return shot;
}

std::vector<Eigen::MatrixXd> commanded_torque(const FlightData& flight, const ShotFlight& shot, double smoothed_s) {
  const std::vector<Eigen::Vector4d> rotors = rotor_acceleration(flight);
  const auto reach = static_cast<std::ptrdiff_t>(std::lround(3.0 * smoothed_s / flight.sample_s));
  std::vector<Vector3> acceleration(rotors.size(), Vector3::Zero());
  for (std::ptrdiff_t k = 0; k < std::ssize(rotors); ++k) {
    double sum = 0.0;
    for (std::ptrdiff_t j = std::max<std::ptrdiff_t>(0, k - reach); j < std::min(std::ssize(rotors), k + reach + 1);
         ++j) {
      const double weight =
          j == k ? 1.0 : std::exp(-0.5 * std::pow(static_cast<double>(j - k) * flight.sample_s / smoothed_s, 2));
      acceleration[static_cast<std::size_t>(k)] += weight * rotors[static_cast<std::size_t>(j)].head<3>();
      sum += weight;
    }
    acceleration[static_cast<std::size_t>(k)] /= sum;
  }
  std::vector<Eigen::MatrixXd> windows;
  for (const auto& sample : shot.sample) {
    Eigen::MatrixXd& out = windows.emplace_back(Eigen::MatrixXd::Zero(window_rows, 6));
    Vector3 rate = Vector3::Zero(), angle = Vector3::Zero();
    std::size_t k = sample.front();
    for (std::size_t h = 0; h + 1 < sample.size(); ++h) {
      for (; k < sample[h + 1]; ++k) {
        angle += (rate + 0.5 * acceleration[k] * flight.sample_s) * flight.sample_s;
        rate += acceleration[k] * flight.sample_s;
      }
      const bool turns = flight.samples[k].channels & has_rate;
      const double lasted_s = static_cast<double>(k - sample.front()) * flight.sample_s;
      const Eigen::Index row = torque_row(static_cast<Eigen::Index>(h), 0);
      out.block<3, 3>(row, 0) = (turns ? rate : angle).asDiagonal();
      out.block<3, 3>(row, 3).diagonal().setConstant(turns ? lasted_s : 0.5 * lasted_s * lasted_s);
    }
  }
  return windows;
}

namespace {

bool scales_with_commands(const Catalogue& catalogue, int c) {
  const Column& column = catalogue.column(c);
  return column.group < 0 ? column.parameter >= command_clock : catalogue.group(column.group).row->commanded;
}

// Sums over all windows of products of whitened rows: left(flight, window)ᵀ right(flight, window).
template <typename Left, typename Right>
Eigen::MatrixXd products(const std::vector<ShotFlight>& flights, const ShootingWeights& weights, const Left& left,
                         const Right& right) {
  Eigen::MatrixXd sum;
  for (std::size_t f = 0; f < flights.size(); ++f)
    for (std::size_t w = 0; w < flights[f].window.size(); ++w) {
      const Eigen::MatrixXd part = (weights * left(f, w)).transpose() * (weights * right(f, w));
      if (sum.size() == 0) sum = part;
      else sum += part;
    }
  return sum;
}

// How much more torque per command a column is, axes × columns of the catalogue: of its own torque rows, beside a constant torque.
Eigen::MatrixXd torque_gains(const Answers& answers, const std::vector<ShotFlight>& flights, int columns) {
  Eigen::MatrixXd gain = Eigen::MatrixXd::Zero(std::ssize(answers.axes), columns);
  for (std::size_t i = 0; i < answers.axes.size(); ++i) {
    const int axis = answers.axes[i];
    Eigen::Matrix2d A = Eigen::Matrix2d::Zero();
    Eigen::MatrixXd right = Eigen::MatrixXd::Zero(2, columns);
    for (std::size_t f = 0; f < flights.size(); ++f)
      for (std::size_t w = 0; w < flights[f].window.size(); ++w)
        for (Eigen::Index h = 0; h < std::ssize(shooting_horizon_s); ++h) {
          const Eigen::Index row = torque_row(h, axis);
          const Eigen::Vector2d x(answers.torque[f][w](row, axis), answers.torque[f][w](row, 3 + axis));
          A += x * x.transpose();
          for (std::size_t j = 0; j < flights[f].columns.size(); ++j)
            right.col(flights[f].columns[j]) += x * flights[f].window[w](row, static_cast<Eigen::Index>(j));
        }
    gain.row(static_cast<Eigen::Index>(i)) = A.ldlt().solve(right).row(0);
  }
  return gain;
}

}  // namespace

Answers answers_of(const std::vector<ShotFlight>& nominal, const std::vector<std::vector<Eigen::MatrixXd>>& torque,
                   const ShootingWeights& weights, const Catalogue& catalogue, const std::vector<int>& axes) {
  Answers answers{axes, {}, torque, {}};
  answers.window.resize(nominal.size());
  // columns of all flights beside each other, as a flight has them
  std::vector<int> others;
  for (int c = 0; c < catalogue.size(); ++c)
    if (!scales_with_commands(catalogue, c)) others.push_back(c);
  const auto all = [&](std::size_t f, std::size_t w) {
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(window_rows, std::ssize(others) + std::ssize(axes));
    for (std::size_t j = 0; j < nominal[f].columns.size(); ++j)
      if (const auto at = std::lower_bound(others.begin(), others.end(), nominal[f].columns[j]);
          at != others.end() && *at == nominal[f].columns[j])
        rows.col(at - others.begin()) = nominal[f].window[w].col(static_cast<Eigen::Index>(j));
    rows.rightCols(std::ssize(axes)) = torque[f][w](Eigen::all, axes);
    return rows;
  };
  const Eigen::MatrixXd gram = products(nominal, weights, all, all);
  if (gram.size() == 0) return answers;
  const Eigen::Index known = std::ssize(others);
  Eigen::MatrixXd weight(gram.cols(), std::ssize(axes));
  weight << -solve_ridged(gram.topLeftCorner(known, known), gram.topRightCorner(known, std::ssize(axes)), 1e-6),
      Eigen::MatrixXd::Identity(std::ssize(axes), std::ssize(axes));
  for (std::size_t f = 0; f < nominal.size(); ++f)
    for (std::size_t w = 0; w < nominal[f].window.size(); ++w) answers.window[f].push_back(all(f, w) * weight);
  const auto own = [&](std::size_t f, std::size_t w) { return answers.window[f][w]; };
  const auto left = [&](std::size_t f, std::size_t w) { return nominal[f].window[w].rightCols(1); };
  answers.share = products(nominal, weights, own, own).ldlt().solve(products(nominal, weights, own, left));
  return answers;
}

void set_aside(const Answers& answers, const ShootingWeights& weights, const Catalogue& catalogue,
               std::vector<ShotFlight>& flights) {
  if (answers.axes.empty()) return;
  const auto own = [&](std::size_t f, std::size_t w) { return answers.window[f][w]; };
  const auto left = [&](std::size_t f, std::size_t w) { return flights[f].window[w].rightCols(1); };
  const Eigen::VectorXd share =
      products(flights, weights, own, own).ldlt().solve(products(flights, weights, own, left));
  const Eigen::MatrixXd gain = torque_gains(answers, flights, catalogue.size());
  for (std::size_t f = 0; f < flights.size(); ++f)
    for (std::size_t w = 0; w < flights[f].window.size(); ++w) {
      Eigen::MatrixXd& window = flights[f].window[w];
      for (std::size_t j = 0; j < flights[f].columns.size(); ++j)
        if (scales_with_commands(catalogue, flights[f].columns[j]))
          window.col(static_cast<Eigen::Index>(j)) -=
              answers.torque[f][w](Eigen::all, answers.axes) * gain.col(flights[f].columns[j]);
      window.rightCols(1) -= answers.window[f][w] * share;
    }
}

namespace {

// the correlations along the horizons of an axis alone, the same for both level axes
Eigen::MatrixXd alike_in_level_axes(const Eigen::MatrixXd& correlation) {
  constexpr std::array<std::array<int, 2>, rows_per_horizon> with = {{{0, 1}, {0, 1}, {2, 2}, {3, 4}, {3, 4}, {5, 5}}};
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(window_rows, window_rows);
  for (Eigen::Index i = 0; i < window_rows; ++i)
    for (Eigen::Index j = i % rows_per_horizon; j < window_rows; j += rows_per_horizon)
      for (const int axis : with[static_cast<std::size_t>(i % rows_per_horizon)])
        result(i, j) += 0.5 * correlation(i - i % rows_per_horizon + axis, j - j % rows_per_horizon + axis);
  return result;
}

// Of sums over windows of z zᵀ and of its squares. Some tens of windows do not determine the 435 correlations of 30 rows: those between axes
// are kept as far as they are more than chance (Schäfer & Strimmer, Stat. Appl. Genet. Mol. Biol. 4, 2005, eq. 8).
Eigen::MatrixXd shrunk(const Eigen::MatrixXd& sum, const Eigen::MatrixXd& squares, double windows) {
  double chance = 0.0, all = 0.0;
  for (Eigen::Index i = 0; i < window_rows; ++i)
    for (Eigen::Index j = 0; j < window_rows; ++j) {
      if (i % rows_per_horizon == j % rows_per_horizon) continue;
      const double mean = sum(i, j) / windows;
      chance += (squares(i, j) / windows - mean * mean) / std::max(1.0, windows - 1.0);
      all += mean * mean;
    }
  const double share = std::clamp(chance / (all + 1e-300), 0.0, 1.0);
  return share * alike_in_level_axes(sum) + (1.0 - share) * sum;
}

}  // namespace

ShootingWeights shooting_weights(const std::vector<ShotFlight>& flights, const std::vector<int>& columns,
                                 const Eigen::VectorXd& coefficient) {
  // what is left, one column per window
  std::vector<Eigen::VectorXd> left;
  for (const ShotFlight& flight : flights)
    for (const Eigen::MatrixXd& window : flight.window) {
      Eigen::VectorXd r = window.col(window.cols() - 1);
      for (std::size_t j = 0; j < flight.columns.size(); ++j)
        for (std::size_t i = 0; i < columns.size(); ++i)
          if (columns[i] == flight.columns[j])
            r -= window.col(static_cast<Eigen::Index>(j)) * coefficient[static_cast<Eigen::Index>(i)];
      left.push_back(std::move(r));
    }
  // robust size of each row: median
  Eigen::VectorXd sd(window_rows);
  constexpr std::array<double, 2> least = {1e-3, 1e-2};  // m/s and rad/s
  for (Eigen::Index row = 0; row < window_rows; ++row) {
    std::vector<double> sizes;
    for (const Eigen::VectorXd& r : left) sizes.push_back(std::abs(r[row]));
    sd[row] = std::max(left.empty() ? 1.0 : median(std::move(sizes)) / 0.6745,
                       least[static_cast<std::size_t>(row % rows_per_horizon / 3)]);
  }
  // an error grows along the horizons: the rows of a window belong together
  Eigen::MatrixXd correlation = Eigen::MatrixXd::Zero(window_rows, window_rows), squares = correlation;
  double count = 0.0;
  for (const Eigen::VectorXd& r : left) {
    Eigen::VectorXd z = r.cwiseQuotient(sd);
    const double size = z.norm() / std::sqrt(static_cast<double>(window_rows));
    if (size > clearly_lost) z *= clearly_lost / size;
    correlation += z * z.transpose();
    squares += (z * z.transpose()).cwiseAbs2();
    count += 1.0;
  }
  correlation = (shrunk(correlation, squares, std::max(1.0, count)) +
                 own_share * count * Eigen::MatrixXd::Identity(window_rows, window_rows)) /
                ((1.0 + own_share) * std::max(1.0, count));
  if (count == 0.0) correlation.setIdentity();
  const Eigen::MatrixXd inverse =
      correlation.llt().matrixL().solve(Eigen::MatrixXd::Identity(window_rows, window_rows));
  // a fit of k numbers leaves n - k of n rows
  const double rows = std::max(1.0, count * window_rows);
  const double left_share = std::max(0.5, 1.0 - static_cast<double>(columns.size()) / rows);
  return std::sqrt(left_share) * inverse * sd.cwiseInverse().asDiagonal();
}

Grams shooting_grams(const std::vector<ShotFlight>& flights, const ShootingWeights& weights, const Catalogue& catalogue,
                     const Eigen::VectorXd& value) {
  Grams grams;
  const int catalogue_size = catalogue.size();
  grams.columns = catalogue_size;
  for (std::size_t f = 0; f < flights.size(); ++f) {
    std::vector<int> at = flights[f].columns;
    at.push_back(catalogue_size);
    for (std::size_t w = 0; w < flights[f].window.size(); ++w) {
      const Eigen::MatrixXd& window = flights[f].window[w];
      Eigen::MatrixXd z = weights * window;
      // a window that the model loses altogether weighs no more than one that it loses clearly
      const double size = z.col(z.cols() - 1).norm() / std::sqrt(static_cast<double>(window_rows));
      if (size > clearly_lost) z *= std::sqrt(clearly_lost / size);
      const Eigen::MatrixXd local = z.transpose() * z;
      Eigen::MatrixXd full = Eigen::MatrixXd::Zero(catalogue_size + 1, catalogue_size + 1);
      for (std::size_t i = 0; i < at.size(); ++i)
        for (std::size_t j = 0; j < at.size(); ++j)
          full(at[i], at[j]) = local(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      grams.add(static_cast<int>(f), flights[f].time_s[w], std::move(full), false);
      grams.rows += static_cast<double>(window_rows);
    }
  }
  // what is small unless the data say otherwise: one more measurement of each
  Eigen::MatrixXd prior = Eigen::MatrixXd::Zero(catalogue_size + 1, catalogue_size + 1);
  for (int c = 0; c < catalogue_size; ++c) {
    const Column& column = catalogue.column(c);
    if (column.known_to > 0.0 || column.of_torque_trim()) continue;
    Eigen::Vector2d row(1.0, -(value[c] - column.nominal) / column.natural);
    if (column.group >= 0) row /= loose_prior;
    prior(c, c) += row[0] * row[0];
    prior(c, catalogue_size) = prior(catalogue_size, c) = row[0] * row[1];
    prior(catalogue_size, catalogue_size) += row[1] * row[1];
  }
  grams.add(0, 0.0, std::move(prior), true);
  return grams;
}

}  // namespace gustlab::diagnosis
