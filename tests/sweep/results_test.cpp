#include "sweep/results.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "gustlab/errors.hpp"
#include "util/files.hpp"

namespace gustlab {
namespace results_test {

namespace fs = std::filesystem;

class ResultsCsv : public testing::Test {
 protected:
  std::string path_ = (fs::path(testing::TempDir()) / "gustlab_results_test.csv").string();
  void TearDown() override { fs::remove(path_); }

  std::string message_for(const std::string& text) {
    write_file(path_, text);
    try {
      read_results_csv(path_);
    } catch (const DataError& error) {
      return error.what();
    }
    return "";
  }
};

const std::string header =
    "experiment,vehicle,trajectory,controller,replicate,outcome,duration_s,rmse_xy_m,mae_xy_m,p95_xy_m,max_xy_m,rmse_z_"
    "m,key\n";

TEST_F(ResultsCsv, ReadsBackWhatWasWritten) {
  ResultRow row{"e", "iris", "circle", "pid", 7, Outcome::crashed, 1.0 / 3.0, 0.1, 0.2, 0.3, 0.4, 0.5, "0123"};
  ResultRow empty{"e", "iris", "circle", "pid", 8, Outcome::diverged, 0.0};
  write_file(path_, to_csv({row, empty}));
  const auto rows = read_results_csv(path_);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].duration_s, 1.0 / 3.0);
  EXPECT_EQ(rows[0].outcome, Outcome::crashed);
  EXPECT_EQ(rows[0].key, "0123");
  EXPECT_TRUE(std::isnan(rows[1].rmse_xy_m));
  EXPECT_EQ(to_csv(rows), to_csv({row, empty}));
  EXPECT_EQ(to_csv({}), header.substr(0, header.size() - 1) + ",rotor_sd_radps,rotor_rate_radps2\n");
}

// GIVEN rows with effort and axes, and a table of an older program that has neither WHEN read THEN all that is there comes back
TEST_F(ResultsCsv, ReadsAxesAndTablesWithoutEffort) {
  ResultRow row{"e", "iris", "circle", "pid", 7, Outcome::completed, 1.0, 0.1, 0.2, 0.3, 0.4, 0.5, "0123"};
  row.rotor_sd_radps = 40.0;
  row.axes = {{"strength", "0.5"}, {"mass", "-0.2"}};
  write_file(path_, to_csv({row}));
  const auto rows = read_results_csv(path_);
  EXPECT_EQ(rows[0].axes, row.axes);
  EXPECT_EQ(rows[0].rotor_sd_radps, 40.0);
  EXPECT_EQ(to_csv(rows), to_csv({row}));
  write_file(path_, header + "e,v,t,c,1,completed,1,1,1,1,1,1,k\n");
  EXPECT_TRUE(std::isnan(read_results_csv(path_)[0].rotor_sd_radps));
}

// GIVEN a table whose lines end as on Windows WHEN read THEN it is the same table
TEST_F(ResultsCsv, ReadsLinesOfAnySystem) {
  ResultRow row{"e", "iris", "circle", "pid", 7, Outcome::completed, 1.0, 0.1, 0.2, 0.3, 0.4, 0.5, "0123"};
  row.rotor_rate_radps2 = 148.75;
  for (const std::vector<NamedValue>& axes : {std::vector<NamedValue>{}, {{"mass", "-0.2"}}}) {
    row.axes = axes;
    std::string text = to_csv({row});
    for (std::size_t end = 0; (end = text.find('\n', end)) != std::string::npos; end += 2) text.insert(end, 1, '\r');
    write_file(path_, text);
    EXPECT_EQ(to_csv(read_results_csv(path_)), to_csv({row}));
  }
}

TEST_F(ResultsCsv, SaysWhereATableIsBroken) {
  EXPECT_THAT(message_for("a,b\n"), testing::HasSubstr(":1:1: not a table of runs"));
  EXPECT_THAT(message_for(header + "e,v,t,c,1,completed,1,1,1,1,1\n"), testing::HasSubstr(":2:30: a cell is missing"));
  EXPECT_THAT(message_for(header + "e,v,t,c,1,completed,1,x,1,1,1,1,k\n"),
              testing::HasSubstr(":2:23: \"x\" is not a number"));
  EXPECT_THAT(message_for(header + "e,v,t,c,1,flew,1,1,1,1,1,1,k\n"),
              testing::HasSubstr(":2:11: \"flew\" is no outcome"));
  EXPECT_THAT(message_for(header + "e,v,t,c,1,completed,1,1,1,1,1,1,k,z\n"), testing::HasSubstr("too many cells"));
  // only a run that was not completed may have no error
  for (const auto& [cells, column] : {std::pair{"1,,1,1,1,1", 23}, {"1,1,1,1,1,", 31}, {",1,1,1,1,1", 21}})
    EXPECT_THAT(message_for(header + "e,v,t,c,1,completed," + cells + ",k\n"),
                testing::HasSubstr(":2:" + std::to_string(column) + ": the cell is empty, and the run was completed"));
  EXPECT_EQ(message_for(header + "e,v,t,c,1,crashed,1,,,,,,k\n"), "");
  EXPECT_THROW(read_results_csv("/nonexistent/runs.csv"), DataError);
}

}  // namespace results_test
}  // namespace gustlab
