// The published rows of the nanodrone benchmark (arXiv 2512.14450), from its test flights.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "support/flights.hpp"
#include "support/program.hpp"

namespace gustlab {
namespace replay_flights_test {

using test::Said;

// imports the test flights and replays them from every sample at 1, 10 and 50 steps of 10 ms
nlohmann::json replay_test_flights(const std::filesystem::path& flights, const std::string& vehicle) {
  const std::filesystem::path root(source_directory());
  const TemporaryFolder folder;
  std::vector<std::string> import{test::python_program(), (root / "scripts" / "import_log.py").string()};
  std::vector<std::string> replay{"replay"};
  for (const char* name : {"test_melon_run1_bag1", "test_melon_run2_bag4", "test_melon_run3_bag5"}) {
    import.push_back((flights / "nanodrone" / name).string() + ".csv.gz");
    replay.push_back(folder.file(std::string(name) + "_1.csv"));
  }
  import.insert(import.end(), {"--map", "nanodrone", "--out", folder.path().string()});
  const Said imported = test::run_program(import);
  EXPECT_EQ(imported.exit_code, 0) << imported.err;
  replay.insert(replay.end(), {"--vehicle", vehicle, "--stride", "1", "--horizon", "0.01,0.1,0.5", "--format", "json"});
  const Said replayed = test::gustlab(replay);
  EXPECT_EQ(replayed.exit_code, 0) << replayed.err;
  return nlohmann::json::parse(replayed.out);
}

// one step, ten steps, fifty steps
using Row = std::array<double, 3>;

void expect_row(const nlohmann::json& ours, const Row& published, double tolerance, std::size_t first = 0) {
  for (std::size_t h = first; h < published.size(); ++h)
    EXPECT_NEAR(ours[h].get<double>(), published[h], tolerance * published[h]) << "horizon " << h;
}

TEST(ReplayOfTheNanodroneFlights, PrintsThePublishedNaiveAndPhysicsRows) {
  GUSTLAB_FLIGHTS_OR_SKIP(flights);
  const std::string vehicle =
      (std::filesystem::path(source_directory()) / "tests/data/crazyflie_brushless_without_torque/vehicle.toml")
          .string();
  const nlohmann::json fit = replay_test_flights(flights, vehicle);
  EXPECT_EQ(fit["windows"], 3 * (6499 - 50));
  // naive; the published figures have four decimals, of which one step's position has three digits
  expect_row(fit["position_m"]["hold"], {0.0143, 0.1430, 0.6797}, 0.01);
  expect_row(fit["velocity_mps"]["hold"], {0.0329, 0.3182, 1.4749}, 0.01);
  expect_row(fit["attitude_rad"]["hold"], {0.0071, 0.0692, 0.3041}, 0.01);
  expect_row(fit["body_rate_radps"]["hold"], {0.0796, 0.3596, 0.8837}, 0.01);
  // physics at 10 and 50 steps; theirs took single steps of 10 ms, ours are of 1 ms
  expect_row(fit["position_m"]["before"], {0.0013, 0.0126, 0.1269}, 0.05, 1);
  expect_row(fit["velocity_mps"]["before"], {0.0080, 0.0570, 0.5781}, 0.05, 1);
  expect_row(fit["attitude_rad"]["before"], {0.0011, 0.0205, 0.2544}, 0.05, 1);
  expect_row(fit["body_rate_radps"]["before"], {0.0796, 0.3596, 0.8837}, 0.05, 1);
}

}  // namespace replay_flights_test
}  // namespace gustlab
