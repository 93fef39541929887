// What every row of the registry of trajectories must keep.
#include <gtest/gtest.h>

#include "gustlab/trajectory.hpp"
#include "support/allocations.hpp"

// the template that scripts/new_plugin.py copies is held to it as well
#define make_my_trajectory make_template_trajectory
#include "../../examples/plugins/trajectory.cpp"

namespace gustlab::test {
namespace trajectories_contract_test {

class TrajectoryContract : public ::testing::TestWithParam<std::string_view> {
 protected:
  std::unique_ptr<Trajectory> make() const {
    const TrajectoryRow* row = find_trajectory(GetParam());
    auto trajectory = row ? row->make() : make_template_trajectory();
    trajectory->prepare();
    return trajectory;
  }
};

bool same(const Reference& a, const Reference& b) {
  return a.position_W_m == b.position_W_m && a.velocity_W_mps == b.velocity_W_mps &&
         a.acceleration_W_mps2 == b.acceleration_W_mps2 && a.jerk_W_mps3 == b.jerk_W_mps3 &&
         a.snap_W_mps4 == b.snap_W_mps4 && a.yaw_rad == b.yaw_rad && a.yaw_rate_radps == b.yaw_rate_radps;
}

TEST_P(TrajectoryContract, IsFiniteAtEveryTime) {
  const auto trajectory = make();
  for (double t = 0.0; t < 100.0; t += 0.37) {
    const Reference r = trajectory->at(t);
    for (const Vector3& v : {r.position_W_m, r.velocity_W_mps, r.acceleration_W_mps2, r.jerk_W_mps3, r.snap_W_mps4})
      ASSERT_TRUE(v.allFinite()) << t;
    ASSERT_TRUE(std::isfinite(r.yaw_rad) && std::isfinite(r.yaw_rate_radps)) << t;
  }
  EXPECT_TRUE(trajectory->start_position_W_m().allFinite());
  EXPECT_GE(trajectory->duration_s(), 0.0);
}

TEST_P(TrajectoryContract, IsAFunctionOfTimeAlone) {
  const auto one = make(), two = make();
  for (const double t : {7.0, 0.5, 3.0}) one->at(t);
  for (const double t : {0.5, 3.0, 7.0}) EXPECT_TRUE(same(one->at(t), two->at(t)));
}

TEST_P(TrajectoryContract, StaysWithinReachWithItsDefaults) {
  // slow and low enough for every vehicle under models/
  const auto trajectory = make();
  for (double t = 0.0; t < 24.0; t += 0.05) {
    EXPECT_LT(trajectory->at(t).velocity_W_mps.norm(), 2.0);
    EXPECT_LT(trajectory->at(t).acceleration_W_mps2.norm(), 4.0);
    EXPECT_GT(trajectory->at(t).position_W_m.z(), 0.5);
  }
}

TEST_P(TrajectoryContract, AllocatesNothingInFlight) {
  const auto trajectory = make();
  const std::size_t before = allocations();
  for (double t = 0.0; t < 24.0; t += 0.1) trajectory->at(t);
  EXPECT_EQ(allocations(), before);
}

std::vector<std::string_view> names() {
  std::vector<std::string_view> out{"template"};
  for (const TrajectoryRow& row : trajectory_registry()) out.push_back(row.name);
  return out;
}

INSTANTIATE_TEST_SUITE_P(Registry, TrajectoryContract, ::testing::ValuesIn(names()),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace trajectories_contract_test
}  // namespace gustlab::test
