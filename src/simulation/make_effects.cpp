#include "simulation/make_effects.hpp"

#include <fmt/format.h>

#include "config/toml.hpp"
#include "gustlab/errors.hpp"

namespace gustlab {

std::vector<NamedEffect> make_effects(const std::vector<EffectSpec>& specs) {
  std::vector<NamedEffect> effects;
  for (const EffectSpec& spec : specs) {
    const EffectRow* row = find_effect(spec.type);
    if (row == nullptr) {
      std::vector<std::string> names;
      for (const EffectRow& known : effect_registry()) names.emplace_back(known.name);
      const std::string near = config::suggest(spec.type, names);
      throw ConfigError(worded(fmt::format("{}: unknown effect \"{}\"", spec.where, spec.type),
                               near.empty() ? "see `gustlab list effects`" : "", near));
    }
    effects.push_back({row, row->make(), spec});
    config::read_parameters(spec, *effects.back().effect);
  }
  return effects;
}

std::vector<NamedEffect> make_flown_effects(const std::vector<EffectSpec>& specs) {
  std::vector<NamedEffect> effects = make_effects(specs);
  std::erase_if(effects, [](const NamedEffect& effect) { return effect.row->replay_only; });
  return effects;
}

}  // namespace gustlab
