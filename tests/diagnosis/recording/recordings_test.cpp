// What becomes of the logs of a diagnosis before anything is fitted.
#include "diagnosis/recording/recordings.hpp"

#include <gmock/gmock.h>

#include <limits>

#include "gustlab/errors.hpp"
#include "support/closed_form_flights.hpp"
#include "support/flight_data.hpp"
#include "support/temporary_folder.hpp"

namespace gustlab::diagnosis {
namespace recordings_test {

using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

FlightLog named(FlightLog log, const std::string& path) {
  log.path = path;
  return log;
}

std::vector<std::string> labels(const std::vector<FlightLog>& logs) {
  std::vector<std::string> result;
  for (const FlightLog& log : logs) result.push_back(label_of(log.path));
  return result;
}

Recordings of(std::vector<FlightLog> fit, std::vector<FlightLog> holdout = {}) {
  Recordings recordings;
  recordings.vehicle = test::racer();
  recordings.fit = std::move(fit);
  recordings.holdout = std::move(holdout);
  return recordings;
}

class RecordingsOfFlights : public ::testing::Test {
 protected:
  const VehicleModel vehicle = test::racer();
  const FlightLog hover = named(test::fly(test::hover, vehicle), "some/hover.csv"),
                  banked = named(test::fly(test::banked, vehicle), "some/banked.csv"),
                  loop = named(test::fly(test::loop, vehicle), "some/loop.csv");
};

TEST_F(RecordingsOfFlights, TheLastIsHeldOutWhereTheUserHeldOutNone) {
  const Recordings found = check(of({hover, banked, loop}));
  EXPECT_THAT(labels(found.fit), ElementsAre("hover.csv", "banked.csv"));
  EXPECT_THAT(labels(found.holdout), ElementsAre("loop.csv"));
  EXPECT_THAT(found.remarks.notes, ElementsAre(HasSubstr("loop.csv is")));
  const Recordings asked = check(of({hover, banked}, {loop}));
  EXPECT_THAT(labels(asked.fit), ElementsAre("hover.csv", "banked.csv"));
  EXPECT_THAT(asked.remarks.notes, IsEmpty());
}

TEST_F(RecordingsOfFlights, ACopyIsSetAside) {
  const Recordings found = check(of({hover, named(hover, "some/copy.csv"), banked}, {loop}));
  EXPECT_THAT(labels(found.fit), ElementsAre("hover.csv", "banked.csv"));
  EXPECT_THAT(found.set_aside, ElementsAre(Field(&FlightUse::file, "copy.csv")));
}

TEST_F(RecordingsOfFlights, WithoutAFlightToFitThereIsNoDiagnosis) {
  FlightLog broken = hover;
  for (double& value : test::column(broken, "qw")) value = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NO_THROW(check(of({hover})));
  EXPECT_THROW(check(of({})), DataError);
}

TEST_F(RecordingsOfFlights, OfOneFlightTheLastThirdIsHeldOut) {
  const Recordings found = with_held_out_part(of({hover}));
  ASSERT_EQ(found.fit.size(), 1u);
  ASSERT_EQ(found.holdout.size(), 1u);
  const FlightLog &first = found.fit[0], &second = found.holdout[0];
  EXPECT_NEAR(static_cast<double>(first.rows()), 2.0 / 3.0 * static_cast<double>(hover.rows()), 1.0);
  // no row is lost and none is there twice
  for (std::size_t c = 0; c < hover.columns.size(); ++c) {
    std::vector<double> joined = first.columns[c].values;
    joined.insert(joined.end(), second.columns[c].values.begin(), second.columns[c].values.end());
    EXPECT_EQ(joined, hover.columns[c].values);
  }
  EXPECT_LT(first.time_s.back(), second.time_s.front());
  EXPECT_THAT(labels(with_held_out_part(of({hover}, {loop})).holdout), ElementsAre("loop.csv"));
}

TEST_F(RecordingsOfFlights, WhatCannotBeReadIsSetAsideAndSaid) {
  const TemporaryFolder folder;
  FlightLog log = hover;
  log.meta.vehicle = "crazyflie";
  write_flight_log(log, folder.file("good.csv"));
  const std::string bad = folder.write("bad.csv", "time_s,px\n0,zero\n");
  const Recordings found = read_recordings({bad, folder.file("good.csv")}, {bad}, {}, std::nullopt);
  EXPECT_THAT(labels(found.fit), ElementsAre("good.csv"));
  EXPECT_THAT(found.holdout, IsEmpty());
  EXPECT_EQ(found.vehicle.name, "crazyflie");
  EXPECT_THAT(found.set_aside, ElementsAre(Field(&FlightUse::file, "bad.csv"), Field(&FlightUse::file, "bad.csv")));
  EXPECT_EQ(found.remarks.findings.size(), 2u);
  EXPECT_THROW(read_recordings({bad}, {}, {}, std::nullopt), DataError);
}

TEST(Recordings, AColumnIsRecordedFromAHundredAndOneNumbersOn) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  FlightLog one, other;
  one.columns = {{"qw", std::vector<double>(60, 1.0)}, {"px", std::vector<double>(500, 0.0)}};
  other.columns = {{"wx", std::vector<double>(40, 0.0)}};
  one.columns[0].values.resize(90, none);
  EXPECT_FALSE(is_recorded({one, other}, {"qw", "wx"}));
  other.columns[0].values.push_back(0.0);
  EXPECT_TRUE(is_recorded({one, other}, {"qw", "wx"}));
  EXPECT_FALSE(is_recorded({one, other}, {"qw"}));
}

// offsets are listed for all flights; those of this part begin at the second
TEST_F(RecordingsOfFlights, CommandsAreReadLaterByTheirOwnOffset) {
  FlightLog ramp = hover;
  for (std::size_t k = 0; k < ramp.rows(); ++k) test::column(ramp, "u1")[k] = 500.0 + 10.0 * ramp.time_s[k];
  const std::vector<FlightData> as_logged = prepare({ramp, ramp}, vehicle, {}),
                                later = prepare({ramp, ramp}, vehicle, {}, {0.3, 0.05}, 1);
  for (const double t : {1.0, 2.5}) {
    EXPECT_NEAR(later[0].commands.mean(t, t + 0.01)[0], as_logged[0].commands.mean(t - 0.05, t - 0.04)[0], 1e-9);
    EXPECT_EQ(later[1].commands.mean(t, t + 0.01), as_logged[1].commands.mean(t, t + 0.01));
  }
}

}  // namespace recordings_test
}  // namespace gustlab::diagnosis
