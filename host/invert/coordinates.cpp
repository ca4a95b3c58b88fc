#include "host/invert/coordinates.hpp"

#include <algorithm>
#include <cmath>

namespace umov::invert {
namespace {

/// Where p = √x would have an infinite derivative, x stops here: p = 1e-5, whose square no
/// reflectance can see.
constexpr double smallest_square = 1e-10;

}  // namespace

const char* scale_name(Scale scale) {
  switch (scale) {
    case Scale::logarithmic:
      return "logarithmic";
    case Scale::square:
      return "square";
    case Scale::linear:
      break;
  }
  return "linear";
}

Scale scale_named(const std::string& name) {
  for (const Scale scale : {Scale::logarithmic, Scale::square}) {
    if (name == scale_name(scale)) return scale;
  }
  return Scale::linear;
}

double Coordinate::to_x(double parameter) const {
  const double p = std::clamp(parameter, lo, hi);
  switch (scale) {
    case Scale::logarithmic:
      return std::log(p);
    case Scale::square:
      return std::max(p * p, smallest_square);
    case Scale::linear:
      break;
  }
  return p;
}

double Coordinate::to_parameter(double x) const {
  switch (scale) {
    case Scale::logarithmic:
      return std::clamp(std::exp(x), lo, hi);
    case Scale::square:
      return std::clamp(std::sqrt(std::max(x, smallest_square)), lo, hi);
    case Scale::linear:
      break;
  }
  return std::clamp(x, lo, hi);
}

double Coordinate::slope(double x) const {
  switch (scale) {
    case Scale::logarithmic:
      return std::exp(x);
    case Scale::square:
      return 0.5 / std::sqrt(std::max(x, smallest_square));
    case Scale::linear:
      break;
  }
  return 1;
}

double Coordinate::lo_x() const {
  return to_x(lo);
}
double Coordinate::hi_x() const {
  return to_x(hi);
}

std::string bare_name(const std::string& name) {
  const std::size_t dot = name.rfind('.');
  return dot == std::string::npos ? name : name.substr(dot + 1);
}

Scale suitable_scale(const std::string& name, double lo, double hi) {
  if (bare_name(name) == "kappa" && lo >= 0) return Scale::square;
  if (lo > 0 && hi / lo >= 20) return Scale::logarithmic;
  return Scale::linear;
}

}  // namespace umov::invert
