// What a delay remembers, against the function that it was fed.
#include "plant/past.hpp"

#include <gtest/gtest.h>

namespace gustlab {
namespace past_test {

constexpr double step_s = 0.002, lookback_s = 0.0105;

std::array<double, 2> line(double time_s) { return {3.0 + 2.0 * time_s, -time_s}; }

// often enough around the ring
Past<2> fed(int steps) {
  Past<2> past(lookback_s, step_s);
  past.fill(line(0.0));
  for (int k = 1; k <= steps; ++k) past.push(line(k * step_s));
  return past;
}

TEST(Past, IsLinearBetweenStepsAsFarBackAsItLooks) {
  for (const int steps : {7, 50, 51, 52, 53, 54, 55, 56, 57}) {
    const Past<2> past = fed(steps);
    for (double age_s = 0.0; age_s <= lookback_s; age_s += 0.0005) {
      EXPECT_NEAR(past.before(age_s)[0], line(steps * step_s - age_s)[0], 1e-12) << steps << ' ' << age_s;
      EXPECT_NEAR(past.before(age_s)[1], line(steps * step_s - age_s)[1], 1e-12) << steps << ' ' << age_s;
    }
  }
}

TEST(Past, IsWhatItWasFilledWithAtFirst) {
  Past<1> past(lookback_s, step_s);
  past.fill({5.0});
  EXPECT_EQ(past.before(0.0)[0], 5.0);
  EXPECT_EQ(past.before(lookback_s)[0], 5.0);
  past.push({7.0});
  EXPECT_EQ(past.before(0.0)[0], 7.0);
  EXPECT_NEAR(past.before(0.5 * step_s)[0], 6.0, 1e-12);
  EXPECT_EQ(past.before(step_s)[0], 5.0);
}

TEST(Past, GivesItsOldestForWhatIsOlderAndItsNewestForTheFuture) {
  const Past<2> past = fed(50);
  EXPECT_EQ(past.before(10.0), past.before(6.0 * step_s));
  EXPECT_EQ(past.before(-1.0), past.before(0.0));
}

TEST(Past, GoesOnFromASnapshot) {
  Past<2> past = fed(23), again(lookback_s, step_s);
  std::vector<double> snapshot = {42.0};
  past.save(snapshot);
  EXPECT_EQ(again.load(snapshot.data() + 1), snapshot.data() + snapshot.size());
  for (Past<2>* p : {&past, &again}) p->push(line(1.0));
  for (double age_s = 0.0; age_s < 0.02; age_s += 0.0007) EXPECT_EQ(again.before(age_s), past.before(age_s));
}

}  // namespace past_test
}  // namespace gustlab
