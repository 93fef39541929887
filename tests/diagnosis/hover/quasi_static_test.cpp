// Logs without attitude and body rate: mean commands of hover against a normal flight of the same vehicle.
#include "diagnosis/hover/quasi_static.hpp"
#include "diagnosis/diagnose.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "metrics/tracking_error.hpp"
#include "simulation/flight.hpp"
#include "simulation/recorder.hpp"
#include "support/temporary_folder.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab::diagnosis {
namespace quasi_static_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// a hover with planted [[effect]] tables, of which position, velocity, commands and voltage are kept
std::string fly(const TemporaryFolder& folder, const std::string& name, const std::string& planted,
                double voltage_V = 3.8) {
  const std::string experiment_path = folder.write(name + ".toml", R"(
format = "gustlab-experiment/1"
name = "hover"
vehicle = "crazyflie"
trajectories = ["hover"]
controllers = ["geometric"]
replicates = 1
duration_s = 10.0
step_s = 0.002
[[effect]]
type = "measurement_noise"
position_sd = 0.0005
rate_sd = 0.01
)" + planted);
  const Experiment experiment = read_experiment(experiment_path);
  const RunSpec spec = plan(experiment).front();
  Flight flight(experiment, spec);
  FlightRecorder recorder(experiment, flight);
  TrackingError error(0.0, static_cast<std::size_t>(flight.ticks) + 1);
  EXPECT_EQ(gustlab::fly(flight, error, &recorder).outcome, Outcome::completed);
  FlightLog log = recorder.take();
  std::erase_if(log.columns, [](const LogColumn& c) {
    static const std::vector<std::string> kept = {"px", "py", "pz", "vx", "vy", "vz", "u1", "u2", "u3", "u4"};
    return std::find(kept.begin(), kept.end(), c.name) == kept.end();
  });
  log.columns.push_back({"vbat", std::vector<double>(log.rows(), voltage_V)});
  for (std::size_t k = 0; k < log.rows(); ++k) log.columns.back().values[k] -= 1e-4 * static_cast<double>(k);
  log.meta.environment = {};
  const std::string path = folder.file(name + ".csv");
  write_flight_log(log, path);
  return path;
}

Diagnosis compare(const std::vector<std::string>& fit, const std::vector<std::string>& holdout,
                  const std::vector<std::string>& reference) {
  DiagnoseOptions options;
  options.fit = fit;
  options.holdout = holdout;
  options.reference = reference;
  return diagnose(options);
}

std::vector<std::string> names(const Diagnosis& d) {
  std::vector<std::string> result;
  for (const EffectFinding& e : d.effects) result.push_back(e.effect);
  return result;
}

constexpr const char* lost = "[[effect]]\ntype = \"rotor_loss\"\nrotor = 3\nloss = 0.3\n";
constexpr const char* moved = "[[effect]]\ntype = \"center_of_mass\"\nx = -0.005\ny = 0.005\n";
constexpr const char* heavier = "[[effect]]\ntype = \"mass\"\ndelta = 0.2\n";

TEST(QuasiStatic, NamesTheRotorThatLostThrustAgainstANormalFlight) {
  const TemporaryFolder folder;
  const std::string normal = fly(folder, "normal", ""), defect = fly(folder, "defect", lost);
  const Diagnosis d = compare({defect}, {}, {normal});
  ASSERT_THAT(names(d), ElementsAre("rotor_loss")) << to_json(d).dump(1);
  EXPECT_EQ(d.effects[0].classmates, std::vector<std::string>{"rotor_loss"});
  EXPECT_EQ(d.effects[0].parameters[0].value, 3.0);
  EXPECT_NEAR(d.effects[0].parameters[1].value, 0.3, 0.02);
  EXPECT_EQ(d.verdict, Verdict::explained);
  // in any order and without saying which is normal: only one of the two can have lost thrust
  for (const auto& pair : {std::vector{normal, defect}, std::vector{defect, normal}}) {
    const Diagnosis without = compare(pair, {}, {});
    ASSERT_THAT(names(without), ElementsAre("rotor_loss"));
    EXPECT_EQ(without.effects[0].parameters[0].value, 3.0);
    ASSERT_FALSE(without.log_findings.empty());
    EXPECT_EQ(without.log_findings.back().kind, "inconsistent");
    EXPECT_EQ(without.log_findings.back().file, "defect.csv");
  }
}

TEST(QuasiStatic, NamesNothingWithoutANormalFlightOrOnOne) {
  const TemporaryFolder folder;
  const std::string normal = fly(folder, "normal", ""),
                    other = fly(folder, "other", "[[effect]]\ntype = \"mass\"\ndelta = 0.01\n"),
                    defect = fly(folder, "defect", lost),
                    again = fly(folder, "again", "[[effect]]\ntype = \"rotor_loss\"\nrotor = 3\nloss = 0.29\n");
  EXPECT_EQ(compare({other}, {}, {normal}).verdict, Verdict::consistent);
  for (const auto& flights : {std::vector{defect}, std::vector{defect, again}, std::vector{normal, other}}) {
    const Diagnosis d = compare(flights, {}, {});
    EXPECT_THAT(names(d), IsEmpty());
    EXPECT_EQ(d.verdict, Verdict::insufficient_data);
  }
}

// a flight that agrees is no part of what it is compared with
TEST(QuasiStatic, AnAgreeingFlightDiffersFromTheReferenceByAllThatItDiffers) {
  const TemporaryFolder folder;
  const std::string normal = fly(folder, "normal", ""),
                    heavier_by_2 = fly(folder, "other", "[[effect]]\ntype = \"mass\"\ndelta = 0.02\n");
  const Diagnosis d = compare({heavier_by_2}, {}, {normal});
  ASSERT_EQ(d.verdict, Verdict::consistent);
  ASSERT_EQ(d.mismatch.front().channel, "force_z");
  const double weight_N = read_vehicle("crazyflie", "").weight_N();
  EXPECT_NEAR(d.mismatch.front().rms, 0.02 * weight_N, 0.003 * weight_N);
}

TEST(QuasiStatic, SaysHowMuchARotorMayHaveLostWithoutShowing) {
  const TemporaryFolder folder;
  const std::string normal = fly(folder, "normal", "");
  const auto with_loss = [&](const std::string& name, double loss) {
    return compare(
        {fly(folder, name, fmt::format("[[effect]]\ntype = \"rotor_loss\"\nrotor = 3\nloss = {:.4f}\n", loss))}, {},
        {normal});
  };
  const Diagnosis alike = with_loss("alike", 0.01);
  ASSERT_EQ(alike.verdict, Verdict::consistent);
  const std::string& note = alike.notes.back();
  const std::size_t at = note.find("less than ");
  ASSERT_NE(at, std::string::npos) << note;
  const double share = 0.01 * std::stod(note.substr(at + 10));
  EXPECT_GT(share, 0.05);
  EXPECT_EQ(with_loss("less", 0.7 * share).verdict, Verdict::consistent);
  EXPECT_THAT(names(with_loss("more", 1.3 * share)), ElementsAre("rotor_loss"));
}

TEST(QuasiStatic, TellsAMovedCentreOfMassAndMoreWeight) {
  const TemporaryFolder folder;
  const std::string normal = fly(folder, "normal", "");
  const Diagnosis shifted = compare({fly(folder, "shifted", moved)}, {}, {normal});
  ASSERT_THAT(names(shifted), ElementsAre("center_of_mass")) << to_json(shifted).dump(1);
  EXPECT_NEAR(shifted.effects[0].parameters[0].value, -0.005, 0.001);
  EXPECT_NEAR(shifted.effects[0].parameters[1].value, 0.005, 0.001);
  // hover alone cannot tell more weight from weaker rotors or a pull from below: all of them are said
  const Diagnosis loaded = compare({fly(folder, "loaded", heavier)}, {}, {normal});
  ASSERT_EQ(loaded.effects.size(), 1u);
  EXPECT_THAT(loaded.effects[0].classmates,
              ElementsAre("constant_force", "slung_load", "mass", "thrust_scale", "battery_sag"));
  EXPECT_NEAR(loaded.effects[0].parameters[2].value, -0.2 * 0.0282 * 9.81, 0.006);
}

TEST(QuasiStatic, CannotTellALossFromAWeightBesideARotorAtItsLimit) {
  const TemporaryFolder folder;
  const std::string normal = fly(folder, "normal", "");
  // at 2.6 V the rotor cannot have given what was asked of it
  const Diagnosis d = compare({fly(folder, "defect", lost, 2.6)}, {}, {normal});
  ASSERT_THAT(names(d), ElementsAre("center_of_mass")) << to_json(d).dump(1);
  EXPECT_THAT(d.effects[0].classmates, ElementsAre("center_of_mass", "rotor_loss"));
  EXPECT_LT(d.effects[0].parameters[0].value, 0.0);
  EXPECT_GT(d.effects[0].parameters[1].value, 0.0);
}

TEST(QuasiStatic, WithdrawsWhatAHeldOutFlightContradicts) {
  const TemporaryFolder folder;
  const std::string normal = fly(folder, "normal", ""), third = fly(folder, "third", lost),
                    first = fly(folder, "first", "[[effect]]\ntype = \"rotor_loss\"\nrotor = 1\nloss = 0.3\n");
  const Diagnosis d = compare({third}, {first}, {normal});
  EXPECT_THAT(names(d), IsEmpty());
  EXPECT_EQ(d.verdict, Verdict::insufficient_data);
  // which rotor, and what it explains of the flight that it was found on
  ASSERT_EQ(d.rejected.size(), 1u);
  EXPECT_EQ(d.rejected[0].effect, "rotor_loss (rotor 3)");
  EXPECT_GT(d.rejected[0].score, 0.0);
}

}  // namespace quasi_static_test
}  // namespace gustlab::diagnosis
