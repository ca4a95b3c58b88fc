// Table 2 of [R]: reflectance of three standards at three wavelengths by their maker, by a
// spectrophotometer, and computed from in-plane BRDF, for comparison with a campaign's own.
#pragma once

#include <optional>
#include <string_view>

namespace umov::calibrate {

struct PublishedReflectance {
  double maker, spectrophotometer, computed;
};

/// `standard` is SRS-99, SRS-70 or SRS-50; wavelengths 532, 633, 814 nm within 0.5 nm.
std::optional<PublishedReflectance> published_reflectance(std::string_view standard,
                                                          double wavelength_nm);

}  // namespace umov::calibrate
