#include "hil/plant/rough_surface.hpp"

#include <algorithm>
#include <cmath>

#include "host/optics/fresnel.hpp"

namespace umov::plant {
namespace {

constexpr double pi = optics::pi;

/// tan θ of a direction whose cosine is given.
double tangent(double cosine) {
  return std::sqrt(std::max(0.0, 1.0 - cosine * cosine)) / cosine;
}

/// S(θ) of P10 for x = cot θ · τ/(2 σ0).
double smith(double x) {
  if (x > 6.0) return 1.0;  // 1 - S < 1e-16
  const double lambda = 0.5 * (std::exp(-x * x) / (std::sqrt(pi) * x) - std::erfc(x));
  return (1.0 - 0.5 * std::erfc(x)) / (1.0 + lambda);
}

/// log of g^m e^{-g} / Γ(m+1) / m · exp(-a/m), continuous in m.
double log_term(double g, double log_g, double a, double m) {
  const double log_m = std::log(m);
  if (m < 30.0) return m * log_g - g - std::lgamma(m + 1.0) - log_m - a / m;
  // Stirling's series; the first term left out is below 1e-14 from m = 30 on.
  const double inverse = 1.0 / m;
  const double inverse2 = inverse * inverse;
  const double correction = inverse * (1.0 / 12.0 - inverse2 * (1.0 / 360.0 - inverse2 / 1260.0));
  return m * (log_g - log_m + 1.0) - g - 0.5 * std::log(2.0 * pi) - 1.5 * log_m - correction -
         a * inverse;
}

}  // namespace

double HeightStatistics::visible_sigma_um(double cos_i, double cos_r) const {
  if (sigma_um <= 0.0) return 0.0;
  const auto blocked = [&](double cosine) {
    const double t = tangent(cosine);
    return t > 0.0 ? t * std::erfc(tau_um / (2.0 * sigma_um * t)) : 0.0;
  };
  const double right = (sigma_um / 4.0) * (blocked(cos_i) + blocked(cos_r)) / std::sqrt(pi / 2.0);
  if (right <= 0.0) return sigma_um;
  // z0 = right · exp(-z0²/2σ0²): the function z - right·exp(…) rises monotonically for z >= 0, and
  // Newton from a point above the root of a function of this shape stays in bounds when clamped to
  // [0, right].
  double z = std::min(right, sigma_um);
  for (int i = 0; i < 60; ++i) {
    const double e = right * std::exp(-z * z / (2.0 * sigma_um * sigma_um));
    const double next = std::clamp(z - (z - e) / (1.0 + e * z / (sigma_um * sigma_um)), 0.0, right);
    if (std::abs(next - z) <= 1e-15 * sigma_um) {
      z = next;
      break;
    }
    z = next;
  }
  const double ratio = z / sigma_um;
  return sigma_um / std::sqrt(1.0 + ratio * ratio);
}

double HeightStatistics::shadowing(double cos_i, double cos_r) const {
  const auto one = [&](double cosine) {
    const double t = tangent(cosine);
    return t > 0.0 ? smith(tau_um / (2.0 * sigma_um * t)) : 1.0;
  };
  return one(cos_i) * one(cos_r);
}

double HeightStatistics::roughness_phase(double cos_i, double cos_r, double wavelength_um) const {
  const double root = 2.0 * pi * visible_sigma_um(cos_i, cos_r) / wavelength_um * (cos_i + cos_r);
  return root * root;
}

double phase_series(double g, double a) {
  if (g <= 0.0) return 0.0;
  const double log_g = std::log(g);
  // The largest term, as a continuous function of m: log(g/m) - 3/(2m) + a/m² = 0 (Stirling), by
  // Newton on log m, which is monotone.
  double u = std::log(std::max({g, std::cbrt(a), 1.0}));
  for (int i = 0; i < 100; ++i) {
    const double m = std::exp(u);
    const double f = log_g - u - 1.5 / m + a / (m * m);
    const double df = -1.0 + 1.5 / m - 2.0 * a / (m * m);
    double step = df < -1e-3 ? f / df : -f;
    step = std::clamp(step, -1.0, 1.0);
    u -= step;
    if (std::abs(step) < 1e-9) break;
  }
  const double peak = std::max(1.0, std::exp(u));
  const double width = std::sqrt(1.0 / (1.0 / peak + 2.0 * a / (peak * peak * peak)));
  const double low = peak - 9.0 * width;
  const double high = peak + 9.0 * width + 12.0;
  if (low < 40.0) {
    // Few terms: the sum itself.
    const int first = std::max(1, static_cast<int>(std::floor(low)) - 12);
    const int last = static_cast<int>(std::ceil(high)) + 12;
    double sum = 0.0;
    for (int m = first; m <= last; ++m) sum += std::exp(log_term(g, log_g, a, m));
    return sum;
  }
  // Many terms that follow a bell: every `stride`-th one, times the stride. For a Gaussian of rms
  // width w the trapezoid sum with spacing w/2 is exact to exp(-8π²).
  const double stride = std::max(1.0, std::floor(0.5 * width));
  const double first = std::floor(low);
  double sum = 0.0;
  for (double m = first; m <= high; m += stride) sum += std::exp(log_term(g, log_g, a, m));
  return sum * stride;
}

double directional_diffuse_factor(const HeightStatistics& surface, const Vec3& k_i, const Vec3& k_r,
                                  double wavelength_um) {
  const double cos_i = -k_i.z;
  const double cos_r = k_r.z;
  if (cos_i <= 0.0 || cos_r <= 0.0) return 0.0;
  const Vec3 v = k_r - k_i;  // of unit directions; the wave vector is 2π/λ times it
  const double v2 = optics::dot(v, v);
  const double root_g = v2 / v.z;  // G = root_g²; 2 at normal incidence
  const double wave_number = 2.0 * pi / wavelength_um;
  const double v_xy2 = wave_number * wave_number * (v.x * v.x + v.y * v.y);
  const double tau2 = surface.tau_um * surface.tau_um;
  const double g = surface.roughness_phase(cos_i, cos_r, wavelength_um);
  const double d =
      pi * pi * tau2 / (4.0 * wavelength_um * wavelength_um) * phase_series(g, 0.25 * v_xy2 * tau2);
  return root_g * root_g * surface.shadowing(cos_i, cos_r) * d / (pi * cos_i * cos_r);
}

double facet_factor(double slope_rms, const Vec3& k_i, const Vec3& k_r) {
  const double cos_i = -k_i.z;
  const double cos_r = k_r.z;
  if (cos_i <= 0.0 || cos_r <= 0.0) return 0.0;
  const Vec3 v = k_r - k_i;
  const double cos_h = v.z / std::sqrt(optics::dot(v, v));
  const double cos_h2 = cos_h * cos_h;
  const double tan_h2 = (1.0 - cos_h2) / cos_h2;
  const double s2 = slope_rms * slope_rms;
  const double p = std::exp(-tan_h2 / (2.0 * s2)) / (2.0 * pi * s2 * cos_h2 * cos_h2);
  const auto seen = [&](double cosine) {
    const double t = tangent(cosine);
    return t > 0.0 ? smith(1.0 / (std::sqrt(2.0) * slope_rms * t)) : 1.0;
  };
  return p * seen(cos_i) * seen(cos_r) / (4.0 * cos_i * cos_r);
}

double facet_cosine(const Vec3& k_i, const Vec3& k_r) {
  const Vec3 v = k_r - k_i;
  return std::min(1.0, 0.5 * std::sqrt(optics::dot(v, v)));
}

Mueller facet_reflection(double n, double kappa, const Beam& in, const Beam& out) {
  const Mueller m = optics::reflection_mueller(n, kappa, facet_cosine(in.k, out.k));
  return optics::to_beam_bases(m, in, out, optics::scattering_plane_normal(in, out));
}

}  // namespace umov::plant
