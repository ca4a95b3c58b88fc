// Scan CSV: the text form of a scan, exchanged with other programs without loss.
//
// Comment lines `# key: value` and `# block: NAME FIRST-LAST key=value …`, a header line with
// exactly the columns of `scan_columns()` in that order, then one line a lock-in record. Canonical
// numbers: time_s %.3f, angles and wavelength %g, x_v y_v %.8g, standard errors %.4g, monitor_v
// %.7g, integers plain, polariser and analyser also `open`, shutter `open` or `closed`.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <string_view>

#include "host/formats/scan_table.hpp"

namespace umov::formats {

/// Reads a Scan CSV. Tolerates a byte order mark, CRLF, blanks around fields, a leading `+` and
/// blank lines at the end. Throws umov::Error with file, line and column for everything else that
/// is not the contract: missing, unknown, repeated or misplaced columns, wrong units, bad or
/// non-finite numbers, angles out of range, an index that does not grow, blocks outside the rows,
/// no rows.
ScanTable read_scan_csv(const std::filesystem::path& path);
ScanTable read_scan_csv(std::istream& in, const std::string& name);
ScanTable parse_scan_csv(std::string_view text, const std::string& name);

/// Writes from the columns alone. A number whose canonical text does not read back to the same
/// value is written with as many digits as it needs, so nothing is lost; canonical files come back
/// byte by byte. The path form writes beside the target and renames. Throws umov::Error as
/// `validate` does.
void write_scan_csv(const ScanTable& table, const std::filesystem::path& path);
void write_scan_csv(const ScanTable& table, std::ostream& out);
std::string scan_csv_text(const ScanTable& table);

/// Rounds every column to its canonical number of digits (well below the noise of any lock-in), so
/// that the table's CSV is canonical.
void round_to_canonical(ScanTable& table);

/// Throws umov::Error (place: `name`, record, column) unless the table fulfils the contract: equal
/// column lengths, finite numbers, ranges, growing index, blocks inside the rows.
void validate(const ScanTable& table, const std::string& name);

}  // namespace umov::formats
