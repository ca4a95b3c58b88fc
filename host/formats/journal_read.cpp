// Recovery of a journal and the scan it holds.
#include <algorithm>
#include <unordered_set>

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/journal.hpp"
#include "host/formats/journal_records.hpp"
#include "host/formats/scan_csv.hpp"

namespace umov::formats {

void append(ScanTable& table, const ScanRecord& r) {
  table.index.push_back(r.index);
  table.time_s.push_back(r.time_s);
  table.theta_i_deg.push_back(r.theta_i_deg);
  table.theta_r_deg.push_back(r.theta_r_deg);
  table.phi_r_deg.push_back(r.phi_r_deg);
  table.wavelength_nm.push_back(r.wavelength_nm);
  table.polarizer_deg.push_back(r.polarizer_deg);
  table.analyzer_deg.push_back(r.analyzer_deg);
  table.direction.push_back(r.direction < 0 ? -1 : 1);
  table.gain.push_back(r.gain);
  table.x_v.push_back(r.x_v);
  table.y_v.push_back(r.y_v);
  table.x_se_v.push_back(r.x_se_v);
  table.y_se_v.push_back(r.y_se_v);
  table.monitor_v.push_back(r.monitor_v);
  table.saturated.push_back(r.saturated ? 1 : 0);
  table.shutter_open.push_back(r.shutter_open ? 1 : 0);
}

std::int64_t Journal::next_index() const {
  std::vector<std::int64_t> present;
  present.reserve(records.size());
  for (const ScanRecord& record : records) present.push_back(record.index);
  std::sort(present.begin(), present.end());
  std::int64_t next = 0;
  for (const std::int64_t index : present)
    if (index == next) ++next;
  return next;
}

Journal parse_journal(std::span<const std::byte> bytes, const std::string& name) {
  const auto text = std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (!text.starts_with(journal_signature))
    throw Error(Place{name}, "is not the journal of a scan", "name the .journal file of a scan");
  std::size_t at = journal_signature.size();
  Journal journal;
  const auto header_payload = frame_at(bytes.subspan(at));
  std::optional<JournalHeader> header;
  if (header_payload) header = decode_header(*header_payload);
  if (!header)
    throw Error(Place{name}, "the journal's header is damaged or cut off",
                "delete the journal and start the scan again");
  journal.header = std::move(*header);
  at += frame_overhead + header_payload->size();
  journal.valid_bytes = at;

  constexpr std::size_t frame_size = frame_overhead + record_payload_size;
  std::unordered_set<std::int64_t> seen;
  while (bytes.size() - at >= frame_size) {
    // All records have one length, so that a search after damage looks at single frames only.
    const auto payload = frame_at(bytes.subspan(at, frame_size));
    const auto record = payload ? decode_record(*payload) : std::nullopt;
    if (!record) {
      ++at;
      continue;
    }
    journal.damaged_bytes += at - journal.valid_bytes;
    at += frame_size;
    journal.valid_bytes = at;
    if (seen.insert(record->index).second) journal.records.push_back(*record);
  }
  journal.torn_bytes = bytes.size() - journal.valid_bytes;
  return journal;
}

Journal read_journal(const std::filesystem::path& path) {
  const std::string bytes = read_whole_file(path);
  return parse_journal(std::as_bytes(std::span(bytes)), path.string());
}

ScanTable build_scan_table(const Journal& journal) {
  std::vector<const ScanRecord*> sorted;
  sorted.reserve(journal.records.size());
  for (const ScanRecord& record : journal.records) sorted.push_back(&record);
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const ScanRecord* a, const ScanRecord* b) { return a->index < b->index; });
  ScanTable table;
  table.keys = journal.header.keys;
  table.reserve(sorted.size());
  for (const ScanRecord* record : sorted) append(table, *record);
  if (!sorted.empty())
    for (Block block : journal.header.blocks) {
      block.first = std::max(block.first, table.index.front());
      block.last = std::min(block.last, table.index.back());
      if (block.first <= block.last) table.blocks.push_back(std::move(block));
    }
  round_to_canonical(table);
  return table;
}

}  // namespace umov::formats
