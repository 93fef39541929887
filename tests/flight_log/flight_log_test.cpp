#include "gustlab/flight_log.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "gustlab/errors.hpp"
#include "support/temporary_folder.hpp"

namespace gustlab {
namespace flight_log_test {

using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::NanSensitiveDoubleEq;
using ::testing::Pointwise;
using ::testing::StartsWith;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

const char* const meta_text = "format = \"gustlab-flight/1\"\nvehicle = \"crazyflie\"\nactuator = \"rotor_speed\"\n";
const char* const header = "time_s,px,py,pz,u1,u2,u3,u4\n";

// writes both files and reads them; the message when that throws, without the folder
struct Files {
  TemporaryFolder folder;
  FlightLog log;

  std::string read(const std::string& csv, const std::string& meta = meta_text) {
    folder.write("a.meta.toml", meta);
    const std::string path = folder.write("a.csv", csv);
    try {
      log = read_flight_log(path);
    } catch (const DataError& error) {
      EXPECT_EQ(error.exit_code(), 3);
      return std::string(error.what()).substr(folder.path().string().size() + 1);
    }
    return {};
  }
};
std::string said(const std::string& csv, const std::string& meta = meta_text) { return Files().read(csv, meta); }

// a vehicle that turns about changing axes; the quaternion's order and direction and the rate's unit can be wrong
// attitude in every fifth row and the rate in the odd ones, where each has a clock of its own
std::string turning(bool scalar_last, bool world_to_body, double rate_scale, bool own_clocks = false) {
  std::string csv = "time_s,qw,qx,qy,qz,wx,wy,wz,u1,u2,u3,u4\n";
  Quaternion q(0.9, 0.3, -0.2, 0.1);
  q.normalize();
  for (int i = 0; i < 1000; ++i) {
    const double t = 0.01 * i;
    const Vector3 rate(2.0 * std::sin(3.0 * t), 1.5 * std::cos(2.0 * t), 1.0);
    const Quaternion p = world_to_body ? q.conjugate() : q;
    const double c[4] = {p.w(), p.x(), p.y(), p.z()};
    csv += std::to_string(t);
    const bool has_attitude = !own_clocks || i % 5 == 0, has_rate = !own_clocks || i % 2 == 1;
    for (int k = 0; k < 4; ++k) csv += has_attitude ? "," + std::to_string(c[scalar_last ? (k + 1) % 4 : k]) : ",";
    for (int k = 0; k < 3; ++k) csv += has_rate ? "," + std::to_string(rate_scale * rate[k]) : ",";
    csv += ",1,1,1,1\n";
    const Vector3 half = 0.005 * rate;
    q = q * Quaternion(1.0, half.x(), half.y(), half.z()).normalized();
  }
  return csv;
}

TEST(FlightLog, ReadsColumnsMissingSamplesAndMeta) {
  Files files;
  EXPECT_EQ(
      files.read("time_s,px,py,pz,u1,u2,u3,u4\r\n0,1,+2,-3e-1,1,2,3,4\r\n\r\n 0.5 ,, ,4,5,6,7,8",
                 std::string(meta_text) + "hold = \"zoh\"\n[environment]\nground_z_m = 0\nwalls = [[1, 2, 0, -2]]\n"
                                          "[condition]\nwind_mps = 3.0\n[origin]\nfile = \"x.bin\"\n"),
      "");
  EXPECT_THAT(files.log.time_s, ElementsAre(0.0, 0.5));
  EXPECT_THAT(*files.log.find("py"), ElementsAre(2.0, ::testing::IsNan()));
  EXPECT_EQ(files.log.count("u"), 4);
  EXPECT_EQ(files.log.count("rotor"), 0);
  EXPECT_FALSE(files.log.has("vx"));
  EXPECT_EQ(files.log.meta.hold, Hold::zoh);
  EXPECT_EQ(files.log.meta.environment.ground_z_m, 0.0);
  EXPECT_FALSE(files.log.meta.environment.ceiling_z_m);
  EXPECT_EQ(files.log.meta.environment.walls.at(0).normal_W, Vector3(0.0, -1.0, 0.0));
  EXPECT_EQ(files.log.meta.condition.at(0), std::make_pair(std::string("wind_mps"), std::string("3.0")));
  EXPECT_EQ(files.log.meta.origin.at(0).second, "\"x.bin\"");
  EXPECT_THAT(files.log.repairs, IsEmpty());
}

TEST(FlightLog, RotorColumnsAreNumbered) {
  for (const char* name : {"u1", "u12", "rotor3"}) EXPECT_TRUE(is_rotor_column(name)) << name;
  for (const char* name : {"u", "ux", "u1x", "rotor", "px", "vbat", ""}) EXPECT_FALSE(is_rotor_column(name)) << name;
}

TEST(FlightLog, WrittenLogReadsBackTheSamePlainAndCompressed) {
  FlightLog log;
  log.meta.vehicle = "crazyflie";
  log.meta.source = "simulation";
  log.meta.hold = Hold::zoh;
  log.meta.notes = "a \"note\"\n";
  log.meta.environment.ground_z_m = 0.1;
  log.meta.environment.walls.push_back({Vector3(1.0, 2.0, 0.0), Vector3(0.6, 0.8, 0.0)});
  log.meta.condition = {{"wind_mps", "3.0"}, {"odd key", "[1, 2]"}};
  const double values[] = {1.0 / 3.0, -1e-300, 5e-324, 0.1, 123456.789, 1e5};
  for (const char* name : {"px", "py", "pz", "u1", "rotor1"}) log.columns.push_back({name, {}});
  for (int i = 0; i < 6; ++i) {
    log.time_s.push_back(0.002 * i);
    for (LogColumn& column : log.columns)
      column.values.push_back(i == 2 ? nan : values[i] / static_cast<double>(column.name.size()));
  }
  TemporaryFolder folder;
  for (const char* name : {"b.csv", "b.csv.gz"}) {
    write_flight_log(log, folder.file(name));
    const std::string bytes = read_text(folder.file(name)), meta = read_text(folder.file("b.meta.toml"));
    const FlightLog again = read_flight_log(folder.file(name));
    EXPECT_EQ(again.time_s, log.time_s);
    ASSERT_EQ(again.columns.size(), log.columns.size());
    for (std::size_t c = 0; c < log.columns.size(); ++c)
      for (std::size_t row = 0; row < log.rows(); ++row)
        if (row == 2) EXPECT_TRUE(std::isnan(again.columns[c].values[row]));
        else EXPECT_EQ(again.columns[c].values[row], log.columns[c].values[row]);
    EXPECT_EQ(again.meta.notes, log.meta.notes);
    EXPECT_EQ(again.meta.condition, log.meta.condition);
    write_flight_log(again, folder.file(name));
    EXPECT_EQ(read_text(folder.file(name)), bytes);
    EXPECT_EQ(read_text(folder.file("b.meta.toml")), meta);
  }
  EXPECT_FALSE(std::filesystem::exists(folder.file("b.csv.part")));
}

TEST(FlightLog, APlaceThatIsNotThereIsAWrongPath) {
  FlightLog log;
  EXPECT_THROW(write_flight_log(log, "/nonexistent/a.csv"), ConfigError);
  EXPECT_THROW(write_flight_log(log, "a.txt"), DataError);
}

TEST(FlightLog, RepairsWhatNeedsNoGuessAndSaysIt) {
  Files files;
  EXPECT_EQ(files.read("time_s,qw,qx,qy,qz,px,py,pz,u1,mood\n0,1,0,0,0,1,1,1,9,good\n0,1,0,0,0,1,1,1,9,good\n"
                       "1,1.01,0,0,0,1,1,1,9,bad\n"),
            "");
  EXPECT_EQ(files.log.rows(), 2u);
  EXPECT_EQ((*files.log.find("qw"))[1], 1.0);
  ASSERT_EQ(files.log.repairs.size(), 3u);
  EXPECT_THAT(files.log.repairs[0].says, EndsWith("a.csv:3: 1 rows repeat the one before and are dropped"));
  EXPECT_THAT(files.log.repairs[1].says,
              EndsWith("a.csv:4:3: 1 quaternions are off norm by up to 0.01 and are normalised"));
  EXPECT_THAT(files.log.repairs[2].says, EndsWith("a.csv:1: unknown columns are ignored: mood"));
  EXPECT_TRUE(std::isnan(files.log.find("mood")->at(0)));
}

TEST(FlightLog, TelemetryInASimulatedLogIsNoFinding) {
  const std::string csv = "time_s,px,py,pz,u1,mood\n0,1,1,1,9,2\n1,1,1,1,9,3\n";
  Files files;
  EXPECT_EQ(files.read(csv, std::string(meta_text) + "source = \"simulation\"\n"), "");
  EXPECT_THAT(files.log.repairs, IsEmpty());
  EXPECT_EQ(files.read(csv), "");
  EXPECT_EQ(files.log.repairs.size(), 1u);
}

TEST(FlightLog, WhatIsNoTextIsNotShown) {
  EXPECT_THAT(said(std::string("\xbc\x02\x00time\n1,2\n", 13)),
              EndsWith("a.csv:1:2: not a text file (a CSV is needed)"));
  const std::string shown = said(std::string(header) + "0," + std::string(500, 'x') + ",2,3,4,5,6,7\n");
  EXPECT_THAT(shown, HasSubstr(":2:3: \"" + std::string(40, 'x') + "\" in column px"));
}

TEST(FlightLog, FolderOfARunNamesTheLogInIt) {
  TemporaryFolder folder;
  const auto message = [&] {
    try {
      read_flight_log(folder.path().string());
    } catch (const DataError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(message(), EndsWith("(its name must end with .csv or .csv.gz)"));
  folder.write("flight.csv", header);
  EXPECT_THAT(message(), EndsWith("did you mean \"" + folder.file("flight.csv") + "\"?"));
}

TEST(FlightLog, BadCellsAreNamedWithLineAndColumn) {
  const std::string h = header;
  EXPECT_THAT(said(h + "0,1,2,3,4,5,6,7\n1,1,x,3,4,5,6,7\n"),
              StartsWith("a.csv:3:5: \"x\" in column py is not a number"));
  EXPECT_THAT(said(h + "0,1,2,nan,4,5,6,7\n"), StartsWith("a.csv:2:7: \"nan\" in column pz is not a finite number"));
  EXPECT_THAT(said(h + "0,1,2,inf,4,5,6,7\n"), StartsWith("a.csv:2:7: \"inf\" in column pz is not a finite number"));
  EXPECT_THAT(said(h + "0,1,2,3,4,5,6\n"), StartsWith("a.csv:2:14: this row has 7 cells, the header 8"));
  EXPECT_THAT(said(h + "0,1,2,3,4,5,6,7,8\n"), StartsWith("a.csv:2:17: this row has more cells than the header's 8"));
  EXPECT_THAT(said("time_s,px,,pz\n"), StartsWith("a.csv:1:11: a column has no name"));
  EXPECT_THAT(said("time_s,px,px\n"), StartsWith("a.csv:1:11: column \"px\" is here twice"));
}

TEST(FlightLog, TimeMustRise) {
  const std::string h = header;
  EXPECT_THAT(said(h + "0,1,2,3,4,5,6,7\n2,1,2,3,4,5,6,7\n1,1,2,3,4,5,6,7\n"),
              StartsWith("a.csv:4:1: time does not rise (1 s after 2 s)"));
  EXPECT_THAT(said(h + "0,1,2,3,4,5,6,7\n0,1,2,3,4,5,6,8\n"), StartsWith("a.csv:3:1: time does not rise"));
  EXPECT_THAT(said(h + "0,1,2,3,4,5,6,7\n,1,2,3,4,5,6,8\n"), StartsWith("a.csv:3:1: this sample has no time"));
}

TEST(FlightLog, RequiredColumnsAreAskedFor) {
  EXPECT_THAT(said("px,py,pz,u1\n1,1,1,1\n2,2,2,2\n"), HasSubstr("\"time_s\" is missing"));
  EXPECT_THAT(said("time_s,px,py,pz\n1,1,1,1\n2,2,2,2\n"), HasSubstr("there is no actuator input"));
  EXPECT_THAT(said("time_s,px,py,pz,u1,u3\n1,1,1,1,1,1\n2,2,2,2,2,2\n"),
              StartsWith("a.csv:1:20: column \"u3\" is here and \"u2\" is not"));
  EXPECT_THAT(said("time_s,px,py,u1\n1,1,1,1\n2,2,2,2\n"), HasSubstr("nothing tells the motion"));
  EXPECT_THAT(said("time_s,px,py,pz,u1\n1,,,,1\n2,,,,2\n"), HasSubstr("nothing tells the motion"));
  EXPECT_THAT(said(header), HasSubstr("the log is empty (0 samples)"));
  EXPECT_THAT(said("time_s,wx,wy,wz,rotor1\n0,1,1,1,1\n"),
              HasSubstr("a.csv: the log has one sample (two or more are needed)"));
  EXPECT_THAT(said(""), HasSubstr("the file is empty"));
  EXPECT_EQ(said("time_s,wx,wy,wz,rotor1\n0,1,1,1,1\n1,2,2,2,2\n"), "");
}

TEST(FlightLog, QuaternionNormBeyondRepairIsAnError) {
  EXPECT_THAT(said("time_s,qw,qx,qy,qz,px,py,pz,u1\n0,1,0,0,0,1,1,1,9\n1,1.03,0,0,0,1,1,1,9\n"),
              StartsWith("a.csv:3:3: the quaternion's norm is 1.03"));
}

TEST(FlightLog, AttitudeThatContradictsTheBodyRateIsAnErrorThatNamesTheConvention) {
  EXPECT_EQ(said(turning(false, false, 1.0)), "");
  EXPECT_THAT(said(turning(true, false, 1.0)), EndsWith("turn differently); the quaternion looks scalar-last"));
  EXPECT_THAT(said(turning(false, true, 1.0)), EndsWith("the quaternion looks world-to-body"));
  EXPECT_THAT(said(turning(true, true, 1.0)), EndsWith("the quaternion looks scalar-last and world-to-body"));
  EXPECT_THAT(said(turning(false, false, 180.0 / pi)), EndsWith("the body rate looks like degrees per second"));
  EXPECT_THAT(said(turning(false, false, -1.0)), StartsWith("a.csv:2:10: the attitude contradicts the body rate"));
}

TEST(FlightLog, StepsOfNextToNothingAreRead) {
  std::string csv = "time_s,qw,qx,qy,qz,wx,wy,wz,u1\n";
  for (int i = 0; i < 50; ++i) csv += std::to_string(i) + "e-300,1,0,0,0,0,0,0,1\n";
  EXPECT_EQ(said(csv), "");
}

TEST(FlightLog, ASlowAttitudeIsComparedWithTheRateBetweenItsSamples) {
  EXPECT_EQ(said(turning(false, false, 1.0, true)), "");
  EXPECT_THAT(said(turning(true, false, 1.0, true)), EndsWith("turn differently); the quaternion looks scalar-last"));
  EXPECT_THAT(said(turning(false, true, 1.0, true)), EndsWith("the quaternion looks world-to-body"));
  EXPECT_THAT(said(turning(false, false, 180.0 / pi, true)), EndsWith("the body rate looks like degrees per second"));
  // the first attitude has no rate before it
  EXPECT_THAT(said(turning(false, false, -1.0, true)),
              StartsWith("a.csv:22:10: the attitude contradicts the body rate"));
}

// what is read in parts of so many rows: all of it, or the message, without the folder
std::string in_parts(const std::string& csv, std::size_t most_rows, FlightLog& log) {
  const TemporaryFolder folder;
  folder.write("a.meta.toml", meta_text);
  const std::string path = folder.write("a.csv", csv);
  try {
    read_flight_log_in_parts(
        path,
        [&](const FlightLog& part) {
          EXPECT_LE(part.rows(), most_rows);
          log.time_s.insert(log.time_s.end(), part.time_s.begin(), part.time_s.end());
          log.columns.resize(part.columns.size());
          for (std::size_t c = 0; c < part.columns.size(); ++c) {
            const std::vector<double>& values = part.columns[c].values;
            log.columns[c].name = part.columns[c].name;
            log.columns[c].values.insert(log.columns[c].values.end(), values.begin(), values.end());
          }
          log.repairs = part.repairs;
        },
        most_rows);
  } catch (const DataError& error) {
    return std::string(error.what()).substr(folder.path().string().size() + 1);
  }
  return {};
}

TEST(FlightLog, IsTheSameInPartsOfAnyNumberOfRows) {
  const std::string h = header;
  const std::string logs[] = {
      h + "0,1,2,3,4,5,6,7\n1,,,,4,5,6,7\n2,1,2,3,4,5,6,7\n",
      // motion in the first row or in the last, repeated rows, quaternions off norm
      h + "0,1,2,3,4,5,6,7\n1,,,,4,5,6,7\n2,,,,4,5,6,7\n3,,,,4,5,6,7\n",
      h + "0,,,,4,5,6,7\n1,,,,4,5,6,7\n2,,,,4,5,6,7\n3,1,2,3,4,5,6,7\n",
      h + "0,1,,3,4,5,6,7\n0,1,,3,4,5,6,7\n0,1,,3,4,5,6,7\n1,1,2,3,4,5,6,7\n1,1,2,3,4,5,6,7\n",
      "time_s,qw,qx,qy,qz,px,py,pz,u1,mood\n0,1,0,0,0,1,1,1,9,a\n1,1.01,0,0,0,1,1,1,9,b\n2,0,1.015,0,0,1,1,1,9,c\n",
      turning(false, false, 1.0), turning(false, false, 1.0, true),
      // what is wrong with a row, with two, with all
      h + "0,1,2,3,4,5,6,7\n1,1,2,1e300,4,5,6,7\n", h + "0,1,2,3,4,5,6,7\n1,1,2,3,4,5,6,7\n1,1,2,3,4,5,6,8\n",
      h + "0,1,2,3,4,5,6,7\n,1,2,3,4,5,6,8\n", h + "0,1,2,3,4,5,6,7\n", h, "", h + "0,,,,4,5,6,7\n1,,2,,4,5,6,7\n",
      turning(true, false, 1.0), turning(false, false, -1.0)};
  for (const std::string& csv : logs) {
    SCOPED_TRACE(csv.substr(0, 200));
    Files whole;
    const std::string message = whole.read(csv);
    for (const std::size_t most_rows : {1, 2, 3, 4, 5, 300, 1000}) {
      if (csv.size() > 1000 && most_rows < 300) continue;  // a window of the attitude lies within a part
      SCOPED_TRACE(most_rows);
      FlightLog log;
      EXPECT_EQ(in_parts(csv, most_rows, log), message);
      if (!message.empty()) continue;
      EXPECT_EQ(log.time_s, whole.log.time_s);
      ASSERT_EQ(log.columns.size(), whole.log.columns.size());
      for (std::size_t c = 0; c < log.columns.size(); ++c) {
        EXPECT_EQ(log.columns[c].name, whole.log.columns[c].name);
        EXPECT_THAT(log.columns[c].values, Pointwise(NanSensitiveDoubleEq(), whole.log.columns[c].values));
      }
      ASSERT_EQ(log.repairs.size(), whole.log.repairs.size());
      for (std::size_t i = 0; i < log.repairs.size(); ++i)
        EXPECT_EQ(log.repairs[i].says.substr(log.repairs[i].says.find("a.csv")),
                  whole.log.repairs[i].says.substr(whole.log.repairs[i].says.find("a.csv")));
    }
  }
}

TEST(FlightLog, SidecarErrorsAreDataErrorsWithTheirPlace) {
  const std::string csv = std::string(header) + "0,1,2,3,4,5,6,7\n1,1,2,3,4,5,6,7\n";
  const std::string meta = meta_text;
  EXPECT_THAT(said(csv, "format = \"x\"\n"), StartsWith("a.meta.toml:1:10: format \"x\" is not a flight log's"));
  EXPECT_THAT(said(csv, "format = \"gustlab-flight/1\"\nactuator = \"rotor_sped\"\n"),
              EndsWith("did you mean \"rotor_speed\"?"));
  EXPECT_THAT(said(csv, meta + "hold = \"cubic\"\n"),
              StartsWith("a.meta.toml:4:8: \"cubic\" is not one of unknown, zoh, linear"));
  EXPECT_THAT(said(csv, meta + "hould = \"zoh\"\n"), EndsWith("unknown key \"hould\"; did you mean \"hold\"?"));
  EXPECT_THAT(said(csv, meta + "[environment]\nwalls = [[1, 2, 0, 0]]\n"),
              StartsWith("a.meta.toml:5:9: a wall is a point"));
  EXPECT_THAT(said(csv, meta + "[environment]\nwalls = [1]\n"), HasSubstr("must be an array of arrays of numbers"));
  EXPECT_THAT(said(csv, "format = "), StartsWith("a.meta.toml:1:10: not TOML"));
}

TEST(FlightLog, MissingAndDamagedFilesAreDataErrors) {
  TemporaryFolder folder;
  const auto message = [&](const std::string& name) {
    try {
      read_flight_log(folder.file(name));
    } catch (const DataError& error) {
      return std::string(error.what()).substr(folder.path().string().size() + 1);
    }
    return std::string();
  };
  EXPECT_THAT(message("a.txt"), StartsWith("a.txt: not a flight log"));
  EXPECT_THAT(message("a.csv"), StartsWith("a.csv: cannot read (No such file or directory)"));
  folder.write("a.csv", "");
  EXPECT_THAT(message("a.csv"),
              StartsWith("a.meta.toml: cannot read (No such file or directory); a log needs its sidecar"));
  folder.write("a.meta.toml", meta_text);
  FlightLog log;
  log.columns = {{"px", {}}, {"py", {}}, {"pz", {}}, {"u1", {}}};
  for (int i = 0; i < 1000; ++i) {
    log.time_s.push_back(i);
    for (LogColumn& column : log.columns) column.values.push_back(std::sin(i));
  }
  write_flight_log(log, folder.file("a.csv.gz"));
  const std::string bytes = read_text(folder.file("a.csv.gz"));
  folder.write("a.csv.gz", bytes.substr(0, bytes.size() / 2));
  EXPECT_THAT(message("a.csv.gz"), StartsWith("a.csv.gz: cannot read ("));
}

}  // namespace flight_log_test
}  // namespace gustlab
