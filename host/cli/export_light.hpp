// umov export of what luminaires are described with: intensity distributions and luminance maps.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace umov::cli {

/// A format of distributions (ies, ldt) or maps (exr, map-csv, png).
struct LightFormat {
  std::string_view name, title;
  bool map;
};
const std::vector<LightFormat>& light_formats();

/// Does `bytes` hold a distribution or a map: sim.h5 of `umov simulate chamber`, IES LM-63 or
/// EULUMDAT?
bool is_light(std::string_view bytes, const std::string& name);

struct LightExported {
  std::string what;                ///< "24 planes of 37 angles, 3.84 lm"
  std::vector<std::string> notes;  ///< what the format cannot hold, how far the file is off
};

/// Writes `output`, reads it back and compares. `program` is told as the maker where the source
/// names none. Throws umov::Error, also for a source that has no such thing.
LightExported export_light(const std::string& input, const std::string& bytes,
                           const std::string& output, const std::string& format,
                           const std::string& program);

}  // namespace umov::cli
