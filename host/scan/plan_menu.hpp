// The menu of further scans: what each entry changes, and the rows it takes unless a plan says
// more.
#pragma once

#include <array>
#include <string_view>

#include "host/scan/plan.hpp"

namespace umov::scan {

inline constexpr std::array<std::string_view, 12> menu_names = {
    "reverse", "serpentine", "flip",       "pm45",   "shutter",   "nd",
    "iris",    "oop",        "white_tile", "repeat", "long_pass", "no_sample"};

/// The entry `menu` (one of `menu_names`) of a plan whose own grid is `plan_grid`: its settings and
/// a thinned grid. Incidence: the second and the last angle of the plan, where it has more than
/// two. States: those with parallel axes, or the plan's first.
///
/// reverse     every detector angle, downwards
/// serpentine  every detector angle, every second line downwards
/// flip        sample turned by 180 deg about its normal
/// pm45        polariser and analyser at +-45 deg, each also against p or s
/// shutter     shutter closed
/// nd          neutral density of the plan, +1, +2 (at most 5), at the largest incidence
/// iris        half the aperture's diameter
/// oop         azimuths 30, 90, 150 deg, detector 5 to 80 deg
/// white_tile  white tile in the sample's place: a scan of its own, see scan_part.hpp
/// repeat      two reference points, eight times
/// long_pass   long-pass filter before the detector
/// no_sample   sample taken away
MenuBlock menu_block(std::string_view menu, const Grid& plan_grid);

}  // namespace umov::scan
