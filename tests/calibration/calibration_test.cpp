#include "calibration/calibration.hpp"

#include <gmock/gmock.h>

#include "gustlab/errors.hpp"
#include "support/experiments.hpp"
#include "sweep/sweep.hpp"

namespace gustlab {
namespace calibration_test {

using testing::HasSubstr;

const std::string experiment_text = R"(
format = "gustlab-experiment/1"
name = "planted"
vehicle = "crazyflie"
trajectories = ["hover"]
controllers = ["pid"]
replicates = 2
duration_s = 3.0
[[effect]]
type = "gust"
mean_x = 0.01
)";

Calibration calibration(std::int64_t first_replicate) {
  CalibrationStage stage{
      "gust", 25, {{"hover", "pid", 0, Statistic::mean}}, {{"effect.gust.mean_x", 0.005, 0.05, 0.01, true, "N"}}};
  return {"t", first_replicate, 2, {stage}};
}

Published published(double rmse_m) {
  Published result;
  result.rows.push_back({"t", "hover", "pid", {}});
  result.rows.back().figures.fill({10, rmse_m, 0.0, rmse_m});
  return result;
}

double rmse_m(const std::string& path, const std::string& set) {
  const Experiment experiment = read_experiment(path, {set});
  return fly_all(experiment, plan(experiment), 1).front().error.planar.rmse_m;
}

std::vector<StageResult> fit(const std::string& path, double target_m, int jobs) {
  const std::atomic<bool> stop = false;
  return calibrate(path, {}, calibration(1001), published(target_m), jobs, stop, [](std::size_t, std::size_t) {});
}

// GIVEN a table that was made with a steady force WHEN the force is open THEN calibration finds it, within its budget
TEST(Calibration, FindsWhatATableWasMadeWith) {
  const TemporaryFolder folder;
  const std::string path = folder.write("e.toml", experiment_text);
  const double target_m = rmse_m(path, "effect.gust.mean_x=0.03");
  const auto results = fit(path, target_m, 1);
  ASSERT_EQ(results.size(), 1u);
  EXPECT_NEAR(results[0].values[0], 0.03, 0.001);
  EXPECT_LT(results[0].loss, 1e-3 * results[0].start_loss);
  EXPECT_LE(results[0].evaluations, 25);
  EXPECT_NEAR(results[0].figures[0], target_m, 0.05 * target_m);
  // any number of threads, the same values
  EXPECT_EQ(fit(path, target_m, 2)[0].values, results[0].values);
}

// GIVEN a calibration that was killed while it wrote WHEN it is begun again THEN only what it had not flown is flown, and the values are
// the same; another target is flown anew
TEST(Calibration, GoesOnFromWhatWasFlown) {
  const TemporaryFolder folder;
  const std::string path = folder.write("e.toml", experiment_text), flown = folder.file("flown.jsonl");
  const std::atomic<bool> stop = false;
  const auto fitted = [&](double target_m) {
    return calibrate(
        path, {}, calibration(1001), published(target_m), 1, stop, [](std::size_t, std::size_t) {}, flown)[0];
  };
  const StageResult whole = fitted(0.05);
  const std::string all = read_text(flown);
  ASSERT_GT(std::count(all.begin(), all.end(), '\n'), 5);
  for (const std::size_t left : {all.size() / 2, all.size() - 1, all.size()}) {
    folder.write("flown.jsonl", all.substr(0, left));
    const StageResult again = fitted(0.05);
    EXPECT_EQ(again.values, whole.values);
    EXPECT_EQ(again.figures, whole.figures);
    EXPECT_EQ(again.share_as_far, whole.share_as_far);
    EXPECT_EQ(again.flights, whole.flights);
    EXPECT_EQ(read_text(flown), all);
  }
  EXPECT_NE(fitted(0.1).loss, whole.loss);
  EXPECT_GT(read_text(flown).size(), all.size());
}

// GIVEN a table made with gusts WHEN their strength is open THEN the spread of the runs finds it, and the table is one that such
// flights give; where the paper's spread is zero, nothing flies
TEST(Calibration, FindsGustsByTheSpreadOfTheRuns) {
  const TemporaryFolder folder;
  const std::string path = folder.write("e.toml", experiment_text);
  Calibration asked = calibration(1001);
  asked.replicates = 8;
  asked.stages[0].targets[0].statistic = Statistic::sd;
  asked.stages[0].parameters = {{"effect.gust.sigma_xy", 0.001, 0.05, 0.003, true, "N"}};
  const Experiment made = read_experiment(path, {"effect.gust.sigma_xy=0.01", "first_replicate=1001", "replicates=8"});
  std::vector<double> errors;
  for (const RunRecord& record : fly_all(made, plan(made), 1)) errors.push_back(record.error.planar.rmse_m);
  Published table = published(1.0);
  const std::atomic<bool> stop = false;
  const auto fitted = [&] { return calibrate(path, {}, asked, table, 1, stop, [](std::size_t, std::size_t) {}); };
  EXPECT_THROW(fitted(), ConfigError);

  table.rows[0].figures.fill(summarize(errors));
  const StageResult result = fitted()[0];
  EXPECT_NEAR(result.values[0], 0.01, 0.0005);
  EXPECT_NEAR(result.figures[0], summarize(errors).sd, 0.05 * summarize(errors).sd);
  EXPECT_GT(result.share_as_far, 0.5);
  // ten times the spread that any parameter gives
  table.rows[0].figures[0].sd *= 100.0;
  EXPECT_LT(fitted()[0].share_as_far, 0.05);
}

// GIVEN replicates of the tables, or of the experiment as its file stands WHEN calibrating, whatever --set says THEN it refuses
TEST(Calibration, RefusesSeedsThatAreReported) {
  const TemporaryFolder folder;
  const std::string path = folder.write("e.toml", experiment_text);
  const std::string far = folder.write("far.toml", "first_replicate = 501\n" + std::string(experiment_text));
  const std::atomic<bool> stop = false;
  const auto message = [&](const std::string& experiment, std::int64_t first, const Published& paper) -> std::string {
    try {
      calibrate(experiment, {"first_replicate=900"}, calibration(first), paper, 1, stop,
                [](std::size_t, std::size_t) {});
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "calibrated";
  };
  EXPECT_THAT(message(path, 2, published(0.1)), HasSubstr("calibrates on replicates 2 to 3, which are the tables'"));
  EXPECT_THAT(message(far, 502, published(0.1)), HasSubstr("which are those of "));
  EXPECT_THAT(message(far, 901, published(0.1)), HasSubstr("which are those of "));
  // figures of another vehicle are none to be fitted to
  Published paper = published(0.1);
  paper.vehicles["t"] = "iris";
  EXPECT_THAT(message(path, 1001, paper), HasSubstr("flies crazyflie (the paper's is of iris)"));
}

std::string reading(const std::string& text) {
  const TemporaryFolder folder;
  try {
    read_calibration(folder.write("c.toml", text));
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "read";
}

TEST(Calibration, SaysWhatIsWrongAndWhere) {
  const std::string head = "format = \"gustlab-calibration/1\"\ntable = \"table2\"\n[[stage]]\nname = \"s\"\n";
  const std::string target =
      "targets = [{trajectories = [\"circle\"], controllers = [\"pid\"], metrics = [\"rmse_xy_m\"]}]\n";
  const std::string parameter = "parameters = [{key = \"duration_s\", min = 1, start = 2, max = 3}]\n";
  EXPECT_EQ(reading(head + target + parameter), "read");
  EXPECT_THAT(reading(head + parameter), HasSubstr("\"targets\" is empty"));
  EXPECT_THAT(reading(head + target + "parameters = [{key = \"duration_s\", min = 1, start = 5, max = 3}]\n"),
              HasSubstr("c.toml:6:"));
  EXPECT_THAT(
      reading(head + "targets = [{trajectories = [\"circle\"], controllers = [\"pid\"], metrics = [\"rms\"]}]\n" +
              parameter),
      HasSubstr("\"rms\" is no metric"));
  EXPECT_THAT(reading(head +
                      "targets = [{trajectories = [\"circle\"], controllers = [\"pid\"], metrics = [\"rmse_xy_m\"], "
                      "statistics = [\"max\"]}]\n" +
                      parameter),
              HasSubstr("c.toml:5:101: \"max\" is no statistic"));
}

// GIVEN a file that asks for what is not there WHEN calibrating THEN it says where, before anything flies
TEST(Calibration, SaysWhereItsFileDoesNotFitTheExperiment) {
  const TemporaryFolder folder;
  const std::string path = folder.write("e.toml", experiment_text);
  const auto message = [&](const std::string& table, const std::string& controller, const std::string& key,
                           int replicates = 10) -> std::string {
    const Calibration asked = read_calibration(
        folder.write("c.toml", "format = \"gustlab-calibration/1\"\ntable = \"" + table +
                                   "\"\nreplicates = " + std::to_string(replicates) + "\n[[stage]]\nname = \"s\"\n" +
                                   "targets = [{trajectories = [\"hover\"], controllers = [\"" + controller +
                                   "\"], metrics = [\"rmse_xy_m\"]}]\n" + "parameters = [{key = \"" + key +
                                   "\", min = 0.005, start = 0.01, max = 0.05}]\n"));
    const std::atomic<bool> stop = true;
    try {
      calibrate(path, {}, asked, published(0.1), 1, stop, [](std::size_t, std::size_t) { ADD_FAILURE() << "flew"; });
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "flew";
  };
  EXPECT_THAT(message("u", "pid", "effect.gust.mean_x"), HasSubstr("c.toml:6:53: u has no row hover pid"));
  EXPECT_THAT(message("t", "pdi", "effect.gust.mean_x"), HasSubstr("c.toml:6:53: t has no row hover pdi"));
  EXPECT_THAT(message("t", "pid", "effect.gust.man_x"),
              HasSubstr("c.toml:7:22: unknown key \"man_x\"; did you mean \"mean_x\"?"));
  EXPECT_THAT(message("t", "pid", "effect.gust.mean_x", 0),
              HasSubstr("c.toml:3:14: \"replicates\" is out of range (0 is not from 1 to 1e+06)"));
}

// what is shipped is read, and every target of it was published
TEST(Calibration, ShippedOnesLookAtPublishedCells) {
  const std::string published_path = find_experiment("published_tables");
  const Published all = read_published(published_path);
  EXPECT_EQ(all.rows.size(), 24u);
  for (const char* name : {"table1_iris", "table1_iris_runaways", "table2_crazyflie"}) {
    const Calibration shipped = read_calibration(calibration_path(find_experiment(name)));
    const Experiment experiment = read_experiment(find_experiment(name));
    // neither the ten reported gusts nor those that the experiment itself flies
    EXPECT_GT(shipped.first_replicate, 10) << name;
    EXPECT_TRUE(shipped.first_replicate >= experiment.first_replicate + experiment.replicates ||
                shipped.first_replicate + shipped.replicates <= experiment.first_replicate)
        << name;
    for (const CalibrationStage& stage : shipped.stages)
      for (const Target& cell : stage.targets)
        EXPECT_NE(all.find(shipped.table, cell.trajectory, cell.controller), nullptr)
            << name << " " << cell.trajectory << " " << cell.controller;
  }
}

}  // namespace calibration_test
}  // namespace gustlab
