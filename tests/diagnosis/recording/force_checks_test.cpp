// Units, frames and vehicle are judged by the motion: flights of closed form up to 4 g and 20 m/s, upright, banked and upside down.
#include "diagnosis/recording/force_checks.hpp"

#include <gmock/gmock.h>

#include "diagnosis/recording/log_checks.hpp"
#include "support/closed_form_flights.hpp"

namespace gustlab::diagnosis {
namespace force_checks_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

using test::column;
using test::fly;
using test::gravity_mps2;
using test::Path;
using test::racer;

std::vector<std::string> says(FlightLog log, const VehicleModel& vehicle) {
  std::vector<std::string> texts;
  for (const LogFinding& finding : check_log(log, vehicle)) texts.push_back(finding.says);
  return texts;
}

const std::vector<std::pair<const char*, Path>> flights = {
    {"hover", test::hover}, {"banked at 4 g", test::banked}, {"looping", test::loop}};

TEST(ForceChecks, SayNothingOfARightLogHoweverItIsFlown) {
  for (const auto& [name, path] : flights) EXPECT_THAT(says(fly(path, racer()), racer()), IsEmpty()) << name;
}

TEST(ForceChecks, NeedNoPose) {
  for (const auto& [name, path] : flights) {
    FlightLog log = fly(path, racer());
    log.columns.erase(log.columns.begin(), log.columns.begin() + 10);
    EXPECT_THAT(says(log, racer()), IsEmpty()) << name;
    for (const char* axis : {"ax", "ay", "az"})
      for (double& value : column(log, axis)) value /= gravity_mps2;
    EXPECT_THAT(says(log, racer()), ElementsAre(HasSubstr("is in g"))) << name;
  }
}

TEST(ForceChecks, TellAnotherUnitSignOrFrameOfTheAccelerometer) {
  for (const auto& [name, path] : flights) {
    const FlightLog right = fly(path, racer());
    const auto changed = [&](double by_x, double by_y, double by_z) {
      FlightLog log = right;
      for (double& value : column(log, "ax")) value *= by_x;
      for (double& value : column(log, "ay")) value *= by_y;
      for (double& value : column(log, "az")) value *= by_z;
      return says(log, racer());
    };
    EXPECT_THAT(changed(1.0 / gravity_mps2, 1.0 / gravity_mps2, 1.0 / gravity_mps2), ElementsAre(HasSubstr("is in g")))
        << name;
    EXPECT_THAT(changed(-1.0, -1.0, -1.0), ElementsAre(HasSubstr("reads downward"))) << name;
    EXPECT_THAT(changed(1000.0, 1000.0, 1000.0), ElementsAre(HasSubstr("does not show the specific force"))) << name;

    FlightLog without_gravity = right, in_world = right;
    for (std::size_t k = 0; k < right.rows(); ++k) {
      const Quaternion q((*right.find("qw"))[k], (*right.find("qx"))[k], (*right.find("qy"))[k],
                         (*right.find("qz"))[k]);
      const Vector3 force((*right.find("ax"))[k], (*right.find("ay"))[k], (*right.find("az"))[k]);
      const Vector3 in_W = q * force, rest = q.conjugate() * Vector3(in_W - Vector3(0.0, 0.0, gravity_mps2));
      for (int i = 0; i < 3; ++i) {
        const char* axis[] = {"ax", "ay", "az"};
        column(without_gravity, axis[i])[k] = rest[i];
        column(in_world, axis[i])[k] = in_W[i];
      }
    }
    EXPECT_THAT(says(without_gravity, racer()), ElementsAre(HasSubstr("leaves gravity out"))) << name;
    // a hover's world axes are its body's
    if (std::string_view(name) == "hover") continue;
    EXPECT_THAT(says(in_world, racer()), ElementsAre(HasSubstr("is in world axes"))) << name;
  }
}

TEST(ForceChecks, WeighTheInputsAgainstTheMotion) {
  VehicleModel heavy = racer();
  heavy.mass_kg *= 2.5;
  for (const auto& [name, path] : flights)
    EXPECT_THAT(says(fly(path, racer()), heavy), ElementsAre(HasSubstr("the inputs mean 0.40 times the thrust")))
        << name;
}

}  // namespace force_checks_test
}  // namespace gustlab::diagnosis
