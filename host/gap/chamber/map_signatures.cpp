#include "host/gap/chamber/map_signatures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "host/chamber/synthetic_mcpet.hpp"
#include "host/gap/chamber/smoothing.hpp"
#include "host/optics/angles.hpp"

namespace umov::gap {
namespace {

using chamber::Map;
using chamber::MixingChamber;
using chamber::Surface;

/// Widths of lobes that are tried: an octave apart.
constexpr std::array lobe_widths{0.06, 0.12, 0.24};
constexpr double total = chamber::mcpet_total;

std::shared_ptr<const Surface> matt(double rho) {
  return std::make_shared<const Surface>("matt", chamber::Lambertian{rho});
}

std::shared_ptr<const Surface> glossy(double alpha) {
  return std::make_shared<const Surface>(
      "glossy", chamber::PlanesSurface(
                    chamber::synthetic_plastic(alpha, chamber::mcpet_theta_i_deg, 2.5), 0, total));
}

std::shared_ptr<const Surface> with_mirror(double share) {
  return std::make_shared<const Surface>("mirror", chamber::DiffuseSpecular{total, {0.0}, {share}});
}

/// One parameter: how the chamber is changed by `step` of it.
struct Change {
  Parameter parameter;
  double step;
  std::function<void(MixingChamber&, double)> apply;
};

Parameter sized(const char* name, const char* unit, const char* meaning, double usual) {
  Parameter p{name, unit, meaning};
  p.prior_u = usual;
  return p;
}

struct Cause {
  Effect effect;
  std::vector<Change> changes;
  bool on_matt_wall = false;  ///< the change is that of a diffuse wall
};

std::vector<Cause> causes() {
  std::vector<Cause> all;
  const auto effect = [](const char* name, const char* stage, const char* physics,
                         const char* family = "") {
    Effect e{name, stage, physics, "Opt. Eng. 52, 095101", {}, family};
    e.linear = true;
    return e;
  };
  for (const double alpha : lobe_widths) {
    Cause lobe{effect("near_specular_lobe", "wall",
                      "the wall scatters about the mirror direction, more so towards grazing: "
                      "blurred highlights and a brighter wall around them",
                      fmt::format("alpha {:g}", alpha).c_str()),
               {},
               true};
    lobe.effect.of_object = true;
    Parameter p = sized("strength", "1", "over that of a smooth plastic of n = 1.6", 0.5);
    p.lo = 0.0;
    lobe.changes = {{p, 1.0, [alpha](MixingChamber& c, double) { c.wall = glossy(alpha); }}};
    all.push_back(std::move(lobe));
  }
  Cause mirror{effect("mirror_reflection", "wall",
                      "a share of the light is mirrored: images of the sources with sharp edges"),
               {},
               true};
  mirror.effect.of_object = true;
  Parameter share = sized("share", "1", "mirrored part of the reflectance", 0.01);
  share.lo = 0.0;
  mirror.changes = {{share, 0.02, [](MixingChamber& c, double s) { c.wall = with_mirror(s); }}};
  all.push_back(std::move(mirror));
  Cause wall{
      effect("wall_absorption", "wall", "the wall absorbs more than the simulation's"), {}, true};
  wall.effect.of_object = true;
  wall.changes = {{sized("absorbed", "1", "more of each reflection", 0.005), 0.01,
                   [](MixingChamber& c, double s) { c.wall = matt(total - s); }}};
  all.push_back(std::move(wall));
  all.push_back(
      {effect("source_position", "sources", "holes and sources stand elsewhere on the base"),
       {{sized("shift_x_mm", "mm", "of all, to the right", 0.2), 0.4,
         [](MixingChamber& c, double s) { c.shift_x_mm += s; }},
        {sized("shift_y_mm", "mm", "of all, away from the observer", 0.2), 0.4,
         [](MixingChamber& c, double s) { c.shift_y_mm += s; }},
        {sized("ring_mm", "mm", "radius of their ring", 0.2), 0.4,
         [](MixingChamber& c, double s) { c.ring_radius_mm += s; }}}});
  all.push_back({effect("source_depth", "sources", "the sources lie deeper below the base"),
                 {{sized("depth_mm", "mm", "deeper", 0.1), 0.1,
                   [](MixingChamber& c, double s) { c.depth_mm += s; }}}});
  Cause imbalance{effect("exitance_imbalance", "sources",
                         "the sources shine unequally; all together as much as stated"),
                  {}};
  constexpr std::array<std::array<double, 4>, 3> contrasts{
      {{1.0, 1.0, -1.0, -1.0}, {1.0, -1.0, -1.0, 1.0}, {1.0, -1.0, 1.0, -1.0}}};
  constexpr std::array names{"back_front", "right_left", "crosswise"};
  for (std::size_t k = 0; k < contrasts.size(); ++k) {
    imbalance.changes.push_back(
        {sized(names[k], "1", "share that one pair has more than the other, over two", 0.02), 0.5,
         [contrast = contrasts[k]](MixingChamber& c, double s) {
           for (std::size_t i = 0; i < 4; ++i) c.flux_lm[i] *= 1.0 + s * contrast[i];
         }});
  }
  all.push_back(std::move(imbalance));
  Cause edge{effect("hole_edge_reflection", "holes", "the edges of the holes are not quite black"),
             {}};
  Parameter rho = sized("rho", "1", "reflectance of the edges", 0.05);
  rho.lo = 0.0;
  edge.changes = {{rho, 0.2, [](MixingChamber& c, double s) { c.edge_rho += s; }}};
  all.push_back(std::move(edge));
  all.push_back({effect("observer_angle", "camera", "the camera looks from another angle"),
                 {{sized("view_deg", "deg", "further from the axis", 0.3), 0.5,
                   [](MixingChamber& c, double s) { c.view_deg += s; }}}});
  return all;
}

}  // namespace

MapSignatures map_signatures(const MixingChamber& chamber, const MapOptions& options) {
  MapSignatures s;
  s.chamber = chamber;
  s.options = options;
  std::vector<Cause> all = causes();
  double jobs = 2.0 + static_cast<double>(options.rays_per_pixel) /
                          static_cast<double>(options.rays_per_signature);
  for (const Cause& cause : all) jobs += static_cast<double>(cause.changes.size());
  double done = 0.0;
  const auto simulated = [&](const MixingChamber& c, std::uint64_t rays, std::uint64_t seed) {
    if (options.progress) options.progress(done / jobs);
    done += static_cast<double>(rays) / static_cast<double>(options.rays_per_signature);
    const chamber::Luminaire luminaire = c.luminaire();
    const chamber::Tracer tracer(luminaire);
    chamber::MapRequest request;
    request.rays_per_pixel = rays;
    request.seed = seed;
    request.threads = options.threads;
    return chamber::luminance_map(tracer, c.camera(options.coarser), request);
  };
  // Changes share the random numbers of what they are taken from, and none with the map itself.
  // Each is found twice, with half of the rays: where both agree it is a change, else noise.
  const auto half = [&](const MixingChamber& c, std::uint64_t number) {
    return simulated(c, std::max<std::uint64_t>(2, options.rays_per_signature / 2),
                     options.seed + 1 + number);
  };
  s.map = simulated(chamber, options.rays_per_pixel, options.seed);

  // Away from the rim by more than any angle of view moves it.
  const double a = 0.5 * chamber.diameter_mm - 1.5 * s.map.pixel_mm;
  const double b = 0.5 * chamber.diameter_mm * std::cos(optics::radians(chamber.view_deg)) -
                   1.5 * s.map.pixel_mm;
  std::vector<double> pixel_x, pixel_y;
  for (std::size_t y = 0; y < s.map.height; ++y) {
    for (std::size_t x = 0; x < s.map.width; ++x) {
      const double mm_x =
          s.map.pixel_mm * (static_cast<double>(x) + 0.5 - 0.5 * static_cast<double>(s.map.width));
      const double mm_y =
          s.map.pixel_mm * (static_cast<double>(y) + 0.5 - 0.5 * static_cast<double>(s.map.height));
      if (std::pow(mm_x / a, 2) + std::pow(mm_y / b, 2) >= 1.0) continue;
      s.pixels.push_back(y * s.map.width + x);
      pixel_x.push_back(static_cast<double>(x));
      pixel_y.push_back(static_cast<double>(y));
    }
  }
  const auto inside = [&](const std::vector<double>& values) {
    Eigen::VectorXd v(static_cast<Eigen::Index>(s.pixels.size()));
    for (std::size_t i = 0; i < s.pixels.size(); ++i)
      v[static_cast<Eigen::Index>(i)] = values[s.pixels[i]];
    return v;
  };
  s.mean = inside(s.map.luminance_cd_m2);
  s.se = inside(s.map.luminance_se);
  MixingChamber plain = chamber;
  plain.wall = matt(total);
  using Halves = std::array<Eigen::VectorXd, 2>;
  const auto halves = [&](const MixingChamber& c) -> Halves {
    return {inside(half(c, 0).luminance_cd_m2), inside(half(c, 1).luminance_cd_m2)};
  };
  const Halves plain_mean = halves(plain);
  const Halves own_mean = halves(chamber);
  const Smoothing smoothing(pixel_x, pixel_y);
  s.highlight = Eigen::VectorXd::Zero(s.mean.size());
  for (Cause& cause : all) {
    MapEffect one{cause.effect,
                  Eigen::MatrixXd(s.mean.size(), static_cast<Eigen::Index>(cause.changes.size()))};
    std::vector<Probe> probes;
    for (std::size_t k = 0; k < cause.changes.size(); ++k) {
      const Change& change = cause.changes[k];
      MixingChamber c = cause.on_matt_wall ? plain : chamber;
      change.apply(c, change.step);
      const Halves& from = cause.on_matt_wall ? plain_mean : own_mean;
      const Halves to = halves(c);
      one.columns.col(static_cast<Eigen::Index>(k)) =
          smoothing.mean((to[0] - from[0]) / change.step, (to[1] - from[1]) / change.step);
      one.effect.parameters.push_back(change.parameter);
      Probe probe(cause.changes.size(), 0.0);
      probe[k] = change.parameter.prior_u;
      probes.push_back(std::move(probe));
    }
    one.effect.probes = {std::move(probes)};
    if (one.effect.name == "near_specular_lobe") {
      s.highlight = s.highlight.cwiseMax(one.columns.col(0) / one.columns.col(0).maxCoeff());
    }
    s.effects.push_back(std::move(one));
  }
  return s;
}

}  // namespace umov::gap
