#include "hil/plant/facet_sample.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "hil/plant/rough_surface.hpp"

namespace umov::plant {
namespace {

constexpr double pi = optics::pi;

double across_slope(const FacetLobe& lobe) {
  return lobe.slope_y > 0.0 ? lobe.slope_y : lobe.slope;
}

/// Smith's masking of one beam for normal slopes of rms `slope` along its azimuth.
double gaussian_masking(double slope, double cosine) {
  const double tangent = std::sqrt(std::max(0.0, 1.0 - cosine * cosine)) / cosine;
  if (tangent <= 0.0) return 1.0;
  const double x = 1.0 / (std::sqrt(2.0) * slope * tangent);
  if (x > 6.0) return 1.0;
  const double lambda = 0.5 * (std::exp(-x * x) / (std::sqrt(pi) * x) - std::erfc(x));
  return (1.0 - 0.5 * std::erfc(x)) / (1.0 + lambda);
}

double ggx_masking(double alpha, double cosine) {
  const double tangent2 = (1.0 - cosine * cosine) / (cosine * cosine);
  return 2.0 / (1.0 + std::sqrt(1.0 + alpha * alpha * tangent2));
}

/// rms slope along the azimuth of a beam.
double slope_along(const FacetLobe& lobe, const Vec3& k) {
  if (lobe.distribution == SlopeDistribution::ring) {
    return std::sqrt(0.5 * (lobe.steepness * lobe.steepness + lobe.slope * lobe.slope));
  }
  const double side2 = k.x * k.x + k.y * k.y;
  if (side2 < 1e-24 || lobe.slope_y <= 0.0) return lobe.slope;
  const double sx = lobe.slope * k.x;
  const double sy = lobe.slope_y * k.y;
  return std::sqrt((sx * sx + sy * sy) / side2);
}

double masking(const FacetLobe& lobe, const Vec3& k, double cosine) {
  if (lobe.distribution == SlopeDistribution::ggx)
    return ggx_masking(std::sqrt(2.0) * lobe.slope, cosine);
  return gaussian_masking(slope_along(lobe, k), cosine);
}

/// Density of slopes, before the norm.
double slope_density(const FacetLobe& lobe, double slope_x, double slope_y) {
  const double steep2 = slope_x * slope_x + slope_y * slope_y;
  switch (lobe.distribution) {
    case SlopeDistribution::gaussian: {
      const double x = slope_x / lobe.slope;
      const double y = slope_y / across_slope(lobe);
      return std::exp(-0.5 * (x * x + y * y));
    }
    case SlopeDistribution::ggx: {
      const double alpha2 = 2.0 * lobe.slope * lobe.slope;
      const double u = 1.0 + steep2 / alpha2;
      return 1.0 / (u * u);
    }
    case SlopeDistribution::ring: {
      const double d = (std::sqrt(steep2) - lobe.steepness) / lobe.slope;
      return std::exp(-0.5 * d * d);
    }
  }
  return 0.0;
}

}  // namespace

double lobe_norm(const FacetLobe& lobe) {
  switch (lobe.distribution) {
    case SlopeDistribution::gaussian:
      return 1.0 / (2.0 * pi * lobe.slope * across_slope(lobe));
    case SlopeDistribution::ggx:
      return 1.0 / (2.0 * pi * lobe.slope * lobe.slope);
    case SlopeDistribution::ring: {
      const double w = lobe.slope;
      const double t = lobe.steepness;
      const double area = w * w * std::exp(-0.5 * t * t / (w * w)) +
                          t * w * std::sqrt(0.5 * pi) * (1.0 + std::erf(t / (std::sqrt(2.0) * w)));
      return 1.0 / (2.0 * pi * area);
    }
  }
  return 0.0;
}

double lobe_factor(const FacetLobe& lobe, double norm, const Vec3& k_i, const Vec3& k_r) {
  const double cos_i = -k_i.z;
  const double cos_r = k_r.z;
  if (cos_i <= 0.0 || cos_r <= 0.0) return 0.0;
  const Vec3 v = k_r - k_i;
  const double cos_h2 = v.z * v.z / optics::dot(v, v);
  const double density = norm * slope_density(lobe, v.x / v.z, v.y / v.z) / (cos_h2 * cos_h2);
  return density * masking(lobe, k_i, cos_i) * masking(lobe, k_r, cos_r) / (4.0 * cos_i * cos_r);
}

FacetSample::FacetSample(std::string name, FacetParameters parameters)
    : name_(std::move(name)), parameters_(std::move(parameters)) {
  for (const FacetLobe& lobe : parameters_.lobes) norm_.push_back(lobe_norm(lobe));
}

Mueller FacetSample::brdf(const Beam& in, const Beam& out, double wavelength_nm) const {
  Mueller m = optics::zero_mueller<double>();
  const double cos_i = -in.k.z;
  const double cos_r = out.k.z;
  if (cos_i <= 0.0 || cos_r <= 0.0) return m;
  double facets = 0.0;
  for (std::size_t i = 0; i < norm_.size(); ++i) {
    facets +=
        parameters_.lobes[i].weight * lobe_factor(parameters_.lobes[i], norm_[i], in.k, out.k);
  }
  if (facets > 0.0) {
    m += facets * facet_reflection(parameters_.n.at(wavelength_nm),
                                   parameters_.kappa.at(wavelength_nm), in, out);
  }
  double unpolarised =
      parameters_.rho_d1.at(wavelength_nm) + parameters_.rho_d2.at(wavelength_nm) / (cos_i * cos_r);
  const double forward = parameters_.forward_per_sr.at(wavelength_nm);
  if (forward != 0.0) {
    const Vec3 across = optics::cross(Vec3(in.k.x, in.k.y, -in.k.z), out.k);
    const double angle = std::atan2(std::sqrt(optics::dot(across, across)),
                                    optics::dot(Vec3(in.k.x, in.k.y, -in.k.z), out.k));
    const double width = optics::radians(parameters_.forward_width_deg);
    unpolarised += forward * std::exp(-angle * angle / (2.0 * width * width));
  }
  optics::set_element(m, 0, 0, optics::element(m, 0, 0) + unpolarised);
  return m;
}

std::vector<Truth> FacetSample::truth(double wavelength_nm) const {
  std::vector<Truth> all = {{"n", parameters_.n.at(wavelength_nm), "1"},
                            {"kappa", parameters_.kappa.at(wavelength_nm), "1"},
                            {"rho_d1", parameters_.rho_d1.at(wavelength_nm), "1/sr"},
                            {"rho_d2", parameters_.rho_d2.at(wavelength_nm), "1/sr"}};
  for (std::size_t i = 0; i < parameters_.lobes.size(); ++i) {
    const std::string suffix = i == 0 ? "" : "_" + std::to_string(i + 1);
    all.push_back({"weight" + suffix, parameters_.lobes[i].weight, "1"});
    all.push_back({"slope_rms" + suffix, parameters_.lobes[i].slope, "1"});
  }
  return all;
}

double FacetSample::feature_width_rad() const {
  double width = optics::radians(parameters_.forward_width_deg);
  for (const FacetLobe& lobe : parameters_.lobes) {
    width = std::min({width, 2.0 * lobe.slope, 2.0 * across_slope(lobe)});
  }
  return width;
}

double FacetSample::slope_rms() const {
  return parameters_.lobes.empty() ? 0.0 : parameters_.lobes.front().slope;
}

double FacetSample::surface_index(double wavelength_nm) const {
  return parameters_.n.at(wavelength_nm);
}

std::shared_ptr<const Sample> FacetSample::with_slopes(double factor) const {
  FacetParameters changed = parameters_;
  for (FacetLobe& lobe : changed.lobes) {
    lobe.slope *= factor;
    lobe.slope_y *= factor;
    lobe.steepness *= factor;
  }
  return std::make_shared<FacetSample>(name_, std::move(changed));
}

std::shared_ptr<const Sample> FacetSample::immersed(double medium_n) const {
  FacetParameters changed = parameters_;
  changed.n = parameters_.n.scaled(1.0 / medium_n);
  changed.kappa = parameters_.kappa.scaled(1.0 / medium_n);
  return std::make_shared<FacetSample>(name_, std::move(changed));
}

}  // namespace umov::plant
