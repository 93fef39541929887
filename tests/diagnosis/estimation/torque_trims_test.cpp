// Torque trims of every flight: what is known of them beforehand, and what several flights say of that together.
#include "diagnosis/estimation/torque_trims.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "diagnosis/result/decisions.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab::diagnosis {
namespace torque_trims_test {

Catalogue catalogue_of(int flights) {
  return {read_vehicle("crazyflie"), flights, {.observable = Need::attitude | Need::motion | Need::torque}};
}

int trim_of(const Catalogue& catalogue, int flight, int axis) {
  for (int c = 0; c < catalogue.size(); ++c) {
    const Column& column = catalogue.column(c);
    if (column.of_torque_trim() && column.flight == flight && column.parameter == torque_trim + axis) return c;
  }
  return -1;
}

// every flight says its trim about x, and the same again of an effect that all flights share
Grams flights_that_say(const Catalogue& catalogue, const std::vector<double>& trim_radps2, int shared,
                       double information) {
  Grams grams;
  grams.columns = catalogue.size();
  for (std::size_t f = 0; f < trim_radps2.size(); ++f) {
    const int c = trim_of(catalogue, static_cast<int>(f), 0);
    Eigen::VectorXd row = Eigen::VectorXd::Zero(catalogue.size() + 1);
    row[c] = torque_trim_sd;
    if (shared >= 0) row[shared] = torque_trim_sd;
    row[catalogue.size()] = trim_radps2[f];
    grams.block.emplace_back(information * row * row.transpose());
    grams.flight.push_back(static_cast<int>(f)), grams.time_s.push_back(0.0), grams.cluster.push_back(grams.clusters++);
    grams.known.push_back(false);
  }
  return grams;
}

std::vector<int> trims_of(const Catalogue& catalogue, int flights) {
  std::vector<int> columns;
  for (int f = 0; f < flights; ++f)
    for (int axis = 0; axis < 3; ++axis) columns.push_back(trim_of(catalogue, f, axis));
  return columns;
}

constexpr TrimVariance beforehand = {4.0, 4.0, 4.0}, usual = {25.0, 25.0, 25.0};

// mean 1.5 and 11.5; sum of squares about it 21, and one flight more as usual
TEST(TorqueTrims, AreAsFlightsScatterAboutWhatTheyShare) {
  const Catalogue catalogue = catalogue_of(4);
  const int shared = catalogue.group(catalogue.find("center_of_mass")).columns.front();
  for (const double share_radps2 : {0.0, 10.0})
    for (const bool named : {false, true}) {
      const Grams grams = flights_that_say(
          catalogue, {share_radps2 + 4.0, share_radps2 - 2.0, share_radps2 + 1.0, share_radps2 + 3.0}, shared, 1e4);
      std::vector<int> columns = trims_of(catalogue, 4);
      if (named) columns.push_back(shared);
      const TrimVariance variance = likeliest_trims(catalogue, columns, catalogue.nominal(), grams, usual, beforehand);
      EXPECT_NEAR(variance[0], (21.0 + 25.0) / 4.0, 0.05) << share_radps2 << named;
      EXPECT_NEAR(variance[1], 25.0, 2.0);  // of which these flights say nothing
    }
}

TEST(TorqueTrims, OfOneFlightAreAsTheyWereBeforehand) {
  const Catalogue catalogue = catalogue_of(1);
  const Grams grams = flights_that_say(catalogue, {4.0}, -1, 1e4);
  EXPECT_EQ(likeliest_trims(catalogue, trims_of(catalogue, 1), catalogue.nominal(), grams, usual, beforehand),
            beforehand);
}

TEST(TorqueTrims, AreUsuallyThoseOfABatteryThatIsSeatedAnew) {
  const VehicleModel vehicle = read_vehicle("crazyflie");
  EXPECT_NEAR(std::sqrt(usual_trims(vehicle)[0]),
              decisions::usual_shift * vehicle.arm_m() * vehicle.mass_kg * 9.81 / vehicle.inertia_B_kgm2(0, 0), 0.01);
}

// a centre of mass that two flights share, four times as far as trims scatter, shows as that and not as the first half second
TEST(TorqueTrims, ThatAreKnownAreBlocksOfTheirOwn) {
  const Catalogue catalogue = catalogue_of(2);
  const int shared = catalogue.group(catalogue.find("center_of_mass")).columns.front();
  Grams grams = flights_that_say(catalogue, {20.0, 20.0}, shared, 1e4);
  const Eigen::MatrixXd flown = grams.block.front();
  know_beforehand(catalogue, {25.0, 25.0, 25.0}, catalogue.nominal(), grams);
  EXPECT_EQ(grams.known, (std::vector<bool>{false, false, true, true}));
  EXPECT_EQ(grams.flight, (std::vector<int>{0, 1, 0, 1}));
  EXPECT_EQ(grams.clusters, 4);
  EXPECT_EQ(grams.block.front(), flown);
  std::vector<int> columns = trims_of(catalogue, 2);
  const double without = solve(grams.total(), columns).loss;
  columns.push_back(shared);
  EXPECT_NEAR(without - solve(grams.total(), columns).loss, 2.0 * 16.0, 0.1);
  // it is known as trims scatter: 5 rad/s² over the square root of two flights
  const Fit fit = solve(grams.total(), columns);
  EXPECT_NEAR(std::sqrt(clustered_covariance(grams, columns, fit.coefficient)(6, 6)) * torque_trim_sd,
              5.0 / std::sqrt(2.0), 0.1);
}

// against the mean of a normal variable and its prior, by hand; linearised about another value it is the same trim
TEST(TorqueTrims, ThatAreKnownAreDrawnToZero) {
  const Catalogue catalogue = catalogue_of(2);
  const std::vector<int> columns = trims_of(catalogue, 2);
  for (const double about : {0.0, 1.5}) {
    Eigen::VectorXd value = catalogue.nominal();
    value[columns[0]] = about;
    Grams grams = flights_that_say(catalogue, {4.0 - about, 0.0}, -1, 0.5);
    know_beforehand(catalogue, {2.0, 2.0, 2.0}, value, grams);
    const double found = about + torque_trim_sd * solve(grams.total(), columns).coefficient[0];
    EXPECT_NEAR(found, 4.0 * 0.5 / (0.5 + 1.0 / 2.0), 1e-6);
  }
}

}  // namespace torque_trims_test
}  // namespace gustlab::diagnosis
