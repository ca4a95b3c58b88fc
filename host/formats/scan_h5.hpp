// scan.h5: a scan in HDF5, one dataset a column, with units, provenance and a checksum.
//
// Layout: /records/<column> (columns of the Scan CSV; `unit` attributes; shutter as 0/1 with the
// attribute `enum` listing "closed","open"; an open polariser or analyser is NaN), /blocks/{name,
// first,last,settings}, /header/{key,value} (the `# key: value` lines in order, also copied to root
// attributes of the same name), root attributes of `Provenance`, `format` = "umov scan h5" and
// `content_sha256`, the SHA-256 of all of it that is data.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "host/formats/provenance.hpp"
#include "host/formats/scan_table.hpp"

namespace umov::formats {

struct ScanFile {
  ScanTable table;
  Provenance provenance;
  std::string content_sha256;  ///< of the table, 64 hexadecimal digits
};

/// Reads and verifies the checksum. Throws umov::Error for a file that is missing, truncated,
/// corrupt, foreign or not within the contract.
ScanFile read_scan_h5(const std::filesystem::path& path);

/// The same from memory; `name` stands in messages.
ScanFile parse_scan_h5(std::string_view bytes, const std::string& name);

/// Writes beside the target and renames, so that a failure leaves an older file as it was. Replaces
/// an existing file. `device` and `role` also come from the table's keys where provenance has none.
void write_scan_h5(const std::filesystem::path& path, const ScanTable& table,
                   const Provenance& provenance);

/// SHA-256 of keys, blocks and columns, independent of the file that holds them.
std::string content_sha256(const ScanTable& table);

/// Either kind by its content: scan.h5 or Scan CSV.
ScanFile read_scan(const std::filesystem::path& path);

}  // namespace umov::formats
