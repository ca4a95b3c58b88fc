#include "hil/plant/surface_marks.hpp"

#include <algorithm>
#include <cmath>

#include "hil/plant/rough_surface.hpp"

namespace umov::plant {
namespace {

constexpr double longest_excitation_nm = 580.0;
constexpr double coat_index = 1.5;

/// Angle between two directions that are nearly the same.
double angle_between(const Vec3& a, const Vec3& b) {
  const Vec3 across = optics::cross(a, b);
  return std::atan2(std::sqrt(optics::dot(across, across)), optics::dot(a, b));
}

}  // namespace

Mueller MarkedSurface::brdf(const Beam& in, const Beam& out, double wavelength_nm) const {
  Mueller m = below().brdf(in, out, wavelength_nm);
  const double cos_i = -in.k.z;
  if (cos_i <= 0.0 || out.k.z <= 0.0) return m;
  if (config_.fringe_contrast != 0.0) {
    const double sine2 = 1.0 - std::pow(facet_cosine(in.k, out.k), 2.0);
    const double cos_inside = std::sqrt(1.0 - sine2 / (coat_index * coat_index));
    const double phase = 4.0 * optics::pi * coat_index * config_.fringe_thickness_um * cos_inside /
                         (1e-3 * wavelength_nm);
    m *= 1.0 + config_.fringe_contrast * std::cos(phase);
  }
  if (config_.lobe_weight != 0.0) {
    m += config_.lobe_weight * facet_factor(config_.lobe_slope, in.k, out.k) *
         facet_reflection(surface_index(wavelength_nm), 0.0, in, out);
  }
  if (config_.retro_peak_per_sr != 0.0) {
    const double angle = angle_between(out.k, Vec3(-in.k.x, -in.k.y, -in.k.z));
    const double width = optics::radians(config_.retro_width_deg);
    optics::set_element(
        m, 0, 0,
        optics::element(m, 0, 0) +
            config_.retro_peak_per_sr * std::exp(-angle * angle / (2.0 * width * width)));
  }
  if (config_.gradient_per_mm != 0.0) {
    const double place_mm = config_.beam_offset_mm / std::max(0.02, cos_i);
    m *= std::max(0.0, 1.0 + config_.gradient_per_mm * place_mm);
  }
  return m;
}

double MarkedSurface::emission(const Beam& in, const Beam& out, double wavelength_nm) const {
  double value = below().emission(in, out, wavelength_nm);
  if (wavelength_nm < longest_excitation_nm && in.k.z < 0.0 && out.k.z > 0.0) {
    value += config_.fluorescence_yield_532 / optics::pi;
  }
  return value;
}

std::shared_ptr<const Sample> MarkedSurface::with_slopes(double factor) const {
  auto changed = below().with_slopes(factor);
  return changed ? std::make_shared<MarkedSurface>(std::move(changed), config_) : nullptr;
}

std::shared_ptr<const Sample> MarkedSurface::immersed(double medium_n) const {
  auto changed = below().immersed(medium_n);
  return changed ? std::make_shared<MarkedSurface>(std::move(changed), config_) : nullptr;
}

}  // namespace umov::plant
