#include "config/toml.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "gustlab/errors.hpp"

namespace gustlab::config {
namespace toml_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

// the message of the ConfigError that an action throws; empty when it throws none
template <class Action>
std::string message(Action action) {
  try {
    action();
  } catch (const ConfigError& error) {
    EXPECT_EQ(error.exit_code(), 2);
    return error.what();
  }
  return {};
}

struct Sample final : Parameterized {
  double gain = 1.5;
  std::int64_t count = 3;
  bool on = true;
  std::string mode = "a \"b\"";
  std::vector<double> weights{1.0, 0.1};
  std::vector<std::string> names{"x"};
  Vector3 offset{0.0, 1e-7, -2.0};

  void visit(ParameterVisitor& v) override {
    v.number("gain", gain, {.unit = "1/s", .help = "how much", .min = 0.0, .max = 10.0});
    v.integer("count", count, {.min = 1.0});
    v.flag("on", on, {});
    v.text("mode", mode, {});
    v.numbers("weights", weights, {.min = 0.0});
    v.texts("names", names, {});
    v.vector("offset", offset, {.unit = "m"});
  }
};

TEST(Table, ReadsEveryTypeAndAnIntegerAsANumber) {
  Table table = Table::parse(
      "a = 1\nb = 2.5\nc = true\nd = 'x'\ne = [1, 2.5]\nf = ['p', 'q']\n[g]\nh = 7\n[[i]]\nj = 1\n[[i]]\nj = 2\n",
      "f.toml");
  EXPECT_EQ(table.number("a"), 1.0);
  EXPECT_EQ(table.integer("a"), 1);
  EXPECT_EQ(table.number("b"), 2.5);
  EXPECT_EQ(table.flag("c"), true);
  EXPECT_EQ(table.text("d"), "x");
  EXPECT_THAT(*table.numbers("e"), ElementsAre(1.0, 2.5));
  EXPECT_THAT(*table.texts("f"), ElementsAre("p", "q"));
  EXPECT_EQ(table.table("g")->integer("h"), 7);
  EXPECT_EQ(table.tables("i").at(1).integer("j"), 2);
  EXPECT_FALSE(table.number("absent"));
  EXPECT_EQ(message([&] { table.finish(); }), "f.toml:10:1: unknown key \"j\" (none is known here)");
  EXPECT_EQ(table.tables("i").at(0).integer("j"), 1);
  EXPECT_EQ(message([&] { table.finish(); }), "");
}

TEST(Table, KeysComeInFileOrder) {
  EXPECT_THAT(Table::parse("z = 1\na = 2\n[m]\n[b]\n", "f").keys(), ElementsAre("z", "a", "m", "b"));
}

TEST(Table, SyntaxErrorHasItsPlace) {
  EXPECT_THAT(message([] { Table::parse("a = 1\nb = = 2\n", "f.toml"); }), StartsWith("f.toml:2:5: not TOML ("));
}

TEST(Table, MissingFileIsNamed) {
  EXPECT_EQ(message([] { Table::read_file("/nonexistent/x.toml"); }),
            "/nonexistent/x.toml: cannot read (No such file or directory)");
}

TEST(Table, WrongTypeSaysWhatIsThere) {
  Table table = Table::parse("\n  gain = 'much'\nlist = [1, 'x']\n[t]\n", "f.toml");
  EXPECT_EQ(message([&] { table.number("gain"); }), "f.toml:2:10: \"gain\" must be a number (this is a string)");
  EXPECT_EQ(message([&] { table.numbers("list"); }),
            "f.toml:3:12: \"list\" must be an array of numbers (this entry is a string)");
  Table infinite = Table::parse("a = inf\nb = [1, nan]\nc = [[1, 2], [3, -inf]]\n", "f.toml");
  EXPECT_EQ(message([&] { infinite.number("a"); }), "f.toml:1:5: \"a\" must be finite");
  EXPECT_EQ(message([&] { infinite.numbers("b"); }), "f.toml:2:5: \"b\" must be finite");
  EXPECT_EQ(message([&] { infinite.number_rows("c"); }), "f.toml:3:5: \"c\" must be finite");
  EXPECT_EQ(message([&] { table.integer("t"); }), "f.toml:4:1: \"t\" must be an integer (this is a table)");
  EXPECT_EQ(message([&] { table.tables("t"); }),
            "f.toml:4:1: \"t\" must be tables, each under [[t]] (this is a table)");
  EXPECT_EQ(message([&] { table.need_text("name"); }), "f.toml:1:1: \"name\" is missing (a string is needed here)");
}

TEST(Table, UnknownKeyIsSuggested) {
  Table table = Table::parse("[body]\nmas = 1\n", "f.toml");
  Table body = *table.table("body");
  body.number("mass");
  body.number("inertia");
  EXPECT_EQ(message([&] { table.finish(); }), "f.toml:2:1: unknown key \"mas\"; did you mean \"mass\"?");
}

TEST(Table, OverridesReplaceAndAddAndSayWhereTheyCameFrom) {
  const std::string text = "step = 1\nname = 'x'\n[a.b]\nc = 1\n[[effect]]\ntype = 'gust'\nsigma = 1\n";
  Table table =
      Table::parse(text, "f.toml", {"step=2.5", "a.b.c=7", "a.b.d=[1, 2]", "name=iris", "effect.gust.sigma=0"});
  EXPECT_EQ(table.number("step"), 2.5);
  EXPECT_EQ(table.text("name"), "iris");
  Table b = *table.table("a")->table("b");
  EXPECT_EQ(b.integer("c"), 7);
  EXPECT_THAT(*b.numbers("d"), ElementsAre(1.0, 2.0));
  EXPECT_EQ(table.tables("effect")[0].number("sigma"), 0.0);
  EXPECT_EQ(message([&] { table.text("step"); }), "--set step=2.5: \"step\" must be a string (this is a number)");
  EXPECT_THAT(message([&] { Table::parse(text, "f", {"effect.gus.sigma=0"}); }), HasSubstr("did you mean \"gust\"?"));
  EXPECT_EQ(message([&] { Table::parse(text, "f", {"effect.spring.k=0"}); }),
            "--set effect.spring.k=0: there is no effect.spring to change (write [[effect]] with type = \"spring\" "
            "into the file)");
  Table none = Table::parse("a = 1\n", "f", {"effect.spring.k=0"});
  EXPECT_EQ(message([&] { none.tables("effect"); }),
            "--set effect.spring.k=0: there is no effect.spring to change (write [[effect]] with type = \"spring\" "
            "into the file)");
  EXPECT_THAT(message([&] { Table::parse(text, "f", {"oops"}); }), StartsWith("--set oops: not an override"));
  EXPECT_THAT(message([&] { Table::parse(text, "f", {"a..b=1"}); }), StartsWith("--set a..b=1: not TOML"));
  Table unknown = Table::parse("", "f", {"stp=1"});
  unknown.number("step");
  EXPECT_EQ(message([&] { unknown.finish(); }), "--set stp=1: unknown key \"stp\"; did you mean \"step\"?");
}

TEST(Table, LiteralsReadBackTheSame) {
  const std::string text =
      "a = 1\nb = 2.0\nc = 0.1\nd = \"q\\\"\\n\"\ne = [1, 'x']\nf = {g = true}\nh = 1979-05-27\ni = 1e-7\n";
  Table table = Table::parse(text, "f");
  std::string again;
  for (const std::string& key : table.keys()) again += key + " = " + *table.literal(key) + "\n";
  EXPECT_EQ(
      again,
      "a = 1\nb = 2.0\nc = 0.1\nd = \"q\\\"\\n\"\ne = [1, \"x\"]\nf = { \"g\" = true }\nh = 1979-05-27\ni = 1e-07\n");
  Table reread = Table::parse(again, "f");
  for (const std::string& key : table.keys()) EXPECT_EQ(table.literal(key), reread.literal(key));
}

TEST(Parameters, PrintedTextReadsBackTheSame) {
  Sample sample, other;
  other.gain = 0.1 + 0.2, other.mode = "", other.offset.setZero(), other.weights.clear();
  const std::string text = canonical_text(other);
  EXPECT_THAT(text, StartsWith("gain = 0.30000000000000004\ncount = 3\n"));
  Table table = Table::parse(text, "f");
  read_parameters(table, sample);
  EXPECT_EQ(canonical_text(sample), text);
  Table commented = Table::parse(commented_text(other), "f");
  EXPECT_THAT(commented_text(other), HasSubstr("gain = 0.30000000000000004  # [1/s] how much; from 0 to 10\n"));
  Sample third;
  read_parameters(commented, third);
  EXPECT_EQ(canonical_text(third), text);
}

TEST(Parameters, AbsentKeysKeepTheirDefaults) {
  Sample sample;
  const std::string before = canonical_text(sample);
  Table table = Table::parse("gain = 2", "f");
  read_parameters(table, sample);
  EXPECT_EQ(sample.gain, 2.0);
  sample.gain = 1.5;
  EXPECT_EQ(canonical_text(sample), before);
}

TEST(Parameters, RangesTypesAndUnknownKeysAreErrors) {
  const auto read = [](const char* text) {
    return message([&] {
      Sample sample;
      Table table = Table::parse(text, "f");
      read_parameters(table, sample);
    });
  };
  EXPECT_EQ(read("gain = 11"), "f:1:8: \"gain\" is out of range (11 1/s is not from 0 to 10)");
  EXPECT_EQ(read("gain = nan"), "f:1:8: \"gain\" must be finite");
  EXPECT_EQ(read("count = 0"), "f:1:9: \"count\" is out of range (0 is not at least 1)");
  EXPECT_EQ(read("count = 1.0"), "f:1:9: \"count\" must be an integer (this is a number)");
  EXPECT_EQ(read("offset = [1, 2]"), "f:1:10: \"offset\" must have three numbers (this has 2); write [x, y, z]");
  EXPECT_EQ(read("weigths = [1]"), "f:1:1: unknown key \"weigths\"; did you mean \"weights\"?");
}

TEST(Worded, JoinsProblemWhyAndSuggestionWithoutWhatIsEmpty) {
  EXPECT_EQ(worded("it is wrong", "so it is", "mend it"), "it is wrong (so it is); mend it");
  EXPECT_EQ(worded("it is wrong", "", "mend it"), "it is wrong; mend it");
  EXPECT_EQ(worded("it is wrong", "so it is", ""), "it is wrong (so it is)");
  EXPECT_EQ(worded("it is wrong", "", ""), "it is wrong");
}

TEST(Problems, AreSaidOnceEachInOneMessage) {
  Problems none, some;
  none.collect([] {});
  none.add("");
  EXPECT_NO_THROW(none.raise());
  for (const char* says : {"a", "b", "a"}) some.collect([&] { throw ConfigError(says); });
  some.add("c");
  EXPECT_EQ(message([&] { some.raise(); }), "a\nb\nc");
}

TEST(EffectSpecs, KeepTheirPlaces) {
  Table document = Table::parse("[[effect]]\ntype = 'x'\ngain = 1\ngian = 2\n", "f.toml");
  const auto specs = read_effects(document);
  ASSERT_EQ(specs.size(), 1u);
  EXPECT_EQ(specs[0].type, "x");
  EXPECT_EQ(specs[0].where, "f.toml:1:1");
  Sample sample;
  EXPECT_EQ(message([&] { read_parameters(specs[0], sample); }),
            "f.toml:4:8: unknown key \"gian\"; did you mean \"gain\"?");
}

TEST(EffectSpecs, SayWhereAnEntryIsWrong) {
  Table document = Table::parse("[[effect]]\ntype = 'x'\nnames = ['a', 2]\n", "f.toml");
  const auto specs = read_effects(document);
  Sample sample;
  EXPECT_EQ(message([&] { read_parameters(specs[0], sample); }),
            "f.toml:3:9: \"names\" must be an array of strings (this entry is an integer)");
}

// GIVEN an object that finds a parameter wrong WHEN its spec is at hand THEN the place is said, else it is left to who knows it
TEST(EffectSpecs, KnowThePlaceOfWhatAnObjectFindsWrong) {
  Table document = Table::parse("[[effect]]\ntype = 'x'\ngain = 1\n", "f.toml");
  const auto specs = read_effects(document);
  const auto said = [&](const EffectSpec& spec, const char* parameter) {
    return message([&] { at_place(spec, [&] { throw ParameterError(parameter, "is wrong"); }); });
  };
  EXPECT_EQ(said(specs[0], "gain"), "f.toml:3:8: is wrong");
  EXPECT_EQ(said(specs[0], "absent"), "f.toml:1:1: is wrong");
  EXPECT_EQ(said(EffectSpec{}, "gain"), "is wrong");
  EXPECT_THROW(at_place(EffectSpec{}, [] { throw ParameterError("gain", "is wrong"); }), ParameterError);
  EXPECT_EQ(at_place(specs[0], [] { return 3; }), 3);
}

TEST(EffectSpecs, LaterReplaceEarlierOfTheSameTypeInPlace) {
  const EffectSpec a{"a", {{"k", "1"}}, "f:1:1", {}}, b{"b", {}, "f:2:1", {}}, a2{"a", {{"k", "2"}}, "g:1:1", {}},
      c{"c", {}, "g:2:1", {}};
  const auto merged = merge_effects({a, b}, {c, a2});
  ASSERT_EQ(merged.size(), 3u);
  EXPECT_EQ(merged[0].values[0].second, "2");
  EXPECT_EQ(merged[1].type, "b");
  EXPECT_EQ(merged[2].type, "c");
  EXPECT_EQ(message([&] {
              merge_effects({}, {a, a2});
            }),
            "g:1:1: effect \"a\" is here twice (first at f:1:1); keep one");
}

TEST(EffectSpecs, RotorLossIsOnePerRotor) {
  const EffectSpec one{"rotor_loss", {{"rotor", "1"}}, "f:1:1", {}}, two{"rotor_loss", {{"rotor", "2"}}, "f:2:1", {}};
  EXPECT_EQ(merge_effects({one}, {two}).size(), 2u);
  EXPECT_THAT(message([&] { merge_effects({one, one}, {}); }), HasSubstr("\"rotor_loss of rotor 1\" is here twice"));
}

TEST(Suggest, FindsTheNearestNameOrNone) {
  const std::vector<std::string> known{"rotor_drag", "quadratic_drag", "mass", "gust"};
  EXPECT_EQ(suggest("rotor_darg", known), "did you mean \"rotor_drag\"?");
  EXPECT_EQ(suggest("masss", known), "did you mean \"mass\"?");
  EXPECT_EQ(suggest("quad", known), "did you mean \"quadratic_drag\"?");
  EXPECT_EQ(suggest("zebra", known), "");
  EXPECT_EQ(suggest("", known), "");
}

TEST(Shortest, ReadsBackTheSameDouble) {
  for (const double value : {0.1, 1.0 / 3.0, 1e-300, -5.0, 1.7965e-8, 0.30000000000000004})
    EXPECT_EQ(std::stod(shortest(value)), value);
  EXPECT_EQ(shortest(5.0), "5");
}

}  // namespace toml_test
}  // namespace gustlab::config
