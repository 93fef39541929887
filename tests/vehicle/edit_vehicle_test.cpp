// Numbers replaced in a vehicle file that is otherwise left as it was written.
#include "vehicle/edit_vehicle.hpp"

#include <gtest/gtest.h>

namespace gustlab {
namespace edit_vehicle_test {

constexpr const char* file = R"(# my vehicle
mass = 1.0

[thrust]
# from the shop
# (they say)
coefficient = 1e-5
torque_ratio = 0.01  # mine

[actuator]
coefficient = 3

[[effect]]
type = "motor_lag"
time_constant = 0.05

# the wind of that day
[[effect]]
type = "steady_wind"

[[effect]]
type = "motor_lag"
)";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(EditVehicle, SetsAKeyAndItsSourceInItsTableAlone) {
  std::string text = file;
  set_key(text, "thrust", "coefficient", "2e-5", "thrust stand");
  EXPECT_EQ(text,
            replaced(file, "# from the shop\n# (they say)\ncoefficient = 1e-5", "# thrust stand\ncoefficient = 2e-5"));
  // again: nothing piles up
  std::string again = text;
  set_key(again, "thrust", "coefficient", "2e-5", "thrust stand");
  EXPECT_EQ(again, text);
}

TEST(EditVehicle, PutsAKeyInPlaceOfAProposal) {
  const std::string without = replaced(file, "# from the shop\n# (they say)\ncoefficient = 1e-5\n", "");
  std::string text = replaced(without, "# mine\n", "# mine\n# when speeds are logged\n# coefficient = 1e-5\n");
  set_key(text, "thrust", "coefficient", "2e-5", "thrust stand");
  EXPECT_EQ(text, replaced(without, "# mine\n", "# mine\n# thrust stand\ncoefficient = 2e-5\n"));
}

TEST(EditVehicle, AddsAKeyAndATableBeforeTheEffects) {
  std::string text = file;
  set_key(text, "actuator", "pwm", "7", "guess");
  EXPECT_EQ(text, replaced(file, "[actuator]\n", "[actuator]\n# guess\npwm = 7\n"));
  text = file;
  set_key(text, "battery", "cells", "3", "label");
  EXPECT_EQ(text, replaced(file, "[[effect]]\ntype = \"motor_lag\"\ntime",
                           "[battery]\n# label\ncells = 3\n\n[[effect]]\ntype = \"motor_lag\"\ntime"));
}

TEST(EditVehicle, DropsAKeyOfOneTable) {
  std::string text = file;
  drop_key(text, "thrust", "coefficient");
  EXPECT_EQ(text, replaced(file, "# from the shop\n# (they say)\ncoefficient = 1e-5\n", ""));
  text = file;
  drop_key(text, "thrust", "torque");
  drop_key(text, "nowhere", "coefficient");
  EXPECT_EQ(text, file);
}

TEST(EditVehicle, DropsEveryEffectOfATypeAndNoComment) {
  std::string text = file;
  drop_effect(text, "motor_lag");
  EXPECT_EQ(text.find("motor_lag"), std::string::npos);
  EXPECT_NE(text.find("# the wind of that day\n[[effect]]\ntype = \"steady_wind\""), std::string::npos) << text;
  EXPECT_NE(text.find("coefficient = 3"), std::string::npos);
  text = file;
  drop_effect(text, "motor");
  EXPECT_EQ(text, file);
}

}  // namespace edit_vehicle_test
}  // namespace gustlab
