// Columns without a name: what they push, by hand, and what they gain, against dense least squares on whitened rows.
#include "diagnosis/validation/generic_bases.hpp"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>

#include "support/flight_data.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace generic_bases_test {

const VehicleModel& vehicle() {
  static const VehicleModel model = test::crazyflie();
  return model;
}

// a vehicle that goes round and turns, each flight at another pace; rotors that differ a little
FlightData flight(double pace_radps) {
  return test::flight_of(
      vehicle(), 2.0, 0.01,
      [=](double t) {
        Motion m;
        m.position_W_m = Vector3(std::sin(pace_radps * t), std::cos(pace_radps * t), 1.0 + 0.3 * std::sin(1.7 * t));
        m.velocity_W_mps = Vector3(pace_radps * std::cos(pace_radps * t), -pace_radps * std::sin(pace_radps * t),
                                   0.51 * std::cos(1.7 * t));
        m.acceleration_W_mps2 = -pace_radps * pace_radps * Vector3(m.position_W_m.x(), m.position_W_m.y(), 0.0);
        m.attitude_WB = Quaternion(Eigen::AngleAxisd(0.4 * t, Vector3::UnitZ())) *
                        Quaternion(Eigen::AngleAxisd(0.2 * std::sin(2.0 * t), Vector3::UnitX()));
        return m;
      },
      [](double t) {
        RotorArray speeds{};
        for (std::size_t i = 0; i < 4; ++i)
          speeds[i] = vehicle().hover_speed_radps() * (1.0 + 0.03 * std::sin(11.0 * t + static_cast<double>(i)));
        return speeds;
      });
}

class GenericBases : public ::testing::Test {
 protected:
  GenericBases() : session({flight(1.1), flight(1.9)}, vehicle(), 1) {
    session.linearise(session.value(), session.all_columns());
  }
  const BasisFamily& named(const std::vector<BasisFamily>& families, const std::string& name) const {
    for (const BasisFamily& family : families)
      if (family.name == name) return family;
    throw std::invalid_argument(name);
  }
  static SpatialAccelerations pushes(const BasisFamily& family, std::size_t flight, std::size_t sample) {
    SpatialAccelerations columns = SpatialAccelerations::Zero(6, family.size);
    family.set(flight, sample, columns);
    return columns;
  }
  // warm rows of [some columns, the family, z] of both flights
  Eigen::MatrixXd rows(const BasisFamily& family, const std::vector<int>& columns) const {
    std::vector<Eigen::VectorXd> list;
    const auto known = static_cast<Eigen::Index>(columns.size());
    for (std::size_t f = 0; f < 2; ++f) {
      const LinearFlight linear = only(session.linear()[f], columns);
      SpatialAccelerations now;
      const Whitened w = whiten(
          session.flights()[f], linear, session.noise,
          {family.size, [&](std::size_t k) -> const SpatialAccelerations& { return now = pushes(family, f, k); }});
      for (Eigen::Index r = 0; r < w.rows.rows(); ++r) {
        if (!w.warm[static_cast<std::size_t>(r)]) continue;
        Eigen::VectorXd row = Eigen::VectorXd::Zero(known + family.size + 1);
        for (std::size_t j = 0; j < linear.columns.size(); ++j)
          row[std::find(columns.begin(), columns.end(), linear.columns[j]) - columns.begin()] =
              w.rows(r, static_cast<Eigen::Index>(j));
        row.tail(family.size + 1) = w.rows.row(r).tail(family.size + 1);
        list.push_back(row);
      }
    }
    Eigen::MatrixXd all(static_cast<Eigen::Index>(list.size()), known + family.size + 1);
    for (std::size_t i = 0; i < list.size(); ++i) all.row(static_cast<Eigen::Index>(i)) = list[i].transpose();
    return all;
  }
  Session session;
};

// what is left of the last column
double loss(const Eigen::MatrixXd& X, const Eigen::VectorXd& z) {
  return (z - X * X.completeOrthogonalDecomposition().solve(z)).squaredNorm();
}

TEST_F(GenericBases, FunctionsOfThePlaceAreOfTheFlownVolume) {
  const FlownVolume volume(session);
  Vector3 low = Vector3::Constant(1e9), high = -low;
  for (const FlightData& f : session.flights())
    for (const Motion& m : f.motion) low = low.cwiseMin(m.position_W_m), high = high.cwiseMax(m.position_W_m);
  const PlaceFunctions corner = volume.functions(high), middle = volume.functions(0.5 * (low + high));
  for (int i = 0; i < 7; ++i) EXPECT_NEAR(corner[i], 1.0, 1e-12) << i;
  for (int i = 0; i < 7; ++i) EXPECT_NEAR(middle[i], 0.0, 1e-12) << i;
  EXPECT_NEAR(volume.functions(low)[near_ground], 1.0, 1e-12);  // (5 cm)² over the square of 5 cm
  EXPECT_NEAR(volume.functions(low + 0.05 * Vector3::UnitZ())[near_ground], 0.25, 1e-12);
  EXPECT_NEAR(middle[near_ground + 5], 1.0, 1e-12);  // the bump in the middle
  EXPECT_LT(middle.tail<9>().minCoeff(), 0.02);
}

TEST_F(GenericBases, PushAlongTheirChannelAlone) {
  std::vector<BasisFamily> families = omnibus_bases(session);
  for (BasisFamily& family : channel_bases(session)) families.push_back(std::move(family));
  EXPECT_EQ(families.size(), 10u);
  for (const BasisFamily& family : families)
    for (int j = 0; j < family.size; ++j) {
      const int channel = family.channel[static_cast<std::size_t>(j)];
      for (const std::size_t k : {30u, 170u}) {
        const Eigen::Matrix<double, 6, 1> push = pushes(family, 1, k).col(j);
        const Matrix3 R = session.flights()[1].motion[k].attitude_WB.toRotationMatrix();
        const bool world = family.name == "position" || family.name == "time";
        const Vector3 axis = channel > 2 ? Vector3(Vector3::Unit(channel - 3))
                             : world     ? Vector3(Vector3::Unit(channel))
                                         : Vector3(R.col(channel));
        const Vector3 own = channel > 2 ? push.tail<3>() : push.head<3>();
        EXPECT_EQ((channel > 2 ? push.head<3>() : push.tail<3>()).norm(), 0.0) << family.name;
        EXPECT_LT((own - own.dot(axis) * axis).norm(), 1e-12 * (1.0 + own.norm())) << family.name << " " << j;
      }
    }
}

// the first of the velocity's: forward force of the forward speed
TEST_F(GenericBases, ForceOfTheVelocityIsInTheBody) {
  const std::vector<BasisFamily> families = omnibus_bases(session);
  const BasisFamily& velocity = named(families, "velocity");
  const Motion& m = session.flights()[0].motion[120];
  const Matrix3 R = m.attitude_WB.toRotationMatrix();
  const Vector3 v = R.transpose() * m.velocity_W_mps;
  EXPECT_LT((pushes(velocity, 0, 120).col(0).head<3>() - v.x() * R.col(0)).norm(), 1e-12);
  EXPECT_LT((pushes(velocity, 0, 120).col(1).head<3>() - v.norm() * v.x() * R.col(0)).norm(), 1e-12);
}

TEST_F(GenericBases, GramsAreThoseOfTheRows) {
  const std::vector<int> columns = session.with_biases({session.catalogue().find("rotor_drag")});
  const std::vector<BasisFamily> families = omnibus_bases(session);
  const BasisFamily& family = named(families, "velocity");
  const Eigen::MatrixXd X = rows(family, columns), gram = X.transpose() * X;
  EXPECT_LT((gram_with(session, family, columns) - gram).norm(), 1e-9 * gram.norm());
}

TEST_F(GenericBases, GainsAreWhatDenseLeastSquaresSaves) {
  const std::vector<int> columns = session.with_biases({session.catalogue().find("mass")});
  const int scatter = session.catalogue().group(session.catalogue().find("inertia")).columns[0];
  const std::vector<Trim> trims = {{scatter, 0.03}};
  std::vector<int> beside = columns;
  beside.push_back(scatter);
  const std::vector<BasisFamily> all = omnibus_bases(session);
  const std::vector<BasisFamily> families = {named(all, "time"), named(all, "velocity")};
  const std::vector<FamilyDeltaChi2> delta_chi2 = delta_chi2_of_families(session, families, columns, trims);
  const auto known = static_cast<Eigen::Index>(beside.size());
  for (std::size_t i = 0; i < families.size(); ++i) {
    Eigen::MatrixXd X = rows(families[i], beside);
    // a trim is small: one row more, in its standard deviations
    X.conservativeResize(X.rows() + 1, Eigen::NoChange);
    X.bottomRows<1>().setZero();
    X(X.rows() - 1, known - 1) = 1.0 / trims[0].deviation;
    const Eigen::VectorXd z = X.rightCols<1>();
    const double before = loss(X.leftCols(known), z), after = loss(X.leftCols(X.cols() - 1), z);
    ASSERT_GT(before - after, 1.0);
    EXPECT_NEAR(delta_chi2[i].all, before - after, 1e-3 * (before - after)) << families[i].name;
    // the terms on one channel alone
    Eigen::MatrixXd own = X.leftCols(known);
    for (int j = 0; j < families[i].size; ++j)
      if (families[i].channel[static_cast<std::size_t>(j)] == 2) {
        own.conservativeResize(Eigen::NoChange, own.cols() + 1);
        own.rightCols<1>() = X.col(known + j);
      }
    EXPECT_EQ(delta_chi2[i].size[2], own.cols() - known);
    EXPECT_NEAR(delta_chi2[i].channel[2], before - loss(own, z), 1e-3 * (before - after)) << families[i].name;
  }
}

}  // namespace generic_bases_test
}  // namespace gustlab::diagnosis
