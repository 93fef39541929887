// A CSV of numbers, and where its faults stand.
#include "flight_log/csv.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>

#include "flight_log/columns.hpp"
#include "gustlab/errors.hpp"
#include "support/temporary_folder.hpp"

namespace gustlab {
namespace csv_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::IsNan;

bool strict(std::string_view) { return false; }
bool notes(std::string_view name) { return name == "note"; }

CsvNumbers read(const std::string& text, bool (*lenient)(std::string_view) = strict) {
  const TemporaryFolder folder;
  return {folder.write("log.csv", text), lenient};
}

// what it says of a fault, from the file's name on
std::string fault(const std::string& text) {
  try {
    read(text);
  } catch (const DataError& error) {
    EXPECT_EQ(error.exit_code(), 3);
    const std::string what = error.what();
    return what.substr(what.find("log.csv"));
  }
  return "accepted";
}

TEST(Csv, ReadsNumbersHoweverTheyAreWritten) {
  const CsvNumbers csv = read("\xEF\xBB\xBF a ,b\r\n+1, 2e3\t\r\n\r\n , -.5\n4,5");
  EXPECT_THAT(csv.names(), ElementsAre("a", "b"));
  ASSERT_EQ(csv.rows(), 3u);
  EXPECT_EQ(csv.column(0)[0], 1.0);
  EXPECT_TRUE(std::isnan(csv.column(0)[1]));
  EXPECT_THAT(csv.column(1), ElementsAre(2000.0, -0.5, 5.0));
}

TEST(Csv, SaysWhereAFaultStands) {
  EXPECT_THAT(fault(""), HasSubstr("log.csv:1:1: the file is empty"));
  EXPECT_THAT(fault("a,,c\n"), HasSubstr("log.csv:1:3: a column has no name"));
  EXPECT_THAT(fault("\xEF\xBB\xBF a;b\r\n1;2\r\n"),
              HasSubstr("log.csv:1:3: not comma-separated (semicolons stand between its columns); write commas there"));
  EXPECT_THAT(fault("a\tb\n1\t2\n"), HasSubstr("log.csv:1:2: not comma-separated (tabs stand between its columns)"));
  EXPECT_THAT(fault("a,b,a\n"), HasSubstr("log.csv:1:5: column \"a\" is here twice"));
  EXPECT_THAT(fault("a,b\n1,2\n\n3,x1\n"), HasSubstr("log.csv:4:3: \"x1\" in column b is not a number"));
  EXPECT_THAT(fault(std::string("a,b\n1,0\0001\n", 10)),
              HasSubstr("log.csv:2:3: \"0\\x001\" in column b is not a number"));
  EXPECT_THAT(fault("a,b\n1,inf\n"), HasSubstr("log.csv:2:3: \"inf\" in column b is not a finite number"));
  EXPECT_THAT(fault("a,b\n1,2,3\n"), HasSubstr("log.csv:2:5: this row has more cells than the header's 2"));
  EXPECT_THAT(fault("a,b,c\n1,2\n"), HasSubstr("log.csv:2:4: this row has 2 cells, the header 3"));
  EXPECT_THROW(CsvNumbers("/nowhere/log.csv", strict), DataError);
}

TEST(Csv, LetsTextPassWhereItMay) {
  const CsvNumbers csv = read("a,note\n1,landed\n2,3\n", notes);
  EXPECT_TRUE(std::isnan(csv.column(1)[0]));
  EXPECT_EQ(csv.column(1)[1], 3.0);
}

TEST(Csv, KnowsItsRowsAfterSomeWent) {
  const TemporaryFolder folder;
  CsvNumbers csv(folder.write("log.csv", "a,bb\n1,\n\n1,\n2,3\n"), strict);
  EXPECT_TRUE(csv.same(0, 1));
  EXPECT_FALSE(csv.same(0, 2));
  csv.keep({true, false, true});
  ASSERT_EQ(csv.rows(), 2u);
  EXPECT_THAT(csv.column(0), ElementsAre(1.0, 2.0));
  EXPECT_THAT(csv.where(1, 1), HasSubstr("log.csv:5:3"));
  EXPECT_THAT(csv.where_row(1), HasSubstr("log.csv:5"));
  EXPECT_THAT(csv.where_name(1), HasSubstr("log.csv:1:3"));
}

// longer than what is read at once
std::string many_rows(int count) {
  std::string text = "time_s,a,note\n";
  for (int i = 0; i < count; ++i) text += fmt::format("{},{},row {}\n", 0.5 * i, i, i);
  return text;
}

TEST(Csv, ReadsOnlyTheRowsOfSomeTimes) {
  const TemporaryFolder folder;
  const std::string path = folder.write("log.csv", many_rows(50000));
  const CsvNumbers csv(path, notes, {{1.0, 2.0}, {20000.0, 20001.0}});
  EXPECT_THAT(csv.column(1), ElementsAre(2.0, 3.0, 40000.0, 40001.0));
  EXPECT_THAT(csv.where(3, 2), HasSubstr("log.csv:40003:15"));
  EXPECT_EQ(CsvNumbers(path, notes).rows(), 50000u);
  // a fault in other rows is none
  folder.write("log.csv", "time_s,a\n0,x\n1,2\n");
  EXPECT_THAT(CsvNumbers(path, strict, {{1.0, 2.0}}).column(1), ElementsAre(2.0));
}

TEST(Csv, ReadsALineThatIsLongerThanABlock) {
  const CsvNumbers csv = read("a,note\n1," + std::string(300000, 'x') + "\n2,3", notes);
  EXPECT_THAT(csv.column(0), ElementsAre(1.0, 2.0));
  EXPECT_THAT(csv.column(1)[1], 3.0);
}

TEST(Csv, HandsItsRowsOverOneAfterTheOther) {
  const TemporaryFolder folder;
  std::vector<double> a;
  const auto keep = [&](const std::vector<double>& cells) {
    EXPECT_EQ(cells.size(), 2u);
    EXPECT_TRUE(std::isnan(cells[0]));
    a.push_back(cells[1]);
  };
  for_each_row(folder.write("log.csv", many_rows(50000)), {"not there", "a"}, keep);
  ASSERT_EQ(a.size(), 50000u);
  EXPECT_EQ(a[49999], 49999.0);
  // what is no number, a row that ends early, and an empty line, which is no row
  a.clear();
  for_each_row(folder.write("other.csv", "b,a\n1,x\n\n1\n1, 4 ,9\n"), {"not there", "a"}, keep);
  EXPECT_THAT(a, ElementsAre(IsNan(), IsNan(), 4.0));
}

TEST(Columns, HaveANameAndALargestValue) {
  for (const char* name : {"time_s", "px", "rvz", "qw", "wx", "vbat", "u1", "u8", "rotor8", "ryaw"})
    EXPECT_TRUE(is_known_column(name)) << name;
  for (const char* name : {"", "u", "u0", "u9", "u11", "rotor", "p", "Time_s", "rotors1"})
    EXPECT_FALSE(is_known_column(name)) << name;
  // rpm and deg/s of anything that flies are no fault, a time stamp in nanoseconds is
  EXPECT_GT(*most_of_column("rotor1"), 1e5);
  EXPECT_GT(*most_of_column("wx"), 1e4);
  EXPECT_LT(*most_of_column("time_s"), 1e18);
  EXPECT_FALSE(most_of_column("temperature"));
}

TEST(Columns, AreSuggestedAmongThoseWithoutAMeaning) {
  EXPECT_THAT(suggest_column("time_s", {"time", "px"}), HasSubstr("\"time\""));
  // what has a meaning of its own is not meant
  EXPECT_THAT(suggest_column("px", {"py", "pz"}), IsEmpty());
}

}  // namespace csv_test
}  // namespace gustlab
