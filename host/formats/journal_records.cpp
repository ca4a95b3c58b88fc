#include "host/formats/journal_records.hpp"

namespace umov::formats {
namespace {

using Pairs = std::vector<std::pair<std::string, std::string>>;

void put_pairs(Bytes& out, const Pairs& pairs) {
  put_integer(out, pairs.size(), 4);
  for (const auto& [key, value] : pairs) {
    put_text(out, key);
    put_text(out, value);
  }
}

Pairs take_pairs(PayloadReader& in) {
  Pairs pairs;
  for (std::uint64_t left = in.integer(4); left > 0 && in.ok(); --left) {
    std::string key = in.text();
    std::string value = in.text();
    pairs.emplace_back(std::move(key), std::move(value));
  }
  return pairs;
}

}  // namespace

Bytes encode_header(const JournalHeader& header) {
  Bytes out;
  put_integer(out, header.program_id, 4);
  put_integer(out, header.row_count, 8);
  const Provenance& p = header.provenance;
  for (const std::string* text : {&p.program, &p.command, &p.created, &p.device, &p.firmware_hash,
                                  &p.role, &p.settings, &p.plan})
    put_text(out, *text);
  put_pairs(out, header.keys);
  put_integer(out, header.blocks.size(), 4);
  for (const Block& block : header.blocks) {
    put_text(out, block.name);
    put_integer(out, static_cast<std::uint64_t>(block.first), 8);
    put_integer(out, static_cast<std::uint64_t>(block.last), 8);
    put_pairs(out, block.settings);
  }
  return out;
}

std::optional<JournalHeader> decode_header(std::span<const std::byte> payload) {
  PayloadReader in(payload);
  JournalHeader header;
  header.program_id = static_cast<std::uint32_t>(in.integer(4));
  header.row_count = in.integer(8);
  Provenance& p = header.provenance;
  for (std::string* text : {&p.program, &p.command, &p.created, &p.device, &p.firmware_hash,
                            &p.role, &p.settings, &p.plan})
    *text = in.text();
  header.keys = take_pairs(in);
  for (std::uint64_t left = in.integer(4); left > 0 && in.ok(); --left) {
    Block block;
    block.name = in.text();
    block.first = static_cast<std::int64_t>(in.integer(8));
    block.last = static_cast<std::int64_t>(in.integer(8));
    block.settings = take_pairs(in);
    header.blocks.push_back(std::move(block));
  }
  if (!in.at_end()) return std::nullopt;
  return header;
}

void put_record(Bytes& out, const ScanRecord& r) {
  put_integer(out, static_cast<std::uint64_t>(r.index), 8);
  for (const double value : {r.time_s, r.theta_i_deg, r.theta_r_deg, r.phi_r_deg, r.wavelength_nm,
                             r.polarizer_deg, r.analyzer_deg})
    put_number(out, value);
  put_integer(out, r.direction < 0 ? 0 : 1, 1);
  for (const double value : {r.gain, r.x_v, r.y_v, r.x_se_v, r.y_se_v, r.monitor_v})
    put_number(out, value);
  put_integer(out, (r.saturated ? 1u : 0u) | (r.shutter_open ? 2u : 0u), 1);
}

std::optional<ScanRecord> decode_record(std::span<const std::byte> payload) {
  if (payload.size() != record_payload_size) return std::nullopt;
  PayloadReader in(payload);
  ScanRecord r;
  r.index = static_cast<std::int64_t>(in.integer(8));
  for (double* value : {&r.time_s, &r.theta_i_deg, &r.theta_r_deg, &r.phi_r_deg, &r.wavelength_nm,
                        &r.polarizer_deg, &r.analyzer_deg})
    *value = in.number();
  r.direction = in.integer(1) == 0 ? -1 : 1;
  for (double* value : {&r.gain, &r.x_v, &r.y_v, &r.x_se_v, &r.y_se_v, &r.monitor_v})
    *value = in.number();
  const std::uint64_t flags = in.integer(1);
  r.saturated = (flags & 1) != 0;
  r.shutter_open = (flags & 2) != 0;
  return r;
}

}  // namespace umov::formats
