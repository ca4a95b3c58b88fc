#include "host/gap/chamber/map_picture.hpp"

#include <algorithm>
#include <limits>

namespace umov::gap {
namespace {

/// Used pixels as a map of one row, for figures of merit.
chamber::Map as_row(const Eigen::VectorXd& values) {
  chamber::Map row;
  row.width = static_cast<std::size_t>(values.size());
  row.height = 1;
  row.luminance_cd_m2.assign(values.data(), values.data() + values.size());
  row.luminance_se.assign(row.width, 0.0);
  return row;
}

std::vector<double> spread_out(const Eigen::VectorXd& values, const MapSignatures& s) {
  std::vector<double> all(s.map.luminance_cd_m2.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < s.pixels.size(); ++i)
    all[s.pixels[i]] = values[static_cast<Eigen::Index>(i)];
  return all;
}

}  // namespace

MapPicture picture_of(const ChamberModel& model, const Diagnosis& d) {
  const MapSignatures& s = model.signatures();
  const Eigen::VectorXd& measured = model.observations().value;
  const Refit& base = d.search.hypotheses[d.search.base].refit;
  MapPicture picture;
  picture.width = s.map.width;
  picture.height = s.map.height;
  picture.pixel_mm = s.map.pixel_mm;
  picture.measured = spread_out(measured, s);
  picture.base = spread_out(base.mean, s);
  picture.best = spread_out(d.best.mean, s);
  picture.sigma = spread_out(d.search.whitening->white_sigma(), s);
  picture.before = chamber::likeness(as_row(measured), as_row(s.mean));
  picture.after = chamber::likeness(as_row(measured), as_row(d.best.mean));
  for (const std::size_t effect : d.best.explanation.effects) {
    MapContribution c;
    c.effect = model.effects()[effect];
    c.named = std::any_of(d.causes.begin(), d.causes.end(), [&](const Cause& cause) {
      return cause.effect == c.effect.name && cause.family == c.effect.family;
    });
    const Explanation without = without_effect(d.best.explanation, effect);
    const Refit anew = refit(model, without, *d.search.whitening);
    Eigen::VectorXd mean;
    model.predict(without, mean, nullptr);
    c.held = spread_out(d.best.mean - mean, s);
    c.refitted = spread_out(d.best.mean - anew.mean, s);
    c.delta_chi2 = anew.chi2 - d.best.chi2;
    picture.contributions.push_back(std::move(c));
  }
  picture.alternatives = alternatives_of(model, d);
  return picture;
}

}  // namespace umov::gap
