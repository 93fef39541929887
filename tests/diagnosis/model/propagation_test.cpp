// Motion between samples against closed forms: free fall, a spinning top, rotors that lag.
#include "diagnosis/model/propagation.hpp"

#include <gtest/gtest.h>

#include "support/flight_data.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace propagation_test {

constexpr double lag_s = 0.03;

VehicleModel vehicle() { return test::ring(4, 1.5, 0.25, lag_s); }

TEST(Rotation, LogOfExpIsTwiceTheSineOfHalfTheTurn) {
  const Quaternion a(Eigen::AngleAxisd(1.2, Vector3(1.0, -2.0, 0.5).normalized()));
  EXPECT_TRUE(exp_rotation(Vector3::Zero()).isApprox(Quaternion::Identity()));
  for (const double angle : {1e-9, 1e-3, 0.4, 3.0}) {
    const Vector3 axis = Vector3(0.3, 0.2, -1.0).normalized();
    const Quaternion b = a * exp_rotation(angle * axis);
    EXPECT_LT((log_rotation(a, b) - 2.0 * std::sin(0.5 * angle) * axis).norm(), 1e-12);
    // a quaternion and its negative are one attitude
    EXPECT_LT((log_rotation(a, Quaternion(-b.coeffs())) - log_rotation(a, b)).norm(), 1e-12);
  }
}

TEST(Point, MinusTakesBackWhatPlusAdds) {
  Point point;
  point.position = {1.0, -2.0, 3.0};
  point.velocity = {0.5, 0.1, -0.2};
  point.attitude = exp_rotation({0.3, -0.5, 1.0});
  point.rate = {1.0, 2.0, -1.0};
  EXPECT_EQ(point.minus(point).norm(), 0.0);
  for (int i = 0; i < error_size; ++i)
    EXPECT_LT((point.plus(i, 1e-4).minus(point) - 1e-4 * Vector12::Unit(i)).norm(), 1e-12) << i;
}

// its velocity is the derivative of its position
TEST(Point, CentreOfMassTurnsWithTheBody) {
  const Vector3 arm(0.1, -0.2, 0.05);
  const auto motion = [](double t) {
    Motion m;
    m.position_W_m = Vector3(1.0, 2.0, 3.0) + t * Vector3(0.3, -0.1, 0.2);
    m.velocity_W_mps = {0.3, -0.1, 0.2};
    m.body_rate_B_radps = {1.0, -2.0, 0.5};
    m.attitude_WB = exp_rotation({0.4, 0.1, -0.3}) * exp_rotation(t * m.body_rate_B_radps);
    return m;
  };
  constexpr double h = 1e-5;
  const Vector3 slope =
      (center_of_mass(motion(h), arm).position - center_of_mass(motion(-h), arm).position) / (2.0 * h);
  EXPECT_LT((center_of_mass(motion(0.0), arm).velocity - slope).norm(), 1e-8);
}

// rotors at rest, inertias alike about x and y
Point spun(double duration_s, int substeps, const Vector3& trim = Vector3::Zero()) {
  VehicleModel top = vehicle();
  top.effects.clear();
  ForceModel forces(top, {});
  forces.prepare(0.0025, 0, 0);
  Evaluator evaluate{forces, {}, {}, trim};
  const std::vector<RotorArray> still(static_cast<std::size_t>(substeps), RotorArray{});
  Point start;
  start.position = {1.0, 2.0, 30.0};
  start.velocity = {3.0, -1.0, 2.0};
  start.attitude = Quaternion::Identity();
  start.rate = {1.0, 0.0, 6.0};
  return propagate(evaluate, start, 0.0, duration_s, 0.0, substeps, still.data(), still.data());
}

TEST(Propagate, FallsFreelyWithoutError) {
  const Point end = spun(0.5, 7);
  EXPECT_LT((end.position - Vector3(2.5, 1.5, 31.0 - 0.5 * 9.81 * 0.25)).norm(), 1e-12);
  EXPECT_LT((end.velocity - Vector3(3.0, -1.0, 2.0 - 9.81 * 0.5)).norm(), 1e-12);
}

// Euler's equations of a symmetric top: the rate about x and y turns at (I_z - I_x)/I_x times that about z
TEST(Propagate, TurnsAsATopWithAnErrorOfSecondOrder) {
  constexpr double duration_s = 0.2;
  const double angle = (1.8 - 1.0) / 1.0 * 6.0 * duration_s;
  const Vector3 rate(std::cos(angle), std::sin(angle), 6.0);
  const VehicleModel top = vehicle();
  const Vector3 momentum = top.inertia_B_kgm2 * Vector3(1.0, 0.0, 6.0);
  double last_rate = 0.0, last_momentum = 0.0;
  for (const int substeps : {20, 40, 80}) {
    const Point end = spun(duration_s, substeps);
    const double in_rate = (end.rate - rate).norm(),
                 in_momentum = (end.attitude * Vector3(top.inertia_B_kgm2 * end.rate) - momentum).norm();
    if (substeps > 20) {
      EXPECT_NEAR(last_rate / in_rate, 4.0, 0.3);
      EXPECT_NEAR(last_momentum / in_momentum, 4.0, 0.5);
    }
    last_rate = in_rate, last_momentum = in_momentum;
  }
  EXPECT_LT(last_rate, 1e-4);
}

TEST(Propagate, TurnsFasterByATrim) {
  EXPECT_NEAR(spun(0.2, 10, {0.0, 0.0, 2.5}).rate.z() - spun(0.2, 10).rate.z(), 0.5, 1e-9);
}

TEST(MeanOf, IsOverSubsteps) {
  const std::vector<RotorArray> values = {test::all_at(1.0), test::all_at(4.0), test::all_at(4.0)};
  EXPECT_NEAR(mean_of(values.data(), 3)[2], 3.0, 1e-12);
}

FlightData stepped(double from_radps, double to_radps) {
  return test::flight_of(
      vehicle(), 0.3, 0.01, [](double) { return Motion{}; },
      [=](double t) { return test::all_at(t < 0.0995 ? from_radps : to_radps); });
}

ForceModel forces_of(const FlightData& flight) {
  const Catalogue catalogue(flight.vehicle, 1, {.observable = Need::attitude | Need::motion | Need::torque});
  return force_model(flight, catalogue, catalogue.nominal(), 0, -1);
}

TEST(RotorHistory, OfCommandsLagsAsAFirstOrderRotor) {
  const FlightData flight = stepped(400.0, 600.0);
  const RotorHistory history = commanded_history(flight, forces_of(flight));
  const auto speed = [](double t) { return t < 0.1 ? 400.0 : 600.0 - 200.0 * std::exp(-(t - 0.1) / lag_s); };
  ASSERT_EQ(history.at_sample.size(), flight.samples.size());
  const auto count = static_cast<std::size_t>(history.substeps);
  const double h = flight.sample_s / history.substeps;
  for (std::size_t k = 0; k + 1 < flight.samples.size(); ++k) {
    const double t = flight.samples[k].time_s;
    EXPECT_NEAR(history.at_sample[k][1], speed(t), 1e-6) << k;
    for (std::size_t s = 0; s < count; ++s) {
      const double from = t + static_cast<double>(s) * h, rise = (speed(from + h) - speed(from)) / h;
      EXPECT_NEAR(history.acceleration[k * count + s][3], rise, 1e-5) << k << ' ' << s;
      // dΩ/dt = (command − Ω)/τ, and so of their means
      const double command = t < 0.0995 ? 400.0 : 600.0;
      EXPECT_NEAR(history.mean[k * count + s][3], command - lag_s * rise, 1e-5) << k << ' ' << s;
    }
  }
}

TEST(RotorHistory, TakesTheBestThatThereIs) {
  FlightData flight = stepped(400.0, 600.0);
  const ForceModel forces = forces_of(flight);
  EXPECT_EQ(rotor_history(flight, forces).mean, commanded_history(flight, forces).mean);
  flight.measured_speed = test::record_of([](double t) { return test::all_at(300.0 + 50.0 * t); }, 0.3, 0.01, true);
  const RotorHistory measured = rotor_history(flight, forces);
  const auto count = static_cast<std::size_t>(measured.substeps);
  for (std::size_t k = 1; k + 2 < flight.samples.size(); ++k) {
    EXPECT_NEAR(measured.mean[k * count][0], 300.0 + 50.0 * (flight.samples[k].time_s + 0.5 * 0.01 / 4.0), 1e-9);
    EXPECT_NEAR(measured.acceleration[k * count][0], 50.0, 1e-6);
  }
  EXPECT_EQ(measured.mean, measured_history(flight).mean);
  EXPECT_NE(commanded_history(flight, forces).mean, measured.mean);
  flight.estimated.mean = {test::all_at(7.0)};
  EXPECT_EQ(rotor_history(flight, forces).mean, flight.estimated.mean);
}

}  // namespace propagation_test
}  // namespace gustlab::diagnosis
