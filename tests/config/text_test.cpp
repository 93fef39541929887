// Quoting for TOML is undone by the TOML reader; text of others cannot command a terminal.
#include "config/text.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "config/json_text.hpp"
#include "config/toml.hpp"

namespace gustlab::config {
namespace text_test {

TEST(Text, WhatIsQuotedIsReadBackByteForByte) {
  std::string every;
  for (char c = 1; c < 127; ++c) every += c;
  for (const std::string& text :
       {std::string(), std::string("plain"), std::string("a\"b\\c\n\td"), every + "\x7f", std::string("Größe µ")}) {
    Table table = Table::parse("key = " + config::quoted(text), "test.toml");
    EXPECT_EQ(table.text("key"), text);
  }
}

TEST(Text, ControlCharactersAreShownAndNotObeyed) {
  EXPECT_EQ(printable("red \x1b[31m"), "red \\x1b[31m");
  EXPECT_EQ(printable("bell\a rub\x7fout"), "bell\\x07 rub\\x7fout");
  // U+009B, the eight-bit control sequence introducer, as UTF-8
  EXPECT_EQ(printable("\xc2\x9b"
                      "31m"),
            "\\x9b31m");
  EXPECT_EQ(printable("two\nlines, µ and Ω"), "two\nlines, µ and Ω");
  EXPECT_EQ(printable("cut short \xc2"), "cut short \\xc2");
  EXPECT_EQ(printable("\xff\xfe"), "\\xff\\xfe");
}

TEST(Text, OfAnotherEncodingBytesAreShown) {
  EXPECT_EQ(valid_utf8("caf\xe9.csv"), "caf\\xe9.csv");
  EXPECT_EQ(valid_utf8("tab\t, café, 日本, 🛩"), "tab\t, café, 日本, 🛩");
  // longer than it need be, half of a pair of UTF-16, beyond the last, cut short
  EXPECT_EQ(valid_utf8("\xc0\xaf|\xed\xa0\x80|\xf4\x90\x80\x80|\xe6\x97"),
            "\\xc0\\xaf|\\xed\\xa0\\x80|\\xf4\\x90\\x80\\x80|\\xe6\\x97");
}

TEST(Text, OfJsonIsUtf8WhateverANameIs) {
  const nlohmann::ordered_json document{{"file", "caf\xe9.csv"}, {"n\xe9", {1, "\xff", nullptr}}, {"a", "é\n"}};
  EXPECT_EQ(json_text(document), R"({"file":"caf\\xe9.csv","n\\xe9":[1,"\\xff",null],"a":"é\n"})");
  EXPECT_EQ(json_text({{"a", 1}}, 1), "{\n \"a\": 1\n}");
}

TEST(Text, OfAnEndlessWordTheBeginningIsShown) {
  const std::string path(4096, 'p'), key(120000, 'k');
  EXPECT_EQ(printable("at " + path + " now"), "at " + path + " now");
  EXPECT_EQ(printable("unknown key " + key + "\nand more"),
            "unknown key " + std::string(60, 'k') + "… (120000 characters)\nand more");
}

TEST(Text, OfThreeLettersOneMayBeWrong) {
  EXPECT_EQ(suggest("pxx", {"px", "v_x"}), "did you mean \"px\"?");
  EXPECT_EQ(suggest("rpx", {"v_x"}), "");
  EXPECT_EQ(suggest("u1", {"v7"}), "");
  EXPECT_EQ(suggest("mas", {"mass"}), "did you mean \"mass\"?");
}

TEST(Text, LowerTouchesOnlyAsciiLetters) { EXPECT_EQ(lower("AbZ-9 Ω[`{@"), "abz-9 Ω[`{@"); }

}  // namespace text_test
}  // namespace gustlab::config
