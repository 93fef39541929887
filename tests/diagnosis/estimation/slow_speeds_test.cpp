// Commands that jitter from row to row, beside speeds that follow another sample of that jitter, late or not.
#include "diagnosis/estimation/slow_speeds.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "diagnosis/model/speed_comparison.hpp"
#include "gustlab/random.hpp"
#include "support/flight_data.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace slow_speeds_test {

constexpr double sample_s = 0.01, duration_s = 15.0;

struct Asked {
  double late_s;   // the rotors
  double jitter;   // of commands and, apart, of speeds; share of the hover speed
  double found_s;  // the delay that is asked
};

std::optional<double> told(const Asked& asked) {
  const VehicleModel vehicle = test::crazyflie();
  const double hover = vehicle.hover_speed_radps();
  const auto series = [&](const char* stream, double late_s) {
    return [=, random = RandomStream(7, 0, stream)](double t) {
      RotorArray speeds{};
      const auto jitter = random.normal4(static_cast<std::uint64_t>(std::lround(t / sample_s)));
      for (std::size_t i = 0; i < 4; ++i)
        speeds[i] =
            hover * (1.0 + 0.15 * std::sin((12.0 + static_cast<double>(i)) * (t - late_s)) + asked.jitter * jitter[i]);
      return speeds;
    };
  };
  FlightData flight = test::flight_of(
      vehicle, duration_s, sample_s, [](double) { return Motion{}; }, series("commands", 0.0));
  const Catalogue catalogue{vehicle, 1, {.observable = Need::attitude | Need::motion | Need::torque}};
  const double lag_s = 0.0125;  // of the vehicle file
  flight.measured_speed = test::record_of(series("speeds", asked.late_s + lag_s), duration_s, sample_s, true);
  flight.measured_at_sample = measured_beside_commands(flight);
  Eigen::VectorXd found = catalogue.nominal();
  found[catalogue.group(catalogue.find(Place::actuation, Latency::delay)).columns.front()] += asked.found_s;
  return latency_of_slow_speeds({flight}, catalogue, found, catalogue.nominal());
}

TEST(SlowSpeeds, AreNotAskedWhereCommandsPredictEveryRow) { EXPECT_FALSE(told({0.03, 0.0, 0.03}).has_value()); }

TEST(SlowSpeeds, ShowADelayThatIsThereAndNoneThatOnlyAverages) {
  const auto there = told({0.04, 0.02, 0.03}), averages = told({0.0, 0.02, 0.026});
  ASSERT_TRUE(there.has_value() && averages.has_value());
  EXPECT_GT(*there, 50.0);
  EXPECT_LT(*averages, 0.0);
}

TEST(SlowSpeeds, SayNothingOfFlightsWithoutSpeeds) {
  FlightData flight = test::flight_of(
      test::crazyflie(), 1.0, sample_s, [](double) { return Motion{}; }, [](double) { return test::all_at(2000.0); });
  const Catalogue catalogue{test::crazyflie(), 1, {.observable = Need::attitude | Need::motion | Need::torque}};
  EXPECT_FALSE(latency_of_slow_speeds({flight}, catalogue, catalogue.nominal(), catalogue.nominal()).has_value());
}

}  // namespace slow_speeds_test
}  // namespace gustlab::diagnosis
