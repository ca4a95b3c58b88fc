#include "host/cli/study/plots.hpp"

#include <cmath>
#include <vector>

namespace umov::study {
namespace {

/// Rounded to what a figure can show; null where there is no value.
Json rounded(std::span<const double> values) {
  Json out = Json::array();
  for (const double value : values) {
    if (!std::isfinite(value)) {
      out.push_back(nullptr);
    } else if (value == 0) {
      out.push_back(0.0);
    } else {
      const double scale = std::pow(10.0, 4 - std::floor(std::log10(std::abs(value))));
      out.push_back(std::round(value * scale) / scale);
    }
  }
  return out;
}

}  // namespace

std::string colour_of(double wavelength_nm) {
  if (wavelength_nm < 580) return "#16883a";
  if (wavelength_nm < 700) return "#d4331d";
  return "#74296f";
}

Json points(std::string_view name, std::span<const double> x, std::span<const double> y,
            std::span<const double> u, std::string_view colour) {
  Json trace = {{"type", "scatter"}, {"mode", "markers"},
                {"name", name},      {"x", rounded(x)},
                {"y", rounded(y)},   {"marker", {{"color", colour}, {"size", 5}}}};
  if (!u.empty())
    trace["error_y"] = {
        {"type", "data"}, {"array", rounded(u)}, {"color", colour}, {"thickness", 1}, {"width", 2}};
  return trace;
}

Json line(std::string_view name, std::span<const double> x, std::span<const double> y,
          std::string_view colour, std::string_view dash) {
  return {{"type", "scatter"}, {"mode", "lines"},
          {"name", name},      {"x", rounded(x)},
          {"y", rounded(y)},   {"line", {{"color", colour}, {"width", 1.8}, {"dash", dash}}}};
}

Json axes(std::string_view x_title, std::string_view y_title, bool log_y) {
  Json layout = {{"xaxis", {{"title", {{"text", x_title}}}}},
                 {"yaxis", {{"title", {{"text", y_title}}}}}};
  if (log_y) {
    layout["yaxis"]["type"] = "log";
    layout["yaxis"]["dtick"] = 1;
  }
  return layout;
}

Json on(Json trace, int number) {
  if (number > 1) {
    trace["xaxis"] = "x" + std::to_string(number);
    trace["yaxis"] = "y" + std::to_string(number);
  }
  return trace;
}

}  // namespace umov::study
