// Journals: recovery reads anything without losing its footing, accounts for every byte, and what
// it recovers is itself a journal that reads the same. fuzz-link: umov_formats
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "host/errors/error.hpp"
#include "host/formats/journal.hpp"
#include "host/formats/journal_records.hpp"
#include "tests/fuzz/foreign_bytes.hpp"

namespace {

using umov::fuzz::require;

/// The input with lengths and CRCs put right wherever a frame would start, so that the fuzzer gets
/// past the checks and into the payloads.
umov::formats::Bytes framed(std::span<const std::byte> data) {
  using namespace umov::formats;
  Bytes out;
  for (const char c : journal_signature) out.push_back(static_cast<std::byte>(c));
  const std::size_t header_size = std::min<std::size_t>(data.size(), 200);
  put_frame(out, data.first(header_size));
  data = data.subspan(header_size);
  while (data.size() >= record_payload_size) {
    put_frame(out, data.first(record_payload_size));
    data = data.subspan(record_payload_size);
  }
  out.insert(out.end(), data.begin(), data.end());
  return out;
}

void check(std::span<const std::byte> bytes) {
  using namespace umov::formats;
  Journal journal;
  try {
    journal = parse_journal(bytes, "fuzz");
  } catch (const umov::Error&) {
    return;
  }
  require(journal.valid_bytes + journal.torn_bytes == bytes.size());
  const Journal again =
      parse_journal(bytes.first(static_cast<std::size_t>(journal.valid_bytes)), "again");
  require(again.records.size() == journal.records.size() && again.torn_bytes == 0);
  require(again.next_index() == journal.next_index());
  require(build_scan_table(journal).size() == journal.records.size());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span<const std::byte> bytes = std::as_bytes(std::span(data, size));
  check(bytes);
  check(framed(bytes));
  return 0;
}
