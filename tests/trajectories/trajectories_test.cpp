// Every trajectory: its derivatives are those of its position, and it starts where it says.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "gustlab/errors.hpp"
#include "support/parameters.hpp"
#include "support/temporary_folder.hpp"
#include "trajectories/jet.hpp"
#include "trajectories/trajectories.hpp"

namespace gustlab {
namespace trajectories_test {

using test::set;
using test::set_number;
using test::set_text;

// derivative of one field by central differences of fourth order
Vector3 difference(const Trajectory& trajectory, Vector3 Reference::*field, double t, double h) {
  const auto value = [&](double time) { return Vector3(trajectory.at(time).*field); };
  return (8.0 * (value(t + h) - value(t - h)) - (value(t + 2 * h) - value(t - 2 * h))) / (12.0 * h);
}

void expect_derivatives(const Trajectory& trajectory, const std::vector<double>& times_s, const std::string& name) {
  const double h = 1e-3;
  Vector3 Reference::*fields[] = {&Reference::position_W_m, &Reference::velocity_W_mps, &Reference::acceleration_W_mps2,
                                  &Reference::jerk_W_mps3, &Reference::snap_W_mps4};
  for (const double t : times_s)
    for (int k = 0; k < 4; ++k) {
      const Vector3 given = trajectory.at(t).*fields[k + 1];
      const Vector3 measured = difference(trajectory, fields[k], t, h);
      EXPECT_LT((given - measured).norm(), 1e-7 * (1.0 + given.norm()))
          << name << " derivative " << k + 1 << " at " << t;
    }
  for (const double t : times_s) {
    const double yaw_rate = (trajectory.at(t + h).yaw_rad - trajectory.at(t - h).yaw_rad) / (2 * h);
    EXPECT_NEAR(trajectory.at(t).yaw_rate_radps, yaw_rate, 1e-5) << name << " yaw rate at " << t;
  }
}

const std::vector<double> some_times_s{0.3, 1.7, 4.0, 7.9, 11.3, 20.1};

TEST(Jet, KnowsTheDerivativesOfAFormula) {
  // f = sin(3t) / (2 + cos t) at t = 0.4, derivatives by complex-step-free closed forms of the factors
  const Jet t = Jet::time(0.4);
  const Jet f = sine_cosine(3.0 * t).sine / (2.0 + sine_cosine(t).cosine);
  const auto exact = [](double x) { return std::sin(3.0 * x) / (2.0 + std::cos(x)); };
  const double h = 1e-2;
  EXPECT_NEAR(f.derivative(0), exact(0.4), 1e-15);
  EXPECT_NEAR(f.derivative(1), (exact(0.4 + h) - exact(0.4 - h)) / (2 * h), 2e-3);
  // f (2 + cos t) = sin 3t holds for every derivative
  const Jet back = f * (2.0 + sine_cosine(t).cosine);
  for (int k = 0; k <= 4; ++k) EXPECT_NEAR(back.derivative(k), sine_cosine(3.0 * t).sine.derivative(k), 1e-12);
  EXPECT_NEAR(sine_cosine(3.0 * t).sine.derivative(4), 81.0 * std::sin(1.2), 1e-12);
}

TEST(Trajectories, DerivativesAreThoseOfThePosition) {
  for (const TrajectoryRow& row : trajectory_registry()) {
    const std::unique_ptr<Trajectory> trajectory = row.make();
    trajectory->prepare();
    // waypoints end after 10 s, where they are at rest
    std::vector<double> times_s = some_times_s;
    if (row.name == "waypoints") times_s = {0.3, 1.1, 3.3, 5.7, 8.0};
    expect_derivatives(*trajectory, times_s, std::string(row.name));
  }
}

TEST(Trajectories, DerivativesHoldWithEveryOption) {
  const auto with = [](std::unique_ptr<Trajectory> trajectory, auto change, const std::string& name) {
    change(*trajectory);
    trajectory->prepare();
    expect_derivatives(*trajectory, some_times_s, name);
  };
  with(
      make_circle(), [](Trajectory& t) { set_number(t, "ramp_s", 5.0); }, "ramped circle");
  with(
      make_lemniscate(),
      [](Trajectory& t) {
        set_text(t, "shape", "bernoulli");
        set_number(t, "ramp_s", 3.0);
      },
      "bernoulli");
  with(
      make_spiral(),
      [](Trajectory& t) {
        set_number(t, "ramp_s", 4.5);
        set_number(t, "climb_m", 1.0);
      },
      "spiral");
  with(
      make_multisine(), [](Trajectory& t) { set_number(t, "yaw_amplitude_rad", 0.5); }, "multisine with yaw");
}

TEST(Trajectories, ARampStartsAtRestAndEndsAtFullSpeed) {
  const std::unique_ptr<Trajectory> circle = make_circle();
  set_number(*circle, "ramp_s", 4.0);
  circle->prepare();
  EXPECT_EQ(circle->at(0.0).velocity_W_mps.norm(), 0.0);
  EXPECT_EQ(circle->at(0.0).acceleration_W_mps2.norm(), 0.0);
  EXPECT_NEAR(circle->at(4.0).velocity_W_mps.norm(), 2.0 * pi * 1.1 / 24.0, 1e-12);
  // no jump at the end of the ramp
  EXPECT_LT((circle->at(4.0 - 1e-9).snap_W_mps4 - circle->at(4.0).snap_W_mps4).norm(), 1e-6);
}

TEST(Circle, StartsOneRadiusAway) {
  const std::unique_ptr<Trajectory> circle = make_circle();
  circle->prepare();
  EXPECT_NEAR((circle->start_position_W_m() - circle->at(0.0).position_W_m).norm(), 1.1, 1e-15);
  set_text(*circle, "start", "reference");
  circle->prepare();
  EXPECT_EQ(circle->start_position_W_m(), circle->at(0.0).position_W_m);
}

TEST(Circle, ClosesAfterALap) {
  const std::unique_ptr<Trajectory> circle = make_circle();
  circle->prepare();
  EXPECT_LT((circle->at(24.0).position_W_m - circle->at(0.0).position_W_m).norm(), 1e-12);
  EXPECT_NEAR(circle->at(3.1).velocity_W_mps.norm() * circle->at(3.1).velocity_W_mps.norm() / 1.1,
              circle->at(3.1).acceleration_W_mps2.norm(), 1e-12);
}

TEST(LemniscateAndSpiral, StartAtTheirCentre) {
  for (const auto& make : {make_lemniscate, make_spiral}) {
    const std::unique_ptr<Trajectory> trajectory = make();
    trajectory->prepare();
    EXPECT_EQ(trajectory->start_position_W_m(), Vector3(0.0, 0.0, 1.0));
  }
}

TEST(Spiral, ReachesItsRadiusAtItsEnd) {
  const std::unique_ptr<Trajectory> spiral = make_spiral();
  set_number(*spiral, "ramp_s", 2.0);
  spiral->prepare();
  EXPECT_NEAR(spiral->at(spiral->duration_s()).position_W_m.head<2>().norm(), 0.6, 1e-12);
}

TEST(Waypoints, PassEveryPointAndRestAtTheEnds) {
  const std::unique_ptr<Trajectory> waypoints = make_waypoints();
  set(*waypoints, "points_m", std::vector<double>{0, 0, 1, 2, 1, 1, 3, -1, 2, 0, 0, 1});
  set(*waypoints, "times_s", std::vector<double>{0, 2, 5, 9});
  waypoints->prepare();
  EXPECT_LT((waypoints->at(0).position_W_m - Vector3(0, 0, 1)).norm(), 1e-9);
  EXPECT_LT((waypoints->at(2).position_W_m - Vector3(2, 1, 1)).norm(), 1e-9);
  EXPECT_LT((waypoints->at(5).position_W_m - Vector3(3, -1, 2)).norm(), 1e-9);
  EXPECT_LT((waypoints->at(9).position_W_m - Vector3(0, 0, 1)).norm(), 1e-9);
  for (const double t : {0.0, 9.0}) {
    EXPECT_LT(waypoints->at(t).velocity_W_mps.norm(), 1e-9);
    EXPECT_LT(waypoints->at(t).acceleration_W_mps2.norm(), 1e-9);
    EXPECT_LT(waypoints->at(t).jerk_W_mps3.norm(), 1e-8);
  }
  // snap is continuous at inner points, and the vehicle stays where it arrived
  EXPECT_LT((waypoints->at(2 - 1e-9).snap_W_mps4 - waypoints->at(2 + 1e-9).snap_W_mps4).norm(), 1e-5);
  EXPECT_LT((waypoints->at(20).position_W_m - Vector3(0, 0, 1)).norm(), 1e-9);
  EXPECT_EQ(waypoints->at(20).velocity_W_mps.norm(), 0.0);
}

TEST(Waypoints, HaveLessSnapThanANearbyCurve) {
  // adding any polynomial that keeps points and ends at rest can only raise the cost
  const std::unique_ptr<Trajectory> waypoints = make_waypoints();
  set(*waypoints, "points_m", std::vector<double>{0, 0, 1, 1, 0, 1, 0, 0, 1});
  set(*waypoints, "times_s", std::vector<double>{0, 2, 4});
  waypoints->prepare();
  const auto bump = [](double t) {  // t⁴ (2−t)⁴ (4−t)⁴, zero with three derivatives at all three points
    const Jet x = Jet::time(t), u = x * (2.0 - x) * (4.0 - x);
    return (u * u) * (u * u);
  };
  double cost = 0.0, other = 0.0;
  for (double t = 0.0005; t < 4.0; t += 0.001) {
    const double snap = waypoints->at(t).snap_W_mps4.x(), more = bump(t).derivative(4);
    cost += snap * snap;
    other += (snap + 1e-3 * more) * (snap + 1e-3 * more);
  }
  EXPECT_LT(cost, other);
}

// GIVEN the samples of a circle WHEN they are flown as a recording THEN the circle comes back, and rests at its ends
TEST(Recorded, GivesBackWhatWasRecorded) {
  const std::unique_ptr<Trajectory> circle = make_circle();
  circle->prepare();
  TemporaryFolder folder;
  for (const bool derivatives : {true, false}) {
    std::string text = "time_s,rpx,rpy,rpz,ryaw";
    text += derivatives ? ",rvx,rvy,rvz,rax,ray,raz\n" : "\n";
    for (int i = 0; i <= 200; ++i) {
      const Reference r = circle->at(0.05 * i);
      text += fmt::format("{},{},{},{},{}", 7.0 + 0.05 * i, r.position_W_m.x(), r.position_W_m.y(), r.position_W_m.z(),
                          0.0);
      if (derivatives)
        for (const Vector3& v : {r.velocity_W_mps, r.acceleration_W_mps2})
          text += fmt::format(",{},{},{}", v.x(), v.y(), v.z());
      text += '\n';
    }
    const std::string path = folder.write("log.csv", text);
    const std::unique_ptr<Trajectory> recorded = make_recorded();
    set(*recorded, "file", InputFile{path, text});
    recorded->prepare();
    EXPECT_NEAR(recorded->duration_s(), 10.0, 1e-9);
    for (const double t : {0.5, 1.234, 4.321, 8.765}) {
      EXPECT_LT((recorded->at(t).position_W_m - circle->at(t).position_W_m).norm(), derivatives ? 1e-9 : 1e-6);
      EXPECT_LT((recorded->at(t).velocity_W_mps - circle->at(t).velocity_W_mps).norm(), derivatives ? 1e-7 : 1e-4);
      EXPECT_LT((recorded->at(t).acceleration_W_mps2 - circle->at(t).acceleration_W_mps2).norm(),
                derivatives ? 1e-5 : 5e-3);
    }
    EXPECT_LT((recorded->at(99.0).position_W_m - circle->at(10.0).position_W_m).norm(), 1e-9);
    EXPECT_EQ(recorded->at(99.0).velocity_W_mps.norm(), 0.0);
    expect_derivatives(*recorded, {0.43, 2.01, 7.77}, "recorded");
  }
}

TEST(Recorded, SaysWhatIsMissing) {
  TemporaryFolder folder;
  const auto message = [&](const std::string& text) -> std::string {
    const std::unique_ptr<Trajectory> recorded = make_recorded();
    set(*recorded, "file", InputFile{folder.write("log.csv", text), text});
    try {
      recorded->prepare();
    } catch (const DataError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(message("time_s,px\n0,1\n"), testing::HasSubstr("column rpx is missing"));
  EXPECT_THAT(message("time_s,rpx,rpy,rpz\n0,1,1,1\n"), testing::HasSubstr("fewer than two"));
  EXPECT_THAT(message("time_s,rpx,rpy,rpz\n0,1,1,1\n1,1,1,1\n1,1,1,1\n"),
              testing::HasSubstr("log.csv:4:1: time does not rise"));
}

TEST(Trajectories, ContradictionsAreSaid) {
  const auto message = [](std::unique_ptr<Trajectory> trajectory, auto change) -> std::string {
    change(*trajectory);
    try {
      trajectory->prepare();
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(message(make_circle(), [](Trajectory& t) { set_text(t, "start", "middle"); }),
              testing::HasSubstr("middle"));
  EXPECT_THAT(message(make_lemniscate(), [](Trajectory& t) { set_text(t, "shape", "8"); }),
              testing::HasSubstr("gerono"));
  EXPECT_THAT(message(make_waypoints(),
                      [](Trajectory& t) {
                        set(t, "points_m", std::vector<double>{1, 2});
                      }),
              testing::HasSubstr("three numbers"));
  EXPECT_THAT(message(make_waypoints(),
                      [](Trajectory& t) {
                        set(t, "times_s", std::vector<double>{0, 2, 1, 3, 4});
                      }),
              testing::HasSubstr("rise"));
  EXPECT_THAT(message(make_multisine(), [](Trajectory& t) { set(t, "frequencies_x_hz", std::vector<double>{-1.0}); }),
              testing::HasSubstr("0 and 50 Hz"));
}

}  // namespace trajectories_test
}  // namespace gustlab
