#include "diagnosis/selection/selection.hpp"

namespace gustlab::diagnosis {

std::vector<int> Selection::groups() const {
  std::vector<int> result;
  for (const Finding& finding : findings) result.push_back(finding.group);
  return result;
}

const Finding* Selection::find(int group) const {
  for (const Finding& finding : findings)
    if (finding.group == group) return &finding;
  return nullptr;
}

bool equal(const Rival& rival, const Finding& finding) {
  return rival.z < decisions::equivalent_z && rival.delta_chi2 < decisions::most_lost_to_rival * finding.delta_chi2;
}

}  // namespace gustlab::diagnosis
