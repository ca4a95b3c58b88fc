#include "host/formats/number_csv.hpp"

#include <istream>

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/decimal.hpp"
#include "host/formats/text_lines.hpp"

namespace umov::formats {

std::string read_stream(std::istream& in, const std::string& name) {
  std::string text;
  std::string chunk(1 << 16, '\0');
  while (in) {
    in.read(chunk.data(), static_cast<std::streamsize>(chunk.size()));
    text.append(chunk.data(), static_cast<std::size_t>(in.gcount()));
    require_readable_size(text.size(), name);
  }
  if (in.bad()) throw Error(Place{name}, "cannot read", "check the source");
  return text;
}

std::string_view csv_header_line(std::string_view text) {
  LineReader lines(text);
  std::string_view line;
  while (lines.next(line))
    if (!is_blank(line) && !line.starts_with('#')) return line;
  return {};
}

void read_number_csv(std::string_view text, const std::string& name,
                     std::span<const std::string_view> columns, std::size_t text_columns,
                     const std::function<void(std::span<const std::string_view>,
                                              std::span<const double>, std::size_t)>& row) {
  LineReader lines(text);
  std::string_view line;
  std::vector<std::string_view> fields;
  const auto fail = [&](std::string_view column, const std::string& problem,
                        const std::string& remedy) {
    throw Error(Place{name, lines.line_number(), std::string(column)}, problem, remedy);
  };
  do {
    if (!lines.next(line)) fail({}, "no header line", "the file is empty or cut off");
  } while (is_blank(line) || line.starts_with('#'));
  split_fields(line, fields);
  for (std::size_t i = 0; i < columns.size(); ++i)
    if (i >= fields.size() || fields[i] != columns[i])
      fail(columns[i],
           "column " + std::to_string(i + 1) + " should be `" + std::string(columns[i]) + "`",
           "the file is of another kind; see `umov import --help`");
  if (fields.size() != columns.size())
    fail(fields[columns.size()], "unknown column", "the file is of another kind");

  std::vector<double> numbers(columns.size() - text_columns);
  std::size_t rows = 0;
  while (lines.next(line)) {
    if (is_blank(line)) {
      if (lines.only_blank_left()) break;
      fail({}, "blank line between records", "delete it");
    }
    split_fields(line, fields);
    if (fields.size() != columns.size())
      fail({},
           "the line has " + std::to_string(fields.size()) + " fields, not " +
               std::to_string(columns.size()),
           "one value a column; the file may have been cut off");
    lines.require_line_end(line, name);
    for (std::size_t i = text_columns; i < columns.size(); ++i)
      if (const char* problem = read_decimal(fields[i], numbers[i - text_columns]))
        fail(columns[i],
             std::string(problem) + ": \"" + std::string(fields[i].substr(0, 40)) + "\"",
             "give a plain decimal number");
    row(std::span(fields).first(text_columns), numbers, lines.line_number());
    ++rows;
  }
  if (rows == 0) fail({}, "there are no records after the header line", "the file may be cut off");
}

}  // namespace umov::formats
