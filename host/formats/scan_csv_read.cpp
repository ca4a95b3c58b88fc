// Reading a Scan CSV; the rules are those of scan_rules.hpp, here with the line they were broken
// on.
#include <algorithm>
#include <string>
#include <variant>

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/decimal.hpp"
#include "host/formats/number_csv.hpp"
#include "host/formats/scan_columns.hpp"
#include "host/formats/scan_csv.hpp"
#include "host/formats/scan_rules.hpp"
#include "host/formats/text_lines.hpp"

namespace umov::formats {
namespace {

constexpr const char* header_remedy =
    "the header line is "
    "index,time_s,theta_i_deg,theta_r_deg,phi_r_deg,wavelength_nm,polarizer_deg,analyzer_deg,"
    "direction,gain,x_v,y_v,x_se_v,y_se_v,monitor_v,saturated,shutter";

/// Quotes text from a file for a message: one line, not longer than a line.
std::string in_quotes(std::string_view text) {
  std::string result = "\"";
  for (const char c : text.substr(0, 40)) result += static_cast<unsigned char>(c) < 32 ? '?' : c;
  return result + (text.size() > 40 ? "…\"" : "\"");
}

class Parser {
 public:
  Parser(std::string_view text, const std::string& name)
      : lines_(text), name_(name), text_size_(text.size()) {}

  ScanTable run() {
    read_header();
    read_records();
    for (const auto& [block, line] : block_lines_)
      if (const std::string problem = block_problem(table_.blocks[block], table_.index);
          !problem.empty())
        throw Error(Place{name_, line}, problem, "a block's range lies within the rows");
    return std::move(table_);
  }

 private:
  [[noreturn]] void fail(std::string_view column, const std::string& problem,
                         const std::string& remedy) const {
    throw Error(Place{name_, lines_.line_number(), std::string(column)}, problem, remedy);
  }

  void read_header() {
    std::string_view line;
    while (true) {
      if (!lines_.next(line))
        throw Error(Place{name_, lines_.line_number()}, "no header line", header_remedy);
      if (line.starts_with('#')) {
        read_comment(trimmed(line.substr(1)));
      } else if (!is_blank(line)) {
        check_column_names(line);
        return;
      }
    }
  }

  void read_comment(std::string_view comment) {
    if (comment.empty()) return;
    for (const char c : comment)
      if (static_cast<unsigned char>(c) < 32 && c != '\t')
        fail({}, "a header line holds a control character", "the file is not plain text");
    const std::size_t colon = comment.find(':');
    std::string key, value;
    if (colon == std::string_view::npos || colon == 0) {
      key = "comment";  // free text of another program: kept, as everything unknown
      value = comment;
    } else {
      key = trimmed(comment.substr(0, colon));
      value = trimmed(comment.substr(colon + 1));
    }
    if (key == "block") return read_block(value);
    if (is_contract_key(key) && table_.key(key))
      fail({}, "the header key `" + key + "` stands twice", "leave one of the two lines out");
    if (const std::string problem = key_problem(key, value); !problem.empty())
      fail({}, problem, "correct the header line");
    table_.keys.emplace_back(std::move(key), std::move(value));
  }

  void read_block(std::string_view text) {
    constexpr const char* remedy = "write `# block: NAME FIRST-LAST key=value …`";
    const auto next_word = [&text]() {
      text = trimmed(text);
      const std::size_t end = std::min(text.find_first_of(" \t"), text.size());
      const std::string_view word = text.substr(0, end);
      text.remove_prefix(end);
      return word;
    };
    Block block;
    block.name = next_word();
    const std::string_view range = next_word();
    const std::size_t dash = range.find('-');
    if (block.name.empty() || dash == std::string_view::npos ||
        read_integer(range.substr(0, dash), block.first) ||
        read_integer(range.substr(dash + 1), block.last))
      fail({},
           "the block line " + in_quotes(std::string(block.name) + " " + std::string(range)) +
               " has no name and row range",
           remedy);
    for (std::string_view word = next_word(); !word.empty(); word = next_word()) {
      const std::size_t equals = word.find('=');
      if (equals == std::string_view::npos || equals == 0)
        fail({}, "block `" + block.name + "` has the setting " + in_quotes(word), remedy);
      block.settings.emplace_back(word.substr(0, equals), word.substr(equals + 1));
    }
    block_lines_.emplace_back(table_.blocks.size(), lines_.line_number());
    table_.blocks.push_back(std::move(block));
  }

  /// Explains a column name that the contract does not have: often the right one in another unit.
  void refuse_unknown_column(std::string_view found) const {
    for (const ScanColumn& column : scan_columns) {
      const std::string_view stem = column.name.substr(0, column.name.rfind('_'));
      if (column.unit != "1" &&
          (found == stem ||
           (found.starts_with(stem) && found.size() > stem.size() && found[stem.size()] == '_' &&
            found.find('_', stem.size() + 1) == std::string_view::npos)))
        fail(found, "unknown column or wrong unit: " + in_quotes(found),
             "convert it to `" + std::string(column.name) + "`, in " + std::string(column.unit));
    }
    fail(found, "unknown column " + in_quotes(found), header_remedy);
  }

  void check_column_names(std::string_view line) {
    split_fields(line, fields_);
    for (std::size_t i = 0; i < fields_.size(); ++i) {
      const auto known = std::find_if(scan_columns.begin(), scan_columns.end(),
                                      [&](const ScanColumn& c) { return c.name == fields_[i]; });
      if (known == scan_columns.end()) refuse_unknown_column(fields_[i]);
      if (std::find(fields_.begin(), fields_.begin() + static_cast<std::ptrdiff_t>(i),
                    fields_[i]) != fields_.begin() + static_cast<std::ptrdiff_t>(i))
        fail(fields_[i], "the column stands twice", header_remedy);
    }
    for (const ScanColumn& column : scan_columns)
      if (std::find(fields_.begin(), fields_.end(), column.name) == fields_.end())
        fail(column.name, "the column is missing", header_remedy);
    for (std::size_t i = 0; i < scan_columns.size(); ++i)
      if (fields_[i] != scan_columns[i].name)
        fail(fields_[i], "the column is out of order", header_remedy);
  }

  void read_records() {
    // A record has at least 17 characters of digits and 17 separators: never more than the text
    // can hold, whatever the header says.
    table_.reserve(std::min<std::size_t>(text_size_ / 60 + 1, 4'000'000));
    std::string_view line;
    while (lines_.next(line)) {
      if (is_blank(line)) {
        if (lines_.only_blank_left()) break;
        fail({}, "blank line between records", "delete it");
      }
      read_record(line);
    }
    if (table_.size() == 0)
      fail({}, "there are no records after the header line", "the file may have been cut off");
  }

  void read_record(std::string_view line) {
    split_fields(line, fields_);
    if (fields_.size() != scan_columns.size())
      fail({},
           "the line has " + std::to_string(fields_.size()) + " fields, not " +
               std::to_string(scan_columns.size()),
           "one value a column; the file may have been cut off");
    for (std::size_t i = 0; i < scan_columns.size(); ++i) {
      const ScanColumn& column = scan_columns[i];
      std::visit([&](auto member) { read_field(column, fields_[i], table_.*member); }, column.data);
    }
    const std::size_t row = table_.size() - 1;
    if (row > 0 && table_.index[row] <= table_.index[row - 1])
      fail("index",
           std::to_string(table_.index[row]) + " follows " + std::to_string(table_.index[row - 1]),
           "the index grows from line to line");
    if (table_.phi_r_deg[row] != 0 && table_.theta_r_deg[row] < 0)
      fail("theta_r_deg", "theta_r_deg < 0 with phi_r_deg not 0", out_of_plane_remedy);
  }

  [[noreturn]] void refuse_field(const ScanColumn& column, std::string_view field,
                                 const char* problem) const {
    fail(column.name, in_quotes(field) + ": " + problem, "permitted: " + column_range_text(column));
  }

  void read_field(const ScanColumn& column, std::string_view field, std::vector<double>& values) {
    double value = 0;
    if (column.text == Text::axis && field == "open") {
      value = open_axis;
    } else if (const char* problem = read_decimal(field, value)) {
      refuse_field(column, field, problem);
    }
    if (!within_column(column, value)) refuse_field(column, field, "outside its range");
    values.push_back(value);
  }

  template <class Integer>
  void read_field(const ScanColumn& column, std::string_view field, std::vector<Integer>& values) {
    std::int64_t value = 0;
    if (column.text == Text::shutter) {
      if (field != "open" && field != "closed")
        refuse_field(column, field, "not a state of the shutter");
      value = field == "open";
    } else if (const char* problem = read_integer(field, value)) {
      refuse_field(column, field, problem);
    }
    if (!within_column(column, static_cast<double>(value)))
      refuse_field(column, field, "outside its range");
    values.push_back(static_cast<Integer>(value));
  }

  LineReader lines_;
  const std::string& name_;
  std::size_t text_size_;
  ScanTable table_;
  std::vector<std::pair<std::size_t, std::size_t>> block_lines_;  ///< block, line
  std::vector<std::string_view> fields_;
};

}  // namespace

ScanTable parse_scan_csv(std::string_view text, const std::string& name) {
  return Parser(text, name).run();
}

ScanTable read_scan_csv(std::istream& in, const std::string& name) {
  return parse_scan_csv(read_stream(in, name), name);
}

ScanTable read_scan_csv(const std::filesystem::path& path) {
  return parse_scan_csv(read_whole_file(path), path.string());
}

}  // namespace umov::formats
