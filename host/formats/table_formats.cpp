// The list of table formats. A new one is a line here and a reader or writer of its own.
#include <array>

#include "host/formats/astm.hpp"
#include "host/formats/cornell_brdf.hpp"
#include "host/formats/merl.hpp"
#include "host/formats/rgl_tensor.hpp"
#include "host/formats/scatmech_text.hpp"
#include "host/formats/table_csv.hpp"
#include "host/formats/table_file.hpp"
#include "host/formats/table_h5.hpp"
#include "host/formats/tensor_file.hpp"
#include "host/formats/window_xml.hpp"
#include "host/formats/zemax_bsdf.hpp"

namespace umov::formats {
namespace {

// {name, title, recognises, read, write, read_points, write_points, takes_mirror}; missing
// functions are nullptr.
constexpr auto formats = std::to_array<TableFormat>({
    {"table", "table of this program (table.h5)", looks_like_table_h5, read_table_h5,
     write_table_h5},
    {"merl", "MERL half-angle table, 3 channels (.binary)", looks_like_merl, read_merl, write_merl},
    {"rgl", "RGL / Mitsuba measured tensor (.bsdf)", looks_like_tensor_file, read_rgl, write_rgl},
    {"zemax", "Zemax tabular BSDF (.bsdf)", looks_like_zemax, read_zemax, write_zemax},
    {"window", "Radiance / WINDOW 6 XML over Klems patches (.xml)", is_window_xml,
     read_window_table, write_window_table, nullptr, nullptr, true},
    {"table-csv", "grid of directions as CSV", is_grid_csv, read_grid_csv, write_grid_csv},
    {"planes-csv", "in-plane and cross-plane profiles as CSV", is_planes_csv, read_planes_csv,
     write_planes_csv},
    {"scatmech", "SCATMECH / MIST model parameters", is_scatmech, read_scatmech, write_scatmech,
     nullptr, nullptr, true},
    {"astm", "ASTM E1392 / E2387 measured points", is_astm, nullptr, nullptr, read_astm,
     write_astm},
    {"cornell", "Cornell gonioreflectometer spectra (.brdf)", is_cornell_brdf, nullptr, nullptr,
     read_cornell_brdf, nullptr},
});

}  // namespace

std::span<const TableFormat> table_formats() {
  return formats;
}

}  // namespace umov::formats
