#include "host/formats/text_lines.hpp"

#include "host/errors/error.hpp"
#include "host/formats/decimal.hpp"

namespace umov::formats {

LineReader::LineReader(std::string_view text) : rest_(text) {
  if (rest_.starts_with("\xef\xbb\xbf")) rest_.remove_prefix(3);
}

bool LineReader::next(std::string_view& line) {
  if (rest_.empty()) return false;
  const std::size_t end = rest_.find('\n');
  line = rest_.substr(0, end);
  within_line_ = end == std::string_view::npos;
  rest_ = end == std::string_view::npos ? std::string_view{} : rest_.substr(end + 1);
  if (line.ends_with('\r')) line.remove_suffix(1);
  ++number_;
  return true;
}

bool LineReader::only_blank_left() const {
  return rest_.find_first_not_of(" \t\r\n") == std::string_view::npos;
}

void LineReader::require_line_end(std::string_view line, const std::string& file) const {
  if (within_line_ && !is_blank(line))
    throw Error(Place{file, number_}, "the file ends within a line: cut off?",
                "fetch the whole file; if it is whole, end its last line with a line end");
}

void split_fields(std::string_view line, std::vector<std::string_view>& fields) {
  fields.clear();
  std::size_t start = 0;
  while (true) {
    const std::size_t comma = line.find(',', start);
    if (comma == std::string_view::npos) break;
    fields.push_back(trimmed(line.substr(start, comma - start)));
    start = comma + 1;
  }
  fields.push_back(trimmed(line.substr(start)));
}

bool is_blank(std::string_view text) {
  return text.find_first_not_of(" \t\r") == std::string_view::npos;
}

}  // namespace umov::formats
