#include "gustlab/build_info.hpp"

#include <gmock/gmock.h>
#include <mujoco/mujoco.h>

#include <filesystem>
#include <string>

namespace gustlab {
namespace build_info_test {

using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::Not;

TEST(BuildInfo, NamesVersionCommitAndCompiler) {
  EXPECT_THAT(std::string(build_info().version), MatchesRegex("[0-9]+\\.[0-9]+\\.[0-9]+"));
  EXPECT_THAT(std::string(build_info().commit), MatchesRegex("[0-9a-f]{12}(-dirty)?|unknown"));
  EXPECT_THAT(std::string(build_info().compiler), HasSubstr(__VERSION__));
}

TEST(BuildInfo, LibraryLoadedIsTheOneBuiltAgainst) {
  EXPECT_EQ(build_info().mujoco_version, mj_versionString());
  EXPECT_EQ(mj_version(), mjVERSION_HEADER);
}

TEST(BuildInfo, FlagsKeepFloatingPointReproducible) {
  const std::string flags(build_info().flags);
  EXPECT_THAT(flags, HasSubstr("-ffp-contract=off"));
  EXPECT_THAT(flags, Not(HasSubstr("-march=native")));
  EXPECT_THAT(flags, Not(HasSubstr("fast")));
}

TEST(SourceDirectory, IsTheRootOfTheTree) {
  EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(source_directory()) / "CMakePresets.json"));
}

}  // namespace build_info_test
}  // namespace gustlab
