// What a candidate does beside what is known, and what the whole model leaves.
#include "diagnosis/estimation/signature.hpp"

#include <gtest/gtest.h>

namespace gustlab::diagnosis {
namespace signature_test {

TEST(SignatureSeries, IsOrthogonalToWhatIsKnownAndLeavesWhatTheModelDoesNotSay) {
  Eigen::MatrixXd first(3, 3), second(2, 3);  // known, own, z
  first << 1, 1, 5, 2, 1, 7, 3, 1, 9;
  second << 1, 0, 2, 1, 4, 14;
  const auto series =
      signature_series({{first}, {second}}, column_products({{first}, {second}}), {0}, {1}, Eigen::Vector2d(2.0, 3.0));
  ASSERT_EQ(series.size(), 2u);
  double common = 0.0;
  for (std::size_t f = 0; f < 2; ++f) {
    const Eigen::MatrixXd& rows = f == 0 ? first : second;
    common += rows.col(0).dot(series[f][0].by.col(0));
    EXPECT_LT(series[f][0].left.norm(), 1e-12);
  }
  EXPECT_NEAR(common, 0.0, 1e-8);
  EXPECT_GT(series[1][0].by.norm(), 1.0);
}

}  // namespace signature_test
}  // namespace gustlab::diagnosis
