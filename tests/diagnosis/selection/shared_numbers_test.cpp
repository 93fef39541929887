// A force of each flight against one number of the vehicle, on rows in which both do nearly the same.
#include "diagnosis/selection/shared_numbers.hpp"

#include <gtest/gtest.h>

#include "gustlab/random.hpp"
#include "support/sessions.hpp"

namespace gustlab::diagnosis {
namespace shared_numbers_test {

class SharedNumbers : public ::testing::Test {
 protected:
  static constexpr int rows_per_flight = 4000;
  Session session = test::session_of(test::short_flights("", {"multisine", "lemniscate"}, 3.0));
  const Catalogue& catalogue = session.catalogue();
  const int force = catalogue.find("constant_force"), scale = catalogue.find("thrust_scale"),
            tilt = catalogue.find("rotor_tilt");

  // Two flights whose force along `axis` is the first column of a number of the vehicle, `stronger` times as large; of that number, of some natural
  // sizes, each shows `apart` more or less.
  Grams flights(double apart, int number, std::size_t axis, double naturals = 2.0, double stronger = 1.0) const {
    Grams grams;
    grams.columns = catalogue.size();
    for (int f = 0; f < 2; ++f) {
      const RandomStream random(7, static_cast<std::uint32_t>(f), "shared_numbers_test");
      Eigen::MatrixXd rows(rows_per_flight, catalogue.size() + 1);
      for (Eigen::Index i = 0; i < rows.size(); ++i) rows(i) = random.normal4(static_cast<std::uint64_t>(i))[0];
      for (int c = 0; c < catalogue.size(); ++c)
        if (catalogue.column(c).flight == 1 - f) rows.col(c).setZero();
      const int own = catalogue.group(number).columns.front();
      rows.col(catalogue.group(force).columns[static_cast<std::size_t>(3 * f) + axis]) = stronger * rows.col(own);
      rows.rightCols(1) += (naturals + (f == 0 ? apart : -apart)) * rows.col(own);
      grams.add(f, 0.0, rows.transpose() * rows, false);
      grams.rows += rows_per_flight;
    }
    return grams;
  }
};

TEST_F(SharedNumbers, AForceThatIsAlikeInEveryFlightIsANumberOfTheVehicle) {
  ASSERT_EQ(catalogue.group(force).columns.size(), 6u);
  EXPECT_EQ(shared_instead(session, flights(0.15, scale, 2), {force}, {}), std::vector<int>{scale});
}

TEST_F(SharedNumbers, AForceThatDiffersStays) {
  EXPECT_EQ(shared_instead(session, flights(1.0, scale, 2), {force}, {}), std::vector<int>{force});
}

// a wind of 2 m/s that tilts all rotors by 6° as well
TEST_F(SharedNumbers, AForceOfAFarMoreUsualSizeStays) {
  EXPECT_EQ(shared_instead(session, flights(0.0, tilt, 0, 10.0, 1.0), {force}, {}), std::vector<int>{tilt});
  EXPECT_EQ(shared_instead(session, flights(0.0, tilt, 0, 10.0, 5.0), {force}, {}), std::vector<int>{force});
  // what pushes another way is told by the flights
  EXPECT_EQ(shared_instead(session, flights(0.0, scale, 2, 4.0, 5.0), {force}, {}), std::vector<int>{scale});
}

TEST_F(SharedNumbers, WhatIsLeftOutIsNotAsked) {
  const std::set<int> left_out{scale};
  EXPECT_EQ(shared_instead(session, flights(0.15, scale, 2), {force}, left_out), std::vector<int>{force});
}

TEST_F(SharedNumbers, WhatIsSharedAlreadyStays) {
  EXPECT_EQ(shared_instead(session, flights(0.0, scale, 2), {scale}, {}), std::vector<int>{scale});
}

}  // namespace shared_numbers_test
}  // namespace gustlab::diagnosis
