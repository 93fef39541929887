// What the fuzzers began with and what they found, read once more: an answer or a UserError, and nothing else.
#include "fuzz/readers.hpp"

#include <gtest/gtest.h>

#include "gustlab/build_info.hpp"
#include "gustlab/errors.hpp"
#include "support/temporary_folder.hpp"

namespace gustlab {
namespace {

class Readers : public testing::TestWithParam<fuzz::ReaderTarget> {};

TEST_P(Readers, AnswerEveryInputOfTheirCorpus) {
  const std::filesystem::path corpus =
      std::filesystem::path(source_directory()) / "tests" / "fuzz" / "corpus" / GetParam().name;
  int inputs = 0, read = 0;
  for (const auto& entry : std::filesystem::directory_iterator(corpus)) {
    const TemporaryFolder folder;
    SCOPED_TRACE(entry.path());
    ++inputs;
    try {
      GetParam().read(read_text(entry.path()), folder.path().string());
      ++read;
    } catch (const UserError& error) {
      EXPECT_NE(std::string(error.what()), "");
      EXPECT_NE(error.exit_code(), 4) << error.what();
    }
  }
  EXPECT_GE(inputs, 2);
  EXPECT_GE(read, 1) << "a corpus begins with an input that is right";
}

INSTANTIATE_TEST_SUITE_P(All, Readers, testing::ValuesIn(fuzz::reader_targets()),
                         [](const auto& one) { return std::string(one.param.name); });

}  // namespace
}  // namespace gustlab
