// The acceleration by a force of every flight's own, against the force over the mass.
#include <gtest/gtest.h>

#include <cmath>

#include "diagnosis/evidence/gather_evidence.hpp"
#include "support/flight_data.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace own_acceleration_test {

TEST(OwnAcceleration, OfAForcePerFlightIsItsRootMeanSquareOverBothFlights) {
  const VehicleModel vehicle = test::crazyflie();
  const auto hover = [&](double) {
    RotorArray speeds{};
    speeds.fill(vehicle.hover_speed_radps());
    return speeds;
  };
  const FlightData flight = test::flight_of(
      vehicle, 2.0, 0.01, [](double) { return Motion{}; }, hover);
  Session session({flight, flight}, vehicle, 1);
  session.linearise(session.value(), session.all_columns());
  Selection selection;
  Finding finding;
  finding.group = session.catalogue().find("constant_force");
  selection.findings.push_back(finding);
  selection.value = session.value();
  for (const int c : session.catalogue().group(finding.group).columns) {
    const Column& column = session.catalogue().column(c);
    if (column.name == "x") selection.value[c] = column.flight == 0 ? 0.01 : 0.0;
    if (column.name == "z") selection.value[c] = column.flight == 0 ? 0.0 : -0.02;
  }
  const double expected_mps2 = std::hypot(0.01, 0.02) / std::sqrt(2.0) / vehicle.mass_kg;
  EXPECT_NEAR(own_acceleration_mps2(session, selection, finding), expected_mps2, 1e-6 * expected_mps2);
}

}  // namespace own_acceleration_test
}  // namespace gustlab::diagnosis
