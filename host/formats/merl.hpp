// MERL BRDF data base files (.binary): docs/formats/merl.md.
#pragma once

#include <string>
#include <string_view>

#include "host/formats/half_angle_table.hpp"
#include "host/formats/table_file.hpp"

namespace umov::formats {

/// The only sampling that MERL files have.
inline constexpr HalfAngleCells merl_cells = {90, 90, 180};

bool looks_like_merl(std::string_view bytes);

/// Three little-endian 32-bit sizes, which must be those of `cells`, then the doubles of
/// HalfAngleTable. Throws umov::Error with the byte.
std::shared_ptr<const HalfAngleTable> parse_merl(std::string_view bytes, const std::string& name,
                                                 const HalfAngleCells& cells);
TablePtr read_merl(std::string_view bytes, const std::string& name);

/// A HalfAngleTable of `cells` is written number by number; any other table is sampled at the
/// middles of the cells. Channels: the table at HalfAngleTable::channel_um, or at the wavelengths
/// asked for: three ascending ones become blue, green, red, a single one fills all channels.
std::string merl_bytes(const brdf::Table& table, const TableWriting& writing,
                       const HalfAngleCells& cells);
std::string write_merl(const brdf::Table& table, const TableWriting& writing);

}  // namespace umov::formats
