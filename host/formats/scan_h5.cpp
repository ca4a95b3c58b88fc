#include "host/formats/scan_h5.hpp"

#include <string>
#include <variant>

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/content_hash.hpp"
#include "host/formats/h5_header.hpp"
#include "host/formats/hdf5_image.hpp"
#include "host/formats/scan_columns.hpp"
#include "host/formats/scan_csv.hpp"

namespace umov::formats {
namespace {

constexpr const char* format_name = "umov scan h5";

std::string column_path(const ScanColumn& column) {
  return "/records/" + std::string(column.name);
}

std::string settings_text(const Block& block) {
  std::string text;
  for (const auto& [key, value] : block.settings)
    text += (text.empty() ? "" : " ") + key + "=" + value;
  return text;
}

/// Splits "key=value key=value"; keys and values have no blanks.
Keys settings_of(const std::string& text, const Hdf5Reader& file) {
  Keys settings;
  for (std::size_t start = 0; start < text.size();) {
    const std::size_t end = std::min(text.find(' ', start), text.size());
    const std::string word = text.substr(start, end - start);
    const std::size_t equals = word.find('=');
    if (equals == std::string::npos || equals == 0)
      file.fail("/blocks/settings", "\"" + word + "\" is not key=value");
    settings.emplace_back(word.substr(0, equals), word.substr(equals + 1));
    start = end + 1;
  }
  return settings;
}

void write_blocks(Hdf5Builder& file, const std::vector<Block>& blocks) {
  std::vector<std::string> names, settings;
  std::vector<std::int64_t> first, last;
  for (const Block& block : blocks) {
    names.push_back(block.name);
    settings.push_back(settings_text(block));
    first.push_back(block.first);
    last.push_back(block.last);
  }
  file.group("/blocks");
  file.column("/blocks/name", names);
  file.column("/blocks/first", first, "1");
  file.column("/blocks/last", last, "1");
  file.column("/blocks/settings", settings);
}

std::vector<Block> read_blocks(const Hdf5Reader& file) {
  std::vector<Block> blocks;
  if (!file.has("/blocks")) return blocks;
  const std::vector<std::string> names = file.texts("/blocks/name");
  const std::vector<std::string> settings = file.texts("/blocks/settings");
  const std::vector<std::int64_t> first = file.integers("/blocks/first");
  const std::vector<std::int64_t> last = file.integers("/blocks/last");
  if (settings.size() != names.size() || first.size() != names.size() ||
      last.size() != names.size())
    file.fail("/blocks", "the columns differ in length");
  for (std::size_t i = 0; i < names.size(); ++i)
    blocks.push_back(Block{names[i], first[i], last[i], settings_of(settings[i], file)});
  return blocks;
}

}  // namespace

std::string content_sha256(const ScanTable& table) {
  ContentHash hash;
  hash.text(format_name);
  hash.pairs("header", table.keys);
  hash.integer(static_cast<std::int64_t>(table.blocks.size()));
  for (const Block& block : table.blocks) {
    hash.text(block.name);
    hash.integer(block.first);
    hash.integer(block.last);
    hash.text(settings_text(block));
  }
  for (const ScanColumn& column : scan_columns)
    std::visit(
        [&](auto member) {
          using Value = typename std::remove_reference_t<decltype(table.*member)>::value_type;
          hash.column(column.name, std::span<const Value>(table.*member));
        },
        column.data);
  return hash.hex_digest();
}

void write_scan_h5(const std::filesystem::path& path, const ScanTable& table,
                   const Provenance& provenance) {
  validate(table, path.string());
  check_storable(table.keys, path.string());
  Hdf5Builder file(path.string());
  write_h5_header(file, format_name, table.keys, provenance, content_sha256(table));
  write_blocks(file, table.blocks);
  file.group("/records");
  for (const ScanColumn& column : scan_columns) {
    const std::string at = column_path(column);
    const std::string unit(column.unit);
    std::visit(
        [&](auto member) {
          using Values = std::remove_cvref_t<decltype(table.*member)>;
          if constexpr (std::is_same_v<Values, std::vector<int>>) {
            file.small_column(at, table.*member, unit);
          } else {
            file.column(at, table.*member, unit);
          }
        },
        column.data);
    file.attribute(at, "meaning", std::string(column.meaning));
    if (column.text == Text::shutter)
      file.attribute(at, "enum", std::vector<std::string>{"closed", "open"});
    if (column.text == Text::axis) file.attribute(at, "open", "NaN");
  }
  replace_file(path, file.finish());
}

ScanFile parse_scan_h5(std::string_view bytes, const std::string& name) {
  const Hdf5Reader file(bytes, name);
  ScanFile scan;
  scan.provenance = read_h5_header(file, format_name, scan.table.keys);
  scan.table.blocks = read_blocks(file);
  for (const ScanColumn& column : scan_columns) {
    const std::string path = column_path(column);
    std::visit(
        [&](auto member) {
          using Values = std::remove_reference_t<decltype(scan.table.*member)>;
          if constexpr (std::is_same_v<Values, std::vector<double>>) {
            scan.table.*member = file.doubles(path);
          } else if constexpr (std::is_same_v<Values, std::vector<int>>) {
            scan.table.*member = file.small_integers(path);
          } else {
            scan.table.*member = file.integers(path);
          }
        },
        column.data);
  }
  validate(scan.table, name);
  scan.content_sha256 = content_sha256(scan.table);
  verify_h5_content(file, scan.content_sha256);
  return scan;
}

ScanFile read_scan_h5(const std::filesystem::path& path) {
  return parse_scan_h5(read_whole_file(path), path.string());
}

ScanFile read_scan(const std::filesystem::path& path) {
  const std::string bytes = read_whole_file(path);
  if (looks_like_hdf5(bytes)) return parse_scan_h5(bytes, path.string());
  ScanFile scan;
  scan.table = parse_scan_csv(bytes, path.string());
  scan.provenance.device = scan.table.key("device").value_or("");
  scan.provenance.role = scan.table.key("role").value_or("");
  scan.content_sha256 = content_sha256(scan.table);
  return scan;
}

}  // namespace umov::formats
