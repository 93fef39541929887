// A model that was written as an effect, flown in the simulator and identified from the flight is the model again.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "identification/identify.hpp"
#include "simulation/flight.hpp"
#include "simulation/recorded_forces.hpp"
#include "simulation/recorder.hpp"

namespace gustlab {
namespace simulator_test {

constexpr const char* experiment_text = R"(
format = "gustlab-experiment/1"
name = "planted"
vehicle = "crazyflie"
trajectories = ["multisine"]
controllers = ["pid"]
replicates = 2
duration_s = 20.0
[[effect]]
type = "sindy_residual"
terms = ["1", "T sin theta", "phi", "T sin phi", "T cos theta"]
fx = [0.01, -0.3, 0, 0, 0]
fy = [0, 0, 0.04, 0.2, 0]
fz = [-0.03, 0, 0, 0, 0.15]
)";

struct Flown {
  FlightLog log;
  VehicleModel vehicle;
};

Flown fly_planted() {
  const std::string path = (std::filesystem::temp_directory_path() / "gustlab_planted.toml").string();
  std::ofstream(path) << experiment_text;
  const Experiment experiment = read_experiment(path);
  std::filesystem::remove(path);
  Flight flight(experiment, plan(experiment).front());
  TrackingError error(0.0, static_cast<std::size_t>(flight.ticks));
  FlightRecorder recorder(experiment, flight);
  EXPECT_EQ(fly(flight, error, &recorder).outcome, Outcome::completed);
  return {recorder.take(), experiment.vehicle};
}

std::vector<std::vector<ResidualSamples>> samples(const Flown& flown, AccelerationSource source) {
  const RecordedForces forces(flown.log, flown.vehicle, Known::vehicle);
  const KnownModel known = [&](std::size_t row, const VehicleState& state) {
    const RecordedForces::Force force = forces.at(row, state);
    return KnownForce{force.force_B_N, force.thrust_N};
  };
  return {force_residual(flown.log, forces.vehicle(), known, {.edge_s = 0.5}, source)};
}

Eigen::MatrixXd planted() {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(3, 7);
  out(0, 0) = 0.01;
  out(0, 3) = -0.3;
  out(1, 2) = 0.04;
  out(1, 5) = 0.2;
  out(2, 0) = -0.03;
  out(2, 4) = 0.15;
  return out;
}

void expect_found(AccelerationSource source, double largest_error, double largest_share) {
  const Flown flown = fly_planted();
  const auto flights = samples(flown, source);
  for (const OptimizerRow& row : optimizer_registry()) {
    IdentifyOptions options;
    options.optimizer = row.name;
    const Identification found = identify(flights, {}, options);
    EXPECT_TRUE(((found.fit.coefficients.array() != 0.0) == (planted().array() != 0.0)).all())
        << row.name << '\n'
        << found.fit.coefficients;
    EXPECT_LT((found.fit.coefficients - planted()).cwiseAbs().maxCoeff(), largest_error) << row.name;
    EXPECT_LT(found.error_holdout, largest_share * found.force_rms) << row.name;
  }
}

// the accelerometer rides off the centre of mass, so a derivative of the body rate is left in it
TEST(FlownModel, IsFoundAgainFromTheAccelerometer) { expect_found(AccelerationSource::accelerometer, 1e-4, 1e-3); }

TEST(FlownModel, IsFoundAgainFromTheDerivativeOfVelocity) { expect_found(AccelerationSource::velocity, 0.01, 0.01); }

}  // namespace simulator_test
}  // namespace gustlab
