#include "metrics/tracking_error.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace gustlab {
namespace tracking_error_test {

TEST(TrackingError, ConstantOffsetGivesTheSameFourFigures) {
  TrackingError error(0.0, 10);
  for (int i = 0; i < 10; ++i) error.add(0.1 * i, Vector3(3.0, 4.0, 12.0), Vector3::Zero());
  const TrackingFigures figures = error.figures();
  EXPECT_EQ(figures.samples, 10u);
  for (const double value : {figures.planar.rmse_m, figures.planar.mae_m, figures.planar.p95_m, figures.planar.max_m})
    EXPECT_DOUBLE_EQ(value, 5.0);
  for (const double value :
       {figures.spatial.rmse_m, figures.spatial.mae_m, figures.spatial.p95_m, figures.spatial.max_m})
    EXPECT_DOUBLE_EQ(value, 13.0);
  EXPECT_DOUBLE_EQ(figures.rmse_z_m, 12.0);
}

// numpy 2: e = arange(1, 9); sqrt(mean(e**2)), mean(e), percentile(e, 95), max(e)
TEST(TrackingError, AgreesWithNumpy) {
  TrackingError error(0.0, 8);
  for (int i = 1; i <= 8; ++i) error.add(i, Vector3(0.0, -i, 1.0), Vector3(0.0, 0.0, 1.0));
  const TrackingFigures figures = error.figures();
  EXPECT_DOUBLE_EQ(figures.planar.rmse_m, std::sqrt(25.5));
  EXPECT_DOUBLE_EQ(figures.planar.mae_m, 4.5);
  EXPECT_DOUBLE_EQ(figures.planar.p95_m, 7.65);
  EXPECT_DOUBLE_EQ(figures.planar.max_m, 8.0);
  EXPECT_DOUBLE_EQ(figures.rmse_z_m, 0.0);
}

TEST(TrackingError, SettleWindowStartsAtItsOwnSampleInSpiteOfRounding) {
  TrackingError error(3.0, 10000);
  for (int i = 0; i < 2000; ++i) error.add(i * 0.002, Vector3(i < 1500 ? 100.0 : 1.0, 0.0, 0.0), Vector3::Zero());
  EXPECT_EQ(error.figures().samples, 500u);
  EXPECT_DOUBLE_EQ(error.figures().planar.max_m, 1.0);
}

TEST(TrackingError, NoSampleIsNotANumber) {
  const TrackingFigures figures = TrackingError(0.0, 0).figures();
  EXPECT_EQ(figures.samples, 0u);
  EXPECT_TRUE(std::isnan(figures.planar.rmse_m));
  EXPECT_TRUE(std::isnan(figures.spatial.p95_m));
  EXPECT_TRUE(std::isnan(figures.rmse_z_m));
}

}  // namespace tracking_error_test
}  // namespace gustlab
