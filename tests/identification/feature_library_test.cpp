#include "identification/feature_library.hpp"

#include <gtest/gtest.h>

#include "gustlab/errors.hpp"
#include "identification/synthetic.hpp"

namespace gustlab {
namespace feature_library_test {

std::vector<std::string> names(const char* text) {
  std::vector<std::string> out;
  for (const FeatureTerm& term : make_library(text)) out.push_back(term.name());
  return out;
}
using Names = std::vector<std::string>;

TEST(Library, Paper) {
  EXPECT_EQ(names("paper"), (Names{"1", "theta", "phi", "T sin theta", "T cos theta", "T sin phi", "T cos phi"}));
}

TEST(Library, PolynomialListsEveryMonomialOnceByDegree) {
  EXPECT_EQ(names("polynomial:2:vx,vy"), (Names{"1", "vx", "vy", "vx^2", "vx vy", "vy^2"}));
  EXPECT_EQ(names("polynomial:3:px,py,pz").size(), 20u);
  EXPECT_EQ(names("polynomial").size(), 10u);
}

TEST(Library, Trigonometric) {
  EXPECT_EQ(names("trigonometric:2:psi"), (Names{"sin psi", "cos psi", "sin 2 psi", "cos 2 psi"}));
  EXPECT_EQ(names("trigonometric").size(), 6u);
}

TEST(Library, UserChosenTermsAndSumsWithoutRepeats) {
  EXPECT_EQ(names("vx abs vx, T*cos(phi)"), (Names{"vx abs vx", "T cos phi"}));
  EXPECT_EQ(names("paper+polynomial:1:vx,vy+theta").size(), 9u);
}

TEST(Library, Refusals) {
  for (const char* text : {"", "papr", "polynomial:0", "polynomial:x", "polynomial:5", "polynomial:2:vx:3", "vx,,vy",
                           "polynomial:4:px,py,pz,vx,vy,vz,wx,wy"}) {
    EXPECT_THROW(make_library(text), ConfigError) << text;
  }
}

TEST(FeatureMatrix, IsTermByTermTheValueOnEachSample) {
  const std::vector<FeatureInput> flight = rocking_flight(17);
  const std::vector<FeatureTerm> library = make_library("paper");
  const Eigen::MatrixXd theta = feature_matrix(library, flight);
  ASSERT_EQ(theta.rows(), 17);
  ASSERT_EQ(theta.cols(), 7);
  for (Eigen::Index i = 0; i < 17; ++i) {
    for (Eigen::Index j = 0; j < 7; ++j) {
      EXPECT_EQ(theta(i, j), library[static_cast<std::size_t>(j)].value(flight[static_cast<std::size_t>(i)]));
    }
  }
}

TEST(Registry, EveryLibraryCanBeMadeByItsName) {
  for (const LibraryRow& row : library_registry()) EXPECT_FALSE(make_library(row.name).empty()) << row.name;
}

}  // namespace feature_library_test
}  // namespace gustlab
