// The append-only journal of a running scan: what is synced to it survives kill -9 and power cuts.
//
// File: 8 bytes "UMOVJNL1", then frames of {length u32, CRC-32C of the payload u32, payload}, all
// little-endian. The first frame is the header, every further one a record. scan.h5 is built from
// it at the end, and can be built again.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host/formats/provenance.hpp"
#include "host/formats/scan_table.hpp"

namespace umov::formats {

/// What has to be known to build the scan file without the program that measured.
struct JournalHeader {
  std::uint32_t program_id = 0;  ///< hash of the plan; a resumed scan must have the same
  std::uint64_t row_count = 0;   ///< rows of the whole program
  Provenance provenance;         ///< with the plan's text
  std::vector<std::pair<std::string, std::string>> keys;  ///< header keys of the scan
  std::vector<Block> blocks;                              ///< of the whole program
};

/// One row of a ScanTable; see there for units.
struct ScanRecord {
  std::int64_t index = 0;
  double time_s = 0;
  double theta_i_deg = 0, theta_r_deg = 0, phi_r_deg = 0, wavelength_nm = 0;
  double polarizer_deg = 0, analyzer_deg = 0;
  int direction = 1;
  double gain = 1;
  double x_v = 0, y_v = 0, x_se_v = 0, y_se_v = 0, monitor_v = 0;
  bool saturated = false;
  bool shutter_open = true;
};

void append(ScanTable& table, const ScanRecord& record);

/// A journal as read. Records are in the order they were written; of records with the same index
/// only the first is kept.
struct Journal {
  JournalHeader header;
  std::vector<ScanRecord> records;
  std::uint64_t valid_bytes = 0;    ///< end of the last good frame
  std::uint64_t torn_bytes = 0;     ///< behind it: a write that was cut off
  std::uint64_t damaged_bytes = 0;  ///< between good frames: the disk lied; those rows are missing

  /// Lowest row index that has no record: where a resumed scan goes on.
  std::int64_t next_index() const;
  bool complete() const { return next_index() >= static_cast<std::int64_t>(header.row_count); }
};

/// Throws umov::Error for a missing or foreign file and for a header that is cut off or damaged.
Journal read_journal(const std::filesystem::path& path);
/// The same from memory; `name` stands in messages.
Journal parse_journal(std::span<const std::byte> bytes, const std::string& name);

/// Sorted by index, rounded to canonical digits, blocks cut to the rows that are there.
ScanTable build_scan_table(const Journal& journal);

/// Writer; owns the file and an advisory lock on it. Move-only.
class JournalWriter {
 public:
  /// Refuses a file that exists. Header and directory entry are on disk when it returns.
  static JournalWriter create(const std::filesystem::path& path, const JournalHeader& header);
  /// Recovers what is there (`recovered`), cuts a torn tail off and appends from then on.
  static JournalWriter resume(const std::filesystem::path& path, Journal& recovered);

  JournalWriter(JournalWriter&& other) noexcept;
  JournalWriter& operator=(JournalWriter&& other) noexcept;
  JournalWriter(const JournalWriter&) = delete;
  JournalWriter& operator=(const JournalWriter&) = delete;
  ~JournalWriter();

  /// Hands records to the operating system in the order given. Throws umov::Error (disk full …);
  /// then nothing more can be appended and the journal must be resumed.
  void append(std::span<const ScanRecord> records);
  /// Returns when everything appended is on the medium; only then may records be acknowledged.
  void sync();

 private:
  JournalWriter(int descriptor, std::filesystem::path path);
  int descriptor_ = -1;
  bool failed_ = false;
  std::filesystem::path path_;
};

}  // namespace umov::formats
