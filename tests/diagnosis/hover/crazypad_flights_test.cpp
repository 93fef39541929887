// CrazyPAD: two vehicles with labelled defects, no pitch and no gyroscope (docs/DATA.md).
#include <gmock/gmock.h>

#include "diagnosis/diagnose.hpp"
#include "support/flights.hpp"
#include "support/program.hpp"
#include "support/temporary_folder.hpp"

namespace gustlab::diagnosis {
namespace crazypad_flights_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

class CrazyPad : public ::testing::Test {
 protected:
  void import(const std::filesystem::path& flights) {
    std::vector<std::string> command{
        test::python_program(), (std::filesystem::path(source_directory()) / "scripts" / "import_log.py").string()};
    for (const auto& file : std::filesystem::recursive_directory_iterator(flights / "crazypad"))
      if (file.path().filename().string().starts_with("E")) command.push_back(file.path().string());
    std::sort(command.begin() + 2, command.end());
    command.insert(command.end(), {"--map", "crazypad", "--out", folder_.path().string()});
    const test::Said said = test::run_program(command);
    ASSERT_EQ(said.exit_code, 0) << said.err;
  }
  std::string log(const char* condition, const char* flight) const {
    return folder_.file(std::string(condition) + "-" + flight + "_1.csv");
  }
  static Diagnosis against(const std::string& reference, const std::string& flight) {
    DiagnoseOptions options;
    options.fit = {flight};
    options.reference = {reference};
    return diagnose(options);
  }
  TemporaryFolder folder_;
};

constexpr const char *normal = "normal_flight", *cut = "cut_propeller_M3_3mm_3mm_41mm",
                     *weight = "add_weight_W3_near_M3";

TEST_F(CrazyPad, NamesTheDefectAgainstEachNormalFlightAndNothingElse) {
  GUSTLAB_FLIGHTS_OR_SKIP(flights);
  import(flights);
  for (const char* reference : {"E8_log00", "E8_log01"})
    for (const char* flight : {"E8_log00", "E8_log01"}) {
      const Diagnosis d = against(log(normal, reference), log(cut, flight));
      ASSERT_EQ(d.effects.size(), 1u);
      EXPECT_THAT(d.effects[0].classmates, ElementsAre("rotor_loss"));
      EXPECT_EQ(d.effects[0].parameters[0].value, 3.0);
    }
  for (const char* reference : {"E9_log00", "E9_log03"})
    for (const char* flight : {"E9_log00", "E9_log02"}) {
      const Diagnosis d = against(log(normal, reference), log(weight, flight));
      ASSERT_EQ(d.effects.size(), 1u);
      EXPECT_THAT(d.effects[0].classmates, ElementsAre("center_of_mass", "rotor_loss"));
      // M3 is behind and to the left
      EXPECT_LT(d.effects[0].parameters[0].value, -0.002);
      EXPECT_GT(d.effects[0].parameters[1].value, 0.002);
    }
  const std::vector<const char*> normals = {"E8_log00", "E8_log01", "E9_log00", "E9_log03"};
  for (const char* reference : normals)
    for (const char* flight : normals) {
      if (reference == flight) continue;
      EXPECT_THAT(against(log(normal, reference), log(normal, flight)).effects, IsEmpty())
          << flight << " against " << reference;
    }
}

TEST_F(CrazyPad, NamesNothingFromDefectFlightsAlone) {
  GUSTLAB_FLIGHTS_OR_SKIP(flights);
  import(flights);
  for (const auto& both : {std::vector{log(cut, "E8_log00"), log(cut, "E8_log01")},
                           std::vector{log(weight, "E9_log00"), log(weight, "E9_log02")}})
    for (const auto& some : {both, std::vector{both[0]}, std::vector{both[1]}}) {
      DiagnoseOptions options;
      options.fit = some;
      const Diagnosis d = diagnose(options);
      EXPECT_THAT(d.effects, IsEmpty());
      EXPECT_EQ(d.verdict, Verdict::insufficient_data);
    }
}

}  // namespace crazypad_flights_test
}  // namespace gustlab::diagnosis
