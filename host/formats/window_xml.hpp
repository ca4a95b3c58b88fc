// Radiance / WINDOW 6 XML: BSDF as a matrix over Klems patches. What the numbers mean:
// docs/formats/window-xml.md.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/formats/klems_matrix.hpp"
#include "host/formats/table_file.hpp"

namespace umov::formats {

/// One matrix of a file.
struct WindowBlock {
  std::string band;       ///< "Visible", "Solar", "CIE-X" …, or a number in `unit`
  std::string unit;       ///< "Integral", or of the wavelength: "Microns", "Nanometers"
  std::string direction;  ///< "Reflection Front" or "Reflection Back"
  KlemsMatrix matrix;
};

/// What a file says about reflection. Transmission is left out and counted.
struct WindowElement {
  std::string name, manufacturer;
  std::vector<WindowBlock> blocks;  ///< in file order, at least one
  std::size_t transmission_blocks = 0;
};

/// Most light that a patch may reflect: Monte Carlo noise of other programs, but no more.
inline constexpr double largest_reflectance = 1.01;

/// Reads all reflection matrices. Throws umov::Error with the line for text that is not XML, tensor
/// trees, bases that are unknown or have gaps, blocks with too few or too many numbers, numbers
/// that are negative or not finite, and patches that reflect more than largest_reflectance.
WindowElement parse_window_xml(std::string_view text, const std::string& file);

/// `comments` go to the top of the file, one line each. Every block's bases are defined in the
/// file; they must be the same in all blocks. Throws umov::Error as the reader does.
std::string window_xml_text(const WindowElement& element, std::span<const std::string> comments);

/// For the list of table formats. The table is the "Visible" "Reflection Front" matrix, or else the
/// first one in the file; one wavelength, 0.555 um for Visible. A KlemsTable is written as it is;
/// any other table is averaged over the 145 patches of the full basis, several wavelengths by
/// visible_shares(). The same matrix is written for front and back.
bool is_window_xml(std::string_view bytes);
TablePtr read_window_table(std::string_view bytes, const std::string& file);
std::string write_window_table(const brdf::Table& table, const TableWriting& writing);

}  // namespace umov::formats
