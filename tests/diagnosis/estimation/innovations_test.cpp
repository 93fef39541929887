// Correlation of innovations against the sums that it stands for.
#include "diagnosis/estimation/innovations.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "gustlab/random.hpp"

namespace gustlab::diagnosis {
namespace innovations_test {

// innovations of one channel among those of another, a first column that is not y, and cold rows that must not count
struct Written {
  Whitened whitened;
  void add(int channel, double y, bool warm) {
    auto& rows = whitened.rows;
    rows.conservativeResize(rows.rows() + 1, 2);
    rows.bottomRows<1>() << 1e6, y;
    whitened.channel.push_back(channel);
    whitened.warm.push_back(warm);
    whitened.time_s.push_back(0.01 * static_cast<double>(whitened.time_s.size()));
  }
};

std::vector<double> series(std::size_t size, double memory, double mean, const char* stream) {
  const RandomStream random(2, 0, stream);
  std::vector<double> out;
  double value = 0.0;
  for (std::uint64_t k = 0; k < size; ++k) {
    value = memory * value + random.normal4(k)[0];
    out.push_back(mean + value);
  }
  return out;
}

struct Sums {
  double square = 0.0, lagged = 0.0;
};
Sums sums(const std::vector<double>& z, std::size_t lag) {
  double mean = 0.0;
  for (const double x : z) mean += x / static_cast<double>(z.size());
  Sums out;
  for (std::size_t i = 0; i < z.size(); ++i) {
    out.square += (z[i] - mean) * (z[i] - mean);
    if (i >= lag) out.lagged += (z[i] - mean) * (z[i - lag] - mean);
  }
  return out;
}

TEST(LagCorrelation, IsThatOfEachFlightAboutItsOwnMean) {
  const std::vector<double> a = series(150, 0.6, 3.0, "a"), b = series(300, 0.6, -2.0, "b"),
                            c = series(300, 0.0, 0.0, "c");
  Written one, two;
  for (int i = 0; i < 40; ++i) one.add(4, 1e5, false);
  for (const double z : a) one.add(4, z, true);
  for (std::size_t i = 0; i < b.size(); ++i) two.add(4, b[i], true), two.add(7, c[i], true);
  const auto found = lag_correlation({one.whitened, two.whitened}, 3);
  ASSERT_EQ(found.size(), 3u);
  for (std::size_t lag = 1; lag <= 3; ++lag) {
    const Sums first = sums(a, lag), second = sums(b, lag), other = sums(c, lag);
    EXPECT_NEAR(found[lag - 1][4], (first.lagged + second.lagged) / (first.square + second.square), 1e-12);
    EXPECT_NEAR(found[lag - 1][7], other.lagged / other.square, 1e-12);
  }
  EXPECT_NEAR(found[0][4], 0.6, 0.15);
}

TEST(LagCorrelation, IsUnknownOfFewInnovations) {
  Written few;
  for (const double z : series(99, 0.5, 0.0, "a")) few.add(2, z, true);
  for (const double z : series(200, 0.5, 0.0, "a")) few.add(3, z, false);
  const auto found = lag_correlation({few.whitened}, 1);
  for (const double r : found.front()) EXPECT_TRUE(std::isnan(r));
  few.add(2, 0.0, true);
  EXPECT_TRUE(std::isfinite(lag_correlation({few.whitened}, 1).front()[2]));
}

}  // namespace innovations_test
}  // namespace gustlab::diagnosis
