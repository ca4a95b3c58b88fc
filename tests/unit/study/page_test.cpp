// The page of a study: what Markdown, HTML and JSON make of the same content.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "host/cli/study/embedded_plans.hpp"
#include "host/cli/study/page.hpp"
#include "host/cli/study/plots.hpp"
#include "host/cli/study/study.hpp"
#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/scan/plan.hpp"

namespace umov::study {
namespace {

using testing::HasSubstr;
using testing::Not;

Page example() {
  Page page("demo", "A & B");
  page.heading("First");
  page.paragraph("Less < more, `code <x>` and **bold**.");
  page.list({"one", "two"});
  page.table({"a", "b"}, {{"1", "2"}});
  const std::vector<double> x{0, 1}, y{0.123456789, std::nan("")};
  page.figure("curve", "What it shows.", Json::array({line("truth", x, y, "#000")}),
              axes("θ / °", "BRDF / sr<sup>−1</sup>", true));
  page.targets({{"error", "< 1 %", "0.2 %", true}, {"other", "< 1 %", "3 %", false}});
  page.numbers()["error"] = 0.002;
  return page;
}

TEST(Page, MarkdownHasEveryPartInOrder) {
  const std::string text = example().markdown();
  EXPECT_THAT(text, HasSubstr("# A & B\n\n## First\n\nLess < more, `code <x>`"));
  EXPECT_THAT(text, HasSubstr("- one\n- two\n"));
  EXPECT_THAT(text, HasSubstr("| a | b |\n| --- | --- |\n| 1 | 2 |\n"));
  EXPECT_THAT(text, HasSubstr("![curve](demo-curve.svg)\n\nWhat it shows.\n"));
  EXPECT_THAT(text, HasSubstr("| other | < 1 % | 3 % | **no** |"));
}

TEST(Page, LongParagraphsAreBrokenAndLoseNoWord) {
  std::string words, word;
  for (int i = 0; i < 100; ++i) words += (i ? " word" : "word") + std::to_string(i);
  Page page("demo", "t");
  page.paragraph(words);
  std::string text = page.markdown();
  std::size_t longest = 0, start = 0;
  for (std::size_t i = 0; i < text.size(); ++i)
    if (text[i] == '\n') {
      longest = std::max(longest, i - start);
      start = i + 1;
      text[i] = ' ';
    }
  EXPECT_LE(longest, 110u);
  EXPECT_THAT(text, HasSubstr(words));
}

TEST(Page, HtmlEscapesWhatIsTextAndLoadsNothing) {
  const std::string html = example().html();
  EXPECT_THAT(html, HasSubstr("<h1>A &amp; B</h1>"));
  EXPECT_THAT(html, HasSubstr("<code>code &lt;x&gt;</code> and <b>bold</b>"));
  EXPECT_THAT(html, HasSubstr("<td><b>no</b></td>"));
  EXPECT_THAT(html, HasSubstr("<div id=\"curve\">"));
  EXPECT_THAT(html, HasSubstr("<li>one</li><li>two</li>"));
  EXPECT_THAT(html, HasSubstr("sr\\u003csup>"));
  EXPECT_THAT(html, Not(HasSubstr("<script src")));
  EXPECT_THAT(html, Not(HasSubstr("<link rel=\"stylesheet")));
}

TEST(Page, FiguresAreWhatTheDrawingScriptReads) {
  const auto figures = example().figures()["figures"];
  ASSERT_EQ(figures.size(), 1u);
  EXPECT_EQ(figures[0]["name"], "curve");
  EXPECT_EQ(figures[0]["data"][0]["y"][0], 0.12346);
  EXPECT_TRUE(figures[0]["data"][0]["y"][1].is_null()) << "a gap, not a number";
  EXPECT_EQ(figures[0]["layout"]["yaxis"]["type"], "log");
}

TEST(Page, NumbersCarryTheTargets) {
  const auto page = example();
  EXPECT_EQ(page.numbers()["targets"][0]["met"], true);
  EXPECT_EQ(page.numbers()["targets"][1]["met"], false);
  const auto folder =
      std::filesystem::temp_directory_path() / ("umov-page-" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  page.write(folder);
  for (const char* file : {"demo.md", "figures.json", "numbers.json", "index.html"})
    EXPECT_TRUE(std::filesystem::exists(folder / file)) << file;
  EXPECT_EQ(Json::parse(formats::read_whole_file(folder / "numbers.json"))["error"], 0.002);
  std::filesystem::remove_all(folder);
}

TEST(Studies, AreFoundByNameAndTheirPlansCanBeMeasured) {
  for (const Study& study : studies()) EXPECT_EQ(find_study(study.name).name, study.name);
  try {
    find_study("reflectomter");
    FAIL() << "an unknown study was found";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("reflectometer"));
  }
  for (const char* name :
       {"white-99", "white-70", "white-50", "white-again", "red-paint", "germanium", "black-paint"})
    EXPECT_GT(scan::row_count(scan::parse_plan(embedded_plan(name), name)), 50u) << name;
  EXPECT_THROW(embedded_plan("no-such-plan"), Error);
}

}  // namespace
}  // namespace umov::study
