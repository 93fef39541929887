#include "report/diagnosis_candidates.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "diagnosis/output/weak_points.hpp"
#include "diagnosis/result/decisions.hpp"

namespace gustlab::report {

bool lists(const Json& list, const std::string& effect) {
  return std::any_of(list.begin(), list.end(), [&](const Json& entry) { return text(entry, "effect") == effect; });
}

std::string taken_back_because(const Json& rejected) {
  constexpr std::string_view mark = "only suspected: ";
  const std::string reason = text(rejected, "why");
  return reason.starts_with(mark) ? reason.substr(mark.size()) : "";
}

bool was_taken_back(const Json& diagnosis, const Json& record) {
  const Json& rejected = part(diagnosis, "rejected");
  return std::any_of(rejected.begin(), rejected.end(), [&](const Json& entry) {
    return same_candidate(entry, record) && !taken_back_because(entry).empty();
  });
}

bool same_candidate(const Json& one, const Json& other) { return plain_name(one) == plain_name(other); }

std::string weak_points_of(const Json& record) {
  std::vector<std::string> points;
  for (const Json& point : part(record, "weak_points"))
    if (point.is_string()) points.push_back(point.get<std::string>());
  return diagnosis::in_one_clause(points);
}

double removed_share(const Json& record) {
  const Json &share = part(record, "recovered"), &z = part(record, "recovered_z");
  // too few held-out windows leave both at zero
  const bool flown = share.size() > 1 && share[1].is_number() && z.size() > 1 && z[1].is_number() && z[1] != 0.0;
  return flown ? share[1].get<double>() : std::numeric_limits<double>::quiet_NaN();
}

bool stands_alone(const Json& diagnosis, const Json& record) {
  const std::string effect = text(record, "effect");
  for (const char* list : {"effects", "suspected", "calibration", "not_identifiable"})
    if (lists(part(diagnosis, list), effect)) return false;
  return std::isfinite(number(record, "probability")) && named_instead_of(diagnosis, record).empty() &&
         !was_taken_back(diagnosis, record);
}

bool surprises(const Json& diagnosis, const Json& record) {
  constexpr double much = 0.2;
  return removed_share(record) >= much && number(record, "probability") < diagnosis::decisions::suspected_from &&
         !weak_points_of(record).empty() && stands_alone(diagnosis, record);
}

}  // namespace gustlab::report
