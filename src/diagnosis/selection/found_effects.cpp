#include "diagnosis/selection/found_effects.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "config/toml.hpp"
#include "diagnosis/result/decisions.hpp"

namespace gustlab::diagnosis {

namespace {

double with_model_form(double deviation, double value, double nominal) {
  return std::hypot(deviation, decisions::model_form * (value - nominal));
}

}  // namespace

std::vector<NamedValue> values_of(const Catalogue& catalogue, const Selection& selection, const Group& group,
                                  int flight) {
  std::vector<NamedValue> values;
  if (group.rotor > 0) values.push_back({"rotor", "-", static_cast<double>(group.rotor), 0.0});
  if (group.row->column == ColumnFrom::swing)
    values.push_back({"length", "m", group.swing.length_m,
                      std::hypot(group.swing.length_deviation_m, decisions::cable_form * group.swing.length_m)});
  if (group.row->column == ColumnFrom::speed_limit)
    return {{"max_speed", "rad/s", group.limit_radps, 0.01 * group.limit_radps}};
  // mean over flights of values per flight
  std::vector<std::pair<int, std::vector<int>>> by_parameter;
  for (const int c : group.columns) {
    const Column& column = catalogue.column(c);
    if (flight >= 0 && column.flight != flight) continue;
    auto at = std::find_if(by_parameter.begin(), by_parameter.end(),
                           [&](const auto& p) { return p.first == column.parameter; });
    if (at == by_parameter.end()) at = by_parameter.insert(at, {column.parameter, {}});
    at->second.push_back(c);
  }
  for (const auto& [parameter, columns] : by_parameter) {
    NamedValue value;
    double variance = 0.0;
    for (const int c : columns) {
      const Column& column = catalogue.column(c);
      value.name = column.name;
      value.unit = column.unit;
      value.value += selection.value[c] / static_cast<double>(columns.size());
      const double sd = with_model_form(selection.deviation[c], selection.value[c], column.nominal);
      variance += sd * sd / std::pow(static_cast<double>(columns.size()), 2);
    }
    value.deviation = std::sqrt(variance);
    values.push_back(value);
  }
  return values;
}

std::vector<EffectSpec> effects_found(const Catalogue& catalogue, const Selection& selection) {
  std::vector<EffectSpec> specs;
  for (const Finding& finding : selection.findings) {
    const Group& group = catalogue.group(finding.group);
    EffectSpec& spec = specs.emplace_back();
    spec.type = group.row->name;
    for (const NamedValue& value : values_of(catalogue, selection, group, -1))
      spec.values.emplace_back(
          value.name, value.name == "rotor" ? fmt::format("{:.0f}", value.value) : config::shortest(value.value));
  }
  return specs;
}

}  // namespace gustlab::diagnosis
