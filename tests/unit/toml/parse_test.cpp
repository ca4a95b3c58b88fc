#include "host/toml/parse.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/errors/error.hpp"

namespace umov {
namespace {

TEST(TomlText, LettersOutsideAsciiStandInTextsAndComments) {
  const toml::table table = parse_toml(
      "\xef\xbb\xbf"
      "a = 'é'\n\"b é\" = \"\"\"x é\"\"\"\"\"\nc = ['ü', \"\\u00e9\"]\n'd'.e = '''\n'q'é'''\n"
      "f = {g='é'} # é\n[\"h é\".i]\nj = \"\"\"one \\\n   two é\"\"\"#é\nk = ''''a''''\n",
      "x.toml", "remedy");
  EXPECT_EQ(table["a"].value_or(""), std::string("é"));
  EXPECT_EQ(table["b é"].value_or(""), std::string("x é\"\""));
  EXPECT_EQ(table["c"][1].value_or(""), std::string("é"));
  EXPECT_EQ(table["d"]["e"].value_or(""), std::string("'q'é"));
  EXPECT_EQ(table["f"]["g"].value_or(""), std::string("é"));
  EXPECT_EQ(table["h é"]["i"]["j"].value_or(""), std::string("one two é"));
  EXPECT_EQ(table["h é"]["i"]["k"].value_or(""), std::string("'a'"));
}

struct Refusal {
  const char* text;
  std::size_t line;
  const char* column;
  const char* problem;
};

class TomlRefusal : public ::testing::TestWithParam<Refusal> {};

TEST_P(TomlRefusal, NamesThePlace) {
  const Refusal& expected = GetParam();
  try {
    parse_toml(expected.text, "x.toml", "do this");
    FAIL() << "taken: " << expected.text;
  } catch (const Error& error) {
    EXPECT_EQ(error.place().file, "x.toml");
    EXPECT_EQ(error.place().line, expected.line);
    EXPECT_EQ(error.place().column, expected.column);
    EXPECT_THAT(error.what(), ::testing::HasSubstr(expected.problem));
  }
}

// Each of these but the last is undefined behaviour in toml++ 3.3 or one step from it.
INSTANTIATE_TEST_SUITE_P(
    Texts, TomlRefusal,
    ::testing::Values(Refusal{"a = 0''''\xef\xbb\xbd", 1, "6", "middle of a word"},
                      Refusal{"a = ''''\xc3\xa9''''''é", 1, "16", "end of a text"},
                      Refusal{"\na = ''x", 2, "7", "end of a text"},
                      Refusal{"a = \"\"\"x \\\n \xc3\xa9\"\"\"", 2, "2", "continued line"},
                      Refusal{"a = 'x\nb = 'y'", 1, "5", "without its closing"},
                      Refusal{"a = '''x\n", 1, "5", "without its closing"},
                      Refusal{"a = \"x\\", 1, "5", "without its closing"},
                      Refusal{"a = \xc2\xa0 1", 1, "5", "outside ASCII"},
                      Refusal{"a = [1}", 1, "7", "brackets"},
                      Refusal{"[=]", 1, "2", "table header"},
                      Refusal{"a = 1 2", 1, "7", "not valid TOML"}));

}  // namespace
}  // namespace umov
