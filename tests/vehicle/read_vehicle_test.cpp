#include "vehicle/read_vehicle.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "gustlab/errors.hpp"
#include "support/temporary_folder.hpp"
#include "vehicle/gaps.hpp"
#include "vehicle/mjcf.hpp"
#include "vehicle/rotor_speed.hpp"

namespace gustlab {
namespace read_vehicle_test {

using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsSupersetOf;
using ::testing::StartsWith;

template <class Action>
std::string message(Action action) {
  try {
    action();
  } catch (const ConfigError& error) {
    return error.what();
  }
  return {};
}

const char* const body_text = R"(<mujoco><worldbody>
<geom type="plane" size="1 1 1"/>
<body pos="3 4 5" euler="0 0 90"><freejoint/><inertial pos="0 0 0" mass="1" diaginertia="0.01 0.02 0.025"/>
<geom type="sphere" size="0.1" mass="0" pos="0 0 -0.1"/><geom type="box" size="1 1 1" mass="0" contype="0" conaffinity="0"/>
<body pos="0 1 0"><inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.01"/></body>
<site name="a" pos="1 0 0"/><site name="b" pos="0 1 0"/><site name="c" pos="-1 0 0.5" zaxis="1 0 1"/>
</body></worldbody></mujoco>)";

const char* const vehicle_text = R"(format = "gustlab-vehicle/1"
name = "tri"
mjcf = "body.xml"
[[rotor]]
site = "a"
direction = "ccw"
[[rotor]]
site = "b"
direction = "cw"
coefficient = 2e-3
[[rotor]]
site = "c"
direction = "ccw"
[thrust]
coefficient = 1e-3
torque_ratio = 0.01
max_speed_radps = 200
radius_m = 0.1
)";

// a folder with a good vehicle, in which one text is replaced by another
struct Broken {
  TemporaryFolder folder;
  std::string toml = vehicle_text, mjcf = body_text;

  static void swap(std::string& text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
  }
  std::string say() {
    folder.write("body.xml", mjcf);
    const std::string path = folder.write("vehicle.toml", toml);
    std::string said = message([&] { read_vehicle(path); });
    for (std::size_t at; (at = said.find(folder.path().string() + "/")) != std::string::npos;)
      said.erase(at, folder.path().string().size() + 1);
    return said;
  }
};
std::string broken_toml(const std::string& from, const std::string& to) {
  Broken broken;
  Broken::swap(broken.toml, from, to);
  return broken.say();
}
std::string broken_mjcf(const std::string& from, const std::string& to) {
  Broken broken;
  Broken::swap(broken.mjcf, from, to);
  return broken.say();
}

TEST(ReadVehicle, ComposesWhatIsWeldedTogetherInBodyAxes) {
  TemporaryFolder folder;
  folder.write("body.xml", body_text);
  const VehicleModel v = read_vehicle(folder.write("vehicle.toml", vehicle_text));
  EXPECT_EQ(v.name, "tri");
  EXPECT_DOUBLE_EQ(v.mass_kg, 2.0);
  EXPECT_NEAR((v.center_of_mass_B_m - Vector3(0.0, 0.5, 0.0)).norm(), 0.0, 1e-15);
  // parallel axes: 2 × 1 kg at 0.5 m
  EXPECT_NEAR((v.inertia_B_kgm2 - Vector3(0.52, 0.03, 0.535).asDiagonal().toDenseMatrix()).norm(), 0.0, 1e-12);
  EXPECT_EQ(v.rotor_count, 3);
  EXPECT_NEAR((v.rotors[0].position_B_m - Vector3(1.0, 0.0, 0.0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((v.rotors[2].axis_B - Vector3(1.0, 0.0, 1.0).normalized()).norm(), 0.0, 1e-12);
  EXPECT_EQ(v.rotors[0].direction, 1.0);
  EXPECT_EQ(v.rotors[1].direction, -1.0);
  EXPECT_EQ(v.rotors[0].thrust_coefficient_Ns2, 1e-3);
  EXPECT_EQ(v.rotors[1].thrust_coefficient_Ns2, 2e-3);
  EXPECT_DOUBLE_EQ(v.gravity_mps2, 9.81);
  ASSERT_EQ(v.shapes.size(), 1u);
  EXPECT_EQ(v.shapes[0].type, "sphere");
  EXPECT_NEAR((v.shapes[0].position_B_m - Vector3(0.0, 0.0, -0.1)).norm(), 0.0, 1e-12);
  EXPECT_EQ(v.source_bytes, std::string(vehicle_text) + '\0' + body_text);
}

TEST(ReadVehicle, NameFileOrRelativePathLeadToTheSameVehicle) {
  EXPECT_THAT(vehicle_names(), IsSupersetOf({"crazyflie", "crazyflie_brushless", "crazyflie_real", "iris"}));
  const VehicleModel by_name = read_vehicle("crazyflie");
  const VehicleModel by_path = read_vehicle(find_resource("models/crazyflie/vehicle.toml"));
  const VehicleModel relative = read_vehicle("../crazyflie/vehicle.toml", find_resource("models/iris/vehicle.toml"));
  EXPECT_EQ(by_name.source_bytes, by_path.source_bytes);
  EXPECT_EQ(by_name.source_bytes, relative.source_bytes);
}

TEST(ReadVehicle, AFolderThatHoldsAVehicleFileStandsForIt) {
  TemporaryFolder folder;
  std::filesystem::create_directory(folder.file("my_quad"));
  folder.write("my_quad/body.xml", body_text);
  const std::string path = folder.write("my_quad/vehicle.toml", vehicle_text), beside = folder.file("flight.meta.toml");
  const std::string bytes = read_vehicle(path).source_bytes;
  EXPECT_EQ(read_vehicle(folder.file("my_quad")).source_bytes, bytes);
  EXPECT_EQ(read_vehicle(folder.file("my_quad/")).source_bytes, bytes);
  EXPECT_EQ(read_vehicle("my_quad", beside).source_bytes, bytes);
  // a name under models/ stays that
  std::filesystem::rename(folder.file("my_quad"), folder.file("iris"));
  EXPECT_EQ(read_vehicle("iris", beside).source_bytes, read_vehicle("iris").source_bytes);
  EXPECT_THAT(message([] { read_vehicle(""); }), StartsWith("unknown vehicle \"\" (known: "));
}

// composite numbers as read in, or derived from, the systems' own files
TEST(Models, HaveTheCompositeMassAndInertiaOfTheirSources) {
  const VehicleModel iris = read_vehicle("iris");
  EXPECT_NEAR(iris.mass_kg, 1.98, 1e-12);
  EXPECT_NEAR(iris.center_of_mass_B_m.y(), -0.23 * 0.01 / 1.98, 1e-12);
  EXPECT_NEAR(iris.hover_speed_radps(), 473.0, 1.0);
  EXPECT_NEAR(4.0 * 2.1665e-5 * 620.9 * 620.9 / iris.weight_N(), 1.72, 0.005);
  const VehicleModel crazyflie = read_vehicle("crazyflie");
  EXPECT_NEAR(crazyflie.mass_kg, 0.0282, 1e-12);
  EXPECT_NEAR(crazyflie.inertia_B_kgm2(0, 0), 2.09e-5, 0.01e-5);
  EXPECT_NEAR(crazyflie.inertia_B_kgm2(1, 1), 2.10e-5, 0.01e-5);
  EXPECT_NEAR(crazyflie.inertia_B_kgm2(2, 2), 3.54e-5, 0.01e-5);
  // hover pwm 38781
  EXPECT_NEAR((crazyflie.hover_speed_radps() - 380.8359) / 0.04076521, 38781.0, 20.0);
}

TEST(Models, RotorsTurnSoThatYawTorqueBalances) {
  for (const std::string& name : vehicle_names()) {
    const VehicleModel v = read_vehicle(name);
    double sum = 0.0;
    for (int i = 0; i < v.rotor_count; ++i) sum += v.rotors[static_cast<std::size_t>(i)].direction;
    EXPECT_EQ(sum, 0.0) << name;
    EXPECT_FALSE(v.shapes.empty()) << name;
  }
}

TEST(ReadVehicle, ErrorsNameThePlaceAndWhatToDo) {
  EXPECT_EQ(broken_toml("site = \"b\"", "site = \"d\""),
            "vehicle.toml:8:8: there is no site \"d\" in body.xml (sites on the vehicle: a, b, c)");
  EXPECT_EQ(broken_toml("site = \"b\"", "site = \"a\""),
            "vehicle.toml:8:8: site \"a\" carries two rotors; give each rotor its own");
  EXPECT_THAT(broken_toml("\"cw\"", "\"left\""), StartsWith("vehicle.toml:9:13: \"left\" is not a direction"));
  EXPECT_THAT(broken_toml("radius_m = 0.1", "radius = 0.1"),
              StartsWith("vehicle.toml:18:1: unknown key \"radius\"; did you mean \"radius_m\"?"));
  EXPECT_THAT(broken_toml("coefficient = 1e-3", "coefficient = 1e-3\nhover = 0.5"),
              HasSubstr("both \"coefficient\" and \"hover\" are here"));
  EXPECT_THAT(broken_toml("coefficient = 1e-3", "hover = 1.5"), HasSubstr("rotor speed 20 to 8000 rad/s"));
  EXPECT_THAT(broken_toml("coefficient = 1e-3", "hover = 70000"), HasSubstr("\"hover\" of 70000 is no actuator input"));
  EXPECT_THAT(broken_toml("[thrust]", "[actuator]\nthrottle_curve = 0.3\n[thrust]"),
              HasSubstr("there is no [thrust] hover"));
  EXPECT_THAT(broken_toml("[thrust]\ncoefficient = 1e-3", "[actuator]\nthrottle_curve = 2\n[thrust]\nhover = 0.5"),
              HasSubstr("must be from 0 to 1"));
  EXPECT_THAT(
      broken_toml("[thrust]\ncoefficient = 1e-3", "[actuator]\nthrottle_thrust = [0, 1, 2]\n[thrust]\nhover = 0.5"),
      HasSubstr("two answers to one question"));
  EXPECT_THAT(broken_toml("torque_ratio", "torque_ration = 1\ntorque_ratio"),
              EndsWith("did you mean \"torque_ratio\"?"));
  EXPECT_THAT(broken_toml("coefficient = 1e-3", "coefficient = -1"), HasSubstr("\"coefficient\" must be positive"));
  EXPECT_THAT(broken_toml("gustlab-vehicle/1", "gustlab-vehicle/9"), StartsWith("vehicle.toml:1:10: format"));
  EXPECT_THAT(broken_toml("body.xml", "other.xml"), StartsWith("vehicle.toml:3:8: there is no file"));
  EXPECT_THAT(broken_toml("body.xml", "../body.xml"),
              StartsWith("vehicle.toml:3:8: \"../body.xml\" is outside the vehicle's folder"));
  EXPECT_THAT(broken_toml("body.xml", "/etc/hostname"), StartsWith("vehicle.toml:3:8: \"/etc/hostname\" is outside"));
  EXPECT_THAT(broken_toml("max_speed_radps = 200", "max_speed_radps = 20"), HasSubstr("the vehicle cannot hover"));
  EXPECT_THAT(broken_toml("[[rotor]]\nsite = \"c\"\ndirection = \"ccw\"\n", ""),
              StartsWith("vehicle.toml:4:1: 2 rotors"));
  EXPECT_THAT(broken_toml("[thrust]", "[actuator]\npwm_thrust = [1, 2]\n[thrust]"),
              StartsWith("vehicle.toml:15:14: \"pwm_thrust\" must have three"));
}

TEST(ReadVehicle, EverythingThatIsRequiredAndMissingIsSaidAtOnce) {
  TemporaryFolder folder;
  const std::string said = message(
      [&] { read_vehicle(folder.write("vehicle.toml", "[[rotor]]\nsite = \"a\"\n[[rotor]]\ndirection = \"cw\"\n")); });
  EXPECT_THAT(said, HasSubstr("vehicle.toml: 5 required keys are missing:\n"));
  for (const char* key : {"format = \"gustlab-vehicle/1\"", "mjcf = ", "direction of [[rotor]] 1",
                          "site of [[rotor]] 2", "coefficient [N/(rad/s)^2], or hover"})
    EXPECT_THAT(said, HasSubstr(key));
}

TEST(ReadVehicle, EveryWrongKeyIsSaidBesideWhatIsMissing) {
  Broken wrong;
  Broken::swap(wrong.toml, "mjcf = \"body.xml\"\n", "");
  Broken::swap(wrong.toml, "site = \"b\"", "site = 3");
  Broken::swap(wrong.toml, "direction = \"cw\"", "direction = \"left\"");
  Broken::swap(wrong.toml, "torque_ratio = 0.01", "torque_ratio = -1");
  Broken::swap(wrong.toml, "radius_m = 0.1",
               "radius_m = -1\nfoo = 3\n[actuator]\npwm = { slope = \"a\", ofset = 1 }\n[[effect]]\ngain = 1");
  const std::string said = wrong.say();
  EXPECT_THAT(said, StartsWith("vehicle.toml: one required key is missing:\n  mjcf = "));
  EXPECT_THAT(said,
              EndsWith("\nvehicle.toml:7:8: \"site\" must be a string (this is an integer)"
                       "\nvehicle.toml:8:13: \"left\" is not a direction; write \"ccw\" or \"cw\", seen from above"
                       "\nvehicle.toml:17:12: \"radius_m\" must be positive"
                       "\nvehicle.toml:15:16: \"torque_ratio\" must not be negative"
                       "\nvehicle.toml:20:17: \"slope\" must be a number (this is a string)"
                       "\nvehicle.toml:21:1: \"type\" is missing (a string is needed here)"
                       "\nvehicle.toml:20:22: unknown key \"ofset\"; did you mean \"offset\"?"
                       "\nvehicle.toml:18:1: unknown key \"foo\" (known: coefficient, hover, max_speed_radps, "
                       "nominal_voltage_V, radius_m, torque_ratio)"));
}

TEST(ReadVehicle, OnlyMassRotorsAndACoefficientAreRequired) {
  Broken least;
  for (const char* key : {"name = \"tri\"\n", "torque_ratio = 0.01\n", "max_speed_radps = 200\n", "radius_m = 0.1\n"})
    Broken::swap(least.toml, key, "");
  EXPECT_EQ(least.say(), "");
  const VehicleModel v = read_vehicle(least.folder.file("vehicle.toml"));
  EXPECT_EQ(v.name, least.folder.path().filename().string());
  EXPECT_EQ(v.max_speed_radps, std::numeric_limits<double>::infinity());
  EXPECT_EQ(v.rotor_radius_m, 0.0);
  EXPECT_TRUE(v.rotor_speed_known);
  EXPECT_FALSE(v.torque_ratio_known);
  // 0.07 diameters of 0.8 of the distance between hubs
  EXPECT_NEAR(v.rotors[0].torque_ratio_m, 0.07 * 0.8 * 2.0 * v.arm_m() * std::sin(pi / 3.0), 1e-12);
  std::vector<std::string> said;
  for (const VehicleGap& gap : gaps_of(v)) said.push_back(gap.says());
  EXPECT_THAT(said, ElementsAre("the vehicle file has no rotor radius ([thrust] radius_m)",
                                "the vehicle file has no torque ratio of the rotors ([thrust] torque_ratio)"));
}

// f of thrust ~ f u² + (1 − f) u, which carries the weight at u = hover
TEST(ReadVehicle, HoverThrottleAndCurveStandForACoefficient) {
  Broken hovers;
  Broken::swap(hovers.toml, "[thrust]\ncoefficient = 1e-3", "[actuator]\nthrottle_curve = 0.3\n[thrust]\nhover = 0.49");
  Broken::swap(hovers.toml, "coefficient = 2e-3\n", "");
  Broken::swap(hovers.toml, "max_speed_radps = 200\n", "");
  EXPECT_EQ(hovers.say(), "");
  const VehicleModel v = read_vehicle(hovers.folder.file("vehicle.toml"));
  EXPECT_FALSE(v.rotor_speed_known);
  const Rotor& rotor = v.rotors[0];
  const auto thrust_N = [&](double throttle) {
    return rotor.thrust_coefficient_Ns2 * std::pow(rotor_speed_radps(v, rotor, ActuatorKind::throttle, throttle), 2);
  };
  EXPECT_NEAR(3.0 * thrust_N(0.49), v.weight_N(), 1e-9);
  EXPECT_NEAR(thrust_N(1.0) / thrust_N(0.49), 1.0 / (0.3 * 0.49 * 0.49 + 0.7 * 0.49), 1e-9);
  EXPECT_NEAR(rotor_speed_radps(v, rotor, ActuatorKind::throttle, 1.0), v.max_speed_radps, 1e-9);
  EXPECT_THROW(rotor_speed_radps(v, rotor, ActuatorKind::pwm, 30000.0), DataError);
}

TEST(ReadVehicle, HoverIsInTheUnitOfItsSize) {
  for (const auto& [hover, kind] : {std::pair{"120.0", ActuatorKind::rotor_speed}, {"30000", ActuatorKind::pwm}}) {
    Broken hovers;
    Broken::swap(hovers.toml, "coefficient = 1e-3", std::string("hover = ") + hover);
    Broken::swap(hovers.toml, "coefficient = 2e-3\n", "");
    Broken::swap(hovers.toml, "max_speed_radps = 200\n", "");
    EXPECT_EQ(hovers.say(), "");
    const VehicleModel v = read_vehicle(hovers.folder.file("vehicle.toml"));
    EXPECT_EQ(v.rotor_speed_known, kind == ActuatorKind::rotor_speed);
    const double speed = rotor_speed_radps(v, v.rotors[0], kind, std::stod(hover));
    EXPECT_NEAR(3.0 * v.rotors[0].thrust_coefficient_Ns2 * speed * speed, v.weight_N(), 1e-9);
  }
}

TEST(ReadVehicle, BrokenMjcfIsAConfigurationErrorWithItsLine) {
  EXPECT_THAT(broken_mjcf("mass=\"1\"", "mass=\"x\""), StartsWith("body.xml:3"));
  EXPECT_THAT(broken_mjcf("<body pos=\"0 1 0\">", "<bdy>"), StartsWith("body.xml:5"));
  EXPECT_THAT(broken_mjcf("</mujoco>", ""), StartsWith("body.xml:"));
  EXPECT_THAT(broken_mjcf("<freejoint/>", ""), HasSubstr("exactly one free joint and no other joint (here: 0)"));
  EXPECT_THAT(broken_mjcf("<body pos=\"0 1 0\">", "<body pos=\"0 1 0\"><joint/>"), HasSubstr("(here: 2)"));
  EXPECT_THAT(broken_mjcf("<worldbody>", "<option gravity='0 0 0'/><worldbody>"),
              HasSubstr("gravity must point along -z"));
  EXPECT_THAT(broken_mjcf("<worldbody>", "<include file='../x.xml'/><worldbody>"), HasSubstr("<include> is not read"));
  EXPECT_THAT(broken_mjcf("<worldbody>", "<asset><mesh file='../x.stl'/></asset><worldbody>"),
              HasSubstr("outside the vehicle's folder"));
}

TEST(ReadVehicle, UnknownNameIsSuggested) {
  EXPECT_THAT(message([] { read_vehicle("crazyfly"); }), EndsWith("did you mean \"crazyflie\"?"));
  EXPECT_THAT(message([] { read_vehicle("no/such/vehicle.toml"); }), StartsWith("no/such/vehicle.toml: cannot read"));
}

TEST(FindResource, PrefersGustlabHome) {
  TemporaryFolder home;
  home.write("models/mine/vehicle.toml", "x = ");
  setenv("GUSTLAB_HOME", home.path().c_str(), 1);
  EXPECT_THAT(vehicle_names(), IsSupersetOf({"crazyflie", "mine"}));
  EXPECT_EQ(find_resource("models/mine/vehicle.toml"), home.file("models/mine/vehicle.toml"));
  unsetenv("GUSTLAB_HOME");
  EXPECT_THAT(message([] { find_resource("models/mine"); }), StartsWith("models/mine: not found"));
}

}  // namespace read_vehicle_test
}  // namespace gustlab
