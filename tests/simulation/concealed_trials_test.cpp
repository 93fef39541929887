#include "simulation/concealed_trials.hpp"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "gustlab/errors.hpp"

namespace gustlab {
namespace concealed_trials_test {

using testing::HasSubstr;
using testing::Not;

constexpr const char* head = R"(
format = "gustlab-trials/1"
name = "test"
vehicle = "crazyflie"
controllers = ["pid"]
trajectories = ["circle", "hover"]
fit = ["circle"]
holdout = ["hover"]
duration_s = 1.0
step_s = 0.001
[environment]
ground_z_m = 0.0
[[effect]]
type = "measurement_noise"
position_sd = 0.0004
)";

class ConcealedTrialsTest : public testing::Test {
 protected:
  ConcealedTrialsTest() : folder_(std::filesystem::path(testing::TempDir()) / "gustlab_concealed") {
    std::filesystem::remove_all(folder_);
  }
  ~ConcealedTrialsTest() override { std::filesystem::remove_all(folder_); }

  TrialsFile read(const std::string& trials) const {
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ / "trials.toml") << head << trials;
    return read_trials_file((folder_ / "trials.toml").string());
  }
  std::string error(const std::string& trials) const {
    try {
      read(trials);
    } catch (const ConfigError& problem) {
      return problem.what();
    }
    return "accepted";
  }
  std::string bytes(const std::string& file) const {
    std::ostringstream text;
    text << std::ifstream(folder_ / file).rdbuf();
    return text.str();
  }

  std::filesystem::path folder_;
};

TEST_F(ConcealedTrialsTest, TheRecordingsSayNothingOfWhatIsConcealed) {
  const TrialsFile file =
      read("[[trial]]\nname = \"a\"\neffects = [{type = \"rotor_drag\", at_hover = 0.03}]\n[[trial]]\nname = \"b\"\n");
  const std::string answers = fly_concealed_trials(file, folder_.string(), 1);
  EXPECT_THAT(answers, HasSubstr(R"("effects":[{"effect":"rotor_drag","parameters":{"at_hover":0.03}}])"));
  EXPECT_THAT(answers, HasSubstr(R"({"trial":"b","vehicle":"crazyflie","kind":"clean","effects":[]})"));
  for (const char* name : {"a/fit_1", "a/holdout_1", "b/fit_1", "b/holdout_1"}) {
    const std::string log = bytes(std::string(name) + ".csv"), sidecar = bytes(std::string(name) + ".meta.toml");
    EXPECT_THAT(log, testing::StartsWith("time_s,px,py,pz,vx,vy,vz,qw,qx,qy,qz,wx,wy,wz,u1,u2,u3,u4\n"));
    EXPECT_THAT(log + sidecar, Not(HasSubstr("drag")));
  }
  // the concealed drag moves the vehicle: the commands of the same flight differ
  EXPECT_NE(bytes("a/fit_1.csv"), bytes("b/fit_1.csv"));
}

TEST_F(ConcealedTrialsTest, TheSameBytesForAnyNumberOfThreads) {
  const TrialsFile file =
      read("[[trial]]\nname = \"a\"\n[[trial]]\nname = \"b\"\neffects = [{type = \"mass\", delta = 0.1}]\n");
  const std::string answers = fly_concealed_trials(file, (folder_ / "one").string(), 1);
  EXPECT_EQ(fly_concealed_trials(file, (folder_ / "three").string(), 3), answers);
  for (const char* name : {"a/fit_1.csv", "b/fit_1.csv", "b/holdout_1.csv"}) {
    EXPECT_EQ(bytes(std::string("one/") + name), bytes(std::string("three/") + name));
    EXPECT_GT(bytes(std::string("one/") + name).size(), 1000u);
  }
}

TEST_F(ConcealedTrialsTest, WhatIsWrongIsSaidWithItsPlace) {
  EXPECT_THAT(error(""), HasSubstr("there is no [[trial]]"));
  EXPECT_THAT(error("[[trial]]\nname = \"a\"\nfit = [\"spiral\"]\n"), HasSubstr("trials.toml:18:"));
  EXPECT_THAT(error("[[trial]]\nname = \"a\"\neffects = [{type = \"rotor_dragg\"}]\n"), HasSubstr("rotor_drag"));
  EXPECT_THAT(error("[[trial]]\nname = \"a\"\n[[trial]]\nname = \"a\"\n"),
              HasSubstr("is no name of a folder of its own"));
  EXPECT_THAT(error("[[trial]]\nname = \"a\"\nhide = 1\n"), HasSubstr("trials.toml:18:1: unknown key \"hide\""));
  // score refuses them
  EXPECT_THAT(error("[[trial]]\nname = \"a\"\nkind = \"singel\"\n"),
              HasSubstr("trials.toml:18:8: \"singel\" is no kind of trial"));
}

TEST_F(ConcealedTrialsTest, AFlightThatDoesNotEndWellIsNoTrial) {
  const TrialsFile file = read("[[trial]]\nname = \"a\"\neffects = [{type = \"thrust_scale\", delta = -0.9}]\n");
  try {
    fly_concealed_trials(file, folder_.string(), 1);
    FAIL() << "written";
  } catch (const ConfigError& problem) {
    EXPECT_THAT(problem.what(), HasSubstr("trial \"a\": fit_1.csv crashed at"));
  }
  EXPECT_FALSE(std::filesystem::exists(folder_ / "a"));
}

}  // namespace concealed_trials_test
}  // namespace gustlab
