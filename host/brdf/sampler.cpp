#include "host/brdf/sampler.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/brdf/evaluate.hpp"
#include "host/brdf/sampling_incidence_grid.hpp"
#include "host/brdf/sampling_parts.hpp"
#include "host/errors/error.hpp"

namespace umov::brdf {
namespace {

using optics::Mueller;
using optics::Vec3;

/// No part is drawn more rarely than this, so that an estimate of its light that is too low at some
/// incidence can't blow up a weight.
constexpr double least_share = 0.005;
/// Only u1 or u2 within 1e-200 of an end lead to tails below this, where a quotient has no digits.
constexpr double least_density = 1e-280;

Vec3<double> draw(const Lobe& lobe, const Incidence& in, double u1, double u2, double u3) {
  return std::visit([&](const auto& one) { return one.draw(in, u1, u2, u3); }, lobe);
}

double density(const Lobe& lobe, const Incidence& in, const Exit& exit) {
  return std::visit([&](const auto& one) { return one.pdf(in, exit); }, lobe);
}

/// ∫ brdf cos θr dω from a few hundred draws of its own lobe: good to some per cent, which is all
/// that choosing among lobes needs.
double estimated_reflectance(const SampledPart& part, const Incidence& in) {
  constexpr int strata = 16;
  double sum = 0.0;
  for (int i = 0; i < strata; ++i) {
    for (int j = 0; j < strata; ++j) {
      const double turn = 0.6180339887498949 * (i * strata + j);
      const Vec3<double> to =
          draw(part.lobe, in, (i + 0.5) / strata, (j + 0.5) / strata, turn - std::floor(turn));
      if (!(to.z > 0.0)) continue;
      const double pdf = density(part.lobe, in, Exit(in, to));
      const double light = part.brdf(geometry_of(in.theta, to)) * to.z;
      if (light > 0.0 && pdf > 0.0) sum += light / pdf;
    }
  }
  return sum / (strata * strata);
}

/// Nodes where nothing is reflected take the shares of the nearest one where something is: between
/// the two there may be light.
void fill_dark_nodes(std::vector<double>& share, const std::vector<bool>& lit, std::size_t lobes) {
  const std::size_t nodes = lit.size();
  for (std::size_t i = 0; i < nodes; ++i) {
    if (lit[i]) continue;
    for (std::size_t away = 1; away < nodes; ++away) {
      const bool below = i >= away && lit[i - away];
      if (!below && !(i + away < nodes && lit[i + away])) continue;
      const std::size_t from = below ? i - away : i + away;
      std::copy_n(share.data() + from * lobes, lobes, share.data() + i * lobes);
      break;
    }
  }
}

Mueller<double> scaled(Mueller<double> m, double factor) {
  m *= factor;
  return m;
}

}  // namespace

struct Sampler::Prepared {
  Model model;
  std::vector<SpectralValues> spectrum;
  std::vector<Lobe> lobes;
  /// For each node of IncidenceGrid the share of each lobe (they add up to 1, or all to 0 if
  /// nothing is reflected at any node), and the mirror part's probability.
  std::vector<double> share;
  std::vector<double> mirror;

  double mirror_at(const IncidenceGrid::Place& place) const {
    return mirror[place.lower] * (1.0 - place.share) + mirror[place.lower + 1] * place.share;
  }
  double share_at(const IncidenceGrid::Place& place, std::size_t lobe) const {
    const double* row = share.data() + place.lower * lobes.size();
    return row[lobe] * (1.0 - place.share) + row[lobes.size() + lobe] * place.share;
  }
  double pdf_at(const Incidence& in, const Exit& exit, const IncidenceGrid::Place& place) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < lobes.size(); ++k) {
      const double part = share_at(place, k);
      if (part > 0.0) sum += part * density(lobes[k], in, exit);
    }
    return sum * (1.0 - mirror_at(place));
  }
  Mueller<double> weight_of(const Incidence& in, const Sample& sample,
                            std::size_t wavelength) const {
    const SpectralValues& s = spectrum[wavelength];
    if (sample.mirror) {
      return scaled(
          mirror_reflectance<double>(model, s.values, s.wavelength_um, sample.geometry.theta_i),
          1.0 / sample.density);
    }
    return scaled(evaluate<double>(model, s.values, s.wavelength_um, sample.geometry,
                                   facet_frame(in, sample.direction)),
                  sample.direction.z / sample.density);
  }
};

Sampler::Sampler(const Model& model, std::vector<double> values, double wavelength_um)
    : Sampler(model, std::vector<SpectralValues>{{std::move(values), wavelength_um}}) {}

Sampler::Sampler(const Model& model, std::vector<SpectralValues> spectrum) {
  if (spectrum.empty()) {
    throw Error("a sampler of model '" + model.name() + "' got no wavelength",
                "give it one set of values at least");
  }
  if (model.needs_table()) refuse_missing_table(model);
  for (const SpectralValues& s : spectrum) model.check(s.values);

  auto prepared = std::make_shared<Prepared>(Prepared{model, std::move(spectrum), {}, {}, {}});
  std::vector<SampledPart> parts = sampled_parts(prepared->model, prepared->spectrum);
  const std::size_t count = parts.size();
  prepared->share.assign(IncidenceGrid::count * count, 0.0);
  prepared->mirror.assign(IncidenceGrid::count, 0.0);
  std::vector<bool> lit(IncidenceGrid::count, false);
  for (std::size_t i = 0; i < IncidenceGrid::count; ++i) {
    const Incidence in(IncidenceGrid::theta(i));
    double* share = prepared->share.data() + i * count;
    double total = 0.0;
    for (std::size_t k = 0; k < count; ++k) {
      share[k] = estimated_reflectance(parts[k], in);
      total += share[k];
    }
    double mirror = 0.0;
    for (const SpectralValues& s : prepared->spectrum) {
      mirror += optics::element(mirror_reflectance<double>(prepared->model, s.values,
                                                           s.wavelength_um, in.theta),
                                0, 0) /
                static_cast<double>(prepared->spectrum.size());
    }
    if (!(total > 0.0)) {
      prepared->mirror[i] = mirror > 0.0 ? 1.0 : 0.0;
      continue;
    }
    lit[i] = true;
    prepared->mirror[i] = mirror / (mirror + total);
    double raised = 0.0;
    for (std::size_t k = 0; k < count; ++k) {
      share[k] = std::max(share[k] / total, least_share);
      raised += share[k];
    }
    for (std::size_t k = 0; k < count; ++k) share[k] /= raised;
  }
  fill_dark_nodes(prepared->share, lit, count);
  for (SampledPart& part : parts) prepared->lobes.push_back(std::move(part.lobe));
  prepared_ = std::move(prepared);
}

std::optional<Sample> Sampler::sample(double theta_i, double u1, double u2, double u3,
                                      std::size_t wavelength) const {
  const Prepared& p = *prepared_;
  const Incidence in(theta_i);
  if (!(in.cosine > 0.0)) return std::nullopt;
  const IncidenceGrid::Place place = IncidenceGrid::locate(theta_i);
  const double mirror = p.mirror_at(place);
  Sample sample;
  if (u3 < mirror) {
    sample.geometry = {theta_i, theta_i, 0.0};
    sample.direction = {in.sine, 0.0, in.cosine};
    sample.mirror = true;
    sample.density = mirror;
    sample.weight = p.weight_of(in, sample, wavelength);
    return sample;
  }
  if (p.lobes.empty()) return std::nullopt;

  // What is left of u3 after each choice is uniform again.
  double rest = (u3 - mirror) / (1.0 - mirror);
  std::size_t chosen = 0;
  double share = p.share_at(place, 0);
  while (rest >= share && chosen + 1 < p.lobes.size()) {
    rest -= share;
    share = p.share_at(place, ++chosen);
  }
  if (!(share > 0.0)) return std::nullopt;
  constexpr double below_one = 1.0 - 1e-16;
  sample.direction = draw(p.lobes[chosen], in, u1, u2, std::min(rest / share, below_one));
  if (!(sample.direction.z > 0.0)) return std::nullopt;
  sample.geometry = geometry_of(theta_i, sample.direction);
  sample.density = p.pdf_at(in, Exit(in, sample.direction), place);
  if (!(sample.density > least_density)) return std::nullopt;
  sample.weight = p.weight_of(in, sample, wavelength);
  return sample;
}

double Sampler::pdf(const Geometry<double>& geometry) const {
  const Incidence in(geometry.theta_i);
  const Vec3<double> to = optics::exit_direction(geometry.theta_r, geometry.phi_r);
  if (!(in.cosine > 0.0) || !(to.z > 0.0)) return 0.0;
  return prepared_->pdf_at(in, Exit(in, to), IncidenceGrid::locate(geometry.theta_i));
}

double Sampler::mirror_probability(double theta_i) const {
  if (!(std::cos(theta_i) > 0.0)) return 0.0;
  return prepared_->mirror_at(IncidenceGrid::locate(theta_i));
}

Mueller<double> Sampler::weight(const Sample& sample, std::size_t wavelength) const {
  return prepared_->weight_of(Incidence(sample.geometry.theta_i), sample, wavelength);
}

const Model& Sampler::model() const {
  return prepared_->model;
}

const std::vector<SpectralValues>& Sampler::spectrum() const {
  return prepared_->spectrum;
}

}  // namespace umov::brdf
