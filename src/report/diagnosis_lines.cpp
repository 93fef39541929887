#include "report/diagnosis_lines.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "report/diagnosis_candidates.hpp"

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

std::string speaks_against(const report::Json& record) {
  const std::string weak = report::weak_points_of(record);
  return weak.empty() ? "" : "    what speaks against it: " + weak + "\n";
}

}  // namespace

std::string diagnosis_lines(const diagnosis::Diagnosis& result) {
  std::string lines = fmt::format("{}: {}\n", result.vehicle, to_string(result.verdict));
  for (const auto& effect : result.effects) lines += "  " + name_line(effect) + "\n";
  const report::Json document = to_json(result);
  const report::Json& evidence = report::part(document, "evidence");
  for (std::size_t i = 0; i < result.suspected.size(); ++i) {
    lines += "  only suspected: " + name_line(result.suspected[i]) + "\n";
    for (const report::Json& record : evidence)
      if (report::same_candidate(record, document["suspected"][i])) lines += speaks_against(record);
  }
  for (const report::Json& record : evidence)
    if (report::surprises(document, record))
      lines += fmt::format("  not named: {}, though it removes {:.0f} % of the error 0.5 s ahead (confidence {:.2f})\n",
                           diagnosis::with_rotor(report::text(record, "effect"), record.value("rotor", 0)),
                           100.0 * report::removed_share(record), report::number(record, "probability")) +
               speaks_against(record);
  return lines;
}

}  // namespace gustlab
