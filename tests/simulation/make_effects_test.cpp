#include "simulation/make_effects.hpp"

#include <gmock/gmock.h>

#include "config/toml.hpp"
#include "gustlab/errors.hpp"

namespace gustlab {
namespace make_effects_test {

std::vector<NamedEffect> make(const char* text) {
  config::Table document = config::Table::parse(text, "f.toml");
  return make_effects(config::read_effects(document));
}

std::string message(const char* text) {
  try {
    make(text);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return {};
}

TEST(MakeEffects, MakesEachWithItsParameters) {
  const auto effects =
      make("[[effect]]\ntype = 'mass'\ndelta = 0.1\n[[effect]]\ntype = 'rotor_drag'\nat_hover = 0.0072\n");
  ASSERT_EQ(effects.size(), 2u);
  EXPECT_EQ(effects[0].row->name, "mass");
  EXPECT_EQ(config::canonical_text(*effects[0].effect), "delta = 0.1\n");
  EXPECT_EQ(config::canonical_text(*effects[1].effect), "at_hover = 0.0072\n");
}

TEST(MakeEffects, ErrorsNameThePlace) {
  EXPECT_EQ(message("[[effect]]\ntype = 'rotor_darg'\n"),
            "f.toml:1:1: unknown effect \"rotor_darg\"; did you mean \"rotor_drag\"?");
  EXPECT_EQ(message("[[effect]]\ntype = 'zebra'\n"),
            "f.toml:1:1: unknown effect \"zebra\" (see `gustlab list effects`)");
  EXPECT_EQ(message("[[effect]]\ntype = 'mass'\ndelta = -2\n"),
            "f.toml:3:9: \"delta\" is out of range (-2 is not from -0.9 to 10)");
  EXPECT_EQ(message("[[effect]]\ntype = 'mass'\nx = 1\n"), "f.toml:3:5: unknown key \"x\" (known: delta)");
}

TEST(MakeEffects, EveryEffectPrintsWhatItReads) {
  for (const EffectRow& row : effect_registry()) {
    const auto fresh = row.make();
    const std::string text = config::canonical_text(*fresh);
    config::Table table = config::Table::parse(text, "f");
    const auto again = row.make();
    config::read_parameters(table, *again);
    EXPECT_EQ(config::canonical_text(*again), text) << row.name;
  }
}

}  // namespace make_effects_test
}  // namespace gustlab
