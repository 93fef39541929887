// Effects that are a history of each flight: their scans on flights that have them.
#include "diagnosis/selection/suspect_histories.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "diagnosis/result/decisions.hpp"
#include "diagnosis/selection/limit_scan.hpp"
#include "support/sessions.hpp"

namespace gustlab::diagnosis {
namespace suspect_histories_test {

using test::Unexplained;

TEST(LimitScanOfFlights, FindsTheLimitAndGainsWhatItExplains) {
  const Unexplained limited(R"({type = "saturation", max_speed = 2120})");
  const LimitScan found = scan_limit(limited.session, limited.session.biases());
  EXPECT_NEAR(found.limit_radps, 2120.0, 30.0);
  EXPECT_GT(found.delta_chi2, decisions::least_limit_delta_chi2);
}

// The scan's gain is what the limit's own column gains in the Gram matrices, the other coefficients as they were.
TEST(LimitScanOfFlights, GainsWhatItsColumnGainsInTheGramMatrices) {
  Unexplained limited(R"({type = "saturation", max_speed = 2120})");
  Session& session = limited.session;
  const LimitScan found = scan_limit(session, session.biases());
  session.suspect_limit(found.limit_radps);
  session.linearise(session.value(), session.all_columns());
  const int column = limited.group(ColumnFrom::speed_limit).columns.front();
  const Eigen::MatrixXd total = session.grams().total();
  Eigen::VectorXd left = Eigen::VectorXd::Unit(total.cols(), total.cols() - 1);
  left(session.biases()) = -solve(total, session.biases()).coefficient;
  const double seen = total.col(column).dot(left);
  EXPECT_NEAR(found.delta_chi2, seen * seen / total(column, column), 1e-6 * found.delta_chi2);
}

// measured speeds drive the body, which then says nothing of a limit: they say it themselves
struct LimitOfMeasuredSpeeds : ::testing::Test {
  Unexplained limited{R"({type = "saturation", max_speed = 2120})", {"pose", "gyroscope", "rotor_speed"}, 0.0};
  Session& session = limited.session;
};

TEST_F(LimitOfMeasuredSpeeds, IsSuspectedWhereItIs) {
  suspect_histories(session, session.value(), {});
  EXPECT_NEAR(limited.group(ColumnFrom::speed_limit).limit_radps, 2120.0, 30.0);
  for (const FlightData& flight : session.flights()) {
    EXPECT_EQ(flight.limit_speed_change.size(), flight.samples.size());
    EXPECT_TRUE(flight.limit_change.empty());
  }
}

TEST_F(LimitOfMeasuredSpeeds, GainsWhatItsColumnGainsInTheGramMatrices) {
  const LimitScan found = scan_limit(session, session.biases());
  session.suspect_limit(found.limit_radps);
  session.linearise(session.value(), session.all_columns());
  const int column = limited.group(ColumnFrom::speed_limit).columns.front();
  EXPECT_TRUE(session.seen_in_speeds(session.catalogue().find(ColumnFrom::speed_limit)));
  const Eigen::MatrixXd total = session.grams().total();
  const double seen = total(column, total.cols() - 1);
  EXPECT_NEAR(found.delta_chi2, seen * seen / total(column, column), 1e-6 * found.delta_chi2);
  // with the limit in its place nothing of it is left
  Eigen::VectorXd value = session.value();
  value[column] = 1.0;
  session.predict_at(value);
  const Eigen::MatrixXd rest = session.grams().total();
  EXPECT_LT(std::abs(rest(column, rest.cols() - 1)), 0.1 * std::abs(seen));
}

TEST(SuspectHistories, ALowerLimitIsSuspectedWhereItIs) {
  Unexplained limited(R"({type = "saturation", max_speed = 2120})");
  suspect_histories(limited.session, limited.session.value(), {});
  EXPECT_NEAR(limited.group(ColumnFrom::speed_limit).limit_radps, 2120.0, 30.0);
  for (const FlightData& flight : limited.session.flights())
    EXPECT_EQ(flight.limit_change.size(), flight.samples.size());
}

TEST(SuspectHistories, ASwingingLoadIsSuspectedWithItsLength) {
  Unexplained loaded(R"({type = "slung_load", mass = 0.004, length = 0.3})");
  suspect_histories(loaded.session, loaded.session.value(), {});
  EXPECT_NEAR(loaded.group(ColumnFrom::swing).swing.length_m, 0.3, 0.03);
  for (const FlightData& flight : loaded.session.flights())
    EXPECT_EQ(flight.load_force_W_mps2.size(), flight.samples.size());
}

}  // namespace suspect_histories_test
}  // namespace gustlab::diagnosis
