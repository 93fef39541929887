// What single controllers promise beyond the contract of their registry.
#include "controllers/controllers.hpp"

#include <gmock/gmock.h>

#include "control/daiml_input.hpp"
#include "control/network.hpp"
#include "gustlab/errors.hpp"
#include "gustlab/random.hpp"
#include "support/fly.hpp"
#include "trajectories/trajectories.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab::test {
namespace controllers_test {

constexpr double circle_speed_mps = 2.0 * pi * 1.1 / 24.0;

struct Telemetry {
  std::vector<std::string_view> names;
  std::vector<double> values;
  double operator[](std::string_view name) const {
    for (std::size_t i = 0; i < names.size(); ++i)
      if (names[i] == name) return values[i];
    throw std::logic_error("no such telemetry");
  }
};

Telemetry telemetry_of(const Controller& controller) {
  Telemetry out{controller.telemetry_names(), {}};
  out.values.resize(out.names.size());
  controller.telemetry(out.values);
  return out;
}

ControllerFlightEnd circle(Controller& controller, const VehicleModel& vehicle) {
  const auto trajectory = make_circle();
  trajectory->prepare();
  ControllerFlight flight;
  flight.controller = &controller;
  flight.trajectory = trajectory.get();
  flight.vehicle = vehicle;
  flight.duration_s = 24.0;
  flight.settle_s = 12.0;
  return fly(flight);
}

ControllerFlightEnd hover(Controller& controller, const VehicleModel& vehicle, const ForceEffect::Force& force,
                          double duration_s = 30.0) {
  const auto trajectory = make_hover();
  ControllerFlight flight;
  flight.controller = &controller;
  flight.trajectory = trajectory.get();
  flight.vehicle = vehicle;
  flight.duration_s = duration_s;
  flight.settle_s = duration_s / 2.0;
  flight.force = force;
  return fly(flight);
}

std::string reset_message(Controller& controller, const VehicleModel& vehicle) {
  try {
    controller.reset({vehicle, 1.0 / controller.rate_hz(vehicle)}, Observation{});
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

// no feed-forward: velocity is P times the lag, so that the lag is v/2; drag and tilt add a little
TEST(Pid, OnTheCrazyflieLagsBehindByHalfASecond) {
  const auto pid = make_pid();
  EXPECT_NEAR(circle(*pid, crazyflie()).rmse_xy_m, circle_speed_mps / 2.0, 0.1 * circle_speed_mps / 2.0);
}

TEST(Pid, FeedForwardTakesTheLagAway) {
  const auto velocity = make_pid(), full = make_pid();
  set_text(*velocity, "feedforward", "velocity");
  set_text(*full, "feedforward", "full");
  EXPECT_LT(circle(*velocity, crazyflie()).rmse_xy_m, 0.03);
  EXPECT_LT(circle(*full, crazyflie()).rmse_xy_m, 0.03);
}

TEST(Pid, OnTheIrisFollowsBecauseItsTargetIsFedForward) {
  const auto with = make_pid(), without = make_pid();
  set_text(*without, "feedforward", "none");
  EXPECT_LT(circle(*with, iris()).rmse_xy_m, 0.03);
  EXPECT_NEAR(circle(*without, iris()).rmse_xy_m, circle_speed_mps / 1.0, 0.25 * circle_speed_mps);
}

TEST(Pid, GainsAreTimesTheFirmwares) {
  const auto quick = make_pid();
  set_number(*quick, "position_gain", 2.0);
  EXPECT_NEAR(circle(*quick, crazyflie()).rmse_xy_m, circle_speed_mps / 4.0, 0.15 * circle_speed_mps / 4.0);
}

TEST(Pid, SaysWhatIsWrong) {
  const auto pid = make_pid();
  set_text(*pid, "feedforward", "some");
  EXPECT_THAT(reset_message(*pid, iris()), testing::HasSubstr("feedforward"));
  const auto odd = make_pid();
  set_number(*odd, "rate_hz", 130.0);
  EXPECT_THAT(reset_message(*odd, crazyflie()), testing::HasSubstr("does not divide"));
}

// velocity wanted is 1.0 times the lag
TEST(Indi, OnTheCrazyflieLagsBehindByASecond) {
  const auto indi = make_indi();
  EXPECT_NEAR(circle(*indi, crazyflie()).rmse_xy_m, circle_speed_mps, 0.08 * circle_speed_mps);
}

TEST(Indi, InFlatnessFormFollows) {
  for (const VehicleModel& vehicle : {crazyflie(), iris()}) {
    const auto indi = make_indi();
    set_text(*indi, "law", "flatness");
    EXPECT_LT(circle(*indi, vehicle).rmse_xy_m, 0.02) << vehicle.name;
  }
}

// GIVEN a steady force WHEN acceleration is inverted THEN nothing is left of it, without any integral
TEST(Indi, LeavesNothingOfAConstantForce) {
  for (const char* law : {"firmware", "flatness"})
    for (const VehicleModel& vehicle : {crazyflie(), iris()}) {
      const auto indi = make_indi();
      set_text(*indi, "law", law);
      const Vector3 force = 0.06 * vehicle.weight_N() * Vector3(1.0, -1.0, 0.5);
      EXPECT_LT(hover(*indi, vehicle, [=](double) { return force; }).rmse_xy_m, 2e-3) << vehicle.name << " " << law;
    }
}

// the Crazyflie's firmware clamps roll and pitch to 10 degrees: a force above tan(10°) of the weight on an axis wins
TEST(Indi, HoldsWhatItsTiltLimitAllows) {
  const auto drift = [](const VehicleModel& vehicle, double tilt_limit_deg) {
    const auto indi = make_indi();
    set_number(*indi, "tilt_limit_deg", tilt_limit_deg);
    const Vector3 force = 0.22 * vehicle.weight_N() * Vector3::UnitX();
    return hover(*indi, vehicle, [=](double) { return force; }).rmse_xy_m;
  };
  EXPECT_GT(drift(crazyflie(), 0.0), 1.0);
  EXPECT_LT(drift(crazyflie(), 20.0), 2e-3);
  EXPECT_LT(drift(iris(), 0.0), 2e-3);
}

TEST(Indi, FliesOverTheUsualLoopsToo) {
  const auto indi = make_indi();
  set_text(*indi, "inner", "low_level");
  EXPECT_LT(hover(*indi, crazyflie(), gust(0.02)).rmse_xy_m, 0.15);
}

TEST(Indi, SaysWhatIsWrong) {
  for (const char* name : {"law", "inner", "low_level"}) {
    const auto indi = make_indi();
    set_text(*indi, name, "other");
    std::string message = "accepted";
    try {
      indi->reset({iris(), 0.0025}, Observation{});
    } catch (const ConfigError& error) {
      message = error.what();
    }
    EXPECT_THAT(message, testing::HasSubstr("\"other\" is unknown")) << name;
  }
}

// GIVEN a constant force WHEN an adaptive law has settled THEN its estimate is that force, in newton
TEST(AdaptiveControllers, EstimateTheForce) {
  for (const auto& make : {make_asindy, make_daiml, make_l1, make_mpc})
    for (const VehicleModel& vehicle : {crazyflie(), iris()})
      for (const char* from : {"command", "rotor_speed"}) {
        const auto controller = make();
        set_text(*controller, "thrust_estimate", from);
        const Vector3 force = 0.06 * vehicle.weight_N() * Vector3(1.0, -0.7, 0.5);
        hover(*controller, vehicle, [=](double) { return force; });
        const Telemetry told = telemetry_of(*controller);
        EXPECT_NEAR(told["force_x_N"], force.x(), 0.05 * force.norm()) << vehicle.name;
        EXPECT_NEAR(told["force_y_N"], force.y(), 0.05 * force.norm()) << vehicle.name;
        EXPECT_NEAR(told["force_z_N"], force.z(), 0.05 * force.norm()) << vehicle.name;
      }
}

TEST(AdaptiveControllers, BeatTheirOwnTrackingLawInAGust) {
  for (const VehicleModel& vehicle : {crazyflie(), iris()}) {
    const auto plain = make_geometric();
    set_number(*plain, "integral", 0.0);
    const double without = hover(*plain, vehicle, gust(0.06 * vehicle.weight_N())).rmse_xy_m;
    for (const auto& make : {make_asindy, make_daiml, make_l1, make_mpc}) {
      const auto controller = make();
      EXPECT_LT(hover(*controller, vehicle, gust(0.06 * vehicle.weight_N())).rmse_xy_m, 0.6 * without) << vehicle.name;
    }
  }
}

TEST(AdaptiveControllers, LimitWhatTheyCancel) {
  const VehicleModel vehicle = iris();
  for (const auto& make : {make_asindy, make_daiml, make_l1, make_mpc}) {
    const auto controller = make();
    set_number(*controller, "limit_weights", 0.02);
    hover(*controller, vehicle, [=](double) { return Vector3(0.05 * vehicle.weight_N(), 0.0, 0.0); });
    EXPECT_NEAR(telemetry_of(*controller)["force_x_N"], 0.02 * vehicle.weight_N(), 1e-9);
  }
}

// poses reach the controller so late, with their time stamps, as they do over a link
struct LateLink {
  double late_s;
  std::vector<Observation> past{};
  void operator()(Observation& seen) {
    past.push_back(seen);
    const auto late = static_cast<std::size_t>(std::lround(late_s * 500.0));
    const Observation& old = past[past.size() > late ? past.size() - 1 - late : 0];
    seen.pose_time_s = old.pose_time_s;
    seen.position_W_m = old.position_W_m;
    seen.velocity_W_mps = old.velocity_W_mps;
  }
};

ControllerFlight link_flight(Controller& controller, const Trajectory& trajectory, double late_s) {
  ControllerFlight flight;
  flight.controller = &controller;
  flight.trajectory = &trajectory;
  flight.vehicle = crazyflie();
  flight.duration_s = 20.0;
  flight.sensor = LateLink{late_s};
  return flight;
}

// root mean square of the horizontal force that a law estimates on a quick figure of eight in still air, without drag: there is none
double estimate_of_nothing(Controller& controller, double late_s) {
  const auto eight = make_lemniscate();
  set_number(*eight, "period_s", 4.0);
  eight->prepare();
  ControllerFlight flight = link_flight(controller, *eight, late_s);
  flight.vehicle.effects.clear();
  double sum = 0.0, count = 0.0;
  flight.heard = [&](const RotorCommand&) {
    const Telemetry told = telemetry_of(controller);
    sum += told["force_x_N"] * told["force_x_N"] + told["force_y_N"] * told["force_y_N"];
    count += 1.0;
  };
  fly(flight);
  return std::sqrt(sum / count);
}

// GIVEN poses that are 100 ms old WHEN the thrust beside their acceleration ends at their time stamp THEN the vehicle's own turning is not taken
// for a force
TEST(Offboard, ThrustUpToTheTimeStampBelongsToTheAcceleration) {
  for (const auto& make : {make_l1, make_mpc}) {
    const auto arrival = make(), stamp = make();
    set_text(*stamp, "thrust_until", "stamp");
    EXPECT_LT(estimate_of_nothing(*stamp, 0.1), 0.1 * estimate_of_nothing(*arrival, 0.1));
    EXPECT_EQ(estimate_of_nothing(*stamp, 0.0), estimate_of_nothing(*arrival, 0.0));
  }
  const auto wrong = make_l1();
  set_text(*wrong, "thrust_until", "whenever");
  EXPECT_THAT(reset_message(*wrong, crazyflie()), testing::HasSubstr("\"whenever\" is unknown"));
}

// a law that moves late poses to the present loses less by them than the same feedback on the late ones
TEST(Mpc, MovesLatePosesToThePresent) {
  const auto mpc = make_mpc(), plain = make_geometric();
  const auto error = [](Controller& controller, double late_s) {
    const auto trajectory = make_hover();
    ControllerFlight flight = link_flight(controller, *trajectory, late_s);
    flight.force = gust(0.06 * flight.vehicle.weight_N());
    return fly(flight).rmse_xy_m;
  };
  for (Controller* controller : {mpc.get(), plain.get()}) {
    set_number(*controller, "bandwidth_radps", 3.0);
    set_text(*controller, "thrust_until", "stamp");
  }
  set_number(*plain, "integral", 0.0);
  const double lost = error(*mpc, 0.2) / error(*mpc, 0.0);
  EXPECT_LT(lost, 0.5 * error(*plain, 0.2) / error(*plain, 0.0));
}

TEST(Asindy, FliesWithThePapersTermsAndThePrintedLaw) {
  for (const char* law : {"corrected", "printed"})
    for (const VehicleModel& vehicle : {crazyflie(), iris()}) {
      const auto asindy = make_asindy();
      set(*asindy, "terms",
          std::vector<std::string>{"1", "theta", "phi", "T sin theta", "T cos theta", "T sin phi", "T cos phi"});
      set_text(*asindy, "covariance_law", law);
      EXPECT_LT(hover(*asindy, vehicle, gust(0.05 * vehicle.weight_N())).rmse_xy_m, 0.25) << vehicle.name << " " << law;
    }
}

constexpr const char* model_text = R"(
[[effect]]
type = "sindy_residual"
terms = ["1", "T sin theta"]
fx = [0.3, -0.2]
fy = [0.1, 0.0]
fz = [0.0, 0.0]
)";

// level, at rest on the reference: before anything is learned, the estimate is nothing, or on demand the model's force
TEST(Asindy, StartsAtZeroOrFromAnIdentifiedModel) {
  const VehicleModel vehicle = iris();
  for (const bool start : {true, false}) {
    const auto asindy = make_asindy();
    set(*asindy, "model", InputFile{"model.toml", model_text});
    if (start) set(*asindy, "start_at_model", start);
    set_number(*asindy, "leak_radps", 0.0);
    set_number(*asindy, "noise", 1e6);
    Observation observation;
    observation.attitude_WB = Eigen::AngleAxisd(0.2, Vector3::UnitY());
    observation.rotor_speed_radps.fill(vehicle.hover_speed_radps());
    asindy->reset({vehicle, 0.0025}, observation);
    asindy->update(observation, Reference{});
    EXPECT_NEAR(telemetry_of(*asindy)["force_x_N"], start ? 0.3 - 0.2 * vehicle.weight_N() * std::sin(0.2) : 0.0, 1e-3);
    EXPECT_NEAR(telemetry_of(*asindy)["force_y_N"], start ? 0.1 : 0.0, 1e-3);
  }
}

TEST(Asindy, RefusesAFileWithoutAModel) {
  const auto asindy = make_asindy();
  set(*asindy, "model", InputFile{"m.toml", "[[effect]]\ntype = \"mass\"\n"});
  EXPECT_THAT(reset_message(*asindy, iris()), testing::HasSubstr("m.toml: no [[effect]] of type \"sindy_residual\""));
}

TEST(Asindy, SaysWhatIsWrong) {
  const auto none = make_asindy();
  set(*none, "terms", std::vector<std::string>{});
  EXPECT_THAT(reset_message(*none, iris()), testing::HasSubstr("1 to 24 terms"));
  const auto twice = make_asindy();
  set(*twice, "terms", std::vector<std::string>{"T sin theta", "1", "T*sin(theta)"});
  EXPECT_THAT(reset_message(*twice, iris()), testing::HasSubstr("term \"T sin theta\" is here twice"));
  const auto both = make_asindy();
  set(*both, "terms", std::vector<std::string>{"1"});
  set(*both, "model", InputFile{"m.toml", model_text});
  EXPECT_THAT(reset_message(*both, iris()), testing::HasSubstr("\"terms\" stands beside \"model\""));
  const auto empty = make_asindy();
  set(*empty, "model", InputFile{"m.toml", "[[effect]]\ntype = \"sindy_residual\"\n"});
  EXPECT_THAT(reset_message(*empty, iris()), testing::StartsWith("m.toml has 0 terms"));
  const auto short_list = make_asindy();
  set(*short_list, "model",
      InputFile{"m.toml", "[[effect]]\ntype = \"sindy_residual\"\nterms = [\"1\"]\nfx = []\nfy = [0]\nfz = [0]\n"});
  EXPECT_THAT(reset_message(*short_list, iris()), testing::StartsWith("m.toml:4:6: fx must have one number per term"));
  const auto wrong = make_asindy();
  set(*wrong, "terms", std::vector<std::string>{"T sin alpha"});
  EXPECT_THAT(reset_message(*wrong, iris()), testing::HasSubstr("alpha"));
  const auto law = make_asindy();
  set_text(*law, "covariance_law", "new");
  EXPECT_THAT(reset_message(*law, iris()), testing::HasSubstr("corrected or printed"));
}

// a network that was never trained, with outputs of about one
NetworkWeights untrained() {
  NetworkWeights weights;
  weights.inputs.assign(daiml_input_names.begin(), daiml_input_names.end());
  weights.mean = Eigen::VectorXd::Zero(daiml_inputs);
  weights.scale = Eigen::VectorXd::Ones(daiml_inputs);
  Eigen::Index before = daiml_inputs;
  std::uint64_t counter = 0;
  for (const Eigen::Index width : {50, 60, 50, 2}) {
    NetworkWeights::Layer layer{Eigen::MatrixXd(width, before), Eigen::VectorXd::Zero(width)};
    for (Eigen::Index i = 0; i < layer.weight.size(); ++i)
      layer.weight(i) =
          RandomStream(3, 0, "untrained").normal4(counter++)[0] * std::sqrt(2.0 / static_cast<double>(before));
    weights.layers.push_back(layer);
    before = width;
  }
  return weights;
}

TEST(Daiml, FliesOnAnyFeatures) {
  for (const VehicleModel& vehicle : {crazyflie(), iris(), ring(6, 3.0, 0.3, 0.03)}) {
    const auto daiml = make_daiml();
    set(*daiml, "weights", InputFile{"untrained", network_text(untrained())});
    EXPECT_LT(hover(*daiml, vehicle, gust(0.05 * vehicle.weight_N())).rmse_xy_m, 0.25) << vehicle.name;
  }
}

TEST(Daiml, RefusesANetworkWithOtherInputs) {
  NetworkWeights weights = untrained();
  weights.inputs[0] = "speed";
  const auto daiml = make_daiml();
  set(*daiml, "weights", InputFile{"w.txt", network_text(weights)});
  EXPECT_THAT(reset_message(*daiml, iris()), testing::HasSubstr("w.txt looks at other inputs"));
}

TEST(Offboard, DelayAndSlownessCost) {
  const auto error = [](double rate_hz, double delay_s) {
    const auto asindy = make_asindy();
    set_number(*asindy, "rate_hz", rate_hz);
    set_number(*asindy, "delay_s", delay_s);
    return hover(*asindy, crazyflie(), gust(0.02)).rmse_xy_m;
  };
  const double quick = error(100.0, 0.0);
  EXPECT_GT(error(100.0, 0.06), 1.02 * quick);
  EXPECT_GT(error(10.0, 0.0), 1.02 * quick);
}

// the PD then holds the vehicle back by K_v/K_p = 2/w times the speed
TEST(Offboard, WithoutFeedForwardLagsBehind) {
  const auto geometric = make_geometric();
  set(*geometric, "feedforward", false);
  set_number(*geometric, "bandwidth_radps", 2.0);
  set_number(*geometric, "integral", 0.0);
  EXPECT_NEAR(circle(*geometric, crazyflie()).rmse_xy_m, circle_speed_mps, 0.1 * circle_speed_mps);
}

TEST(Offboard, SaysWhatIsWrong) {
  const auto rate = make_geometric();
  set_number(*rate, "rate_hz", 40.0);
  EXPECT_THAT(reset_message(*rate, crazyflie()), testing::HasSubstr("does not divide"));
  EXPECT_EQ(reset_message(*rate, iris()), "accepted");
  const auto estimate = make_geometric();
  set_text(*estimate, "thrust_estimate", "guess");
  EXPECT_THAT(reset_message(*estimate, iris()), testing::HasSubstr("command or rotor_speed"));
}

// every vehicle that is shipped flies with every controller, as they come
TEST(EveryController, FliesEveryVehicleUnderModels) {
  for (const std::string& name : vehicle_names()) {
    const VehicleModel vehicle = read_vehicle(name);
    for (const ControllerRow& row : controller_registry()) {
      const auto controller = row.make();
      const ControllerFlightEnd still = hover(*controller, vehicle, {});
      EXPECT_TRUE(still.finite);
      EXPECT_LT(still.rmse_xy_m, 0.01) << name << " " << row.name;
      EXPECT_LT(still.rmse_z_m, 0.01) << name << " " << row.name;
      const ControllerFlightEnd gusty = hover(*controller, vehicle, gust(0.06 * vehicle.weight_N()));
      EXPECT_TRUE(gusty.finite);
      EXPECT_LT(gusty.rmse_xy_m, 0.8) << name << " " << row.name;
      EXPECT_LT(circle(*controller, vehicle).rmse_xy_m, 0.7) << name << " " << row.name;
    }
  }
}

}  // namespace controllers_test
}  // namespace gustlab::test
