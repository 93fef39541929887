#include "diagnosis/evidence/suspect.hpp"

namespace gustlab::diagnosis {

void suspect(Diagnosis& out, const std::string& why, const std::function<bool(const EffectFinding&)>& stands) {
  std::erase_if(out.effects, [&](const EffectFinding& effect) {
    if (stands(effect)) return false;
    out.rejected.push_back({with_rotor(effect.effect, effect.rotor()), effect.delta_chi2 - effect.price, why});
    return true;
  });
}

}  // namespace gustlab::diagnosis
