#include "host/cli/output_file.hpp"

#include <filesystem>
#include <fstream>

#include "host/errors/error.hpp"
#include "host/formats/h5_kind.hpp"
#include "host/formats/hdf5_image.hpp"

namespace umov::cli {
namespace {

bool same_file(const std::string& a, const std::string& b) {
  std::error_code ignored;
  return a == b || std::filesystem::equivalent(a, b, ignored);
}

std::string first_bytes(const std::string& path, std::size_t count) {
  std::ifstream file(path, std::ios::binary);
  std::string bytes(count, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(count));
  bytes.resize(static_cast<std::size_t>(file.gcount()));
  return bytes;
}

/// A scan as HDF5 or CSV, or the journal of one.
bool is_raw_data(const std::string& path) {
  const std::string start = first_bytes(path, 1024);
  if (start.starts_with("UMOVJNL") || start.starts_with("# format: umov scan csv") ||
      start.starts_with("index,time_s,")) {
    return true;
  }
  if (!formats::looks_like_hdf5(start)) return false;
  try {
    return formats::h5_kind(path) == formats::H5Kind::scan;
  } catch (const Error&) {
    return false;  // no HDF5 file at all
  }
}

}  // namespace

void require_new_output(const std::string& input, const std::string& output, bool force) {
  if (same_file(input, output))
    throw Error(Place{output}, "the output is the input", "name another file with -o");
  std::error_code ignored;
  if (!force && std::filesystem::exists(output, ignored))
    throw Error(Place{output}, "the file exists", "name another file, or replace it with --force");
}

void require_product_output(const std::vector<std::string>& inputs, const std::string& output) {
  for (const std::string& input : inputs)
    if (!input.empty() && same_file(input, output))
      throw Error(Place{output}, "is read or written for something else already",
                  "name another file for the output");
  std::error_code ignored;
  if (std::filesystem::is_regular_file(output, ignored) && is_raw_data(output))
    throw Error(Place{output}, "holds raw records, which are never overwritten",
                "name another file with -o");
}

}  // namespace umov::cli
