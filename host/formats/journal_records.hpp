// Journal header and records as payload bytes.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "host/formats/journal.hpp"
#include "host/formats/journal_frame.hpp"

namespace umov::formats {

inline constexpr std::string_view journal_signature = "UMOVJNL1";
/// Bytes of every record's payload.
inline constexpr std::size_t record_payload_size = 8 + 8 + 6 * 8 + 1 + 8 + 5 * 8 + 1;

Bytes encode_header(const JournalHeader& header);
std::optional<JournalHeader> decode_header(std::span<const std::byte> payload);
void put_record(Bytes& out, const ScanRecord& record);
std::optional<ScanRecord> decode_record(std::span<const std::byte> payload);

}  // namespace umov::formats
