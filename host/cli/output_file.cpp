#include "host/cli/output_file.hpp"

#include <filesystem>

#include "host/errors/error.hpp"

namespace umov::cli {

void require_new_output(const std::string& input, const std::string& output, bool force) {
  std::error_code ignored;
  if (input == output || std::filesystem::equivalent(input, output, ignored))
    throw Error(Place{output}, "the output is the input", "name another file with -o");
  if (!force && std::filesystem::exists(output, ignored))
    throw Error(Place{output}, "the file exists", "name another file, or replace it with --force");
}

}  // namespace umov::cli
