// What both photometric formats share: checks, and planes spread over the whole circle.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "host/formats/photometry.hpp"

namespace umov::formats {

/// Planes as a file lists them: each stands at `c_deg` and holds `candela[i]`. Fills the whole
/// circle by mirroring what the file leaves out: a last plane of 0, 90, 180 or 270 (from 90) tells
/// how. Throws umov::Error naming `file`.
void set_planes(Photometry& into, const std::vector<double>& c_deg,
                const std::vector<std::vector<double>>& candela, const std::string& file);

/// Candela, lumens, watts and millimetres beyond this are no luminaire's.
inline constexpr double largest_quantity = 1e15;

/// Refuses lumens, watts and sizes that no luminaire has; lumens and sizes must not be negative.
void check_quantities(const Photometry& photometry, const std::string& file);

/// Names as both formats can hold them: ASCII on one line, at most so long, without blanks at the
/// ends; what is no letter of it becomes a question mark.
std::string printable(const std::string& text, std::size_t most = 240);

/// Refuses angles that do not rise or leave [low, high].
void check_angles(const std::vector<double>& deg, double low, double high, const char* what,
                  const std::string& file);

}  // namespace umov::formats
