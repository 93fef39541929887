#include "sweep/sweep.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "gustlab/errors.hpp"
#include "support/experiments.hpp"
#include "sweep/sqlite.hpp"

namespace gustlab {
namespace sweep_test {

using test::read_text_experiment;
using test::small_experiment;
using testing::HasSubstr;

class Sweep : public testing::Test {
 protected:
  const Experiment experiment_ = read_text_experiment(small_experiment);
  TemporaryFolder folder_;
  std::atomic<bool> stop_{false};

  SweepReport fly(const Experiment& experiment, SweepOptions options) {
    options.out = folder_.file(options.out);
    return sweep(experiment, options, stop_, [](std::size_t, std::size_t) {});
  }
  std::string csv(const std::string& out) { return read_text(folder_.path() / out / "runs.csv"); }
  // the bytes of one uninterrupted sweep on one thread
  std::string expected() {
    fly(experiment_, {"expected", {}, 1, false});
    return csv("expected");
  }
  template <class Error, class Function>
  std::string message(Function function) {
    try {
      function();
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }
};

TEST_F(Sweep, WritesOneRowForEachPlannedRunInPlanOrder) {
  const SweepReport report = fly(experiment_, {"a", {}, 1, false});
  EXPECT_EQ(report.planned, 6u);
  EXPECT_EQ(report.done, 6u);
  const Results results = read_results(folder_.file("a"));
  ASSERT_EQ(results.rows.size(), 6u);
  const auto runs = plan(experiment_);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    EXPECT_EQ(results.rows[i].experiment, "small");
    EXPECT_EQ(results.rows[i].vehicle, "crazyflie");
    EXPECT_EQ(results.rows[i].trajectory, i < 3 ? "circle" : "hover");
    EXPECT_EQ(results.rows[i].replicate, 1 + static_cast<std::int64_t>(i % 3));
    EXPECT_EQ(results.rows[i].key, to_hex(runs[i].key));
  }
  EXPECT_EQ(csv("a"), to_csv(results.rows));
  EXPECT_EQ(to_csv(read_results_csv(folder_.file("a/runs.csv"))), csv("a"));
  // nothing but the two files
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_.path() / "a"), {}), 2);
}

TEST_F(Sweep, AnyNumberOfThreadsGivesTheSameBytes) {
  const std::string one = expected();
  fly(experiment_, {"two", {}, 2, false});
  fly(experiment_, {"four", {}, 4, false});
  EXPECT_EQ(csv("two"), one);
  EXPECT_EQ(csv("four"), one);
}

TEST_F(Sweep, AnyOrderGivesTheSameRecords) {
  auto runs = plan(experiment_);
  const auto forward = fly_all(experiment_, runs, 1);
  std::reverse(runs.begin(), runs.end());
  auto backward = fly_all(experiment_, runs, 2);
  std::reverse(backward.begin(), backward.end());
  for (std::size_t i = 0; i < forward.size(); ++i) {
    EXPECT_EQ(forward[i].spec.index, backward[i].spec.index);
    EXPECT_EQ(forward[i].error.planar.rmse_m, backward[i].error.planar.rmse_m);
    EXPECT_EQ(forward[i].error.planar.p95_m, backward[i].error.planar.p95_m);
    EXPECT_EQ(forward[i].error.rmse_z_m, backward[i].error.rmse_z_m);
  }
}

TEST_F(Sweep, ThreeShardsMergedAreTheWhole) {
  const std::string whole = expected();
  for (std::size_t part = 1; part <= 3; ++part) {
    const SweepReport report = fly(experiment_, {"part" + std::to_string(part), {part, 3}, 1, false});
    EXPECT_EQ(report.planned, 2u);
  }
  // in any order
  merge({folder_.file("part2"), folder_.file("part3"), folder_.file("part1")}, folder_.file("whole"));
  EXPECT_EQ(csv("whole"), whole);
  EXPECT_EQ(to_csv(read_results(folder_.file("whole")).rows), whole);
}

TEST_F(Sweep, MergeRefusesMissingDoubleAndForeignRuns) {
  for (std::size_t part = 1; part <= 2; ++part) fly(experiment_, {"part" + std::to_string(part), {part, 3}, 1, false});
  fly(experiment_, {"all", {}, 1, false});
  fly(read_text_experiment(small_experiment, {"seed=2"}), {"foreign", {3, 3}, 1, false});
  const auto said = [&](std::vector<std::string> parts) {
    for (std::string& part : parts) part = folder_.file(part);
    return message<DataError>([&] { merge(parts, folder_.file("whole")); });
  };
  EXPECT_THAT(said({"part1", "part2"}), HasSubstr("2 of 6 runs are missing, circle pid 3 the first of them"));
  EXPECT_THAT(said({"part1", "all"}), HasSubstr("both have run circle pid 1"));
  EXPECT_THAT(said({"part1", "part2", "foreign"}), HasSubstr("do not belong together (their experiment differ)"));
  EXPECT_THAT(said({"part1", "nowhere"}), HasSubstr("no results here"));
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "whole"));
}

TEST_F(Sweep, StoppedSweepResumesToTheSameBytes) {
  const std::string whole = expected();
  SweepOptions options{folder_.file("stopped"), {}, 1, false};
  const SweepReport half =
      sweep(experiment_, options, stop_, [&](std::size_t done, std::size_t) { stop_ = done >= 2; });
  EXPECT_EQ(half.done, 2u);
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "stopped/runs.csv"));
  EXPECT_THAT(message<DataError>([&] { read_results(options.out); }), HasSubstr("2 of 6 runs are done"));

  stop_ = false;
  options.resume = true;
  std::size_t first_seen = 99;
  const SweepReport rest = sweep(experiment_, options, stop_,
                                 [&](std::size_t done, std::size_t) { first_seen = std::min(first_seen, done); });
  EXPECT_EQ(first_seen, 2u);
  EXPECT_EQ(rest.done, 6u);
  EXPECT_EQ(csv("stopped"), whole);
}

// so that the time left can be told, and so that what is there early is a table of everything
TEST_F(Sweep, FliesRunsOfEveryCellEarly) {
  const Experiment wide = read_text_experiment(small_experiment, {"replicates=40", "duration_s=0.02"});
  const SweepOptions options{folder_.file("early"), {}, 1, false};
  sweep(wide, options, stop_, [&](std::size_t done, std::size_t all) { stop_ = 10 * done >= all; });
  Database store(options.out + "/runs.sqlite", Database::Mode::read);
  Statement cells = store.prepare("SELECT count(DISTINCT trajectory || controller), count(*) FROM runs");
  ASSERT_TRUE(cells.step());
  EXPECT_EQ(cells.integer(0), 2);
  EXPECT_EQ(cells.integer(1), 8);
}

TEST_F(Sweep, FurtherTrajectoryChangesNoOtherRow) {
  const std::string before = expected();
  fly(read_text_experiment(small_experiment, {"trajectories=[\"circle\", \"spiral\", \"hover\"]"}),
      {"more", {}, 1, false});
  std::string rest;
  std::istringstream lines(csv("more"));
  for (std::string line; std::getline(lines, line);)
    if (line.find(",spiral,") == std::string::npos) rest += line + "\n";
  EXPECT_EQ(rest, before);
  EXPECT_NE(csv("more"), before);
}

TEST_F(Sweep, CrashIsARowWithItsErrors) {
  const Experiment falling =
      read_text_experiment(small_experiment + "[[effect]]\ntype = \"thrust_scale\"\ndelta = -0.9\n");
  fly(falling, {"falling", {}, 1, false});
  for (const ResultRow& row : read_results(folder_.file("falling")).rows) {
    EXPECT_EQ(row.outcome, Outcome::crashed);
    EXPECT_LT(row.duration_s, 1.0);
    EXPECT_GT(row.rmse_z_m, 0.0);
  }
}

TEST_F(Sweep, NeverOverwritesAndNeverMixes) {
  fly(experiment_, {"a", {1, 2}, 1, false});
  const auto said = [&](const Experiment& experiment, const SweepOptions& options) {
    return message<ConfigError>([&] { fly(experiment, options); });
  };
  EXPECT_THAT(said(experiment_, {"a", {1, 2}, 1, false}), HasSubstr("there are results already"));
  EXPECT_THAT(said(read_text_experiment(small_experiment, {"seed=2"}), {"a", {1, 2}, 1, true}),
              HasSubstr("another experiment"));
  EXPECT_THAT(said(experiment_, {"a", {2, 2}, 1, true}), HasSubstr("of shard 1/2, not 2/2"));
  EXPECT_THAT(message<ConfigError>([&] { merge({folder_.file("a")}, folder_.file("a")); }),
              HasSubstr("there are results already"));
}

TEST_F(Sweep, RunsOfAnotherProgramAreFlownAgain) {
  const std::string whole = expected();
  Provenance older = provenance_of(experiment_, {});
  older["commit"] = "000000000000";
  std::filesystem::create_directory(folder_.path() / "old");
  {
    RunStore store(folder_.file("old/runs.sqlite"), Database::Mode::create);
    store.begin(older, experiment_, Plan(experiment_));
    RunRecord wrong;
    wrong.spec = plan(experiment_).front();
    store.add(wrong);
    store.close();
  }
  const SweepReport report = fly(experiment_, {"old", {}, 1, true});
  EXPECT_THAT(report.redone_because, HasSubstr("commit was 000000000000"));
  EXPECT_EQ(csv("old"), whole);
}

TEST_F(Sweep, FileThatIsNoStoreIsRefused) {
  folder_.write("text/runs.sqlite", std::string(5000, 'x'));
  folder_.write("empty/runs.sqlite", "");
  EXPECT_THAT(message<DataError>([&] { read_results(folder_.file("text")); }), HasSubstr("not a database"));
  EXPECT_THAT(message<DataError>([&] { read_results(folder_.file("empty")); }), HasSubstr("not a result store"));
  EXPECT_THAT(message<DataError>([&] { fly(experiment_, {"text", {}, 1, true}); }), HasSubstr("not a database"));
  // a store that was killed while it was made holds nothing and is made again
  EXPECT_EQ(fly(experiment_, {"empty", {}, 1, true}).done, 6u);
}

TEST_F(Sweep, ProvenanceSaysWhereResultsComeFrom) {
  const Provenance provenance = provenance_of(experiment_, {2, 3});
  for (const char* name : {"experiment", "version", "commit", "mujoco", "compiler", "flags", "cpu", "settle_s"})
    EXPECT_EQ(provenance.count(name), 1u) << name;
  EXPECT_EQ(provenance.at("shard"), "2/3");
  EXPECT_EQ(provenance.at("mujoco"), "4.0.1");
  EXPECT_THAT(provenance.at("experiment"), HasSubstr("[trajectory.circle]\ntype = \"circle\""));
}

}  // namespace sweep_test
}  // namespace gustlab
