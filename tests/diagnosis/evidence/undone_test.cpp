// The shares of what an effect does that others take back, or do as well, on rows that are written out.
#include <gtest/gtest.h>

#include "diagnosis/evidence/gather_evidence.hpp"
#include "gustlab/random.hpp"

namespace gustlab::diagnosis {
namespace undone_test {

// predictions of two effects over three rows, and of two that nearly undo each other
TEST(UndoneShares, AreOfThePredictionsAndNotOfTheCoefficients) {
  Eigen::Matrix3d rows;
  rows << 1.0, -1.0, 0.0,  //
      2.0, -2.0, 0.0,      //
      0.0, 1.0, 3.0;
  const Eigen::MatrixXd gram = rows.transpose() * rows;
  const Eigen::Vector3d first(1.0, 0.0, 0.0), second(0.0, 0.9, 0.0), third(0.0, 0.0, 1.0);
  const auto direct = [&](const Eigen::Vector3d& effect, const Eigen::Vector3d& others) {
    return -(rows * effect).dot(rows * others) / (rows * effect).squaredNorm();
  };
  const std::vector<double> shares = undone_shares(gram, {first, second, third});
  ASSERT_EQ(shares.size(), 3u);
  EXPECT_NEAR(shares[0], direct(first, second + third), 1e-12);
  EXPECT_NEAR(shares[0], 0.9, 1e-12);
  EXPECT_NEAR(shares[1], direct(second, first + third), 1e-12);
  EXPECT_EQ(shares[2], 0.0);  // its partner adds to it
}

TEST(UndoneShares, AnEffectAloneIsNotUndone) {
  const Eigen::Matrix2d gram{{4.0, 1.0}, {1.0, 9.0}};
  EXPECT_EQ(undone_shares(gram, {Eigen::Vector2d(0.3, 0.0)}), std::vector<double>{0.0});
  EXPECT_EQ(undone_shares(gram, {Eigen::Vector2d(0.3, 0.0), Eigen::Vector2d::Zero()}), (std::vector<double>{0.0, 0.0}));
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
