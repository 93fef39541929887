// Changes against numbers that other flights tell: against the dense solution with all unknowns.
#include "diagnosis/estimation/reference.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <numeric>

#include "gustlab/random.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab::diagnosis {
namespace reference_test {

Eigen::MatrixXd rows_of(int count, int columns, std::uint32_t replicate) {
  const RandomStream random(11, replicate, "reference_test");
  Eigen::MatrixXd rows(count, columns);
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < columns; ++j) rows(i, j) = random.normal4(static_cast<std::uint64_t>(i * columns + j))[0];
  return rows;
}

Grams one_block(const Eigen::MatrixXd& rows) {
  Grams grams;
  grams.columns = static_cast<int>(rows.cols()) - 1;
  grams.block = {rows.transpose() * rows};
  grams.flight = {0}, grams.time_s = {0.0}, grams.cluster = {0}, grams.known = {false}, grams.clusters = 1,
  grams.rows = static_cast<double>(rows.rows());
  return grams;
}

std::vector<int> all_of(const Catalogue& catalogue) {
  std::vector<int> all(static_cast<std::size_t>(catalogue.size()));
  std::iota(all.begin(), all.end(), 0);
  return all;
}

// z = Φ (change + error), error about an estimate, known from other rows: minimised over the error as well
TEST(Reference, ChangesAreThoseOfTheJointSolution) {
  const Catalogue catalogue(read_vehicle("crazyflie"), 1,
                            {Need::attitude | Need::motion | Need::torque, false, false, false});
  const int size = catalogue.size();
  const Eigen::MatrixXd here = rows_of(400, size + 1, 1), there = rows_of(300, size + 1, 2);
  const Grams normal = one_block(there);
  const Reference reference = reference_of(catalogue, normal, {});
  EXPECT_EQ(reference.flights, 1);
  const Grams changed = beside_reference(catalogue, all_of(catalogue), reference, one_block(here));

  // the columns that both share, each with an error of its own, which the information of the reference (and a prior of one) holds
  std::vector<int> shared;
  for (int c = 0; c < size; ++c)
    if (std::any_of(reference.column.begin(), reference.column.end(), [&](const auto& known) {
          const Column& column = catalogue.column(c);
          return column.group >= 0 && column.flight < 0 && known.second == column.parameter &&
                 known.first == catalogue.group(column.group).label;
        }))
      shared.push_back(c);
  ASSERT_EQ(shared.size(), reference.column.size());
  const int chosen = shared[3];
  const auto known = static_cast<Eigen::Index>(shared.size());
  Eigen::MatrixXd joint = Eigen::MatrixXd::Zero(1 + known, 1 + known);
  Eigen::VectorXd right(1 + known);
  Eigen::MatrixXd columns(here.rows(), 1 + known);
  columns << here.col(chosen), here(Eigen::all, shared);
  joint = columns.transpose() * columns;
  joint.bottomRightCorner(known, known) += reference.information + Eigen::MatrixXd::Identity(known, known);
  EXPECT_GT(reference.estimate.norm(), 0.01);
  right = columns.transpose() * (here.col(size) - here(Eigen::all, shared) * reference.estimate);
  const Eigen::VectorXd solution = joint.ldlt().solve(right);
  EXPECT_NEAR(solve(changed.total(), {chosen}).coefficient[0], solution[0], 1e-6);

  // the errors themselves, once the change is known
  const KnownColumns columns_known = known_columns(catalogue, all_of(catalogue), reference);
  EXPECT_EQ(columns_known.column, shared);
  const Eigen::MatrixXd own = here(Eigen::all, shared);
  const Eigen::VectorXd left = here.col(size) - here.col(chosen) * solution[0],
                        errors = known_errors(reference, columns_known, own.transpose() * own, own.transpose() * left);
  EXPECT_LT((errors - reference.estimate - solution.tail(known)).norm(), 1e-6 * errors.norm());
}

TEST(Reference, MuchInformationLeavesTheMatricesAsTheyAre) {
  const Catalogue catalogue(read_vehicle("crazyflie"), 1,
                            {Need::attitude | Need::motion | Need::torque, false, false, false});
  const Grams here = one_block(rows_of(400, catalogue.size() + 1, 1));
  Reference reference = reference_of(catalogue, one_block(rows_of(300, catalogue.size() + 1, 2)), {});
  reference.information *= 1e9;
  reference.estimate.setZero();
  EXPECT_LT((beside_reference(catalogue, all_of(catalogue), reference, here).total() - here.total()).norm(),
            1e-3 * here.total().norm());
}

// Flights tell nothing of a number that looks like a force of their own, where they have one; and all of it where they do not.
TEST(Reference, OnlyForcesThatTheFlightsHaveHideWhatLooksLikeThem) {
  const Catalogue catalogue(read_vehicle("crazyflie"), 1,
                            {Need::attitude | Need::motion | Need::torque, false, false, false});
  const auto first_with = [&](bool of_one_flight) {
    const auto& all = catalogue.columns();
    return static_cast<int>(
        std::find_if(all.begin(), all.end(),
                     [&](const Column& c) { return c.group >= 0 && (c.flight >= 0) == of_one_flight; }) -
        all.begin());
  };
  const int own = first_with(true), shared = first_with(false);
  Eigen::MatrixXd rows = rows_of(300, catalogue.size() + 1, 2);
  rows.col(own) = rows.col(shared);
  const Grams grams = one_block(rows);
  const double told = reference_of(catalogue, grams, {}).information(0, 0),
               hidden = reference_of(catalogue, grams, {own}).information(0, 0);
  EXPECT_GT(told, 20.0);
  EXPECT_LT(hidden, 1e-6 * told);
}

// z = Φ θ + noise, of which every flight has its own θ
Grams flights_that_differ(const Catalogue& catalogue, int flights, double sd) {
  Grams grams;
  for (int f = 0; f < flights; ++f) {
    Eigen::MatrixXd rows = rows_of(2000, catalogue.size() + 1, static_cast<std::uint32_t>(10 + f));
    const Eigen::VectorXd own =
        sd * rows_of(1, catalogue.size(), static_cast<std::uint32_t>(90 + f)).row(0).transpose();
    rows.rightCols(1) += rows.leftCols(catalogue.size()) * own;
    Grams one = one_block(rows);
    one.flight = {f};
    append(std::move(one), grams);
  }
  return grams;
}

// speeds, torques and sensors have blocks of their own, which come after those of the motion
TEST(Reference, ThirdsOfOneFlightAreThirdsOfItsTime) {
  const Catalogue catalogue(read_vehicle("crazyflie"), 1,
                            {Need::attitude | Need::motion | Need::torque, false, false, false});
  const auto information = [&](std::vector<int> order) {
    const Grams parts = flights_that_differ(catalogue, 6, 0.2);
    Grams flight;
    flight.columns = parts.columns, flight.rows = parts.rows;
    for (const int at : order) flight.add(0, 300.0 + at, parts.block[static_cast<std::size_t>(at)], false);
    flight.add(0, 0.0, Eigen::MatrixXd::Zero(parts.columns + 1, parts.columns + 1), true);
    return reference_of(catalogue, flight, {}).information;
  };
  const Eigen::MatrixXd in_order = information({0, 1, 2, 3, 4, 5}), otherwise = information({0, 2, 4, 1, 3, 5});
  EXPECT_LT((in_order - otherwise).norm(), 1e-9 * in_order.norm());
}

TEST(Reference, FlightsThatDifferHoldLessInformation) {
  const Catalogue catalogue(read_vehicle("crazyflie"), 1,
                            {Need::attitude | Need::motion | Need::torque, false, false, false});
  const auto information = [&](double sd) {
    return reference_of(catalogue, flights_that_differ(catalogue, 4, sd), {}).information.trace();
  };
  const Eigen::VectorXd shared_of_all = flights_that_differ(catalogue, 4, 0.0).total().diagonal();
  const Reference alike = reference_of(catalogue, flights_that_differ(catalogue, 4, 0.0), {});
  double held = 0.0;
  for (int c = 0; c < catalogue.size(); ++c)
    if (const Column& column = catalogue.column(c); column.group >= 0 && column.flight < 0) held += shared_of_all[c];
  // the same numbers in all: noise alone, a mean of 1 with an error of √(2 / scores)
  EXPECT_NEAR(alike.information.trace(), held, 0.25 * held);
  // 2000 rows hold a number to 1 / √2000; those of flights differ by five times as much: 1 + 25, of four flights
  EXPECT_NEAR(held / information(5.0 / std::sqrt(2000.0)), 26.0, 9.0);
}

// what flights have of their own in one number leaves the others as sure as they are
TEST(Reference, FlightsThatDifferInOneNumberAreAsSureOfTheOthers) {
  const Catalogue catalogue(read_vehicle("crazyflie"), 1,
                            {Need::attitude | Need::motion | Need::torque, false, false, false});
  const Reference alike = reference_of(catalogue, flights_that_differ(catalogue, 4, 0.0), {});
  Grams one_differs = flights_that_differ(catalogue, 4, 0.0);
  int first = 0;  // of the shared columns
  while (catalogue.column(first).group < 0 || catalogue.column(first).flight >= 0) ++first;
  for (std::size_t f = 0; f < one_differs.block.size(); ++f) {
    Grams flight;
    flight.columns = one_differs.columns;
    flight.block = {one_differs.block[f]};
    Eigen::VectorXd own = Eigen::VectorXd::Zero(catalogue.size());
    own[first] = f % 2 == 0 ? 1.0 : -1.0;
    flight.shift(own);
    one_differs.block[f] = flight.block[0];
  }
  const Reference differ = reference_of(catalogue, one_differs, {});
  ASSERT_GT(alike.information(0, 0), 1000.0);
  EXPECT_LT(differ.information(0, 0), 0.01 * alike.information(0, 0));
  for (Eigen::Index i = 1; i < alike.information.rows(); ++i)
    EXPECT_GT(differ.information(i, i), 0.2 * alike.information(i, i)) << i;
}

// the first two shared columns
std::array<int, 2> two_shared(const Catalogue& catalogue) {
  std::vector<int> shared;
  for (int c = 0; c < catalogue.size(); ++c)
    if (const Column& column = catalogue.column(c); column.group >= 0 && column.flight < 0) shared.push_back(c);
  return {shared[0], shared[1]};
}

// 400 rows a flight, in which two numbers look alike to one part in a hundred
Eigen::MatrixXd rows_with_alike(const Catalogue& catalogue, int one, int other, std::uint32_t replicate) {
  Eigen::MatrixXd rows = rows_of(400, catalogue.size() + 1, replicate);
  rows.col(other) = rows.col(one) + 0.01 * rows.col(other);
  return rows;
}

// a mass and a thrust scale that flights hardly tell apart: what they say of both together is not lost where flights differ in one of them
TEST(Reference, NumbersThatLookAlikeKeepWhatTheySayTogether) {
  const Catalogue catalogue(read_vehicle("crazyflie"), 1,
                            {Need::attitude | Need::motion | Need::torque, false, false, false});
  const auto [one, other] = two_shared(catalogue);
  Grams grams;
  for (int f = 0; f < 4; ++f) {
    Eigen::MatrixXd rows = rows_with_alike(catalogue, one, other, static_cast<std::uint32_t>(20 + f));
    // they differ in what tells the two apart
    const double own = f % 2 == 0 ? 100.0 : -100.0;
    rows.rightCols(1) += own * (rows.col(one) - rows.col(other));
    Grams flight = one_block(rows);
    flight.flight = {f};
    append(std::move(flight), grams);
  }
  const Eigen::MatrixXd information = reference_of(catalogue, grams, {}).information.topLeftCorner(2, 2);
  const double together = 0.25 * information.sum(),
               apart = 0.25 * (information(0, 0) + information(1, 1)) - 0.5 * information(0, 1);
  EXPECT_GT(together, 0.3 * 1600.0);
  EXPECT_LT(apart, 0.1 * 1600.0 * 0.0001 / 4.0);
}

// what has no column in the flights to compare cannot be wrong there in place of its equal
TEST(Reference, WhatHasNoColumnHereIsAsTheReferenceHasIt) {
  const Catalogue catalogue(read_vehicle("crazyflie"), 1,
                            {Need::attitude | Need::motion | Need::torque, false, false, false});
  const auto [one, other] = two_shared(catalogue);
  const Reference reference = reference_of(catalogue, one_block(rows_with_alike(catalogue, one, other, 20)), {});
  Eigen::MatrixXd here = rows_with_alike(catalogue, one, other, 30);
  here.col(other).setZero();
  const auto left_of = [&, alone = one](const std::vector<int>& present) {
    return beside_reference(catalogue, present, reference, one_block(here)).total()(alone, alone);
  };
  std::vector<int> without = all_of(catalogue);
  EXPECT_LT(left_of(without), 10.0);
  std::erase(without, other);
  EXPECT_GT(left_of(without), 100.0);
}

}  // namespace reference_test
}  // namespace gustlab::diagnosis
