#include "identification/force_residual.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "gustlab/errors.hpp"
#include "identification/planted_flight.hpp"

namespace gustlab {
namespace force_residual_test {

Vector3 planted_force(const FeatureInput& in) {
  return {0.4 - 0.3 * in.thrust_N * std::sin(in.pitch_rad), 0.9 * in.roll_rad, -0.5};
}

double worst_error(const std::vector<ResidualSamples>& parts) {
  double worst = 0.0;
  for (const ResidualSamples& part : parts) {
    for (std::size_t i = 0; i < part.inputs.size(); ++i) {
      worst = std::max(
          worst, (part.force_W_N.row(static_cast<Eigen::Index>(i)).transpose() - planted_force(part.inputs[i])).norm());
    }
  }
  return worst;
}

void remove(FlightLog& log, std::string_view name) {
  std::erase_if(log.columns, [&](const LogColumn& column) { return column.name == name; });
}

TEST(ForceResidual, IsTheForceThatWasPlanted) {
  const PlantedFlight flight = planted_flight(planted_force, 2000, 0.002);
  for (Differentiation d : {Differentiation{}, Differentiation{.kind = DerivativeKind::savitzky_golay, .window = 5}}) {
    const auto parts = force_residual(flight.log, flight.vehicle, flight.known(), d, AccelerationSource::velocity);
    ASSERT_EQ(parts.size(), 1u);
    EXPECT_EQ(parts[0].inputs.size(), 2000u);
    EXPECT_LT(worst_error(parts), 2e-3) << to_string(d.kind);
  }
}

TEST(ForceResidual, TheAccelerometerNeedsNoDerivative) {
  const PlantedFlight flight = planted_flight(planted_force, 100, 0.025);
  const auto parts = force_residual(flight.log, flight.vehicle, flight.known(), {}, AccelerationSource::accelerometer);
  EXPECT_LT(worst_error(parts), 1e-12);
}

TEST(ForceResidual, VelocityIsDerivedFromPositionWhereThereIsNone) {
  PlantedFlight flight = planted_flight(planted_force, 2000, 0.002);
  for (const char* name : {"vx", "vy", "vz"}) remove(flight.log, name);
  const auto parts =
      force_residual(flight.log, flight.vehicle, flight.known(), {.edge_s = 0.01}, AccelerationSource::velocity);
  EXPECT_LT(worst_error(parts), 5e-3);
}

TEST(ForceResidual, TheCentreOfMassIsWhatAccelerates) {
  // a vehicle that spins about its centre of mass while that hovers: the origin circles, no force is left
  PlantedFlight flight = planted_flight([](const FeatureInput&) { return Vector3::Zero(); }, 0, 0.002);
  flight.vehicle.center_of_mass_B_m = {0.1, 0.0, 0.0};
  for (const char* name : {"wx", "wy", "wz"}) flight.log.columns.push_back({name, {}});
  for (int i = 0; i < 1000; ++i) {
    const double t = 0.002 * i, yaw = 2.0 * t;
    const Vector3 arm(0.1 * std::cos(yaw), 0.1 * std::sin(yaw), 0.0), velocity(-2.0 * -arm.y(), 2.0 * -arm.x(), 0.0);
    const double values[] = {
        -arm.x(), -arm.y(), 0.0,  velocity.x(), velocity.y(), 0.0, std::cos(yaw / 2), 0.0, 0.0, std::sin(yaw / 2),
        0.0,      0.0,      9.81, 0.0,          0.0,          2.0};
    flight.log.time_s.push_back(t);
    for (std::size_t c = 0; c < flight.log.columns.size(); ++c) flight.log.columns[c].values.push_back(values[c]);
    flight.thrust_N.push_back(flight.vehicle.weight_N());
  }
  const auto parts = force_residual(flight.log, flight.vehicle, flight.known(), {}, AccelerationSource::velocity);
  EXPECT_LT(parts[0].force_W_N.cwiseAbs().maxCoeff(), 1e-9);
}

TEST(ForceResidual, YawIsUnwrapped) {
  PlantedFlight flight = planted_flight(planted_force, 100, 0.01);
  for (std::size_t i = 0; i < 100; ++i) {
    const double yaw = 0.2 * static_cast<double>(i);
    const double q[] = {std::cos(yaw / 2), 0.0, 0.0, std::sin(yaw / 2)};
    for (std::size_t c = 0; c < 4; ++c) flight.log.columns[6 + c].values[i] = q[c];
  }
  const auto parts = force_residual(flight.log, flight.vehicle, flight.known(), {}, AccelerationSource::velocity);
  EXPECT_NEAR(parts[0].inputs.back().yaw_rad - parts[0].inputs.front().yaw_rad, 0.2 * 99, 1e-9);
}

TEST(ForceResidual, IsCutAtGapsAndTrimmedAtEveryEdge) {
  PlantedFlight flight = planted_flight(planted_force, 1000, 0.002);
  // rows 400–409 have no velocity; row 700 on is later
  for (std::size_t i = 400; i < 410; ++i) flight.log.columns[3].values[i] = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 700; i < 1000; ++i) flight.log.time_s[i] += 1.0;
  const auto parts =
      force_residual(flight.log, flight.vehicle, flight.known(), {.edge_s = 0.0039}, AccelerationSource::velocity);
  ASSERT_EQ(parts.size(), 3u);
  EXPECT_EQ(parts[0].inputs.size(), 396u);
  EXPECT_EQ(parts[1].inputs.size(), 286u);
  EXPECT_EQ(parts[2].inputs.size(), 296u);
  EXPECT_LT(worst_error(parts), 5e-3);
}

TEST(ForceResidual, SaysWhatIsMissing) {
  const auto refuses = [](std::initializer_list<const char*> missing, AccelerationSource source,
                          Differentiation d = {}) {
    PlantedFlight flight = planted_flight(planted_force, 50, 0.01);
    for (const char* name : missing) remove(flight.log, name);
    EXPECT_THROW(force_residual(flight.log, flight.vehicle, flight.known(), d, source), DataError);
  };
  refuses({"qx"}, AccelerationSource::velocity);
  refuses({"vx", "px"}, AccelerationSource::velocity);
  refuses({"az"}, AccelerationSource::accelerometer);
  refuses({}, AccelerationSource::velocity, {.edge_s = 1.0});
  refuses({}, AccelerationSource::velocity, {.kind = DerivativeKind::savitzky_golay, .window = 51});
}

}  // namespace force_residual_test
}  // namespace gustlab
