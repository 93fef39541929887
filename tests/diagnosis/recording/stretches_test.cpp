// Which stretches of a long log are diagnosed.
#include "diagnosis/recording/stretches.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>

#include "diagnosis/recording/flight_labels.hpp"
#include "diagnosis/recording/recordings.hpp"
#include "diagnosis/result/diagnosis.hpp"
#include "gustlab/errors.hpp"
#include "support/temporary_folder.hpp"

namespace gustlab::diagnosis {
namespace stretches_test {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr double row_s = 0.1;

// Hovers for so long; in some seconds of every hundred it moves, and it stands on the ground in others.
struct LongLog {
  double lasts_s = 1000.0, gap_s = 0.0;
  double moves_from_s = 40.0, moves_to_s = 70.0, stands_to_s = 0.0;
  char motion = 'w';

  std::string write(const TemporaryFolder& folder) const {
    folder.write("long.meta.toml",
                 "format = \"gustlab-flight/1\"\nvehicle = \"crazyflie\"\nactuator = \"rotor_speed\"\n");
    std::string text = fmt::format("time_s,{0}x,{0}y,{0}z,u1,u2,u3,u4\n", motion);
    for (int k = 0; k * row_s <= lasts_s; ++k) {
      const double t = k * row_s, in_part_s = std::fmod(t, 100.0), noise = std::sin(1e4 * t);
      const bool moves = in_part_s >= moves_from_s && in_part_s < moves_to_s, stands = in_part_s < stands_to_s;
      const double x = stands ? 50.0 * noise : 7.0 + (moves ? 1.0 : 0.01) * noise;
      // what stands shakes more than anything flies: rotors start and stop
      const double u = stands ? 300.0 + 200.0 * noise : 2000.0 + (moves ? 100.0 : 1.0) * noise;
      text += fmt::format("{},{},{},{},{},{},{},{}\n", t + (t > 50.0 ? gap_s : 0.0), x, x, x, u, u, u, u);
    }
    return folder.write("long.csv", text);
  }
};

TEST(Stretches, AreThoseInWhichMostMoves) {
  const TemporaryFolder folder;
  const auto found = telling_stretches(LongLog{}.write(folder));
  ASSERT_THAT(found, SizeIs(10));
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_NEAR(found[i].from_s, 100.0 * static_cast<double>(i) + 40.0, 1.5);
    EXPECT_NEAR(found[i].to_s - found[i].from_s, stretch_s, 0.2);
  }
}

TEST(Stretches, FlyWhereAnyOfThePartFlies) {
  const TemporaryFolder folder;
  const auto found = telling_stretches(LongLog{.stands_to_s = 40.0}.write(folder));
  ASSERT_THAT(found, SizeIs(10));
  for (const TimeRange& stretch : found) EXPECT_GE(std::fmod(stretch.from_s, 100.0), 39.9);
}

// hover is compared where there is neither attitude nor body rate
TEST(Stretches, AreNotMadeOfLogsThatTellNoTurning) {
  const TemporaryFolder folder;
  LongLog log;
  log.motion = 'p';
  EXPECT_THAT(telling_stretches(log.write(folder)), IsEmpty());
}

TEST(Stretches, AreNotMadeOfWhatIsShortEnough) {
  const TemporaryFolder folder;
  EXPECT_THAT(telling_stretches(LongLog{.lasts_s = most_flight_s}.write(folder)), IsEmpty());
  EXPECT_THAT(telling_stretches(LongLog{.lasts_s = most_flight_s + 1.0}.write(folder)), SizeIs(10));
  // an hour without a sample is no flight time
  EXPECT_THAT(telling_stretches(LongLog{.lasts_s = 250.0, .gap_s = 3600.0}.write(folder)), IsEmpty());
  const auto whole = read_flights(LongLog{.lasts_s = 20.0}.write(folder));
  ASSERT_THAT(whole, SizeIs(1));
  EXPECT_EQ(label_of(whole.front().path), "long.csv");
}

TEST(Stretches, AreFlightsOfTheirOwn) {
  const TemporaryFolder folder;
  const std::string path = LongLog{}.write(folder);
  const auto ranges = telling_stretches(path);
  const auto flights = read_flights(path);
  ASSERT_THAT(flights, SizeIs(10));
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(flights[i].path, fmt::format("{} ({:.0f} to {:.0f} s)", path, ranges[i].from_s, ranges[i].to_s));
    EXPECT_TRUE(is_flight_of(label_of(flights[i].path), "long.csv"));
    EXPECT_EQ(flights[i].time_s.front(), ranges[i].from_s);
    EXPECT_LT(flights[i].time_s.back(), ranges[i].to_s);
    EXPECT_EQ(flights[i].rows(), 300u);
    for (const LogColumn& column : flights[i].columns) EXPECT_THAT(column.values, SizeIs(300));
  }
  EXPECT_FALSE(is_flight_of("long.csv.gz", "long.csv"));
  // what `gustlab run` writes has one name in every folder
  EXPECT_EQ(label_of("out/fit/flight.csv (60 to 90 s)"), "fit/flight.csv (60 to 90 s)");
  EXPECT_EQ(label_of("fit/flight.csv"), "fit/flight.csv");
  EXPECT_EQ(label_of("/flight.csv"), "flight.csv");
  EXPECT_EQ(label_of("./flight.csv"), "flight.csv");
  EXPECT_EQ(label_of("out/fit/long.csv"), "long.csv");
}

TEST(Parts, AreAllRowsOnce) {
  const TemporaryFolder folder;
  const std::string path = LongLog{.lasts_s = 10.0}.write(folder);
  const std::vector<double> time_s = read_flight_log(path).time_s;
  const auto parts = parts_of(path, 34);
  ASSERT_THAT(parts, SizeIs(3));
  std::vector<double> read;
  for (const auto& part : parts) {
    const FlightLog log = read_flight_log(path, part);
    EXPECT_LE(log.rows(), 34u);
    read.insert(read.end(), log.time_s.begin(), log.time_s.end());
  }
  EXPECT_EQ(read, time_s);
}

TEST(Parts, OfAClockThatIsSetBackAreTheWholeLog) {
  const TemporaryFolder folder;
  const std::string path = LongLog{.lasts_s = 100.0, .gap_s = -20.0}.write(folder);
  ASSERT_THAT(parts_of(path, 34), ElementsAre(IsEmpty()));
}

TEST(Stretches, AreSaidByTheDiagnosis) {
  const TemporaryFolder folder;
  const std::string path = LongLog{}.write(folder);
  const Recordings read = read_recordings({path}, {}, {}, std::nullopt);
  EXPECT_THAT(read.fit, SizeIs(10));
  ASSERT_THAT(read.stretches, SizeIs(10));
  EXPECT_THAT(read.stretches, Each(Field(&Stretch::file, "long.csv")));
  EXPECT_EQ(read.stretches[3].flight, label_of(read.fit[3].path));
  EXPECT_THAT(read.remarks.notes, ElementsAre(AllOf(HasSubstr("long.csv"), HasSubstr("longer than 300 s"))));
}

TEST(Stretches, StandInTheJsonWhereThereAreAny) {
  Diagnosis said;
  EXPECT_FALSE(to_json(said).contains("stretches"));
  said.stretches = {{"long.csv (60 to 90 s)", "long.csv", 60.0, 89.9}};
  const auto stretch = to_json(said)["stretches"][0];
  EXPECT_EQ(stretch["flight"], "long.csv (60 to 90 s)");
  EXPECT_EQ(stretch["file"], "long.csv");
  EXPECT_EQ(stretch["from_s"], 60.0);
  EXPECT_EQ(stretch["to_s"], 89.9);
}

TEST(Stretches, OfAClockThatIsSetBackAreAFaultOfTheLog) {
  const TemporaryFolder folder;
  std::string path = LongLog{}.write(folder), text = read_text(path), back = text.substr(text.find('\n') + 1);
  folder.write("long.csv", text + back);
  try {
    read_flights(path);
    FAIL() << "accepted";
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), HasSubstr("time does not rise"));
  }
}

}  // namespace stretches_test
}  // namespace gustlab::diagnosis
