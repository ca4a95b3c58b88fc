#include "host/gap/surface/surface_model.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "host/errors/error.hpp"
#include "host/formats/scan_table.hpp"
#include "host/optics/angles.hpp"
#include "host/optics/frames.hpp"
#include "host/optics/mueller.hpp"
#include "host/surface/hidden_shares.hpp"
#include "host/surface/lays.hpp"

namespace umov::gap {
namespace {

using trace::Result;

// As `umov simulate surface` has it unless told otherwise.
constexpr std::size_t strip_cells = 180;
constexpr double strip_half_width_deg = 2.0;
// θr of the observations of a row: the steps in which they are withheld.
constexpr double row_deg = 15.0;
// Thickness of the water film over the radius of the smallest particles, or over 1/100 period.
constexpr double film_thickness = 0.3;
// Slope of the lobe that a smoother patch of the ground would add.
constexpr double lobe_slope = 0.08;

// Relative change of the particles' reflectance that stands for all changes of it.
constexpr double albedo_step = 0.2;

enum Channel { intensity, polarised };

// What particles are made of, where that is Lambertian.
std::vector<trace::Lambertian*> contaminants(surface::Surface& surface) {
  std::vector<trace::Lambertian*> found;
  std::vector<bool> used(surface.scene.materials.size(), false);
  for (const trace::Sphere& s : surface.scene.spheres) used.at(s.material) = true;
  for (std::size_t m = 0; m < used.size(); ++m) {
    auto* lambertian = std::get_if<trace::Lambertian>(&surface.scene.materials[m]);
    if (used[m] && lambertian != nullptr) found.push_back(lambertian);
  }
  return found;
}

// By how much they can be changed: upwards, unless they are nearly white. 0: no such material.
double albedo_change(surface::Surface surface) {
  double most = 0.0;
  for (const trace::Lambertian* l : contaminants(surface)) {
    most = std::max(most, *std::max_element(l->albedo.begin(), l->albedo.end()));
  }
  if (most == 0.0) return 0.0;
  return most * (1.0 + albedo_step) <= 1.0 ? albedo_step : -albedo_step;
}

struct Direction {
  double theta_i_deg, theta_r_deg, phi_deg, wavelength_nm;
  Channel channel;
};

// Value and error of a simulation where it was measured.
trace::Estimate looked_up(const Result& result, std::size_t wavelength, const Direction& d) {
  const trace::Hemisphere& hemisphere = result.hemisphere();
  const auto cell_value = [&](std::size_t cell) {
    const trace::MuellerEstimate e = result.brdf(cell, wavelength);
    const int row = d.channel == polarised ? 1 : 0;
    return trace::Estimate{optics::element(e.mean, row, 0), optics::element(e.error, row, 0)};
  };
  // A measurement that was simulated is compared cell by cell: then mirror directions fall into the
  // same ones.
  const std::size_t around = hemisphere.find(
      optics::exit_direction(optics::radians(d.theta_r_deg), optics::radians(d.phi_deg)));
  const trace::Cell cell = hemisphere.cell(around);
  const double middle = optics::degrees(0.5 * (cell.theta_low + cell.theta_high));
  if (d.phi_deg != 0.0 || std::abs(middle - d.theta_r_deg) < 1e-6) return cell_value(around);
  const double place = (d.theta_r_deg + 90.0) / 180.0 * static_cast<double>(strip_cells) - 0.5;
  const auto low = static_cast<std::size_t>(
      std::clamp(std::floor(place), 0.0, static_cast<double>(strip_cells - 2)));
  const double part = std::clamp(place - static_cast<double>(low), 0.0, 1.0);
  const trace::Estimate a = cell_value(hemisphere.cells() + low);
  const trace::Estimate b = cell_value(hemisphere.cells() + low + 1);
  return {(1.0 - part) * a.mean + part * b.mean,
          std::hypot((1.0 - part) * a.error, part * b.error)};
}

// Simulations of one scene at every angle of the measurement.
class Bench {
 public:
  Bench(std::string scene, std::string name, const SurfaceModelOptions& options)
      : scene_(std::move(scene)),
        name_(std::move(name)),
        options_(options),
        hemisphere_(options.rings, strip_cells, optics::radians(strip_half_width_deg)),
        launches_(surface::launches_a_lay(lays({}).first(), options.samples)) {}

  /// The scene with further lines.
  surface::ReadSurface reader(const std::string& more = {}) const {
    return [text = scene_ + more, name = name_](const surface::Reading& reading) {
      return surface::surface_from_toml(text, name, reading);
    };
  }

  surface::Lays lays(surface::Reading reading, const std::string& more = {}) const {
    reading.seed = options_.seed;
    return {reader(more), reading};
  }

  /// With particles that reflect more by this share.
  surface::Lays brighter(surface::Reading reading, double change) const {
    reading.seed = options_.seed;
    return {[read = reader(), change](const surface::Reading& r) {
              surface::Surface surface = read(r);
              if (r.like != nullptr) return surface;  // has the materials of the first lay
              for (trace::Lambertian* l : contaminants(surface)) {
                for (double& albedo : l->albedo) albedo *= 1.0 + change;
              }
              return surface;
            },
            reading};
  }

  /// Can the scene be as these lines say too? It is known to be right without them.
  bool takes(const std::string& more) const {
    try {
      reader(more)({.seed = options_.seed});
      return true;
    } catch (const Error&) {
      return false;
    }
  }

  // Means over lays: how the particles of the measurement lay is not known.
  Result simulate(const surface::Lays& lays, double theta_i_deg,
                  std::uint32_t most_meetings) const {
    trace::Request request = how();
    request.theta_i = optics::radians(theta_i_deg);
    request.most_meetings = most_meetings;
    return lays.simulate(hemisphere_, request, launches_);
  }

  std::vector<trace::Estimate> hidden(surface::Reading reading, double theta_i_deg) const {
    reading.seed = options_.seed;
    return surface::hidden_shares(reader(), reading, theta_i_deg, how(), launches_);
  }

  trace::Request how() const {
    trace::Request request;
    request.seed = options_.seed;
    request.threads = options_.threads;
    request.samples = options_.samples;
    return request;
  }

 private:
  std::string scene_, name_;
  const SurfaceModelOptions& options_;
  trace::Hemisphere hemisphere_;
  std::uint64_t launches_;  // of a lay
};

std::vector<Direction> directions_of(const formats::BrdfTable& table, std::vector<double>& value,
                                     std::vector<double>& error) {
  std::vector<Direction> all;
  const auto add = [&](const Direction& d, double v, double u) {
    if (!std::isfinite(v) || !(u > 0.0)) return;
    all.push_back(d);
    value.push_back(v);
    error.push_back(u);
  };
  if (table.mueller && table.mueller->size() > 0) {
    const auto& m = *table.mueller;
    const std::size_t elements = m.elements();
    for (std::size_t i = 0; i < m.size(); ++i) {
      for (const Channel channel : {intensity, polarised}) {
        const std::size_t at =
            i * elements + (channel == polarised ? static_cast<std::size_t>(m.side) : 0);
        add({m.theta_i_deg[i], m.theta_r_deg[i], m.phi_r_deg[i], m.wavelength_nm[i], channel},
            m.mueller[at], m.mueller_u[at]);
      }
    }
    return all;
  }
  const auto& p = table.points;
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (p.used[i] == 0 || !std::isnan(p.polarizer_deg[i]) || !std::isnan(p.analyzer_deg[i])) {
      continue;
    }
    add({p.theta_i_deg[i], p.theta_r_deg[i], p.phi_r_deg[i], p.wavelength_nm[i], intensity},
        p.brdf_per_sr[i], p.brdf_u[i]);
  }
  return all;
}

Effect effect_of(const char* name, const char* stage, const char* physics, const char* parameter,
                 const char* meaning, double lo, double hi, double prior_u) {
  Effect effect{name, stage, physics, "ray tracing of the scene", {}};
  Parameter p{parameter, "1", meaning};
  p.lo = lo;
  p.hi = hi;
  p.prior_u = prior_u;
  effect.parameters = {p};
  effect.linear = true;
  effect.of_object = true;
  effect.probes = {{{1.0}}};
  return effect;
}

}  // namespace

SurfaceModel::SurfaceModel(const formats::BrdfTable& measurement, const std::string& scene,
                           const std::string& name, const SurfaceModelOptions& options) {
  std::vector<double> value, error;
  const std::vector<Direction> directions = directions_of(measurement, value, error);
  constexpr std::size_t fewest = 24;
  if (directions.size() < fewest) {
    throw Error(fmt::format("{} places of a BRDF are too few for a diagnosis", directions.size()),
                fmt::format("measure at least {}, without polariser or as Mueller matrices, each "
                            "with its uncertainty",
                            fewest));
  }
  const Bench bench(scene, name, options);
  const surface::Lays all_of_it = bench.lays({});
  const surface::Surface& whole = all_of_it.first();
  const bool particles = !whole.layers.empty();
  factors_ = particles ? options.coverage_factors : std::vector<double>{1.0};

  // Which wavelength of the scene each observation is of.
  std::vector<std::size_t> band;
  for (const Direction& d : directions) {
    const auto& um = whole.scene.wavelengths_um;
    const auto found = std::find_if(
        um.begin(), um.end(), [&](double w) { return std::abs(1e3 * w - d.wavelength_nm) < 0.5; });
    if (found == um.end()) {
      throw Error(Place{name},
                  fmt::format("does not have {} nm, which was measured", d.wavelength_nm),
                  "give [surface] wavelengths_um those of the measurement");
    }
    band.push_back(static_cast<std::size_t>(found - um.begin()));
  }

  // A film that all stand in, as thick as part of a particle.
  double radius = 0.01 * whole.scene.size_x;
  for (const trace::Sphere& s : whole.scene.spheres) radius = std::min(radius, s.radius);
  const std::string film = fmt::format("\n[film]\nthickness_um = {}\n", film_thickness * radius);

  const bool wettable = !whole.film && bench.takes(film);
  const double change = albedo_change(whole);

  const auto count = static_cast<Eigen::Index>(directions.size());
  const auto columns = static_cast<Eigen::Index>(factors_.size());
  enum { shadowing, bounces, water, contaminant_albedo, ground_albedo, lobe, effect_count };
  templates_.assign(effect_count, Series::Zero(count, columns));
  linear_ = Series::Zero(count, columns);
  Eigen::VectorXd doubt = Eigen::VectorXd::Zero(count);
  std::map<double, std::vector<Eigen::Index>> by_angle;
  for (Eigen::Index i = 0; i < count; ++i) {
    by_angle[directions[static_cast<std::size_t>(i)].theta_i_deg].push_back(i);
  }
  double done = 0.0;
  for (const auto& [theta, members] : by_angle) {
    const Result bare = bench.simulate(bench.lays({.part = surface::Part::bare}), theta, 1);
    std::vector<Result> flat;
    for (std::size_t k = 0; k < whole.layers.size(); ++k) {
      flat.push_back(bench.simulate(bench.lays({.part = surface::Part::contaminant, .layer = k}),
                                    theta, whole.layers[k].kind == "drop" ? 0 : 1));
    }
    for (Eigen::Index c = 0; c < columns; ++c) {
      if (options.progress) {
        options.progress(done++ / static_cast<double>(by_angle.size() * factors_.size()));
      }
      const surface::Reading reading{.coverage_scale = factors_[static_cast<std::size_t>(c)]};
      const surface::Lays described = bench.lays(reading);
      const Result once = bench.simulate(described, theta, 1);
      const Result often = bench.simulate(described, theta, 0);
      const Result wet = !wettable ? often : bench.simulate(bench.lays(reading, film), theta, 0);
      const Result bright =
          change == 0.0 ? often : bench.simulate(bench.brighter(reading, change), theta, 0);
      std::vector<trace::Estimate> shares;
      if (particles) shares = bench.hidden(reading, theta);
      for (const Eigen::Index i : members) {
        const auto place = static_cast<std::size_t>(i);
        const auto seen = [&](const Result& r) {
          return looked_up(r, band[place], directions[place]);
        };
        double covered = 0.0;
        double dirty = 0.0;
        double variance = 0.0;
        for (std::size_t k = 0; k < shares.size(); ++k) {
          const trace::Estimate e = seen(flat[k]);
          covered += shares[k].mean;
          dirty += shares[k].mean * e.mean;
          variance += std::pow(shares[k].mean * e.error, 2);
        }
        const trace::Estimate ground = seen(bare);
        const trace::Estimate single = seen(once);
        const trace::Estimate full = seen(often);
        const trace::Estimate damp = seen(wet);
        const double clean = (1.0 - covered) * ground.mean;
        variance += std::pow((1.0 - covered) * ground.error, 2);
        linear_(i, c) = dirty + clean;
        templates_[shadowing](i, c) = single.mean - linear_(i, c);
        templates_[bounces](i, c) = full.mean - single.mean;
        templates_[water](i, c) = damp.mean - full.mean;
        // Light from particle to particle grows faster than their reflectance.
        templates_[contaminant_albedo](i, c) =
            change == 0.0 ? dirty : (seen(bright).mean - full.mean) / change;
        templates_[ground_albedo](i, c) = clean;
        const double half_tan =
            std::tan(0.5 * optics::radians(std::abs(directions[place].theta_r_deg - theta)));
        templates_[lobe](i, c) =
            directions[place].phi_deg == 0.0 && directions[place].channel == intensity
                ? std::exp(-0.5 * std::pow(half_tan / lobe_slope, 2))
                : 0.0;
        // What is compared is one or another of these simulations.
        doubt[i] = std::max({doubt[i], variance, full.error * full.error, damp.error * damp.error});
      }
    }
  }

  observations_.value = Eigen::Map<const Eigen::VectorXd>(value.data(), count);
  sigma_ = (Eigen::Map<const Eigen::VectorXd>(error.data(), count).array().square() + doubt.array())
               .sqrt();
  observations_.channels = {"m00", "m10"};
  observations_.axes = {{"incidence", "deg", {}},
                        {"exit", "deg", {}},
                        {"azimuth", "deg", {}},
                        {"wavelength", "nm", {}}};
  std::map<std::tuple<double, double, double, int>, int> rows;
  for (const Direction& d : directions) {
    observations_.channel.push_back(d.channel);
    observations_.axes[0].value.push_back(d.theta_i_deg);
    observations_.axes[1].value.push_back(d.theta_r_deg);
    observations_.axes[2].value.push_back(d.phi_deg);
    observations_.axes[3].value.push_back(d.wavelength_nm);
    const std::tuple key{d.theta_i_deg, std::floor(d.theta_r_deg / row_deg),
                         std::floor(d.phi_deg / 45.0), static_cast<int>(d.channel)};
    observations_.row.push_back(rows.emplace(key, static_cast<int>(rows.size())).first->second);
  }

  Parameter gain{"gain", "1", "scale of the measurement"};
  gain.absent = 1.0;
  gain.lo = 0.5;
  gain.hi = 2.0;
  gain.prior_u = 0.02;
  base_.push_back(gain);
  if (particles) {
    Parameter area{"area_scale", "1", "covered area over that of the scene"};
    area.absent = 1.0;
    area.lo = factors_.front();
    area.hi = factors_.back();
    area.prior_u = 0.2;
    base_.push_back(area);
  }
  std::vector<Effect> all{
      effect_of(
          "particle_shadowing", "geometry",
          "Particles stand up: they hide more of the ground than their area, shade it, and show "
          "lit and dark sides.",
          "strength", "1: as simulated", -0.5, 1.5, 0.7),
      effect_of("multiple_scattering", "geometry",
                "Light goes on from face to face before it leaves.", "strength", "1: as simulated",
                -0.5, 1.5, 0.7),
      effect_of("water_film", "sample",
                "A film of water lies on the ground, and particles stand in it.", "coverage",
                "share of the area that is wet", 0.0, 1.2, 0.5),
      effect_of("contaminant_albedo", "sample",
                "Particles reflect more or less than the scene says.", "relative_change",
                "of their reflectance", -0.8, 3.0, 0.3),
      effect_of("ground_albedo", "sample", "The ground reflects more or less than the scene says.",
                "relative_change", "of its reflectance", -0.8, 3.0, 0.1),
      effect_of("near_specular_lobe", "sample",
                "A smooth part of the ground adds a lobe about the mirror direction.", "weight",
                "BRDF at its peak, 1/sr", 0.0, 100.0, 0.05)};
  // An effect that changes nothing here is none; what the scene has already, neither.
  std::vector<Series> kept;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const bool needless =
        (!particles && (k == shadowing || k == contaminant_albedo)) || (!wettable && k == water);
    const double size = (templates_[k].col(0).array() / sigma_.array()).matrix().norm();
    if (needless || !(size > 1e-6)) continue;
    effects_.push_back(all[k]);
    kept.push_back(std::move(templates_[k]));
  }
  templates_ = std::move(kept);
}

// The polynomial through the simulated coverages.
Eigen::VectorXd SurfaceModel::at(const Series& series, double area_scale) const {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(series.rows());
  for (std::size_t i = 0; i < factors_.size(); ++i) {
    double weight = 1.0;
    for (std::size_t j = 0; j < factors_.size(); ++j) {
      if (j != i) weight *= (area_scale - factors_[j]) / (factors_[i] - factors_[j]);
    }
    sum += weight * series.col(static_cast<Eigen::Index>(i));
  }
  return sum;
}

void SurfaceModel::predict(const Explanation& explanation, Eigen::VectorXd& mean,
                           Eigen::MatrixXd* jacobian, const std::vector<bool>& /*wanted*/) const {
  const double gain = explanation.base[0];
  const double scale = base_.size() > 1 ? explanation.base[1] : 1.0;
  const auto shape = [&](double area_scale) {
    Eigen::VectorXd sum = at(linear_, area_scale);
    for (std::size_t k = 0; k < explanation.effects.size(); ++k) {
      sum += explanation.alpha[k][0] * at(templates_[explanation.effects[k]], area_scale);
    }
    return sum;
  };
  const Eigen::VectorXd here = shape(scale);
  mean = gain * here;
  if (jacobian == nullptr) return;
  const auto base = static_cast<Eigen::Index>(base_.size());
  jacobian->resize(mean.size(), base + static_cast<Eigen::Index>(explanation.effects.size()));
  jacobian->col(0) = here;
  if (base > 1) {
    // Polynomials of low order: central differences are exact to the third.
    constexpr double step = 1e-3;
    jacobian->col(1) = gain * (shape(scale + step) - shape(scale - step)) / (2.0 * step);
  }
  for (std::size_t k = 0; k < explanation.effects.size(); ++k) {
    jacobian->col(base + static_cast<Eigen::Index>(k)) =
        gain * at(templates_[explanation.effects[k]], scale);
  }
}

NoiseShape SurfaceModel::noise(const Eigen::VectorXd&) const {
  return {sigma_, {}, {}};
}

}  // namespace umov::gap
