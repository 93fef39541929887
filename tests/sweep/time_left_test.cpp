// How long a sweep still takes, told after a tenth of it, by a clock that the test turns.
#include "util/time_left.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "gustlab/random.hpp"
#include "simulation/plan.hpp"
#include "support/experiments.hpp"

namespace gustlab {
namespace time_left_test {

// 3 trajectories of unlike length, each with 4 controllers whose steps cost what those of table2_crazyflie do
class SweepOfUnlikeRuns {
 public:
  explicit SweepOfUnlikeRuns(int replicates)
      : plan_(test::read_text_experiment(test::small_experiment,
                                         {"trajectories=[\"circle\", \"hover\", \"spiral\"]",
                                          "controllers=[\"pid\", \"geometric\", \"indi\", \"asindy\"]",
                                          "replicates=" + std::to_string(replicates)})) {}

  // seconds of a run; some crash early
  double cost(std::size_t index) const {
    const RunSpec run = plan_[index];
    const auto u = stream_.uniform4(index);
    const double whole_s =
        std::vector{10.0, 17.4, 30.0}[run.trajectory] * std::vector{1.24, 1.28, 1.52, 1.84}[run.controller];
    return whole_s * (u[0] < 0.05 ? u[1] : 0.95 + 0.1 * u[1]);
  }

  // What is told after a tenth of what is to do, over what it then takes. The runs before `first` were flown by an earlier program.
  double told_over_true(std::size_t jobs, std::size_t first = 0) const {
    const auto share = [&](std::size_t done) { return static_cast<double>(done) / static_cast<double>(plan_.size()); };
    const std::size_t here = plan_.size() - first;
    const TimeLeft left(share(first));
    std::vector<double> ends;  // of the runs in hand
    std::size_t next = first;
    double now_s = 0.0, told_s = 0.0, told_at_s = 0.0;
    for (std::size_t done = first; done < plan_.size();) {
      while (ends.size() < jobs && next < plan_.size()) ends.push_back(now_s + cost(plan_.in_turn(next++)));
      const auto end = std::min_element(ends.begin(), ends.end());
      now_s = *end;
      ends.erase(end);
      if (++done == first + here / 10) told_at_s = now_s, told_s = left.seconds(share(done), now_s).value();
    }
    return told_s / (now_s - told_at_s);
  }
  std::size_t size() const { return plan_.size(); }

 private:
  Plan plan_;
  RandomStream stream_{1, 0, "time_left_test"};
};

TEST(TimeLeft, IsWithinATenthAfterATenthOfASweep) {
  for (const int replicates : {20, 100, 1000})
    for (const std::size_t jobs : {1u, 2u, 8u})
      EXPECT_NEAR(SweepOfUnlikeRuns(replicates).told_over_true(jobs), 1.0, 0.1) << replicates << ' ' << jobs;
}

TEST(TimeLeft, CountsOnlyWhatThisProgramDid) {
  const SweepOfUnlikeRuns sweep(100);
  EXPECT_NEAR(sweep.told_over_true(1, sweep.size() / 2), 1.0, 0.1);
}

TEST(TimeLeft, SaysNothingWhereNothingTells) {
  EXPECT_FALSE(TimeLeft(0.0).seconds(0.0, 5.0));
  EXPECT_FALSE(TimeLeft(0.5).seconds(0.5, 5.0));
  EXPECT_FALSE(TimeLeft(0.0).seconds(1.0, 5.0));
}

}  // namespace time_left_test
}  // namespace gustlab
