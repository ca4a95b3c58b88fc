// Pieces of plotly.js figures.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "host/cli/study/page.hpp"

namespace umov::study {

/// Colour of curves at a wavelength in nm.
std::string colour_of(double wavelength_nm);

/// A measured curve: points, with one-sigma bars where `u` is not empty. NaN leaves a gap.
Json points(std::string_view name, std::span<const double> x, std::span<const double> y,
            std::span<const double> u, std::string_view colour);
/// A continuous curve; `dash` as plotly.js names it.
Json line(std::string_view name, std::span<const double> x, std::span<const double> y,
          std::string_view colour, std::string_view dash = "solid");

/// {"xaxis": …, "yaxis": …} with titles; merge more into it.
Json axes(std::string_view x_title, std::string_view y_title, bool log_y = false);

/// Puts a trace on the axes x2/y2 …, `number` from 1.
Json on(Json trace, int number);

}  // namespace umov::study
