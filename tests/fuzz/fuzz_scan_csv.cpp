// Scan CSV: whatever the text, the reader either refuses it with umov::Error or yields a table that
// goes through text unchanged.
// fuzz-link: umov_formats
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "host/errors/error.hpp"
#include "host/formats/scan_csv.hpp"
#include "host/formats/scan_h5.hpp"

namespace {

void require(bool good) {
  if (!good) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace umov::formats;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  ScanTable table;
  try {
    table = parse_scan_csv(text, "fuzz");
  } catch (const umov::Error&) {
    return 0;
  }
  const std::string once = scan_csv_text(table);
  const ScanTable again = parse_scan_csv(once, "again");
  require(content_sha256(again) == content_sha256(table));
  require(scan_csv_text(again) == once);
  return 0;
}
