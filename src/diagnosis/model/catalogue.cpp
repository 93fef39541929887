#include "diagnosis/model/catalogue.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "diagnosis/result/decisions.hpp"
#include "simulation/make_effects.hpp"
#include "vehicle/gaps.hpp"

namespace gustlab::diagnosis {

namespace {

class NumberCollector final : public ParameterVisitor {
 public:
  std::vector<Number> found;
  void number(std::string_view name, double& value, const ParameterInfo& info) override {
    found.push_back({std::string(name), &value, info});
  }
  void vector(std::string_view name, Vector3& value, const ParameterInfo& info) override {
    for (int i = 0; i < 3; ++i) found.push_back({fmt::format("{}.{}", name, "xyz"[i]), &value[i], info});
  }
  void integer(std::string_view, std::int64_t&, const ParameterInfo&) override {}
  void flag(std::string_view, bool&, const ParameterInfo&) override {}
  void text(std::string_view, std::string&, const ParameterInfo&) override {}
  void numbers(std::string_view, std::vector<double>&, const ParameterInfo&) override {}
  void texts(std::string_view, std::vector<std::string>&, const ParameterInfo&) override {}
};

// sets which rotor an effect of one rotor is of
class RotorSetter final : public ParameterVisitor {
 public:
  explicit RotorSetter(int rotor) : rotor_(rotor) {}
  void integer(std::string_view name, std::int64_t& value, const ParameterInfo&) override {
    if (name == "rotor") value = rotor_;
  }
  void number(std::string_view, double&, const ParameterInfo&) override {}
  void flag(std::string_view, bool&, const ParameterInfo&) override {}
  void text(std::string_view, std::string&, const ParameterInfo&) override {}
  void numbers(std::string_view, std::vector<double>&, const ParameterInfo&) override {}
  void texts(std::string_view, std::vector<std::string>&, const ParameterInfo&) override {}
  void vector(std::string_view, Vector3&, const ParameterInfo&) override {}

 private:
  int rotor_;
};

// whether a vehicle's own effect is this group: of a rotor's effect, that rotor's
bool is_of(const EffectSpec& spec, const Group& group) {
  if (spec.type != group.row->name) return false;
  const auto rotor =
      std::find_if(spec.values.begin(), spec.values.end(), [](const auto& value) { return value.first == "rotor"; });
  return group.rotor == 0 || (rotor != spec.values.end() && rotor->second == std::to_string(group.rotor));
}

struct Missing {
  Need need;
  std::string_view why;
  Lack lack;
};
constexpr Missing missing[] = {
    {Need::attitude, "no attitude in the logs", Lack::attitude},
    {Need::motion, "neither position nor velocity in the logs", Lack::motion},
    {Need::torque, "these logs tell no torque", Lack::torque},
    {Need::accelerometer, "no accelerometer in the logs", Lack::accelerometer},
    {Need::gyro, "no gyroscope in the logs", Lack::body_rate},
    {Need::ground, "no ground height in the logs (environment.ground_z_m)", Lack::surroundings},
    {Need::ceiling, "no ceiling height in the logs (environment.ceiling_z_m)", Lack::surroundings},
    {Need::wall, "no walls in the logs (environment.walls)", Lack::surroundings}};

// why an effect is not identifiable in flights, whatever the vehicle file says; no value when they do
std::optional<NotIdentifiable> why_not_observable(const EffectRow& row, const Catalogue::Seen& seen) {
  const auto because = [&](std::string_view why, Lack lack) {
    return NotIdentifiable{std::string(row.name), std::string(why), lack};
  };
  if (seen.inertial_unused && row.asks(Need::accelerometer))
    return because("the accelerometer is not used: the commands tell forces alone, and the pose shows those",
                   Lack::torque);
  for (const auto& [need, why, lack] : missing) {
    if (!row.asks(need) || seen.observes(need)) continue;
    if (need != Need::torque || !seen.mean_torques) return because(why, lack);
    if (!shifts_torques(row)) return because("these logs tell torques over two seconds alone", lack);
  }
  if (row.needs_any != Need::nothing && !seen.observes(row.needs_any)) return because(row.lacking, Lack::other);
  if (seen.thrust_jitters && (row.commanded || row.on_command) && row.in_hover == InHover::nothing)
    return because("the commanded thrust jitters from sample to sample: only its mean is known", Lack::torque);
  if (seen.trims && !row.hidden_by_filter.empty()) return because(row.hidden_by_filter, Lack::raw_sensors);
  return std::nullopt;
}

bool is_fitted(const Number& number, const Catalogue::Seen& seen) {
  switch (number.info.fitted) {
    case Fitted::always:
      return true;
    case Fitted::with_voltage:
      return seen.voltage;
    case Fitted::without_voltage:
      return !seen.voltage;
    case Fitted::unless_negative:
      return !(*number.value < 0.0);
    case Fitted::never:
      return false;
  }
  return true;
}

// what the vehicle file does not have and an effect needs
std::optional<VehicleGap> gap_of(const EffectRow& row, const VehicleModel& vehicle) {
  for (const VehicleGap& gap : gaps_of(vehicle))
    if (row.asks(gap.need)) return gap;
  return std::nullopt;
}

// Shown by neither a mean torque nor a force, or alike to another effect once moments of inertia are not identifiable.
bool needs_torque_gain(const EffectRow& row) {
  return (row.commanded && row.asks(Need::torque) && row.in_hover == InHover::nothing) || !row.never_beside.empty();
}

}  // namespace

bool shifts_torques(const EffectRow& row) { return row.in_hover == InHover::center || row.in_hover == InHover::rotor; }

std::vector<Number> numbers_of(Parameterized& effect) {
  NumberCollector collector;
  effect.visit(collector);
  return collector.found;
}

double scale_of(Scale scale, const VehicleModel& vehicle) {
  switch (scale) {
    case Scale::one:
      return 1.0;
    case Scale::weight:
      return vehicle.weight_N();
    case Scale::arm:
      return vehicle.arm_m();
    case Scale::rotor_torque_per_speed:
      return vehicle.weight_N() * vehicle.arm_m() / (vehicle.rotor_count * vehicle.hover_speed_radps());
    case Scale::yaw_inertia:
      return vehicle.inertia_B_kgm2(2, 2);
    case Scale::weight_per_inflow: {
      const double disc_m2 = vehicle.rotor_count * pi * vehicle.rotor_radius_m * vehicle.rotor_radius_m;
      return std::sqrt(2.0 * air_density_kgpm3 * disc_m2 * vehicle.weight_N());  // W / v_i
    }
  }
  return 1.0;
}

Catalogue::Catalogue(const VehicleModel& vehicle, int flights, const Seen& seen) : vehicle_(vehicle), seen_(seen) {
  for (const EffectRow& row : effect_registry()) {
    if (row.per_rotor)
      for (int rotor = 1; rotor <= vehicle.rotor_count; ++rotor) add_effect(row, rotor, flights);
    else add_effect(row, 0, flights);
  }
  add_biases(flights);
  if (seen.trims || seen.observes(Need::torque)) add_trims(flights);
  if (!seen.trims && seen.observes(Need::torque)) add_command_innovation();
}

void Catalogue::add_effect(const EffectRow& row, int rotor, int flights) {
  Group group;
  group.label = rotor > 0 ? fmt::format("{}#{}", row.name, rotor) : std::string(row.name);
  group.row = &row;
  group.rotor = rotor;
  group.nominal = std::any_of(vehicle_.effects.begin(), vehicle_.effects.end(),
                              [&](const EffectSpec& spec) { return is_of(spec, group); });
  // a number that the file does not have has no effect; a torque ratio that was estimated is fitted, and never named
  const auto gap = gap_of(row, vehicle_);
  group.candidate = row.diagnosable && !why_not_observable(row, seen_) && (!gap || gap->need == Need::torque_ratio);
  if (!row.is_predictable() || (!group.candidate && !group.nominal)) return;
  const auto effect = make(group);
  const auto numbers = numbers_of(*effect);
  for (std::size_t p = 0; group.candidate && p < numbers.size(); ++p) {
    if (!is_fitted(numbers[p], seen_)) continue;
    Column column = column_of(row, numbers[p]);
    column.group = static_cast<int>(groups_.size());
    column.parameter = static_cast<int>(p);
    for (int f = 0; f < (row.per_flight ? flights : 1); ++f) {
      column.flight = row.per_flight ? f : -1;
      group.columns.push_back(size());
      columns_.push_back(column);
    }
  }
  groups_.push_back(std::move(group));
}

Column Catalogue::column_of(const EffectRow& row, const Number& number) const {
  Column column;
  column.name = number.name;
  column.unit = number.info.unit;
  const double scale = scale_of(number.info.scale, vehicle_);
  column.natural = number.info.natural * scale;
  column.tolerance = column.unfiltered_tolerance = number.info.tolerance * scale;
  column.estimate_tolerance = number.info.estimate_tolerance * scale;
  // how late and how smooth rotors answer, a filter looks like
  if (seen_.smoothing && row.place == Place::actuation && column.unit == "s")
    column.tolerance = std::max(column.tolerance, decisions::filter_lag_s);
  // and what a filter of the attitude takes of a turn, another one of the gyroscope leaves
  if (seen_.trims && row.corrects == Corrects::rate_scale)
    column.tolerance = std::max(column.tolerance, decisions::filter_rate_share);
  column.min = number.info.min;
  column.max = number.info.max;
  column.nominal = *number.value;
  column.known_to = number.info.known_to * scale;
  if (const double plausible =
          number.info.plausible * scale_of(number.info.plausible_scale.value_or(number.info.scale), vehicle_);
      plausible > 0.0) {
    column.max = plausible;
    column.min = std::max(number.info.min, number.info.plausible_from.value_or(-plausible));
  }
  // below zero it would be as the number before it
  if (number.info.fitted == Fitted::unless_negative) column.min = 0.0;
  // a switch, near one
  if (row.column == ColumnFrom::speed_limit)
    column.natural = 1.0, column.tolerance = 0.0, column.min = 0.5, column.max = 1.6, column.nominal = 0.0;
  return column;
}

void Catalogue::add_biases(int flights) {
  for (int f = 0; f < flights; ++f)
    for (int p = 0; p < (seen_.observes(Need::accelerometer) ? 6 : 3); ++p) {
      Column bias;
      bias.parameter = p;
      bias.flight = f;
      bias.name = fmt::format("{}_bias_{}", p < 3 ? "gyro" : "accelerometer", "xyz"[p % 3]);
      bias.unit = p < 3 ? "rad/s" : "m/s^2";
      bias.natural = p < 3 ? 0.02 : 0.1;
      bias.min = p < 3 ? -1.0 : -5.0;
      bias.max = -bias.min;
      columns_.push_back(bias);
    }
}

void Catalogue::add_command_innovation() {
  constexpr int innovations = loop_between_of - command_innovation_of;
  for (int p = 0; p < (seen_.slow_commands ? static_cast<int>(CommandInnovation::RowsAtCompileTime) : innovations);
       ++p) {
    Column innovation;
    innovation.parameter = command_innovation_of + p;
    innovation.name = fmt::format("command_innovation_{}", p);
    innovation.max = 1e3;
    innovation.min = -innovation.max;
    columns_.push_back(innovation);
  }
}

void Catalogue::add_trims(int flights) {
  struct OfAFlight {
    const char *name, *unit;
    double natural, most;
  };
  constexpr OfAFlight all[] = {{"torque_trim_x", "rad/s^2", torque_trim_sd, 50.0},
                               {"torque_trim_y", "rad/s^2", torque_trim_sd, 50.0},
                               {"torque_trim_z", "rad/s^2", torque_trim_sd, 50.0},
                               {"command_clock", "s", command_clock_sd, 0.06},
                               {"command_smoothing", "s^2", command_smoothing_sd, 9e-4}};
  for (int f = 0; f < flights; ++f)
    for (int p = torque_trim; p <= (!seen_.trims      ? command_clock - 1
                                    : seen_.smoothing ? command_smoothing
                                                      : command_clock);
         ++p) {
      const OfAFlight& known = all[p - torque_trim];
      Column trim;
      trim.parameter = p;
      trim.flight = f;
      trim.name = known.name;
      trim.unit = known.unit;
      trim.natural = known.natural;
      trim.max = known.most;
      trim.min = -trim.max;
      columns_.push_back(trim);
    }
}

std::optional<NotIdentifiable> Catalogue::why_left_out(const EffectRow& row) const {
  if (loop_answers_ && needs_torque_gain(row))
    return NotIdentifiable{
        std::string(row.name),
        "within half a second the recorded loop answers what disturbs the vehicle: the torque per command is not told",
        Lack::raw_sensors};
  if (const auto lacking = why_not_observable(row, seen_)) return lacking;
  const auto gap = gap_of(row, vehicle_);
  if (gap) return NotIdentifiable{std::string(row.name), gap->says(), Lack::vehicle_file};
  return std::nullopt;
}

std::unique_ptr<Effect> Catalogue::make(const Group& group) const {
  std::unique_ptr<Effect> effect;
  for (const EffectSpec& spec : vehicle_.effects)
    if (is_of(spec, group)) effect = std::move(make_effects({spec}).front().effect);
  if (!effect) effect = group.row->make();
  if (group.rotor > 0) {
    RotorSetter setter(group.rotor);
    effect->visit(setter);
  }
  // a lag that is alike up and down becomes two equal numbers, so that both can be fitted
  const auto numbers = numbers_of(*effect);
  for (std::size_t p = 1; p < numbers.size() && seen_.observes(Need::motion); ++p)
    if (numbers[p].info.fitted == Fitted::unless_negative && *numbers[p].value < 0.0)
      *numbers[p].value = *numbers[p - 1].value;
  return effect;
}

void Catalogue::hide_torque_gains() {
  loop_answers_ = true;
  for (Group& group : groups_)
    if (needs_torque_gain(*group.row)) group.candidate = false;
}

void Catalogue::compare_with_reference() {
  for (Group& group : groups_) {
    if (group.row->built_in) group.candidate = false;
    if (group.row->corrects != Corrects::rate_scale) continue;
    for (const int c : group.columns) {
      Column& column = columns_[static_cast<std::size_t>(c)];
      column.tolerance = column.unfiltered_tolerance;
    }
  }
}

void Catalogue::freeze(int column) {
  const int g = columns_[static_cast<std::size_t>(column)].group;
  std::erase(groups_[static_cast<std::size_t>(g)].columns, column);
}

void Catalogue::thaw(int column) {
  const int g = columns_[static_cast<std::size_t>(column)].group;
  std::vector<int>& asked = groups_[static_cast<std::size_t>(g)].columns;
  asked.insert(std::ranges::lower_bound(asked, column), column);
}

bool Catalogue::asks_last(int group) const {
  int last = size() - 1;
  while (last >= 0 && columns_[static_cast<std::size_t>(last)].group != group) --last;
  const std::vector<int>& asked = groups_[static_cast<std::size_t>(group)].columns;
  return !asked.empty() && asked.back() == last;
}

Eigen::VectorXd Catalogue::nominal() const {
  Eigen::VectorXd value(size());
  for (int c = 0; c < size(); ++c) value[c] = columns_[static_cast<std::size_t>(c)].nominal;
  return value;
}

int Catalogue::find(std::string_view label) const {
  for (std::size_t g = 0; g < groups_.size(); ++g)
    if (groups_[g].label == label) return static_cast<int>(g);
  return -1;
}

int Catalogue::find(const std::function<bool(const EffectRow&)>& is) const {
  for (std::size_t g = 0; g < groups_.size(); ++g)
    if (groups_[g].row->diagnosable && !groups_[g].columns.empty() && is(*groups_[g].row)) return static_cast<int>(g);
  return -1;
}

int Catalogue::find(ColumnFrom column) const {
  return find([column](const EffectRow& row) { return row.column == column; });
}

int Catalogue::find(Airflow air) const {
  return find([air](const EffectRow& row) { return row.air == air; });
}

int Catalogue::find(Place place, Latency latency) const {
  return find([=](const EffectRow& row) { return row.place == place && row.latency == latency; });
}

std::vector<NamedEffect> Catalogue::effects(const Eigen::VectorXd& value, int flight, int also) const {
  std::vector<NamedEffect> result;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const Group& group = groups_[g];
    bool acts = static_cast<int>(g) == also || !group.candidate;
    for (const int c : group.columns) acts = acts || value[c] != 0.0;
    if (!acts || (group.candidate && group.row->is_history())) continue;
    auto effect = make(group);
    const auto numbers = numbers_of(*effect);
    for (const int c : group.columns) {
      const Column& column = columns_[static_cast<std::size_t>(c)];
      if (column.flight < 0 || column.flight == flight)
        *numbers[static_cast<std::size_t>(column.parameter)].value = value[c];
    }
    result.push_back({group.row, std::move(effect)});
  }
  return result;
}

void Catalogue::set_swing(const Swing& swing) {
  for (Group& group : groups_)
    if (group.row->column == ColumnFrom::swing) group.swing = swing;
}

void Catalogue::set_speed_limit(double limit_radps) {
  for (Group& group : groups_)
    if (group.row->column == ColumnFrom::speed_limit) group.limit_radps = limit_radps;
}

SensorCorrection Catalogue::sensor_correction(const Eigen::VectorXd& value, int flight) const {
  SensorCorrection correction;
  for (int c = 0; c < size(); ++c) {
    const Column& column = columns_[static_cast<std::size_t>(c)];
    if (column.flight >= 0 && column.flight != flight) continue;
    if (column.group < 0) {
      if (column.parameter < force_bias) correction.rate_bias_B_radps[column.parameter] = value[c];
      continue;
    }
    const EffectRow& row = *groups_[static_cast<std::size_t>(column.group)].row;
    if (row.corrects == Corrects::attitude) correction.attitude_offset_B_rad[column.parameter] += value[c];
    if (row.corrects == Corrects::heading) correction.attitude_offset_B_rad[2] += value[c];
    if (row.corrects == Corrects::rate_scale) correction.rate_scale = value[c];
    if (row.place == Place::measurement && row.latency == Latency::delay) correction.pose_delay_s = value[c];
  }
  return correction;
}

void Catalogue::clamp(Eigen::VectorXd& value) const {
  for (int c = 0; c < size(); ++c) {
    const Column& column = columns_[static_cast<std::size_t>(c)];
    // what is not there is not bounded either
    if (value[c] != column.nominal) value[c] = std::clamp(value[c], column.min, column.max);
  }
}

std::vector<int> own_columns(const Catalogue& catalogue, const std::vector<int>& groups, int group) {
  std::vector<int> own = catalogue.group(group).columns;
  // only c_τ k_f / J_z is visible: with another torque ratio the moment of inertia in yaw stays as it is, unless a drag at the
  // hubs or the rotors' own inertia turns against it
  const auto in = [&](std::string_view label) {
    return std::find(groups.begin(), groups.end(), catalogue.find(label)) != groups.end();
  };
  const std::string_view name = catalogue.group(group).row->name;
  for (const int g : groups) {
    const ExactAlias& alias = catalogue.group(g).row->alias;
    if (alias.effect == name && std::none_of(alias.unless.begin(), alias.unless.end(), in) &&
        catalogue.asks_last(group))
      own.pop_back();
  }
  return own;
}

std::vector<int> columns_of(const Catalogue& catalogue, const std::vector<int>& groups) {
  std::vector<int> columns;
  for (const int g : groups) {
    const std::vector<int> own = own_columns(catalogue, groups, g);
    columns.insert(columns.end(), own.begin(), own.end());
  }
  return columns;
}

}  // namespace gustlab::diagnosis
