#include "hil/plant/collection.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "hil/plant/quadrature.hpp"
#include "hil/plant/rays.hpp"

namespace umov::plant {
namespace {

constexpr double pi = optics::pi;

/// The sample's axes in the laboratory frame.
struct SampleFrame {
  Vec3 x, y, z;

  Vec3 into(const Vec3& v) const {
    return Vec3(optics::dot(v, x), optics::dot(v, y), optics::dot(v, z));
  }
  Beam into(const Beam& b) const { return {into(b.s), into(b.p), into(b.k)}; }
};

SampleFrame sample_frame(const MountConfig& mount, const Setup& setup, double theta_i) {
  // The tilt turns with the sample: it belongs to how the sample lies on its plate.
  const double turn = optics::radians(setup.sample_azimuth_deg);
  const double a = optics::radians(mount.tilt_in_plane_deg);
  const double b = optics::radians(mount.tilt_out_of_plane_deg);
  // The plate itself bends under gravity, however the sample lies on it.
  const double sag = optics::radians(mount.sag_deg) * std::sin(theta_i);
  const double tilt_x = a * std::cos(turn) - b * std::sin(turn) + sag;
  const double tilt_y = a * std::sin(turn) + b * std::cos(turn);
  const Vec3 z(std::sin(tilt_x) * std::cos(tilt_y), std::sin(tilt_y),
               std::cos(tilt_x) * std::cos(tilt_y));
  Vec3 x(std::cos(tilt_x), 0.0, -std::sin(tilt_x));
  if (turn != 0.0) x = std::cos(turn) * x + std::sin(turn) * optics::cross(z, x);
  return {x, optics::cross(z, x), z};
}

/// A beam deviated towards the p and the s axis of its basis.
Beam steered(const Beam& beam, double towards_p, double towards_s) {
  const double angle = std::hypot(towards_p, towards_s);
  return angle == 0.0 ? beam : tilted(beam, angle, std::atan2(towards_p, towards_s));
}

double angle_between(const Vec3& a, const Vec3& b) {
  const Vec3 across = optics::cross(a, b);
  return std::atan2(std::sqrt(optics::dot(across, across)), optics::dot(a, b));
}

/// Share of the beam on the sample, and share of the lit spot in the detector's field.
double spot_losses(const PlantConfig& config, const Geometry& geometry) {
  double share = 1.0;
  const double cos_i = std::max(1e-3, std::cos(geometry.theta_i));
  if (config.beam.over_sample > 0.0) {
    const double rms = 0.5 * config.beam.over_sample;  // in sample radii; 1/e² radius is two rms
    share *= gaussian_in_ellipse(rms / cos_i, rms, 1.0, 1.0, 0.0);
  }
  if (config.collection.beam_over_field > 0.0) {
    const double rms = 0.5 * config.collection.beam_over_field;
    const double cos_r = std::max(1e-3, std::cos(geometry.theta_r));
    share *= gaussian_in_ellipse(rms / cos_i, rms, 1.0 / cos_r, 1.0, geometry.phi_r);
  }
  return share;
}

double stray_per_sr(const CollectionConfig& config, const Vec3& k_r) {
  double level = config.stray_per_sr;
  if (config.stray_forward_per_sr != 0.0) {
    const double angle = angle_between(k_r, Vec3(1.0, 0.0, 0.0));
    const double width = optics::radians(config.stray_forward_width_deg);
    level += config.stray_forward_per_sr * std::exp(-angle * angle / (2.0 * width * width));
  }
  return level;
}

}  // namespace

Throughput collect(const Sample& sample, const PlantConfig& config, const Setup& setup,
                   const Geometry& geometry, double wavelength_nm, double line_width_nm) {
  const Beam in =
      steered(optics::incident_beam(geometry.theta_i), geometry.steer_in_p, geometry.steer_in_s);
  const Beam out = steered(optics::exit_beam(geometry.theta_r, geometry.phi_r),
                           geometry.steer_out_p, geometry.steer_out_s);
  const SampleFrame frame = sample_frame(config.mount, setup, geometry.theta_i);
  const CollectionConfig& optics_config = config.collection;
  const double iris = setup.iris_fraction;
  const double half_angle = optics::radians(optics_config.half_angle_deg) * iris;
  const double divergence = optics::radians(config.beam.divergence_rms_deg);
  const double solid_angle = optics_config.solid_angle_sr * iris * iris;

  // What the detector is open to: as a point it still stands for the aperture's solid angle.
  const double acceptance =
      half_angle > 0.0 ? half_angle : std::acos(1.0 - solid_angle / (2.0 * pi));

  Throughput result{optics::zero_mueller<double>(), optics::zero_mueller<double>()};
  if (!setup.sample_removed) {
    const auto value = [&](const Beam& ray_in, const Beam& ray_out, double wave) {
      const Beam local_in = frame.into(ray_in);
      const Beam local_out = frame.into(ray_out);
      return std::max(0.0, local_out.k.z) * sample.brdf(local_in, local_out, wave);
    };
    const auto exits = disc_rays(out, half_angle);
    for (const Ray& entry : gaussian_rays(in, divergence)) {
      for (const Ray& exit : exits) {
        result.diffuse += entry.weight * exit.weight * value(entry.beam, exit.beam, wavelength_nm);
      }
    }
    if (line_width_nm > 0.0) {
      // The line is narrow beside the sample's spectrum: its second-order share, on the central
      // ray.
      result.diffuse += 0.5 * (value(in, out, wavelength_nm - line_width_nm) +
                               value(in, out, wavelength_nm + line_width_nm)) -
                        value(in, out, wavelength_nm);
    }

    if (config.ghost.share > 0.0) {
      const Beam ghost = steered(out, -optics::radians(config.ghost.angle_deg), 0.0);
      result.diffuse += config.ghost.share * value(in, ghost, wavelength_nm);
    }
    const Beam local_out = frame.into(out);
    result.emitted =
        std::max(0.0, local_out.k.z) * sample.emission(frame.into(in), local_out, wavelength_nm);

    const Vec3 mirror_k = in.k - 2.0 * optics::dot(in.k, frame.z) * frame.z;
    const double off_axis = angle_between(mirror_k, out.k);
    if (off_axis < acceptance + 10.0 * divergence) {
      const double share = gaussian_in_disc(divergence, off_axis, acceptance);
      // The basis on the arm, carried to the mirrored ray.
      Vec3 s = out.s - optics::dot(out.s, mirror_k) * mirror_k;
      s *= 1.0 / std::sqrt(optics::dot(s, s));
      const Beam mirrored{s, optics::cross(mirror_k, s), mirror_k};
      result.mirror = share * sample.mirror(frame.into(in), frame.into(mirrored), wavelength_nm);
    }
  }

  const double losses = setup.sample_removed ? 1.0 : spot_losses(config, geometry);
  double open = 1.0;
  if (optics_config.retro_half_angle_deg > 0.0) {
    open -= disc_overlap(acceptance, optics::radians(optics_config.retro_half_angle_deg),
                         angle_between(out.k, Vec3(-in.k.x, -in.k.y, -in.k.z)));
  }
  result.diffuse *= losses * open;
  result.mirror *= losses * open;
  result.emitted *= losses * open * solid_angle;
  const double stray = stray_per_sr(optics_config, out.k);
  optics::set_element(result.diffuse, 0, 0, optics::element(result.diffuse, 0, 0) + stray * open);
  result.diffuse *= solid_angle;
  return result;
}

double gaussian_in_ellipse(double rms_x, double rms_y, double half_x, double half_y, double turn) {
  // In polar coordinates the radial integral is closed: ∫ r e^{-a r²/2} dr = (1 - e^{-a R²/2})/a.
  // Substituting the angle of the unit circle for that of the Gaussian's ellipse makes a constant.
  constexpr int steps = 256;
  double sum = 0.0;
  for (int i = 0; i < steps; ++i) {
    const double t = 2.0 * pi * (i + 0.5) / steps;
    const double x = rms_x * std::cos(t);  // point at radius 1 in units of rms
    const double y = rms_y * std::sin(t);
    const double along = (x * std::cos(turn) + y * std::sin(turn)) / half_x;
    const double across = (-x * std::sin(turn) + y * std::cos(turn)) / half_y;
    sum += 1.0 - std::exp(-0.5 / (along * along + across * across));
  }
  return sum / steps;
}

double gaussian_in_disc(double rms, double offset, double radius) {
  if (rms <= 0.0) return offset <= radius ? 1.0 : 0.0;
  // Rings about the disc's centre; the angular integral of the shifted Gaussian is I0, scaled by
  // exp(-x).
  const double r_max = radius / rms;
  const double d = offset / rms;
  const double from = std::max(0.0, std::min(d, r_max) - 9.0);
  const double to = std::min(r_max, d + 9.0);
  if (to <= from) return d < r_max ? 1.0 : 0.0;
  const auto scaled_bessel = [](double x) {
    if (x > 600.0) {
      const double u = 1.0 / x;
      return (1.0 + u * (1.0 / 8.0 + u * (9.0 / 128.0))) / std::sqrt(2.0 * pi * x);
    }
    return std::cyl_bessel_i(0.0, x) * std::exp(-x);
  };
  const QuadratureRule& rule = gauss_legendre(64);
  double sum = 0.0;
  for (std::size_t i = 0; i < rule.node.size(); ++i) {
    const double r = from + (to - from) * rule.node[i];
    sum += rule.weight[i] * r * std::exp(-0.5 * (r - d) * (r - d)) * scaled_bessel(r * d);
  }
  return std::min(1.0, (to - from) * sum);
}

double disc_overlap(double a, double b, double d) {
  if (d >= a + b) return 0.0;
  if (b >= a + d) return 1.0;
  if (a <= 0.0) return d < b ? 1.0 : 0.0;
  if (a >= b + d) return (b / a) * (b / a);
  const double angle_a = std::acos((d * d + a * a - b * b) / (2.0 * d * a));
  const double angle_b = std::acos((d * d + b * b - a * a) / (2.0 * d * b));
  const double area = a * a * (angle_a - 0.5 * std::sin(2.0 * angle_a)) +
                      b * b * (angle_b - 0.5 * std::sin(2.0 * angle_b));
  return area / (pi * a * a);
}

}  // namespace umov::plant
