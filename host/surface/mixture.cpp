#include "host/surface/mixture.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "host/optics/angles.hpp"
#include "host/optics/mueller.hpp"

namespace umov::surface {
namespace {

using trace::Estimate;

constexpr double undefined = std::numeric_limits<double>::quiet_NaN();
// Errors of a difference below which nothing is divided by it.
constexpr double least_contrast = 5.0;

// Means over layers, weighted by what each hides.
struct Contaminant {
  std::vector<double> weight;  // sums to 1
  const std::vector<const trace::Result*>& layers;

  Estimate over(const std::function<Estimate(const trace::Result&)>& value) const {
    Estimate sum{0.0, 0.0};
    for (std::size_t k = 0; k < layers.size(); ++k) {
      const Estimate e = value(*layers[k]);
      sum.mean += weight[k] * e.mean;
      sum.error = std::hypot(sum.error, weight[k] * e.error);
    }
    return sum;
  }
};

Estimate mix(const Estimate& fraction, const Estimate& contaminant, const Estimate& bare) {
  const double f = fraction.mean;
  return {f * contaminant.mean + (1.0 - f) * bare.mean,
          std::hypot(f * contaminant.error, (1.0 - f) * bare.error,
                     (contaminant.mean - bare.mean) * fraction.error)};
}

void add_up(EffectiveFraction& f) {
  f.error = std::hypot(f.own, f.by_bare, f.by_contaminant);
}

EffectiveFraction unknown_fraction() {
  return {{undefined, undefined}};
}

Estimate element(const trace::MuellerEstimate& e, int row, int column) {
  return {optics::element(e.mean, row, column), optics::element(e.error, row, column)};
}

}  // namespace

MixturePoint mixed(const trace::Result& whole, const trace::Result& bare,
                   const std::vector<const trace::Result*>& contaminants,
                   const std::vector<Estimate>& shares, const std::vector<double>& wavelengths_um) {
  MixturePoint point{};
  Contaminant contaminant{{}, contaminants};
  for (const Estimate& share : shares) {
    point.fraction.mean += share.mean;
    point.fraction.error = std::hypot(point.fraction.error, share.error);
  }
  for (const Estimate& share : shares) {
    contaminant.weight.push_back(point.fraction.mean > 0.0
                                     ? share.mean / point.fraction.mean
                                     : 1.0 / static_cast<double>(shares.size()));
  }
  double products = 0.0;
  double squares = 0.0;
  EffectiveFraction sum{{0.0, 0.0}};
  for (std::size_t w = 0; w < wavelengths_um.size(); ++w) {
    MixtureBand band{};
    band.wavelength_um = wavelengths_um[w];
    const auto m00 = [&](const trace::Result& r) { return element(r.hemispherical(w), 0, 0); };
    const auto m10 = [&](const trace::Result& r) { return element(r.hemispherical(w), 1, 0); };
    const Estimate dirty = contaminant.over(m00);
    const Estimate clean = m00(bare);
    band.dhr = m00(whole);
    band.linear_dhr = mix(point.fraction, dirty, clean);
    const double contrast = dirty.mean - clean.mean;
    const double contrast_u = std::hypot(dirty.error, clean.error);
    const double change = band.dhr.mean - clean.mean;
    band.effective = unknown_fraction();
    if (std::abs(contrast) > least_contrast * contrast_u) {
      const double f = change / contrast;
      band.effective = {{f, 0.0},
                        band.dhr.error / std::abs(contrast),
                        (f - 1.0) * clean.error / std::abs(contrast),
                        -f * dirty.error / std::abs(contrast)};
      add_up(band.effective);
      products += change * contrast;
      squares += contrast * contrast;
      // All wavelengths come from the same rays: their errors go together.
      sum.own += band.effective.own * contrast * contrast;
      sum.by_bare += band.effective.by_bare * contrast * contrast;
      sum.by_contaminant += band.effective.by_contaminant * contrast * contrast;
    }
    band.dop = whole.hemispherical_dop(w);
    const Estimate polarised = mix(point.fraction, contaminant.over(m10), m10(bare));
    const double dop = polarised.mean / band.linear_dhr.mean;
    band.linear_dop = {
        dop, std::hypot(polarised.error, dop * band.linear_dhr.error) / band.linear_dhr.mean};
    double difference2 = 0.0;
    for (std::size_t cell = 0; cell < whole.hemisphere().cells(); ++cell) {
      const auto f00 = [&](const trace::Result& r) { return element(r.brdf(cell, w), 0, 0); };
      const Estimate found = f00(whole);
      const Estimate linear = mix({point.fraction.mean, 0.0}, contaminant.over(f00), f00(bare));
      const double d = found.mean - linear.mean;
      difference2 += whole.hemisphere().cell(cell).projected *
                     (d * d - found.error * found.error - linear.error * linear.error);
    }
    band.shape_difference = std::sqrt(std::max(0.0, difference2) * optics::pi) / band.dhr.mean;
    point.bands.push_back(band);
  }
  point.effective = unknown_fraction();
  if (squares > 0.0) {
    point.effective = {{products / squares, 0.0},
                       sum.own / squares,
                       sum.by_bare / squares,
                       sum.by_contaminant / squares};
    add_up(point.effective);
  }
  return point;
}

double MixingLaw::operator()(double fraction) const {
  return 1.0 - std::pow(1.0 - fraction, gamma);
}

MixingLaw fit_law(const std::vector<Estimate>& fraction,
                  const std::vector<EffectiveFraction>& effective) {
  MixingLaw law{1.0, undefined, 0.0, 0, 0.0};
  double information = 0.0;
  double by_bare = 0.0;
  double by_contaminant = 0.0;
  for (int step = 0; step < 100; ++step) {
    double slope = 0.0;
    by_bare = by_contaminant = 0.0;
    information = law.chi2 = law.largest_miss = 0.0;
    law.points = 0;
    for (std::size_t i = 0; i < fraction.size(); ++i) {
      const double f = fraction[i].mean;
      if (!std::isfinite(effective[i].mean) || !(f > 0.0 && f < 1.0)) continue;
      const double left = std::pow(1.0 - f, law.gamma);
      const double derivative = -left * std::log(1.0 - f);
      const double by_fraction = law.gamma * left / (1.0 - f) * fraction[i].error;
      const double variance = effective[i].own * effective[i].own + by_fraction * by_fraction;
      const double miss = effective[i].mean - (1.0 - left);
      slope += derivative * miss / variance;
      by_bare += derivative * effective[i].by_bare / variance;
      by_contaminant += derivative * effective[i].by_contaminant / variance;
      information += derivative * derivative / variance;
      law.chi2 += miss * miss / variance;
      law.largest_miss = std::max(law.largest_miss, std::abs(miss));
      ++law.points;
    }
    if (law.points == 0 || !(information > 0.0)) return law;
    const double move = slope / information;
    // Far from the solution a whole step may overshoot.
    const double next = law.gamma + std::clamp(move, -0.5 * law.gamma, law.gamma);
    if (std::abs(next - law.gamma) <= 1e-12 * law.gamma) break;
    law.gamma = next;
    // The curve of such a γ is a step: the points follow no law of this form.
    if (law.gamma < 1e-3 || law.gamma > 1e3) return {undefined, undefined, 0.0, 0, undefined};
  }
  const double scatter = law.points > 1 ? law.chi2 / (law.points - 1) : 1.0;
  law.gamma_u = std::hypot(std::sqrt(std::max(1.0, scatter) / information), by_bare / information,
                           by_contaminant / information);
  return law;
}

}  // namespace umov::surface
