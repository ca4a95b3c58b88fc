#include "host/calibrate/published_reflectance.hpp"

#include <array>
#include <cmath>

namespace umov::calibrate {

namespace {

struct Row {
  std::string_view standard;
  double wavelength_nm;
  PublishedReflectance value;
};

constexpr std::array<Row, 9> table = {{
    {"SRS-99", 532, {0.990, 0.980, 0.989}},
    {"SRS-99", 633, {0.990, 0.989, 0.989}},
    {"SRS-99", 814, {0.990, 0.989, 0.989}},
    {"SRS-70", 532, {0.660, 0.640, 0.653}},
    {"SRS-70", 633, {0.650, 0.630, 0.645}},
    {"SRS-70", 814, {0.620, 0.610, 0.614}},
    {"SRS-50", 532, {0.500, 0.506, 0.518}},
    {"SRS-50", 633, {0.500, 0.505, 0.520}},
    {"SRS-50", 814, {0.500, 0.505, 0.519}},
}};

}  // namespace

std::optional<PublishedReflectance> published_reflectance(std::string_view standard,
                                                          double wavelength_nm) {
  for (const Row& row : table)
    if (row.standard == standard && std::abs(row.wavelength_nm - wavelength_nm) < 0.5)
      return row.value;
  return std::nullopt;
}

}  // namespace umov::calibrate
