// RGL's tensor files (.bsdf): docs/formats/rgl.md.
#pragma once

#include <string>
#include <string_view>

#include "host/formats/rgl_table.hpp"
#include "host/formats/table_file.hpp"

namespace umov::formats {

/// Throws umov::Error with the byte for a damaged file, for missing or ill-shaped fields, and for
/// anisotropic surfaces (more than two azimuths of incidence).
TablePtr read_rgl(std::string_view bytes, const std::string& name);
/// A table that came from such a file goes back as it was. Any other is fitted: a half-vector
/// density from the table itself, 32 incidences, 96 x 96 warped values a wavelength (64 x 64 where
/// there are more than four). The file's
/// description says how far it is off its source.
std::string write_rgl(const brdf::Table& table, const TableWriting& writing);

/// The fit alone, without description.
RglData rgl_fit(const brdf::Table& table, const std::vector<double>& wavelengths_um,
                const std::function<void(double, double)>& progress = {});
std::string rgl_bytes(const RglData& data);

}  // namespace umov::formats
