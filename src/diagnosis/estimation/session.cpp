#include "diagnosis/estimation/session.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>

#include "diagnosis/estimation/indices.hpp"
#include "diagnosis/estimation/mean_torques.hpp"
#include "diagnosis/estimation/rotor_speeds.hpp"
#include "diagnosis/estimation/sensor_windows.hpp"
#include "diagnosis/estimation/torque_trims.hpp"
#include "diagnosis/model/command_innovation.hpp"
#include "diagnosis/model/linear_model.hpp"
#include "diagnosis/model/speed_comparison.hpp"
#include "diagnosis/recording/command_jitter.hpp"
#include "diagnosis/result/decisions.hpp"
#include "util/parallel.hpp"

namespace gustlab::diagnosis {

namespace {

bool all_have_voltage(const std::vector<FlightData>& flights) {
  return std::all_of(flights.begin(), flights.end(), [](const FlightData& f) { return f.has_voltage; });
}

bool has_channel(const FlightData& flight, unsigned channel) {
  return std::ranges::any_of(flight.samples, [channel](const Sample& s) { return (s.channels & channel) != 0; });
}

bool any_channel(const std::vector<FlightData>& flights, unsigned channel) {
  return std::ranges::any_of(flights, [channel](const FlightData& flight) { return has_channel(flight, channel); });
}

Need observable_in(const std::vector<FlightData>& flights) {
  Need observable = Need::nothing;
  for (const auto& [channel, need] : {std::pair<unsigned, Need>{has_attitude, Need::attitude},
                                      {has_position | has_velocity, Need::motion},
                                      {has_force, Need::accelerometer}})
    if (any_channel(flights, channel)) observable = observable | need;
  for (const FlightData& flight : flights) {
    if (flight.sensors || has_channel(flight, has_rate)) observable = observable | Need::gyro;
    if (flight.sensors && has_channel(*flight.sensors, has_force) && has_channel(*flight.sensors, has_position))
      observable = observable | Need::accelerometer;
    const Environment& around = flight.vehicle.environment;
    if (!flight.collective_only) observable = observable | Need::torque;
    if (around.ground_z_m) observable = observable | Need::ground;
    if (around.ceiling_z_m) observable = observable | Need::ceiling;
    if (!around.walls.empty()) observable = observable | Need::wall;
  }
  return observable;
}

}  // namespace

// what counts degrees of freedom was measured on logs of up to 125 Hz
constexpr double fastest_sample_s = 0.008;

// of all flights together, about
constexpr double most_windows = 600.0;
// standard deviation of what smooths the slow torque: Gaussian, below some 3 Hz
constexpr double slow_s = 0.06;
// EM ends when no variance, power or time changes by more than this share in a step
constexpr double least_change = 0.01;
// of the search for the noise
constexpr NoiseSteps coarse_steps{2.0, 8}, fine_steps{1.4, 4};

std::array<double, disturbance_groups> reference_floor(const VehicleModel& vehicle) {
  // 0.106 m/s² of force; torques in proportion to that force at 0.23 (0.20 in yaw) of the arm
  const double force = 0.106, lever = force * vehicle.mass_kg * vehicle.arm_m();
  return {force, force, 0.23 * lever / vehicle.inertia_B_kgm2(0, 0), 0.20 * lever / vehicle.inertia_B_kgm2(2, 2)};
}

NoiseModel initial_noise(const std::vector<FlightData>& flights, const VehicleModel& vehicle) {
  NoiseModel noise;
  const auto floor = reference_floor(vehicle);
  for (std::size_t g = 0; g < disturbance_groups; ++g) {
    // the air of a calm room, and for what is faster some times the least that is believed
    noise.variance[g] = (g < 2 ? 0.36 : 0.25) * floor[g] * floor[g];
    noise.least_white[g] = 2.0 * white_mean_s(g) * std::pow(decisions::least_share_of_floor * floor[g], 2);
    noise.white[g] = (g < 2 ? 2.0 : 8.0) * noise.least_white[g];
  }
  noise.time_s = {0.2, 0.2, 0.1, 0.1};
  constexpr std::array<unsigned, 4> channel = {has_position, has_attitude, has_rate, has_force};
  constexpr std::array<double, 4> least = {1e-10, 1e-10, 1e-8, 1e-6};
  for (std::size_t g = 0; g < noise_groups; ++g) {
    double sum = 0.0, count = 0.0;
    for (const FlightData& flight : flights)
      for (int axis = 0; axis < 3; ++axis) {
        std::vector<double> series;
        for (const Sample& s : flight.samples) {
          if (!(s.channels & channel[g])) continue;
          series.push_back(g == 0   ? s.position_W_m[axis]
                           : g == 1 ? 2.0 * s.attitude_WB.vec()[axis]
                           : g == 2 ? s.body_rate_B_radps[axis]
                                    : s.specific_force_B_mps2[axis]);
        }
        if (series.size() < 8) continue;
        sum += third_difference_noise(series);
        count += 1.0;
      }
    const double sd = count > 0.0 ? sum / count : 0.0;
    noise.measurement[g] = std::max(sd * sd, least[g]);
  }
  return noise;
}

namespace {

std::vector<FlightData> with_rotors_known(std::vector<FlightData> flights) {
  for (FlightData& flight : flights) flight = without_spin_up(std::move(flight));
  return flights;
}

}  // namespace

Session::Session(std::vector<FlightData> flights, const VehicleModel& vehicle, int jobs,
                 std::vector<FlightData> shooting_flights)
    : noise(initial_noise(flights, vehicle)),
      jobs_(jobs),
      vehicle_(vehicle),
      flights_(with_rotors_known(std::move(flights))),
      catalogue_(
          vehicle, static_cast<int>(flights_.size()),
          {observable_in(flights_), all_have_voltage(flights_), !shooting_flights.empty(),
           std::any_of(shooting_flights.begin(), shooting_flights.end(),
                       [](const FlightData& f) { return !f.commands_filtered; }),
           std::any_of(flights_.begin(), flights_.end(), commands_are_slower),
           std::all_of(flights_.begin(), flights_.end(), [](const FlightData& f) { return f.each_rotor != nullptr; }),
           only_mean_thrust_known(flights_),
           std::any_of(flights_.begin(), flights_.end(), [](const FlightData& f) { return f.inertial_unused; })}),
      linear_(flights_.size()),
      each_rotor_(flights_.size()),
      value_(catalogue_.nominal()),
      shooting_flights_(with_rotors_known(std::move(shooting_flights))),
      shot_(shooting_flights_.size()) {
  sensor_windows_.resize(flights_.size());
  // one flight says nothing of its trims: they are small on filtered logs, and nothing elsewhere
  if (shoots() || flights_.size() > 1) noise.torque_trim.fill(torque_trim_sd * torque_trim_sd);
  for_each_flight([&](std::size_t f) {
    sensor_windows_[f] = sensor_windows(flights_[f], static_cast<int>(f), catalogue_);
    flights_[f].measured_at_sample = measured_beside_commands(flights_[f]);
    if (!shoots()) flights_[f].command_innovation = command_innovation(flights_[f]);
  });
  for (int c = 0; c < catalogue_.size(); ++c) {
    all_.push_back(c);
    if (catalogue_.column(c).group < 0) biases_.push_back(c);
  }
}

std::vector<int> Session::with_biases(const std::vector<int>& groups) const {
  std::vector<int> columns = columns_of(catalogue_, groups);
  columns.insert(columns.end(), biases_.begin(), biases_.end());
  return columns;
}

void Session::freeze(int column) {
  catalogue_.freeze(column);
  std::erase(all_, column);
  frozen_.push_back(column);
}

void Session::freeze_only(const std::vector<int>& columns) {
  for (const int column : std::exchange(frozen_, {})) {
    catalogue_.thaw(column);
    all_.insert(std::ranges::lower_bound(all_, column), column);
  }
  for (const int column : columns) freeze(column);
}

double Session::window_spacing_s() const {
  double duration_s = 0.0;
  for (const FlightData& flight : shooting_flights_) duration_s += flight.duration_s();
  return std::max(shooting_horizon_s.back(), duration_s / most_windows);
}

void Session::read_at(const Eigen::VectorXd& value, std::size_t f) {
  const SensorCorrection correction = catalogue_.sensor_correction(value, static_cast<int>(f));
  if (correction != flights_[f].corrected) smooth_motion(flights_[f], correction);
  estimate_speeds(flights_[f], static_cast<int>(f), catalogue_, value, noise.speeds);
}

void Session::take_biases_out(std::size_t f) {
  for (std::size_t k = 0; k < linear_[f].size(); ++k)
    for (const int c : biases_) {
      const Column& column = catalogue_.column(c);
      if (column.flight == static_cast<int>(f) && column.parameter < torque_trim)
        linear_[f].y[k][6 + column.parameter] -= value_[c];
    }
}

void Session::balance_torques(std::size_t f, const std::vector<int>* wanted) {
  const FlightData* each = flights_[f].each_rotor.get();
  if (each == nullptr) return;
  const int index = static_cast<int>(f);
  if (wanted)
    gustlab::diagnosis::linearise(*each, index, catalogue_, value_, that_shift_torques(catalogue_, *wanted),
                                  each_rotor_[f], jobs_);
  else predict_again(*each, index, catalogue_, value_, each_rotor_[f]);
  gustlab::diagnosis::balance_torques(*each, each_rotor_[f], linear_[f]);
}

void Session::linearise(const Eigen::VectorXd& value, const std::vector<int>& wanted, bool with_filter) {
  value_ = value;
  const double spacing_s = window_spacing_s();
  const bool first = shoots() && shot_nominal_.empty();
  if (first)
    shot_nominal_.resize(flights_.size()), slow_torque_.resize(flights_.size()), torque_.resize(flights_.size());
  for_each_flight([&](std::size_t f) {
    const int index = static_cast<int>(f);
    if (first) {
      shot_nominal_[f] = shoot(shooting_flights_[f], index, catalogue_, catalogue_.nominal(), all_, spacing_s, jobs_);
      slow_torque_[f] = commanded_torque(shooting_flights_[f], shot_nominal_[f], slow_s);
      torque_[f] = commanded_torque(shooting_flights_[f], shot_nominal_[f], 0.0);
    }
    if (shoots())
      shot_[f] = first && wanted == all_ && value == catalogue_.nominal()
                     ? shot_nominal_[f]
                     : shoot(shooting_flights_[f], index, catalogue_, value, wanted, spacing_s, jobs_);
    if (shoots() && !with_filter) return;
    read_at(value, f);
    gustlab::diagnosis::linearise(flights_[f], index, catalogue_, value, wanted, linear_[f], jobs_);
    take_biases_out(f);
    balance_torques(f, &wanted);
  });
  if (shoots()) set_answers_aside();
}

void Session::predict_at(const Eigen::VectorXd& value) {
  value_ = value;
  const double spacing_s = window_spacing_s();
  for_each_flight([&](std::size_t f) {
    const int index = static_cast<int>(f);
    if (shoots()) return shoot_again(shooting_flights_[f], index, catalogue_, value, spacing_s, shot_[f], jobs_);
    read_at(value, f);
    predict_again(flights_[f], index, catalogue_, value, linear_[f]);
    take_biases_out(f);
    balance_torques(f, nullptr);
  });
  if (shoots()) set_answers_aside();
}

void Session::set_answers_aside() {
  shot_aside_ = shot_;
  set_aside(answers_, weights_, catalogue_, shot_aside_);
}

void Session::weigh(ShootingWeights weights) {
  weights_ = std::move(weights);
  if (!answered_axes_) {
    const Eigen::VectorXd share = answers_of(shot_nominal_, slow_torque_, weights_, catalogue_, {0, 1, 2}).share;
    answered_axes_.emplace();
    for (int axis = 0; axis < share.size(); ++axis)
      if (share[axis] < decisions::answered_share) answered_axes_->push_back(axis);
  }
  if (!answered_axes_->empty()) {
    catalogue_.hide_torque_gains();
    std::erase_if(all_, [&](int c) {
      const int g = catalogue_.column(c).group;
      if (g < 0) return false;
      const Group& group = catalogue_.group(g);
      return !group.candidate && !group.nominal;
    });
    answers_ = answers_of(shot_nominal_, torque_, weights_, catalogue_, *answered_axes_);
  }
  set_answers_aside();
}

void Session::take_weights(const Session& other) {
  if (!shoots()) return;
  answered_axes_ = other.answered_axes_;
  weigh(other.weights_);
}

void Session::for_each_flight(const std::function<void(std::size_t)>& body) const {
  // the longest begin first, so that no thread is left alone with one at the end
  std::vector<std::size_t> order(flights_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::greater{}, [&](std::size_t f) { return flights_[f].samples.size(); });
  parallel_for(std::ssize(order), jobs_, [&](std::int64_t at) { body(order[static_cast<std::size_t>(at)]); });
}

void Session::suspect_load(const Swing& swing, std::vector<std::vector<Vector3>> force_per_flight) {
  catalogue_.set_swing(swing);
  for (std::size_t f = 0; f < flights_.size(); ++f) flights_[f].load_force_W_mps2 = std::move(force_per_flight[f]);
}

void Session::suspect_limit(double limit_radps) {
  catalogue_.set_speed_limit(limit_radps);
  for_each_flight([&](std::size_t f) {
    FlightData& flight = flights_[f];
    const int index = static_cast<int>(f);
    if (flight.measured_speed.empty())
      flight.limit_change = limit_changes(flight, index, catalogue_, value_, {limit_radps}).front();
    else if (!linear_[f].predicted.empty())
      flight.limit_speed_change = limit_speed_changes(flight, index, catalogue_, value_, {limit_radps}).front();
  });
}

void Session::forget_transitions() {
  for (LinearFlight& flight : linear_) flight.F.clear();
}

LinearFlight taken_out(const LinearFlight& flight, const std::vector<int>& columns,
                       const Eigen::VectorXd& coefficient) {
  LinearFlight rest;
  static_cast<LinearPlant&>(rest) = flight;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const auto at = std::find(flight.columns.begin(), flight.columns.end(), columns[i]) - flight.columns.begin();
    if (at == std::ssize(flight.columns)) continue;
    const auto sensed = std::ranges::find(flight.sensed, at) - flight.sensed.begin();
    for (std::size_t k = 0; k < rest.size(); ++k) {
      rest.add_moved_by(coefficient[static_cast<Eigen::Index>(i)] * flight.acceleration_by[k].col(at), k, rest.b[k]);
      rest.y[k].tail<3>() -= coefficient[static_cast<Eigen::Index>(i)] * flight.felt_by[k].col(at);
      if (sensed < std::ssize(flight.sensed))
        rest.y[k].head<first_force_row>() -=
            coefficient[static_cast<Eigen::Index>(i)] * flight.sensed_by[k].col(sensed);
    }
    const std::vector<RotorArray>& by = flight.predicted_by[static_cast<std::size_t>(at)];
    for (std::size_t k = 0; k < by.size(); ++k)
      for (std::size_t r = 0; r < max_rotors; ++r)
        rest.faster[k][r] -= coefficient[static_cast<Eigen::Index>(i)] * by[k][r];
    for (std::size_t w = 0; w < rest.mean_acceleration.size(); ++w)
      rest.mean_acceleration[w] -= coefficient[static_cast<Eigen::Index>(i)] * flight.mean_acceleration_by[w].col(at);
  }
  return rest;
}

LinearFlight only(const LinearFlight& flight, const std::vector<int>& columns) {
  LinearFlight part;
  static_cast<LinearPlant&>(part) = flight;
  std::vector<Eigen::Index> at, sensed;
  for (std::size_t j = 0; j < flight.columns.size(); ++j) {
    if (std::find(columns.begin(), columns.end(), flight.columns[j]) == columns.end()) continue;
    const auto was = std::ranges::find(flight.sensed, static_cast<Eigen::Index>(j)) - flight.sensed.begin();
    if (was < std::ssize(flight.sensed)) sensed.push_back(was), part.sensed.push_back(std::ssize(part.columns));
    at.push_back(static_cast<Eigen::Index>(j));
    part.columns.push_back(flight.columns[j]);
    part.predicted_by.push_back(flight.predicted_by[j]);
  }
  for (std::size_t k = 0; k < flight.acceleration_by.size(); ++k) {
    part.acceleration_by.push_back(flight.acceleration_by[k](Eigen::all, at));
    part.felt_by.push_back(flight.felt_by[k](Eigen::all, at));
    part.sensed_by.push_back(flight.sensed_by[k](Eigen::all, sensed));
  }
  for (const auto& by : flight.mean_acceleration_by) part.mean_acceleration_by.push_back(by(Eigen::all, at));
  return part;
}

// columns that were differentiated in the last linearisation
std::vector<int> Session::present(const std::vector<int>& columns) const {
  std::vector<int> result;
  for (const int c : columns)
    for (const LinearFlight& flight : linear_)
      if (std::find(flight.columns.begin(), flight.columns.end(), c) != flight.columns.end()) {
        result.push_back(c);
        break;
      }
  return result;
}

Eigen::VectorXd Session::beside_trims(const std::vector<int>& columns) {
  Grams now = flown_grams(columns);
  // learned on filtered logs, they made the offsets that a vehicle has anyway a centre of mass beside a lost rotor
  if (!shoots())
    noise.torque_trim = likeliest_trims(catalogue_, columns, value_, now, usual_trims(vehicle_), noise.torque_trim);
  know_beforehand(catalogue_, noise.torque_trim, value_, now);
  return solve(now.total(), columns, 1e-4).coefficient;
}

Eigen::VectorXd Session::value_with(const std::vector<int>& columns, const Eigen::VectorXd& coefficient) const {
  Eigen::VectorXd value = value_;
  for (std::size_t i = 0; i < columns.size(); ++i)
    value[columns[i]] += coefficient[static_cast<Eigen::Index>(i)] * catalogue_.column(columns[i]).natural;
  return value;
}

void Session::learn_noise(int iterations, const std::vector<int>& columns) {
  const std::vector<int> fitted = present(columns);
  Eigen::VectorXd coefficient;
  if (shoots()) {
    weigh(shooting_weights(shot_aside_, {}, {}));
    for (int iteration = 0; iteration < 4; ++iteration) {
      coefficient = beside_trims(fitted);
      weigh(shooting_weights(shot_aside_, fitted, coefficient));
    }
  }
  if (shoots())
    noise.sensor_windows = sensor_window_variance(sensor_windows_, catalogue_, value_with(fitted, coefficient));
  noise.speeds = white_speed_noise(flights_, linear_);
  std::vector<NoiseModel> before;
  std::vector<LinearFlight> rest(flights_.size());
  for (int iteration = 0; iteration < iterations; ++iteration) {
    const bool anew = iteration % 2 == 0;
    if (anew && !shoots()) {
      coefficient = beside_trims(fitted);
    }
    smoothed.assign(flights_.size(), Smoothed{});
    for_each_flight([&](std::size_t f) {
      if (anew) rest[f] = taken_out(linear_[f], fitted, coefficient);
      smoothed[f] = smooth(rest[f], noise);
    });
    if (anew) noise.speeds = likeliest(flights_, rest, noise.speeds);
    if (anew) noise.mean_torque = mean_torque_variance(rest);
    if (anew && !shoots())
      noise.sensor_windows = sensor_window_variance(sensor_windows_, catalogue_, value_with(fitted, coefficient));
    before.push_back(noise);
    noise = update(noise, smoothed, sample_s());
    if (largest_change(before.back(), noise) < least_change) return;
    // two steps and a leap, and a step at the end
    if (before.size() == 2 && iteration + 1 < iterations) leap(std::exchange(before, {}), rest);
  }
}

void Session::leap(const std::vector<NoiseModel>& before, const std::vector<LinearFlight>& rest) {
  const NoiseModel far = extrapolated(before[0], before[1], noise);
  std::vector<double> further(rest.size());
  for_each_flight([&](std::size_t f) {
    further[f] = gustlab::diagnosis::misfit(rest[f], far) - gustlab::diagnosis::misfit(rest[f], noise);
  });
  if (std::accumulate(further.begin(), further.end(), 0.0) < 0.0) noise = far;
}

void Session::put_back(Learned before) {
  noise = std::move(before.noise), smoothed = std::move(before.smoothed);
  if (shoots()) weigh(std::move(before.weights));
}

void Session::search_noise(const std::vector<int>& columns) {
  if (shoots() || linear_.front().forces_alone) return;
  const std::vector<int> fitted = present(columns);
  const Eigen::VectorXd coefficient = solve(grams(fitted).total(), fitted, 1e-4).coefficient;
  std::vector<LinearFlight> rest;
  for (const LinearFlight& flight : linear_) rest.push_back(taken_out(flight, fitted, coefficient));
  const NoiseModel calm = noise;
  const double near = descend(rest, noise, coarse_steps), forgetful = descend(rest, noise, fine_steps);
  // errors of the sensors may last
  std::vector<Whitened> whitened(rest.size());
  for_each_flight([&](std::size_t f) { whitened[f] = whiten(flights_[f], rest[f], noise); });
  const auto correlated = [](const auto& of_channels) {
    return std::any_of(of_channels.begin(), of_channels.end(),
                       [](double r) { return std::abs(r) > decisions::lasting_correlation; });
  };
  const auto correlation = lag_correlation(whitened, 3);
  if (std::none_of(correlation.begin(), correlation.end(), correlated)) return;
  NoiseModel lasting = calm;
  lasting.lasting_variance = {1.6e-5, 2.5e-5, any_channel(flights_, has_rate) ? noise.measurement[2] : 1e-12,
                              any_channel(flights_, has_force) ? noise.measurement[3] : 1e-12};  // 4 mm, 5 mrad
  lasting.lasting_time_s = {0.1, 0.1, 0.5 * sample_s(), 0.5 * sample_s()};
  const double rows = std::accumulate(whitened.begin(), whitened.end(), 0.0, [](double sum, const Whitened& w) {
    return sum + static_cast<double>(w.time_s.size());
  });
  const double pays_below = forgetful - decisions::lasting_gain * rows;
  // fine steps bring about as much as without memory, where a state has fewer numbers
  if (descend(rest, lasting, coarse_steps) - 2.0 * (near - forgetful) > pays_below) return;
  if (descend(rest, lasting, fine_steps) < pays_below) noise = lasting;
}

double Session::descend(const std::vector<LinearFlight>& flights, NoiseModel& model, const NoiseSteps& steps) const {
  const std::size_t count = flights.size();
  const auto misfits = [&](const std::vector<NoiseModel>& models) {
    std::vector<double> of(models.size() * count), sum(models.size(), 0.0);
    parallel_for(std::ssize(of), jobs_, [&](std::int64_t at) {
      const auto i = static_cast<std::size_t>(at), f = i % count;
      of[i] = gustlab::diagnosis::misfit(flights[f], models[i / count]);
    });
    for (std::size_t i = 0; i < of.size(); ++i) sum[i / count] += of[i];
    return sum;
  };
  // a variance or a power is tried in steps of the square of what a time is
  using PerGroup = std::array<double, disturbance_groups>;
  struct Part {
    PerGroup NoiseModel::*values;
    bool time = false;
  };
  struct Law {
    std::size_t group;
    std::vector<Part> parts;
  };
  std::vector<Law> groups;
  for (std::size_t g = 0; g < noise_groups && model.errors_last(); ++g)
    groups.push_back({g, {{&NoiseModel::lasting_variance}, {&NoiseModel::lasting_time_s, true}}});
  for (std::size_t g = 0; g < disturbance_groups; ++g)
    groups.push_back({g, {{&NoiseModel::variance}, {&NoiseModel::time_s, true}, {&NoiseModel::white}}});
  double least = misfits({model}).front();
  // groups hardly depend on each other: one that stays will stay
  std::vector<bool> moved(groups.size(), true);
  for (int sweep = 0; sweep < steps.sweeps; ++sweep)
    for (std::size_t g = 0; g < groups.size(); ++g) {
      if (!moved[g]) continue;
      moved[g] = false;
      for (const Part& part : groups[g].parts) {
        std::vector<NoiseModel> trials;
        for (const double by : {steps.factor, 1.0 / steps.factor}) {
          NoiseModel trial = model;
          (trial.*part.values)[groups[g].group] *= part.time ? by : by * by;
          if (trial.possible()) trials.push_back(trial);
        }
        const std::vector<double> here = misfits(trials);
        for (std::size_t i = 0; i < trials.size(); ++i)
          if (here[i] < least - 1.0) least = here[i], model = trials[i], moved[g] = true;
      }
    }
  return least;
}

Grams Session::grams() const { return grams(all_); }

Grams Session::grams(const std::vector<int>& columns) const {
  Grams grams = flown_grams(columns);
  know_beforehand(catalogue_, noise.torque_trim, value_, grams);
  return grams;
}

void Session::add_sensor_windows(const std::vector<int>& columns, Grams& grams) const {
  const double rows = grams.rows;
  for (std::size_t f = 0; f < flights_.size(); ++f) {
    const std::vector<int>& own = sensor_windows_[f].columns;
    std::vector<int> wanted;
    std::ranges::copy_if(own, std::back_inserter(wanted),
                         [&](int c) { return std::ranges::find(columns, c) != columns.end(); });
    Grams of_flight;
    GramBlocks(wanted, static_cast<int>(f), catalogue_.size(), of_flight)
        .add(whiten_sensor_windows(sensor_windows_[f], wanted, catalogue_, value_, noise.sensor_windows));
    append(std::move(of_flight), grams);
  }
  grams.rows = rows;
}

Grams Session::flown_grams(const std::vector<int>& columns) const {
  Grams grams = shoots() ? shooting_grams(shot_aside_, weights_, catalogue_, value_) : filtered_grams(columns);
  add_sensor_windows(columns, grams);
  return grams;
}

Grams Session::filtered_grams(const std::vector<int>& columns) const {
  const auto wanted = [&](int c) { return std::ranges::find(columns, c) != columns.end(); };
  std::vector<Grams> of_body(flights_.size()), beside(2 * flights_.size());
  for_each_flight([&](std::size_t f) {
    std::optional<LinearFlight> part;
    const LinearFlight& flight =
        std::ranges::all_of(linear_[f].columns, wanted) ? linear_[f] : part.emplace(only(linear_[f], columns));
    const auto blocks = [&](Grams& of) {
      return GramBlocks(flight.columns, static_cast<int>(f), catalogue_.size(), of);
    };
    GramBlocks body = blocks(of_body[f]);
    add_innovations(flights_[f], flight, noise, body);
    blocks(beside[f]).add(whiten_speeds(flights_[f], flight, noise.speeds));
    blocks(beside[flights_.size() + f]).add(whiten_mean_torques(flight, noise.mean_torque));
  });
  Grams grams;
  for (Grams& part : of_body) append(std::move(part), grams);
  // speeds say only how commands reach the rotors, and mean torques are few: what is material to the body is counted by the body's rows
  const double rows = grams.rows;
  for (Grams& part : beside) append(std::move(part), grams);
  grams.rows = rows;
  // a faster log has more innovations, and no more information where air and noise hide nothing
  grams.rows *= std::min(1.0, sample_s() / fastest_sample_s);
  return grams;
}

std::vector<Whitened> Session::innovations(const std::vector<int>& columns, const Eigen::VectorXd& coefficient,
                                           const std::vector<std::vector<SpatialAccelerations>>* extra) const {
  std::vector<Whitened> whitened(flights_.size());
  for_each_flight([&](std::size_t f) {
    FurtherColumns further;
    if (extra)
      further = {extra->at(f).front().cols(),
                 [&](std::size_t k) -> const SpatialAccelerations& { return (*extra)[f][k]; }};
    whitened[f] = whiten(flights_[f], taken_out(linear_[f], columns, coefficient), noise, further);
  });
  return whitened;
}

namespace {

// rows that count, by channel; columns of the flight put where they are asked for
void append_channels(const Whitened& rows, int channels, const std::vector<int>& to, Eigen::Index width,
                     std::vector<Eigen::MatrixXd>& series) {
  for (int channel = 0; channel < channels; ++channel) {
    std::vector<Eigen::Index> at;
    for (std::size_t i = 0; i < rows.time_s.size(); ++i)
      if (rows.warm[i] && (rows.channel.empty() ? static_cast<int>(i % static_cast<std::size_t>(channels))
                                                : rows.channel[i]) == channel)
        at.push_back(static_cast<Eigen::Index>(i));
    if (at.empty()) continue;
    Eigen::MatrixXd& of_channel =
        series.emplace_back(Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(at.size()), width));
    for (std::size_t j = 0; j < to.size(); ++j) of_channel.col(to[j]) = rows.rows(at, static_cast<Eigen::Index>(j));
    of_channel.col(width - 1) = rows.rows(at, rows.rows.cols() - 1);
  }
}

}  // namespace

RowSeries Session::row_series(const std::vector<int>& columns) const {
  const auto width = static_cast<Eigen::Index>(columns.size()) + 1;
  RowSeries series(flights_.size());
  std::vector<int> all_of_them(columns.size());
  std::iota(all_of_them.begin(), all_of_them.end(), 0);
  for_each_flight([&](std::size_t f) {
    append_channels(whiten_sensor_windows(sensor_windows_[f], columns, catalogue_, value_, noise.sensor_windows), 6,
                    all_of_them, width, series[f]);
    if (!shoots()) {
      const LinearFlight part = only(linear_[f], columns);
      const std::vector<int> to = indices_of(part.columns, columns);
      append_channels(whiten(flights_[f], part, noise), row_count, to, width, series[f]);
      append_channels(whiten_speeds(flights_[f], part, noise.speeds), vehicle_.rotor_count, to, width, series[f]);
      append_channels(whiten_mean_torques(part, noise.mean_torque), 2, to, width, series[f]);
      return;
    }
    // every row of a window is a channel, which has one sample a window
    const std::vector<int> to = indices_of(shot_aside_[f].columns, columns);
    for (Eigen::Index row = 0; row < weights_.rows(); ++row) {
      Eigen::MatrixXd& of_row = series[f].emplace_back(Eigen::MatrixXd::Zero(std::ssize(shot_aside_[f].window), width));
      for (std::size_t w = 0; w < shot_aside_[f].window.size(); ++w) {
        const Eigen::RowVectorXd z = weights_.row(row) * shot_aside_[f].window[w];
        for (std::size_t j = 0; j < to.size(); ++j)
          if (to[j] + 1 < width) of_row(static_cast<Eigen::Index>(w), to[j]) = z[static_cast<Eigen::Index>(j)];
        of_row(static_cast<Eigen::Index>(w), width - 1) = z[z.size() - 1];
      }
    }
  });
  return series;
}

double Session::misfit(const std::vector<int>& columns, const Eigen::VectorXd& coefficient) const {
  std::vector<double> of(flights_.size());
  for_each_flight([&](std::size_t f) {
    const LinearFlight rest = taken_out(linear_[f], columns, coefficient);
    of[f] = whiten(flights_[f], rest, noise).minus_two_log_likelihood +
            whiten_speeds(flights_[f], rest, noise.speeds).minus_two_log_likelihood +
            whiten_mean_torques(rest, noise.mean_torque).minus_two_log_likelihood;
  });
  return std::accumulate(of.begin(), of.end(), 0.0);
}

double Session::minus_two_log_likelihood(const std::vector<int>& columns, const Fit& fit) const {
  if (!shoots()) return misfit(columns, fit.coefficient);
  double windows = 0.0;
  for (const ShotFlight& flight : shot_aside_) windows += static_cast<double>(flight.window.size());
  return fit.loss -
         2.0 * windows * Eigen::PartialPivLU<Eigen::MatrixXd>(weights_).matrixLU().diagonal().array().abs().log().sum();
}

void Session::start_delay(const std::vector<int>& groups, Eigen::VectorXd& value) const {
  const int delay = catalogue_.find(Place::actuation, Latency::delay);
  if (delay < 0 || std::find(groups.begin(), groups.end(), delay) == groups.end() || !predicts_speeds()) return;
  const int c = catalogue_.group(delay).columns.front();
  const double start_s = value_[c] + speed_latency_s(flights_, linear_);
  if (std::abs(value[c] - start_s) > sample_s()) value[c] = start_s;
}

LatencyStart least_left_at(const Catalogue& catalogue, const Eigen::VectorXd& prompt, double share,
                           const std::function<double(const Eigen::VectorXd&)>& left, double hopeless) {
  const double left_prompt = left(prompt);
  double least = share * left_prompt;
  LatencyStart best{-1, prompt};
  for (const Latency kind : {Latency::lag, Latency::delay}) {
    const int late = catalogue.find(Place::actuation, kind);
    if (late < 0) continue;
    for (const double later_s : {0.005, 0.01, 0.015, 0.02, 0.025, 0.03, 0.035, 0.04, 0.05, 0.06, 0.08, 0.12}) {
      Eigen::VectorXd trial = prompt;
      for (const int c : catalogue.group(late).columns) trial[c] += later_s;
      catalogue.clamp(trial);
      const double left_trial = left(trial);
      if (left_trial > hopeless * left_prompt) break;
      if (left_trial < least) least = left_trial, best = {late, trial};
    }
  }
  return best;
}

void Session::start_latency(Eigen::VectorXd& value) const {
  if (!predicts_speeds()) return;
  value = least_left_at(catalogue_, value, decisions::latency_shows, [&](const Eigen::VectorXd& at) {
            return speeds_left_radps(flights_, catalogue_, at);
          }).value;
}

bool Session::seen_in_speeds(int group) const {
  for (const LinearFlight& flight : linear_)
    for (std::size_t j = 0; j < flight.columns.size(); ++j)
      if (!flight.predicted_by[j].empty() && catalogue_.column(flight.columns[j]).group == group) return true;
  return false;
}

}  // namespace gustlab::diagnosis
