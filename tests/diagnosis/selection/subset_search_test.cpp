// The subset search against every subset, one by one.
#include "diagnosis/selection/subset_search.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "gustlab/random.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab::diagnosis {
namespace subset_search_test {

using ::testing::ElementsAre;

const VehicleModel& vehicle() {
  static const VehicleModel model = [] {
    VehicleModel bare = read_vehicle("crazyflie");
    bare.effects.clear();  // a drag of the file would be felt by a wind
    return bare;
  }();
  return model;
}

const Catalogue& catalogue() {
  static const Catalogue all(vehicle(), 2, {Need::attitude | Need::motion | Need::torque | Need::accelerometer});
  return all;
}

// rows in which a few effects are there, alike ones among them
Eigen::MatrixXd some_gram() {
  const RandomStream random(6, 0, "subset_search_test");
  const int size = catalogue().size();
  Eigen::MatrixXd rows(300, size + 1);
  for (Eigen::Index i = 0; i < rows.rows(); ++i)
    for (Eigen::Index j = 0; j < rows.cols(); ++j)
      rows(i, j) = random.normal4(static_cast<std::uint64_t>(i * rows.cols() + j))[0];
  const auto column = [](const char* name) { return catalogue().group(catalogue().find(name)).columns.front(); };
  rows.col(column("translational_lift")) += 0.8 * rows.col(column("thrust_curve"));
  rows.col(size) += 0.6 * rows.col(column("rotor_drag")) + 0.5 * rows.col(column("thrust_curve")) +
                    0.4 * rows.col(column("rotor_tilt"));
  return rows.transpose() * rows;
}

SubsetSearch search() { return {catalogue(), vehicle(), std::log(300.0)}; }

// it would cost nothing, and gain as little
TEST(SubsetSearch, AGroupOfWhichNoNumberIsAskedIsNoCandidate) {
  Catalogue some = catalogue();
  const int mass = some.find("mass");
  ASSERT_THAT(search().candidates, ::testing::Contains(mass));
  for (const std::vector<int> all = some.group(mass).columns; const int c : all) some.freeze(c);
  const SubsetSearch without(some, vehicle(), 0.0);
  EXPECT_THAT(without.candidates, ::testing::Not(::testing::Contains(mass)));
  EXPECT_EQ(without.candidates.size() + 1, search().candidates.size());
  EXPECT_EQ(without.gained_by_chance(), 2.0 * std::log(static_cast<double>(without.candidates.size())));
}

// the best of all subsets of a size
double best_score(const SubsetSearch& by, const Eigen::MatrixXd& gram, int size) {
  double best = std::numeric_limits<double>::infinity();
  std::vector<int> groups;
  const std::function<void(std::size_t)> add = [&](std::size_t from) {
    if (static_cast<int>(groups.size()) == size) {
      if (by.allowed(groups)) best = std::min(best, by.evaluate(gram, groups).score);
      return;
    }
    for (std::size_t i = from; i < by.candidates.size(); ++i) {
      groups.push_back(by.candidates[i]);
      add(i + 1);
      groups.pop_back();
    }
  };
  add(0);
  return best;
}

TEST(SubsetSearch, FindsTheBestSubsetOfEverySize) {
  const SubsetSearch by = search();
  const Eigen::MatrixXd gram = some_gram();
  const auto found = by.run(gram, 3, 25);
  ASSERT_EQ(found.size(), 4u);
  for (int size = 1; size <= 3; ++size) {
    ASSERT_FALSE(found[static_cast<std::size_t>(size)].empty());
    EXPECT_EQ(found[static_cast<std::size_t>(size)].front().score, best_score(by, gram, size)) << size;
  }
}

TEST(SubsetSearch, StopsWhereAFurtherEffectGainsTooLittle) {
  const auto found = search().run(some_gram(), 4, 25);
  const std::vector<int> wanted = [] {
    std::vector<int> groups;
    for (const char* name : {"rotor_drag", "rotor_tilt", "thrust_curve"}) groups.push_back(catalogue().find(name));
    std::sort(groups.begin(), groups.end());
    return groups;
  }();
  EXPECT_EQ(SubsetSearch::choose(found, 10.0).groups, wanted);
  EXPECT_TRUE(SubsetSearch::choose(found, 1e6).groups.empty());
}

TEST(SubsetSearch, ImprovesASetByWhatPaysMost) {
  const SubsetSearch by = search();
  const Eigen::MatrixXd gram = some_gram();
  std::vector<int> start = {catalogue().find("rotor_drag"), catalogue().find("translational_lift")};
  std::sort(start.begin(), start.end());
  // one more, or one in another's place
  double best = by.evaluate(gram, start).score - 1.0;
  std::vector<int> wanted;
  for (const int g : by.candidates)
    for (std::size_t place = 0; place <= start.size(); ++place) {
      std::vector<int> changed = start;
      if (std::count(start.begin(), start.end(), g) > 0) continue;
      if (place < start.size()) changed[place] = g;
      else changed.push_back(g);
      std::sort(changed.begin(), changed.end());
      if (const double score = by.evaluate(gram, changed).score; by.allowed(changed) && score < best)
        best = score, wanted = changed;
    }
  ASSERT_FALSE(wanted.empty());
  const std::vector<int> better = by.improved(gram, start, {}, 1.0, true);
  EXPECT_EQ(better, wanted);
  // a set that was visited does not come again
  EXPECT_NE(by.improved(gram, start, {better}, 1.0, true), better);
  // without exchanges what was there stays
  const std::vector<int> more = by.improved(gram, start, {}, 1.0, false);
  EXPECT_EQ(more.size(), start.size() + 1);
  EXPECT_TRUE(std::includes(more.begin(), more.end(), start.begin(), start.end()));
}

TEST(SubsetSearch, OneEffectTakesThePlaceOfTwoThatDoTogetherWhatItDoes) {
  const SubsetSearch by = search();
  const RandomStream random(7, 0, "subset_search_test");
  const auto one = [](const char* name) { return catalogue().group(catalogue().find(name)).columns.front(); };
  Eigen::MatrixXd rows(300, catalogue().size() + 1);
  for (Eigen::Index i = 0; i < rows.rows(); ++i)
    for (Eigen::Index j = 0; j < rows.cols(); ++j)
      rows(i, j) = random.normal4(static_cast<std::uint64_t>(i * rows.cols() + j))[0];
  rows.col(one("thrust_curve")) =
      rows.col(one("rotor_drag")) + rows.col(one("translational_lift")) + 0.1 * rows.col(one("thrust_curve"));
  rows.col(catalogue().size()) += rows.col(one("thrust_curve"));
  const Eigen::MatrixXd gram = rows.transpose() * rows;
  std::vector<int> two = {catalogue().find("rotor_drag"), catalogue().find("translational_lift")};
  std::sort(two.begin(), two.end());
  constexpr double material = 20.0;
  EXPECT_THAT(by.improved(gram, two, {}, material, true), ElementsAre(catalogue().find("thrust_curve")));
  // what is only added to replaces nothing
  EXPECT_THAT(by.improved(gram, two, {}, material, false), ElementsAre());
  // and where it does less than the two, they stay
  rows.col(catalogue().size()) += rows.col(one("rotor_drag"));
  EXPECT_THAT(by.improved(rows.transpose() * rows, two, {}, material, true), ElementsAre());
}

TEST(SubsetSearch, KnowsWhatNeedsAnotherAndWhatExcludesIt) {
  const SubsetSearch by = search();
  const int wind = catalogue().find("steady_wind"), mass = catalogue().find("mass"),
            thrust = catalogue().find("thrust_scale");
  EXPECT_FALSE(by.allowed({wind}));
  EXPECT_FALSE(by.allowed({wind, mass}));
  EXPECT_TRUE(by.allowed({wind, catalogue().find("translational_lift")}));
  EXPECT_FALSE(by.allowed({mass, thrust}));
  EXPECT_TRUE(by.allowed({mass, catalogue().find("inertia")}));
}

TEST(SubsetSearch, WhatLeavesItsBoundsIsNotPossible) {
  Eigen::MatrixXd gram = some_gram();
  const int drag = catalogue().find("rotor_drag");
  const int c = catalogue().group(drag).columns.front();
  const Eigen::Index z = gram.cols() - 1;
  // a drag that pushes
  gram(c, z) = gram(z, c) = -std::abs(gram(c, z));
  EXPECT_TRUE(std::isinf(search().evaluate(gram, {drag}).loss));
}

TEST(SubsetSearch, ADragLeavesWithTheWindThatItAloneFeels) {
  const SubsetSearch by = search();
  const int drag = catalogue().find("quadratic_drag"), mass = catalogue().find("mass"),
            wind = catalogue().find("steady_wind"), inflow = catalogue().find("axial_inflow");
  // two areas, a mass, and three numbers of each of two flights
  EXPECT_THAT(by.leaving({drag, mass, wind}, drag), ElementsAre(0, 1, 3, 4, 5, 6, 7, 8));
  EXPECT_THAT(by.leaving({drag, mass, wind}, mass), ElementsAre(2));
  EXPECT_THAT(by.leaving({drag, mass, wind}, wind), ElementsAre(3, 4, 5, 6, 7, 8));
  EXPECT_THAT(by.leaving({drag, inflow, wind}, drag), ElementsAre(0, 1));
}

TEST(SubsetSearch, WhatLeavesItsBoundsIsAskedThere) {
  Eigen::MatrixXd rows = Eigen::MatrixXd::Random(300, catalogue().size() + 1);
  const int wind = catalogue().find("steady_wind"), mass = catalogue().find("mass");
  const int x = catalogue().group(wind).columns.front(), m = catalogue().group(mass).columns.front();
  const auto z = rows.cols() - 1;
  const Column& column = catalogue().column(x);
  const double most = (column.max - column.nominal) / column.natural, beyond = 1.5 * most;
  rows.col(z) += beyond * rows.col(x) + 0.2 * rows.col(m);
  const Eigen::MatrixXd gram = rows.transpose() * rows;
  const std::vector<int> columns = {m, x};
  const Fit fit = solve(gram, columns);
  ASSERT_GT(fit.coefficient[1], most);
  // least squares of what is left of z with the wind at its bound
  const Eigen::VectorXd left = rows.col(z) - most * rows.col(x), of = rows.col(m);
  const double wanted = (left - of * (of.dot(left) / of.squaredNorm())).squaredNorm();
  EXPECT_NEAR(search().loss_within_bounds(gram, columns, fit, wind), wanted, 1e-6 * wanted);
  // another group's bounds are not asked, and a fit within them stays as it is
  EXPECT_NEAR(search().loss_within_bounds(gram, columns, fit, mass), fit.loss, 1e-6 * fit.loss);
}

}  // namespace subset_search_test
}  // namespace gustlab::diagnosis
