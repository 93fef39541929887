// Effects that are a history of each flight: their scans on flights that have them.
#include "diagnosis/selection/suspect_histories.hpp"

#include <gtest/gtest.h>

#include "diagnosis/result/decisions.hpp"
#include "diagnosis/selection/limit_scan.hpp"
#include "support/sessions.hpp"

namespace gustlab::diagnosis {
namespace {

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

}  // namespace
}  // namespace gustlab::diagnosis
