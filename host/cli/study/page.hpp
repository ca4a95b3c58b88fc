// What a study found: paragraphs, tables, figures and numbers, written as Markdown, as plotly.js
// JSON and as an HTML page that stands alone.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

namespace umov::study {

using Json = nlohmann::ordered_json;

/// A claim with the number that was found.
struct Target {
  std::string what;      ///< "mean error of the reflectance over table 2"
  std::string required;  ///< "< 1 %"
  std::string found;     ///< "0.21 %"
  bool met = false;
};

class Page {
 public:
  Page(std::string name, std::string title);
  /// Pictures are PREFIXFIGURE.svg instead of NAME-FIGURE.svg.
  Page(std::string name, std::string title, std::string picture_prefix);

  /// Text may hold `code` and **bold**; nothing else is marked up.
  void heading(std::string text);
  void paragraph(std::string text);
  void list(std::vector<std::string> items);
  void table(std::vector<std::string> header, std::vector<std::vector<std::string>> rows);
  /// `data` and `layout` as plotly.js takes them. The caption stands below.
  void figure(std::string name, std::string caption, Json data, Json layout);
  /// A table of targets; each also goes to the numbers as targets.
  void targets(std::vector<Target> list);

  /// Everything a reader of the JSON may want: `umov study --json`.
  Json& numbers() { return numbers_; }
  const Json& numbers() const { return numbers_; }
  const std::string& name() const { return name_; }

  /// Pictures are NAME-FIGURE.svg beside the page (tools/studies/figures.py draws them).
  std::string markdown() const;
  /// {"figures": [{"name", "data", "layout"}, …]}
  Json figures() const;
  /// A page that loads nothing from anywhere.
  std::string html() const;
  /// Writes NAME.md, figures.json, numbers.json and index.html. Throws umov::Error.
  void write(const std::filesystem::path& folder) const;

 private:
  struct Block {
    enum class Kind { heading, paragraph, list, table, figure } kind;
    std::string text;                      ///< of a figure: its caption
    std::vector<std::string> header = {};  ///< of a list: its items
    std::vector<std::vector<std::string>> rows = {};
    std::string name = {};
    Json data = {}, layout = {};
  };
  std::string name_, title_, picture_prefix_;
  std::vector<Block> blocks_;
  Json numbers_ = Json::object();
};

}  // namespace umov::study
