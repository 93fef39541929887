// Parts of a disturbance that is made by a formula: an Ornstein-Uhlenbeck process and a sinusoid beside it.
#include "diagnosis/validation/gust_parts.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "gustlab/random.hpp"
#include "support/flight_data.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace gust_parts_test {

constexpr double duration_s = 120.0, sample_s = 0.04;

// `moves_radps`: the vehicle sways by half a metre so fast
Session hover(double moves_radps = 0.0) {
  const VehicleModel vehicle = test::ring(4, 1.5, 0.25, 0.0);
  std::vector<FlightData> flights;
  for (int f = 0; f < 2; ++f)
    flights.push_back(test::flight_of(
        vehicle, duration_s, sample_s,
        [=](double t) {
          Motion motion;
          motion.velocity_W_mps.x() = 0.5 * moves_radps * std::cos(moves_radps * t);
          motion.acceleration_W_mps2.x() = -0.5 * moves_radps * moves_radps * std::sin(moves_radps * t);
          return motion;
        },
        [&](double) { return test::all_at(vehicle.hover_speed_radps()); }));
  return Session(std::move(flights), vehicle, 1);
}

// standard deviations, the memory, and the amplitude of a line at 6.3 rad/s
std::vector<Smoothed> disturbed(const Session& session, double horizontal, double vertical, double time_s,
                                double line) {
  std::vector<Smoothed> result(session.flights().size());
  const RandomStream random(8, 0, "gust_parts_test");
  std::uint64_t at = 0;
  const double kept = std::exp(-sample_s / time_s), fresh = std::sqrt(1.0 - kept * kept);
  for (Smoothed& flight : result) {
    Vector3 slow = Vector3::Zero();
    for (std::size_t k = 0; k < session.flights().front().samples.size(); ++k) {
      const auto drawn = random.normal4(at++);
      slow = kept * slow + fresh * Vector3(horizontal * drawn[0], horizontal * drawn[1], vertical * drawn[2]);
      Eigen::Matrix<double, 6, 1> all = Eigen::Matrix<double, 6, 1>::Zero();
      all.head<3>() = slow;
      all.head<2>().array() += line * std::sin(6.3 * sample_s * static_cast<double>(k));
      flight.disturbance.push_back(all);
    }
  }
  return result;
}

TEST(GustParts, AreTheProcessAndTheLineThatMadeIt) {
  const Session session = hover();
  const GustParts parts = gust_parts(session, disturbed(session, 0.5, 0.2, 0.8, 0.3));
  EXPECT_NEAR(parts.horizontal_mps2, 0.5, 0.08);
  EXPECT_NEAR(parts.vertical_mps2, 0.2, 0.04);
  EXPECT_NEAR(parts.time_s, 0.8, 0.25);
  EXPECT_NEAR(parts.slow_mps2, 0.5 * std::exp(-0.25 / 0.8), 0.08);
  EXPECT_NEAR(parts.line_mps2, 0.3, 4.0 * parts.line_deviation_mps2);
  EXPECT_NEAR(parts.line_radps, 6.3, 4.0 * parts.line_deviation_radps);
  EXPECT_LT(parts.line_deviation_radps, 0.01);
}

TEST(GustParts, WithoutALineThereIsNone) {
  const Session session = hover();
  EXPECT_EQ(gust_parts(session, disturbed(session, 0.5, 0.2, 0.8, 0.0)).line_mps2, 0.0);
}

// a simulated flight straight up, without noise
TEST(GustParts, WithoutADisturbanceThereIsNoLine) {
  const Session session = hover();
  EXPECT_EQ(gust_parts(session, disturbed(session, 0.0, 0.2, 0.8, 0.0)).line_mps2, 0.0);
}

// the vehicle sways by 20 m/s² at the same frequency: a model that misses a part of that has a line there
TEST(GustParts, ALineOfTheFlownFigureIsTold) {
  const Session swaying = hover(6.3);
  EXPECT_TRUE(gust_parts(swaying, disturbed(swaying, 0.5, 0.2, 0.8, 0.3)).line_of_motion);
}

// A figure that both flights repeat: its third harmonic is its own, its seventh, or a line between two, is not.
TEST(GustParts, ALineAtALowHarmonicOfTheFlownFigureIsTheFigures) {
  const auto of_motion = [](double figure_radps) {
    const Session flying = hover(figure_radps);
    return gust_parts(flying, disturbed(flying, 0.5, 0.2, 0.8, 0.3)).line_of_motion;
  };
  EXPECT_TRUE(of_motion(6.3 / 3.0));
  EXPECT_FALSE(of_motion(6.3 / 7.0));
  EXPECT_FALSE(of_motion(6.3 / 4.5));
}

// Variance of the mean of such a process over a flight: 2 σ² τ/T for τ much shorter than T. Four standard deviations are no such mean.
TEST(MeansOfGust, AreForcesThatAGustLeavesAndNotLargerOnes) {
  const Session session = hover();
  GustParts gust;
  gust.horizontal_mps2 = gust.vertical_mps2 = 0.5, gust.time_s = 0.8;
  const double sd_N = session.vehicle().mass_kg * 0.5 * std::sqrt(2.0 * 0.8 / duration_s);
  const int force = session.catalogue().find("constant_force"), mass = session.catalogue().find("mass");
  Selection selection;
  selection.findings.resize(2);
  selection.findings[0].group = mass, selection.findings[1].group = force;
  selection.deviation = Eigen::VectorXd::Zero(session.catalogue().size());
  for (const double times : {1.0, 4.0}) {
    selection.value = session.catalogue().nominal();
    for (const int c : session.catalogue().group(force).columns) selection.value[c] = times * sd_N;
    EXPECT_EQ(means_of_gust(session, selection, gust), times < 2.0 ? std::vector<int>{force} : std::vector<int>{});
  }
  // a gust that hardly blows up and down leaves no such force along z
  gust.vertical_mps2 = 0.05;
  selection.value = session.catalogue().nominal();
  for (const int c : session.catalogue().group(force).columns)
    selection.value[c] = session.catalogue().column(c).parameter < 2 ? sd_N : 0.1 * sd_N;
  EXPECT_EQ(means_of_gust(session, selection, gust), std::vector<int>{force});
  for (const int c : session.catalogue().group(force).columns) selection.value[c] = sd_N;
  EXPECT_EQ(means_of_gust(session, selection, gust), std::vector<int>{});
}

}  // namespace gust_parts_test
}  // namespace gustlab::diagnosis
