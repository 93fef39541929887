// What counts as a trim beside reference flights.
#include "diagnosis/selection/trims.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/flight_data.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace {

class Trims : public ::testing::Test {
 protected:
  VehicleModel vehicle = test::ring(4, 1.5, 0.25, 0.0);
  FlightData hover = test::flight_of(
      vehicle, 2.0, 0.02, [](double) { return Motion{}; },
      [this](double) { return test::all_at(vehicle.hover_speed_radps()); });
  Session session{{hover, hover}, vehicle, 1};
  const Catalogue& catalogue = session.catalogue();
  const int force = catalogue.find("constant_force");
  // along x in the second flight, N
  double size_of(double force_N) const {
    Eigen::VectorXd value = catalogue.nominal();
    for (const int c : catalogue.groups()[static_cast<std::size_t>(force)].columns) {
      const Column& column = catalogue.columns()[static_cast<std::size_t>(c)];
      if (column.flight == 1 && column.name == "x") value[c] = force_N;
    }
    return size_in_tolerances(session, value, force);
  }
};

TEST_F(Trims, AForceOfOneFlightHasNoToleranceOfItsOwn) { EXPECT_TRUE(std::isinf(size_of(1e-3))); }

TEST_F(Trims, BesideFlightsThatHaveForcesOfTheirOwnAForceMustBeLarger) {
  Reference reference;
  for (const int parameter : {0, 1, 2}) reference.of_each_flight.push_back({{"constant_force", parameter}, 0.02});
  session.compare_with(reference);
  EXPECT_NEAR(size_of(0.06), 1.0, 1e-12);
  EXPECT_NEAR(size_of(0.12), 2.0, 1e-12);
}

}  // namespace
}  // namespace gustlab::diagnosis
