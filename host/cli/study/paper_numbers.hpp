// Numbers printed in the reflectometer paper [R], wavelength order 532, 633, 814 nm.
#pragma once

#include <array>

namespace umov::study::paper {

inline constexpr std::array<double, 3> wavelengths_nm = {532, 633, 814};

/// Table 2: directional-hemispherical reflectance of three Spectralon standards.
struct Standard {
  const char* name;    ///< the paper's
  const char* sample;  ///< the emulator's
  std::array<double, 3> maker, spectrophotometer, in_plane;
};
inline constexpr std::array<Standard, 3> table_2 = {{
    {"SRS-99", "white-99", {.990, .990, .990}, {.980, .989, .989}, {.989, .989, .989}},
    {"SRS-70", "white-70", {.660, .650, .620}, {.640, .630, .610}, {.653, .645, .614}},
    {"SRS-50", "white-50", {.500, .500, .500}, {.506, .505, .505}, {.518, .520, .519}},
}};

/// Table 3: reflectance of the red paint by spectrophotometer.
inline constexpr std::array<double, 3> table_3 = {.01, .47, .48};

/// Table 4: inversion of the red paint.
struct Inversion {
  std::array<double, 3> k_udf, k_uds, dhr;
};
inline constexpr Inversion table_4 = {
    {.0162, .0300, .0001}, {.0028, .4860, .4914}, {.0190, .4890, .4915}};

}  // namespace umov::study::paper
