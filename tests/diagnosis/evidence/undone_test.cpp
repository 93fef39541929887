// The shares of what an effect does that others take back, or do as well, on rows that are written out.
#include <gtest/gtest.h>

#include <algorithm>

#include "config/text.hpp"
#include "diagnosis/evidence/gather_evidence.hpp"
#include "gustlab/random.hpp"
#include "support/flight_data.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace undone_test {

// predictions of two effects over three rows that nearly undo each other, and of one far larger that goes a little against the first
TEST(Undoings, AreOfThePredictionsAndNotOfTheCoefficients) {
  Eigen::Matrix3d rows;
  rows << 1.0, -1.0, -1.0,  //
      2.0, -2.0, 0.0,       //
      0.0, 1.0, 30.0;
  const Eigen::MatrixXd gram = rows.transpose() * rows;
  const Eigen::Vector3d first(1.0, 0.0, 0.0), second(0.0, 0.9, 0.0), third(0.0, 0.0, 1.0);
  const auto cosine = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return (rows * a).dot(rows * b) / ((rows * a).norm() * (rows * b).norm());
  };
  const auto of = [&](const std::vector<Eigen::VectorXd>& effects, std::size_t i) {
    return undoings(gram, effects)[i];
  };

  // the first is a little larger
  EXPECT_NEAR(of({first, second}, 0).share, 0.9, 1e-12);
  EXPECT_NEAR(of({first, second}, 0).outweighed, 0.9, 1e-12);
  EXPECT_NEAR(of({first, second}, 1).share, -cosine(first, second), 1e-12);
  // a small one takes little back
  EXPECT_NEAR(of({first, 0.1 * second}, 0).share, 0.09, 1e-12);
  // one that is far larger outweighs it, and yet undoes nothing
  EXPECT_NEAR(of({first, 10.0 * third}, 0).outweighed, 10.0 / 5.0, 1e-12);
  EXPECT_LT(of({first, 10.0 * third}, 0).share, 0.05);
  // of several the partner counts that takes most back
  EXPECT_NEAR(of({first, second, 10.0 * third}, 0).share, 0.9, 1e-12);
  EXPECT_EQ(of({second, third}, 1).share, 0.0);  // its partner adds to it
}

TEST(Undoings, AnEffectAloneIsNotUndone) {
  const Eigen::Matrix2d gram{{4.0, 1.0}, {1.0, 9.0}};
  const auto is_free = [](const Undoing& u) { return u.share == 0.0 && u.outweighed == 0.0; };
  EXPECT_TRUE(std::ranges::all_of(undoings(gram, {Eigen::Vector2d(0.3, 0.0)}), is_free));
  EXPECT_TRUE(std::ranges::all_of(undoings(gram, {Eigen::Vector2d(0.3, 0.0), Eigen::Vector2d::Zero()}), is_free));
}

// rows: the first two effects share the first two, the third has the last for itself
TEST(ShownBeside, CountsOnlyWhereTheEffectShows) {
  Eigen::MatrixXd rows(3, 4);  // z last
  rows << 1.0, 100.0, 0.0, 7.0, 2.0, 200.0, 0.0, 7.0, 0.0, 0.0, 1.0, 7.0;
  const Eigen::MatrixXd beside = shown_beside({{rows}}, 0.5 * Eigen::Matrix3d::Identity());
  EXPECT_NEAR(beside(0, 1), 1e4, 1e-8);
  EXPECT_NEAR(beside(1, 0), 1e-4, 1e-12);
  EXPECT_EQ(beside(2, 1), 0.0);
  EXPECT_EQ(beside(2, 2), 1.0);
}

// a wind and the drag that feels it are one push, and a trim is no name
TEST(DwarfedBy, IsTheLargestOtherName) {
  RotorArray hovering{};
  hovering.fill(test::crazyflie().hover_speed_radps());
  const Session session(
      {test::flight_of(
          test::crazyflie(), 2.0, 0.01, [](double) { return Motion{}; }, [&](double) { return hovering; })},
      test::crazyflie(), 1);
  const Catalogue& catalogue = session.catalogue();
  Selection selection;
  for (const int group : {catalogue.find(Airflow::wind), catalogue.find(Airflow::drag), catalogue.find("mass")})
    selection.findings.emplace_back().group = group;
  const Eigen::Matrix3d beside{{1.0, 1e6, 100.0}, {1e-6, 1.0, 10.0}, {0.01, 200.0, 1.0}};
  EXPECT_EQ(dwarfed_by(catalogue, selection, beside, 0), 100.0);
  EXPECT_EQ(dwarfed_by(catalogue, selection, beside, 2), 200.0);
  selection.findings[2].calibration = true;
  EXPECT_EQ(dwarfed_by(catalogue, selection, beside, 0), 0.0);
}

// at rest, so that the drag that was found is felt in the wind alone
TEST(WeightsAddedUp, CountTheForceOfAWindOnce) {
  constexpr double found_Nspm = 0.02, wind_mps = 3.0;
  for (const double filed_Nspm : {0.0, 0.005}) {
    VehicleModel vehicle = test::crazyflie();
    vehicle.effects.clear();
    if (filed_Nspm > 0.0)
      vehicle.effects.push_back({"rotor_drag", {{"at_hover", config::shortest(filed_Nspm)}}, "", {}});
    RotorArray hovering{};
    hovering.fill(vehicle.hover_speed_radps());
    Session session({test::flight_of(
                        vehicle, 2.0, 0.01, [](double) { return Motion{}; }, [&](double) { return hovering; })},
                    vehicle, 1);
    const Catalogue& catalogue = session.catalogue();
    const int drag = catalogue.find(Airflow::drag), wind = catalogue.find(Airflow::wind);
    Selection selection;
    selection.value = catalogue.nominal();
    for (const int g : {drag, wind}) {
      Finding finding;
      finding.group = g;
      selection.findings.push_back(finding);
      selection.value[catalogue.group(g).columns.front()] = g == drag ? found_Nspm : wind_mps;
    }
    session.linearise(selection.value, session.all_columns());
    const std::vector<Eigen::VectorXd> weights = weights_added_up(catalogue, selection);
    const LinearFlight& flight = session.linear().front();
    const Eigen::VectorXd all = weights[0] + weights[1];
    const double pushed_mps2 = (flight.acceleration_by[100].topRows<3>() * all(flight.columns)).norm();
    EXPECT_NEAR(pushed_mps2, found_Nspm * wind_mps / vehicle.mass_kg, 1e-3 * pushed_mps2) << filed_Nspm;
  }
}

// rows: a constant, a command, what nothing predicted of the command, the effect of both commands, z
TEST(ShareDoneBy, IsHowMuchOfAnEffectTheFurtherColumnsAre) {
  const RandomStream random(3, 1, "share_done_by");
  Eigen::MatrixXd rows(4000, 5);
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const auto drawn = random.normal4(static_cast<std::uint64_t>(i));
    const double innovation = drawn[1], command = 2.0 * drawn[0] + innovation;
    rows.row(i) << 1.0, command, innovation, 0.0, drawn[2];
  }
  const Eigen::MatrixXd gram = rows.transpose() * rows;
  Eigen::VectorXd lasting = Eigen::VectorXd::Zero(5), answer = lasting;
  lasting[0] = 0.7, answer[1] = -0.3;
  EXPECT_NEAR(share_done_by(gram, lasting, {}, {2}), 0.0, 0.01);
  EXPECT_NEAR(share_done_by(gram, answer, {}, {2}), 1.0 / 5.0, 0.02);  // 1 of a variance of 2² + 1
  EXPECT_NEAR(share_done_by(gram, answer, {}, {1}), 1.0, 1e-6);
  EXPECT_NEAR(share_done_by(gram, answer, {2}, {}), 0.0, 1e-9);
}

}  // namespace undone_test
}  // namespace gustlab::diagnosis
