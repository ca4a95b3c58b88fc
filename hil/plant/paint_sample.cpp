#include "hil/plant/paint_sample.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "hil/plant/quadrature.hpp"
#include "host/optics/fresnel.hpp"

namespace umov::plant {
namespace {

constexpr double pi = optics::pi;

double forward_norm(double width_rad) {
  // At normal incidence α = θr: N = 2π ∫ exp(-θ²/2w²) cos θ sin θ dθ, in pieces of two widths.
  const QuadratureRule& rule = gauss_legendre(24);
  double sum = 0.0;
  for (double from = 0.0; from < pi / 2.0; from += 2.0 * width_rad) {
    const double span = std::min(2.0 * width_rad, pi / 2.0 - from);
    for (std::size_t i = 0; i < rule.node.size(); ++i) {
      const double theta = from + span * rule.node[i];
      sum += rule.weight[i] * span * std::exp(-theta * theta / (2.0 * width_rad * width_rad)) *
             std::cos(theta) * std::sin(theta);
    }
  }
  return 2.0 * pi * sum;
}

}  // namespace

double mean_transmittance(double n, double kappa) {
  // In t = cos θ the integral is 2∫ T t dt over (0, 1), smooth to the ends.
  const QuadratureRule& rule = gauss_legendre(64);
  double sum = 0.0;
  for (std::size_t i = 0; i < rule.node.size(); ++i) {
    const double cosine = rule.node[i];
    sum += rule.weight[i] * 2.0 * cosine * optics::transmittance(n, kappa, cosine);
  }
  return sum;
}

PaintSample::PaintSample(std::string name, PaintParameters parameters)
    : name_(std::move(name)),
      parameters_(std::move(parameters)),
      surface_{parameters_.sigma_um, parameters_.tau_um},
      fs_width_rad_(optics::radians(parameters_.fs_width_deg)),
      fs_norm_(forward_norm(fs_width_rad_)) {}

Mueller PaintSample::brdf(const Beam& in, const Beam& out, double wavelength_nm) const {
  Mueller m = optics::zero_mueller<double>();
  const double cos_i = -in.k.z;
  const double cos_r = out.k.z;
  if (cos_i <= 0.0 || cos_r <= 0.0) return m;
  const double n = parameters_.n.at(wavelength_nm);
  const double kappa = parameters_.kappa.at(wavelength_nm);

  const double k_dd = parameters_.k_dd.at(wavelength_nm);
  if (k_dd != 0.0) {
    const double factor =
        k_dd * directional_diffuse_factor(surface_, in.k, out.k, wavelength_nm * 1e-3);
    m += factor * facet_reflection(n, kappa, in, out);
  }

  const double k_fs = parameters_.k_fs.at(wavelength_nm);
  if (k_fs != 0.0) {
    const Vec3 mirror_direction(in.k.x, in.k.y, -in.k.z);
    const Vec3 across = optics::cross(mirror_direction, out.k);
    const double alpha =
        std::atan2(std::sqrt(optics::dot(across, across)), optics::dot(mirror_direction, out.k));
    const double lobe = std::exp(-alpha * alpha / (2.0 * fs_width_rad_ * fs_width_rad_)) / fs_norm_;
    const double a = parameters_.fs_polarization.at(wavelength_nm);
    Mueller in_plane = optics::zero_mueller<double>();
    optics::set_element(in_plane, 0, 0, 1.0);
    optics::set_element(in_plane, 1, 1, a);
    optics::set_element(in_plane, 2, 2, -a);
    optics::set_element(in_plane, 3, 3, -a);
    m += k_fs * lobe *
         optics::to_beam_bases(in_plane, in, out, optics::scattering_plane_normal(in, out));
  }

  double uniform = parameters_.k_udf.at(wavelength_nm) / pi;
  const double k_uds = parameters_.k_uds.at(wavelength_nm);
  if (k_uds != 0.0) {
    // T̄ depends on the index alone; lasers are few, so the last value is nearly always the one
    // wanted.
    thread_local double cached_n = -1.0, cached_kappa = -1.0, cached_mean = 0.0;
    if (n != cached_n || kappa != cached_kappa) {
      cached_mean = mean_transmittance(n, kappa);
      cached_n = n;
      cached_kappa = kappa;
    }
    uniform += k_uds / pi * optics::transmittance(n, kappa, cos_i) *
               optics::transmittance(n, kappa, cos_r) /
               (optics::transmittance(n, kappa, 1.0) * cached_mean);
  }
  optics::set_element(m, 0, 0, optics::element(m, 0, 0) + uniform);
  return m;
}

Mueller PaintSample::mirror(const Beam& in, const Beam& out, double wavelength_nm) const {
  const double cosine = -in.k.z;
  if (cosine <= 0.0) return optics::zero_mueller<double>();
  const double g = surface_.roughness_phase(cosine, cosine, wavelength_nm * 1e-3);
  const double factor =
      parameters_.k_dd.at(wavelength_nm) * std::exp(-g) * surface_.shadowing(cosine, cosine);
  if (factor < 1e-15) return optics::zero_mueller<double>();
  return factor * facet_reflection(parameters_.n.at(wavelength_nm),
                                   parameters_.kappa.at(wavelength_nm), in, out);
}

std::vector<Truth> PaintSample::truth(double wavelength_nm) const {
  return {{"n", parameters_.n.at(wavelength_nm), "1"},
          {"kappa", parameters_.kappa.at(wavelength_nm), "1"},
          {"sigma_um", parameters_.sigma_um, "um"},
          {"tau_um", parameters_.tau_um, "um"},
          {"slope_rms", 2.0 * parameters_.sigma_um / parameters_.tau_um / std::sqrt(2.0), "1"},
          {"k_dd", parameters_.k_dd.at(wavelength_nm), "1"},
          {"k_udf", parameters_.k_udf.at(wavelength_nm), "1"},
          {"k_uds", parameters_.k_uds.at(wavelength_nm), "1"},
          {"k_fs", parameters_.k_fs.at(wavelength_nm), "1"},
          {"fs_width_deg", parameters_.fs_width_deg, "deg"},
          {"fs_polarization", parameters_.fs_polarization.at(wavelength_nm), "1"}};
}

double PaintSample::slope_rms() const {
  return std::sqrt(2.0) * parameters_.sigma_um / parameters_.tau_um;
}

double PaintSample::surface_index(double wavelength_nm) const {
  return parameters_.n.at(wavelength_nm);
}

std::shared_ptr<const Sample> PaintSample::with_slopes(double factor) const {
  PaintParameters changed = parameters_;
  changed.tau_um /= factor;
  return std::make_shared<PaintSample>(name_, std::move(changed));
}

std::shared_ptr<const Sample> PaintSample::immersed(double medium_n) const {
  // Inside the medium waves are shorter: the same as a surface that is larger by its index.
  PaintParameters changed = parameters_;
  changed.n = parameters_.n.scaled(1.0 / medium_n);
  changed.kappa = parameters_.kappa.scaled(1.0 / medium_n);
  changed.sigma_um *= medium_n;
  changed.tau_um *= medium_n;
  return std::make_shared<PaintSample>(name_, std::move(changed));
}

double PaintSample::feature_width_rad() const {
  // An exit-direction lobe is twice as wide as the slopes.
  return std::min(2.0 * parameters_.sigma_um / parameters_.tau_um * std::sqrt(2.0), fs_width_rad_);
}

}  // namespace umov::plant
