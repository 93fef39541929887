// Constants of a rotor from rows that follow a known law, in every unit that a stand writes, and tables that tell too little.
#include "vehicle/thrust_stand.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <functional>

#include "gustlab/errors.hpp"
#include "support/temporary_folder.hpp"

namespace gustlab {
namespace thrust_stand_test {

using ::testing::Contains;
using ::testing::HasSubstr;

std::string table(const TemporaryFolder& folder, const std::string& header, int rows,
                  const std::function<std::vector<double>(int)>& row) {
  const std::string path = (folder.path() / "stand.csv").string();
  std::ofstream out(path);
  out << header << '\n';
  for (int i = 0; i < rows; ++i) {
    std::string line;
    for (const double value : row(i)) line += (line.empty() ? "" : ",") + fmt::format("{}", value);
    out << line << '\n';
  }
  return path;
}

TEST(ThrustStand, FindsTheLawsThatTheRowsFollow) {
  const TemporaryFolder folder;
  // f = (0.2 + 1.5 u + 4 u²) (V / mean V)^1.7 and 2e-6 Ω², torque 0.015 f
  const auto volts = [](int i) { return 14.0 + 0.4 * ((i * 7) % 5); };
  double mean_V = 0.0;
  for (int i = 0; i < 20; ++i) mean_V += volts(i) / 20.0;
  const ThrustStand stand =
      read_thrust_stand(table(folder, "throttle,voltage_V,thrust_N,speed_radps,torque_Nm", 20, [&](int i) {
        const double u = 0.2 + 0.04 * i, f = (0.2 + 1.5 * u + 4.0 * u * u) * std::pow(volts(i) / mean_V, 1.7);
        return std::vector<double>{u, volts(i), f, std::sqrt(f / 2e-6), -0.015 * f};
      }));
  EXPECT_EQ(stand.rows, 20u);
  EXPECT_NEAR(stand.coefficient_Ns2->value, 2e-6, 1e-12);
  EXPECT_NEAR(stand.coefficient_Ns2->deviation, 0.0, 1e-12);
  EXPECT_NEAR(stand.torque_ratio_m->value, 0.015, 1e-9);  // whichever way it turns
  EXPECT_EQ(stand.input, "throttle");
  ASSERT_TRUE(stand.input_thrust);
  EXPECT_NEAR((*stand.input_thrust)[0], 0.2, 1e-6);
  EXPECT_NEAR((*stand.input_thrust)[1], 1.5, 1e-6);
  EXPECT_NEAR((*stand.input_thrust)[2], 4.0, 1e-6);
  EXPECT_NEAR(stand.voltage_exponent->value, 1.7, 1e-6);
  EXPECT_NEAR(*stand.nominal_voltage_V, mean_V, 1e-9);
  EXPECT_NEAR(stand.thrust_misfit_N, 0.0, 1e-9);
  EXPECT_TRUE(stand.unknown.empty());
}

// y = b x with residuals that are orthogonal to x: b is exact, its variance Σ r² / ((n − 1) Σ x²)
TEST(ThrustStand, DeviationIsThatOfARegressionThroughTheOrigin) {
  const TemporaryFolder folder;
  const std::array<double, 6> x = {1.0, 1.0, 2.0, 2.0, 3.0, 3.0}, r = {0.1, -0.1, 0.2, -0.2, -0.05, 0.05};
  double squares = 0.0, left = 0.0;
  for (std::size_t i = 0; i < 6; ++i) squares += x[i] * x[i], left += r[i] * r[i];
  const ThrustStand stand = read_thrust_stand(table(folder, "thrust_N,torque_Nm", 6, [&](int i) {
    const auto k = static_cast<std::size_t>(i);
    return std::vector<double>{x[k], 0.5 * x[k] + r[k]};
  }));
  EXPECT_NEAR(stand.torque_ratio_m->value, 0.5, 1e-12);
  EXPECT_NEAR(stand.torque_ratio_m->deviation, std::sqrt(left / (5.0 * squares)), 1e-12);
  EXPECT_FALSE(stand.coefficient_Ns2);
  EXPECT_THAT(stand.unknown, Contains(HasSubstr("speed_radps")));
}

TEST(ThrustStand, ReadsGramsRevolutionsAndPulses) {
  const TemporaryFolder folder;
  const ThrustStand stand = read_thrust_stand(table(folder, "pulse_us,thrust_gf,speed_rpm", 8, [](int i) {
    const double rpm = 3000.0 + 1000.0 * i;
    return std::vector<double>{1100.0 + 100.0 * i, 1e-5 * rpm * rpm, rpm};
  }));
  // 1e-5 gf per (turn a minute)²
  EXPECT_NEAR(stand.coefficient_Ns2->value, 1e-5 * 9.80665e-3 * std::pow(60.0 / (2.0 * 3.14159265358979), 2), 1e-12);
  // the pulse of i is the throttle 0.1 + 0.1 i, so rpm = 2000 + 10000 u
  const double gram_force_N = 9.80665e-3;
  EXPECT_NEAR((*stand.input_thrust)[0], 40.0 * gram_force_N, 1e-6);
  EXPECT_NEAR((*stand.input_thrust)[1], 400.0 * gram_force_N, 1e-6);
  EXPECT_NEAR((*stand.input_thrust)[2], 1000.0 * gram_force_N, 1e-6);
  EXPECT_THAT(stand.unknown, Contains(HasSubstr("voltage_V")));
}

TEST(ThrustStand, SaysWhatATableCannotTell) {
  const TemporaryFolder folder;
  const ThrustStand two = read_thrust_stand(table(folder, "throttle,thrust_N,torque_Nm", 6, [](int i) {
    return std::vector<double>{i % 2 == 0 ? 0.3 : 0.6, i % 2 == 0 ? 1.0 : 3.0, i % 2 == 0 ? 0.01 : 0.03};
  }));
  EXPECT_FALSE(two.input_thrust);
  EXPECT_THAT(two.unknown, Contains(HasSubstr("fewer than three inputs")));
  const auto rows = [&](const std::string& header, int count, const std::vector<double>& row) {
    return table(folder, header, count, [&](int) { return row; });
  };
  EXPECT_THROW(read_thrust_stand(rows("thrust_N", 4, {1.0})), DataError);
  EXPECT_THROW(read_thrust_stand(rows("thrust_N", 6, {-1.0})), DataError);
  EXPECT_THROW(read_thrust_stand(rows("speed_radps", 6, {1.0})), DataError);
  EXPECT_THROW(read_thrust_stand(rows("thrust_N,throttle", 6, {1.0, 40.0})), DataError);
  EXPECT_THROW(read_thrust_stand(rows("thrust_N,throttle", 6, {1.0, 0.5})), DataError);  // one row, six times
}

std::string refused(const std::string& path) {
  try {
    read_thrust_stand(path);
  } catch (const DataError& error) {
    return error.what();
  }
  return "";
}

TEST(ThrustStand, RefusesARowWithItsPlaceAndTheValueAsWritten) {
  const TemporaryFolder folder;
  const auto negative = table(folder, "throttle,thrust_gf", 8, [](int i) {
    return std::vector<double>{0.1 * i, i == 3 ? -120.5 : 40.0 * i};
  });
  EXPECT_THAT(refused(negative), HasSubstr("stand.csv:5:"));
  EXPECT_THAT(refused(negative), HasSubstr("\"thrust_gf\" is negative (-120.5)"));
  const auto shares = table(folder, "thrust_N,pulse_us", 8, [](int i) {
    return std::vector<double>{1.0 * i, 0.125 * (i + 1)};
  });
  EXPECT_THAT(refused(shares), HasSubstr("stand.csv:2:3: throttle is from 0 to 1 and pulse_us from 1000 to 2000"));
  EXPECT_THAT(refused(shares), HasSubstr("(this \"pulse_us\" is 0.125)"));
}

TEST(ThrustStand, RefusesAMapThatFallsAndSaysWhere) {
  const TemporaryFolder folder;
  const auto stand = [&](const std::function<double(double)>& thrust_N) {
    return table(folder, "throttle,thrust_N", 11, [&](int i) {
      return std::vector<double>{0.1 * i, thrust_N(0.1 * i)};
    });
  };
  const auto falls = [](double u) { return 2.0 - 8.0 * u + 16.0 * u * u; };
  EXPECT_THAT(refused(stand(falls)), HasSubstr("it falls from 2 N at 0 to 1 N at 0.25"));
  EXPECT_THAT(refused(stand([&](double u) { return 12.0 - falls(1.0 - u); })),
              HasSubstr("it falls from 11 N at 0.75 to 10 N at 1"));
  EXPECT_THAT(refused(stand([](double u) { return 9.0 - 9.0 * u; })), HasSubstr("to thrust does not rise"));
  // a dead band at the foot
  EXPECT_EQ(refused(stand([](double u) { return u < 0.1 ? 0.0 : 8.0 * (u - 0.1) * (u - 0.1); })), "");
}

}  // namespace thrust_stand_test
}  // namespace gustlab
