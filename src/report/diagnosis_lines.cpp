#include "report/diagnosis_lines.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace gustlab {

namespace {

std::string name_line(const diagnosis::EffectFinding& effect) {
  std::string line = effect.effect;
  for (const auto& value : effect.parameters)
    line += fmt::format(" {} = {:.4g}{}", value.name, value.value, value.unit == "-" ? "" : " " + value.unit);
  const std::size_t flights = effect.per_flight.size();
  line += fmt::format(" ({}confidence {:.2f})", flights > 1 ? fmt::format("means of {} flights, ", flights) : "",
                      effect.confidence);
  std::vector<std::string> others = effect.classmates;
  std::erase(others, effect.effect);
  if (!others.empty())
    line += fmt::format("\n    or {}: these flights cannot tell {} apart", fmt::join(others, " or "),
                        others.size() > 1 ? "them" : "the two");
  return line;
}

}  // namespace

std::string diagnosis_lines(const diagnosis::Diagnosis& result) {
  std::string lines = fmt::format("{}: {}\n", result.vehicle, to_string(result.verdict));
  for (const auto& effect : result.effects) lines += "  " + name_line(effect) + "\n";
  for (const auto& effect : result.suspected) lines += "  only suspected: " + name_line(effect) + "\n";
  return lines;
}

}  // namespace gustlab
