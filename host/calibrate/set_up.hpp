// Which rows of a scan were taken with the plain set-up, which with the shutter closed, and which
// with something changed (a turned sample, an iris …) so that they are no measurement of the
// sample.
#pragma once

#include <string>
#include <vector>

#include "host/formats/scan_table.hpp"

namespace umov::calibrate {

enum class RowUse {
  plain,    ///< an ordinary measurement; neutral-density blocks too, as the monitor sees the filter
  closed,   ///< shutter closed: the dark signal
  changed,  ///< the set-up differs from the calibrated one
};

struct ScanRows {
  std::vector<RowUse> row;         ///< one entry a record
  std::vector<int> block;          ///< number of the record's block in the table, -1 = outside any
  std::vector<std::string> notes;  ///< sentences: what was left out or taken with care, and why
};

/// Sorts the rows of `scan` by its blocks (menu names `flip`, `iris`, `long_pass`, `no_sample` and
/// blocks with settings that change the light path are `changed`; unknown names too).
ScanRows sort_rows(const formats::ScanTable& scan);

/// Angle in degrees between an exit direction and the way back to the source.
double from_retro_deg(double theta_i_deg, double theta_r_deg, double phi_r_deg);

}  // namespace umov::calibrate
