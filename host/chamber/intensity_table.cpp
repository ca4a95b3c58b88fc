#include "host/chamber/intensity_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"

namespace umov::chamber {

using optics::pi;

namespace {

constexpr std::size_t around = 72;
constexpr std::size_t along = 90;

}  // namespace

IntensityTable::IntensityTable(const formats::Photometry& photometry, const std::string& name)
    : photometry_(photometry) {
  const double front = photometry_.zonal_lm(0.0, 90.0);
  const double back = photometry_.zonal_lm(90.0, 180.0);
  if (!(front > 0.0) || back > 0.01 * (front + back)) {
    throw Error(Place{name},
                fmt::format("{:.4g} lm go to the front and {:.4g} lm to the back", front, back),
                "a luminous face shines to its front: give a file with its light within 90°");
  }
  scale_ = 1.0 / front;
  for (std::size_t c = 0; c <= around; ++c) {
    edge_c_.push_back(2.0 * pi * static_cast<double>(c) / around);
  }
  for (std::size_t g = 0; g <= along; ++g) {
    edge_cos_.push_back(std::cos(0.5 * pi * static_cast<double>(g) / along));
  }
  edge_cos_.back() = 0.0;
  double sum = 0.0;
  share_before_.push_back(0.0);
  for (std::size_t c = 0; c < around; ++c) {
    for (std::size_t g = 0; g < along; ++g) {
      double mean = 0.0;
      for (const double s : {0.1, 0.5, 0.9}) {
        for (const double t : {0.1, 0.5, 0.9}) {
          const double phi = edge_c_[c] + s * (edge_c_[c + 1] - edge_c_[c]);
          const double z = edge_cos_[g] + t * (edge_cos_[g + 1] - edge_cos_[g]);
          const double sine = std::sqrt(1.0 - z * z);
          mean += intensity({sine * std::cos(phi), sine * std::sin(phi), z}) / 9.0;
        }
      }
      // A little everywhere, so that no light is missed between the nine points.
      sum += (mean + 1e-3 / (2.0 * pi)) * (edge_c_[c + 1] - edge_c_[c]) *
             (edge_cos_[g] - edge_cos_[g + 1]);
      share_before_.push_back(sum);
    }
  }
  for (double& share : share_before_) share /= sum;
}

double IntensityTable::intensity(const Vec3& direction) const {
  if (!(direction.z > 0.0)) return 0.0;
  return scale_ * photometry_.intensity(optics::degrees(std::atan2(direction.y, direction.x)),
                                        optics::degrees(std::acos(std::min(1.0, direction.z))));
}

IntensityTable::Launch IntensityTable::launch(double u1, double u2, double u3) const {
  const auto above = std::upper_bound(share_before_.begin(), share_before_.end(), u3);
  const auto cell = std::min<std::size_t>(
      static_cast<std::size_t>(std::max<std::ptrdiff_t>(1, above - share_before_.begin())) - 1,
      around * along - 1);
  const std::size_t c = cell / along;
  const std::size_t g = cell % along;
  const double phi = edge_c_[c] + u1 * (edge_c_[c + 1] - edge_c_[c]);
  const double z = std::max(1e-9, edge_cos_[g] + u2 * (edge_cos_[g + 1] - edge_cos_[g]));
  const double sine = std::sqrt(1.0 - z * z);
  const Vec3 direction(sine * std::cos(phi), sine * std::sin(phi), z);
  const double density = (share_before_[cell + 1] - share_before_[cell]) /
                         ((edge_c_[c + 1] - edge_c_[c]) * (edge_cos_[g] - edge_cos_[g + 1]));
  return {direction, intensity(direction) / density};
}

}  // namespace umov::chamber
