// The loop allocates nothing, whoever flies: every controller of the registry, with and without a recorder.
#include <gtest/gtest.h>

#include "simulation/recorder.hpp"
#include "support/allocations.hpp"
#include "support/experiments.hpp"

namespace gustlab {
namespace flight_contract_test {

class FlightContract : public testing::TestWithParam<std::string> {};

TEST_P(FlightContract, NoHeapAllocationFromStartToEnd) {
  const Experiment experiment =
      test::read_text_experiment(test::small_experiment, {"controllers=[\"" + GetParam() + "\"]"});
  for (const bool recorded : {false, true}) {
    Flight flight(experiment, plan(experiment).front());
    TrackingError error(0.0, static_cast<std::size_t>(flight.ticks));
    FlightRecorder recorder(experiment, flight);
    const std::size_t before = test::allocations();
    const FlightEnd end = fly(flight, error, recorded ? &recorder : nullptr);
    EXPECT_EQ(test::allocations() - before, 0u) << (recorded ? "recorded" : "not recorded");
    EXPECT_EQ(end.outcome, Outcome::completed);
  }
}

std::vector<std::string> controllers() {
  std::vector<std::string> names;
  for (const ControllerRow& row : controller_registry()) names.emplace_back(row.name);
  return names;
}
INSTANTIATE_TEST_SUITE_P(Registry, FlightContract, testing::ValuesIn(controllers()),
                         [](const auto& one) { return one.param; });

}  // namespace flight_contract_test
}  // namespace gustlab
