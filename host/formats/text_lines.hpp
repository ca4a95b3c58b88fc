// Lines and fields of delimited text, with line numbers for messages.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace umov::formats {

/// Walks over the lines of a text; takes a byte order mark off the first, CR off every end.
class LineReader {
 public:
  explicit LineReader(std::string_view text);
  /// Next line into `line`; false at the end.
  bool next(std::string_view& line);
  std::size_t line_number() const { return number_; }  ///< 1-based, of the line last returned
  std::size_t bytes_left() const { return rest_.size(); }
  /// True where nothing but blank lines follows.
  bool only_blank_left() const;
  /// The line last returned has no line end behind it: the text may be cut off within it.
  bool within_line() const { return within_line_; }
  /// Refuses such a line, unless it is blank: where the last field is a number, one that lost
  /// digits is a number still. Throws umov::Error; `file` stands in it.
  void require_line_end(std::string_view line, const std::string& file) const;

 private:
  std::string_view rest_;
  std::size_t number_ = 0;
  bool within_line_ = false;
};

/// Fields between commas, trimmed of blanks. `fields` is reused.
void split_fields(std::string_view line, std::vector<std::string_view>& fields);

/// True for text of blanks only.
bool is_blank(std::string_view text);

}  // namespace umov::formats
