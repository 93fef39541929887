#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "gustlab/build_info.hpp"
#include "gustlab/controller.hpp"
#include "gustlab/effect.hpp"
#include "gustlab/trajectory.hpp"
#include "support/program.hpp"

namespace gustlab {
namespace program_test {

using test::Said;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

TEST(Program, SaysItsVersionAndHelp) {
  const Said version = test::gustlab({"--version"});
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_THAT(version.out, StartsWith("gustlab " + std::string(build_info().version)));
  EXPECT_THAT(version.out, HasSubstr("MuJoCo 4.0.1"));
  const Said help = test::gustlab({"replay", "--help"});
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_THAT(help.out, HasSubstr("--horizon"));
}

// the proxy of Table III, the quickest of the three
TEST(Program, ReproducesATableAndGoesOnWhereItStands) {
  const TemporaryFolder folder;
  const Said said = test::gustlab({"reproduce", "table3", "--out", folder.file("out"), "--quiet"});
  ASSERT_EQ(said.exit_code, 0) << said.err;
  const std::string text = read_text(folder.file("out/reproduction.json"));
  const auto json = nlohmann::json::parse(text);
  ASSERT_EQ(json["cells"].size(), 12u);
  for (const auto& cell : json["cells"]) EXPECT_EQ(cell["use"], "proxy");
  EXPECT_EQ(said.out, read_text(folder.file("out/reproduction.md")));
  EXPECT_THAT(read_text(folder.file("out/figures/ours_against_paper.svg")), StartsWith("<svg"));
  EXPECT_EQ(test::gustlab({"reproduce", "table3", "--out", folder.file("out")}).exit_code, 0);
  EXPECT_EQ(read_text(folder.file("out/reproduction.json")), text);
  EXPECT_EQ(test::gustlab({"reproduce", "table4", "--out", folder.file("out")}).exit_code, 2);
}

TEST(Program, ListsEveryRegistry) {
  const Said said = test::gustlab({"list", "--format", "json"});
  ASSERT_EQ(said.exit_code, 0) << said.err;
  const auto all = nlohmann::json::parse(said.out);
  ASSERT_EQ(all["effects"].size(), effect_registry().size());
  for (std::size_t i = 0; i < effect_registry().size(); ++i)
    EXPECT_EQ(all["effects"][i]["name"], effect_registry()[i].name);
  EXPECT_EQ(all["controllers"].size(), controller_registry().size());
  EXPECT_EQ(all["trajectories"].size(), trajectory_registry().size());
  EXPECT_GE(all["vehicles"].size(), 4u);
  const Said effects = test::gustlab({"list", "effects"});
  EXPECT_THAT(effects.out, HasSubstr("  rotor_drag "));
  EXPECT_THAT(effects.out, Not(HasSubstr("circle")));
}

TEST(Program, PrintsDefaultsOfEverythingThatItLists) {
  const auto all = nlohmann::json::parse(test::gustlab({"list", "--format", "json"}).out);
  for (const char* kind : {"effects", "controllers", "trajectories"})
    for (const auto& row : all[kind]) {
      const Said said = test::gustlab({"defaults", row["name"].get<std::string>()});
      EXPECT_EQ(said.exit_code, 0) << said.err;
      EXPECT_THAT(said.out, StartsWith("# "));
      for (const auto& parameter : row["parameters"])
        EXPECT_THAT(said.out, HasSubstr("\n" + parameter["name"].get<std::string>() + " = "));
    }
  EXPECT_EQ(test::gustlab({"defaults", "experiment"}).exit_code, 0);
}

TEST(Program, RunsFromAnyFolderAndPrintsNoColourIntoAFile) {
  const TemporaryFolder folder;
  const Said said = test::gustlab({"list", "vehicles"}, folder.path().string());
  EXPECT_EQ(said.exit_code, 0) << said.err;
  EXPECT_THAT(said.out, HasSubstr("crazyflie"));
  EXPECT_THAT(said.out + said.err, Not(HasSubstr("\033")));
}

}  // namespace program_test
}  // namespace gustlab
