// Parameters that name files: where they are looked for, and what a run's key sees of them.
#include <gmock/gmock.h>

#include <filesystem>

#include "config/toml.hpp"
#include "gustlab/errors.hpp"
#include "support/temporary_folder.hpp"

namespace gustlab {
namespace input_file_test {

using testing::HasSubstr;
using testing::Not;

struct Owner final : Parameterized {
  InputFile weights;
  void visit(ParameterVisitor& visitor) override { visitor.file("weights", weights, {.help = "a file"}); }
};

Owner read(const std::string& text, const std::string& path) {
  config::Table table = config::Table::parse(text, path);
  Owner owner;
  config::read_parameters(table, owner);
  return owner;
}

TEST(InputFile, IsRelativeToTheFileThatNamesIt) {
  TemporaryFolder folder;
  folder.write("nets/w.txt", "abc");
  const Owner owner = read("weights = \"nets/w.txt\"", folder.file("experiment.toml"));
  EXPECT_EQ(owner.weights.bytes, "abc");
  EXPECT_EQ(owner.weights.path, folder.file("nets/w.txt"));
}

TEST(InputFile, IsElseOneThatIsShipped) {
  TemporaryFolder folder;
  const Owner owner = read("weights = \"models/iris/vehicle.toml\"", folder.file("experiment.toml"));
  EXPECT_THAT(owner.weights.bytes, HasSubstr("iris"));
}

TEST(InputFile, MayBeAbsent) {
  EXPECT_EQ(read("", "experiment.toml").weights.bytes, "");
  EXPECT_EQ(read("weights = \"\"", "experiment.toml").weights.bytes, "");
}

TEST(InputFile, ThatIsMissingIsSaidAtItsPlace) {
  try {
    read("weights = \"none.txt\"", "experiment.toml");
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), testing::StartsWith("experiment.toml:1:"));
    EXPECT_THAT(error.what(), HasSubstr("none.txt"));
  }
}

TEST(InputFile, StandsInAKeyWithItsBytesAndNotWithItsPlace) {
  TemporaryFolder folder;
  folder.write("a/w.txt", "abc");
  folder.write("b/w.txt", "abc");
  folder.write("c/w.txt", "abd");
  const auto text = [&](const char* where) {
    Owner owner = read("weights = \"w.txt\"", folder.file(std::string(where) + "/experiment.toml"));
    return config::canonical_text(owner);
  };
  EXPECT_EQ(text("a"), text("b"));
  EXPECT_NE(text("a"), text("c"));
  EXPECT_THAT(text("a"), Not(HasSubstr("w.txt")));
  Owner owner;
  EXPECT_EQ(config::canonical_text(owner), "weights = \"\"\n");
}

}  // namespace input_file_test
}  // namespace gustlab
