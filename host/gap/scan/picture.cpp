#include "host/gap/scan/picture.hpp"

#include <algorithm>

#include "host/parallel/for_each_index.hpp"

namespace umov::gap::scan {
namespace {

Signals signals_of(const Eigen::VectorXd& both) {
  const Eigen::Index n = both.size() / 2;
  return {{both.data(), both.data() + n}, {both.data() + n, both.data() + 2 * n}};
}

}  // namespace

Picture picture_of(const ScanModel& model, const Diagnosis& d, int threads) {
  const Refit& base = d.search.hypotheses[d.search.base].refit;
  const Refit& best = d.best;
  const Whitening& whitening = *d.search.whitening;

  Picture picture;
  picture.wavelengths_nm = model.records().wavelengths_nm;
  picture.records = model.records().records;
  std::vector<Record> all = picture.records;
  for (Record& r : all) {
    picture.measured.x_v.push_back(r.x_v);
    picture.measured.y_v.push_back(r.y_v);
    r.saturated = false;
  }
  const ScanModel whole = model.with_records(std::move(all));
  const auto predicted = [&](const Explanation& explanation) {
    Eigen::VectorXd mean;
    whole.predict(explanation, mean, nullptr);
    return mean;
  };
  const Eigen::VectorXd best_mean = predicted(best.explanation);
  picture.base = signals_of(predicted(base.explanation));
  picture.best = signals_of(best_mean);
  const Whitening noise(whole.noise(best_mean), d.search.relative_noise, d.search.noise_scale);
  const Eigen::VectorXd slow = d.search.relative_noise.slow * noise.shape().relative;
  picture.sigma =
      signals_of((noise.white_sigma().cwiseAbs2() + slow.cwiseAbs2()).cwiseSqrt().eval());

  const auto& effects = best.explanation.effects;
  picture.contributions.resize(effects.size());
  for_each_index(effects.size(), threads, [&](std::size_t k) {
    Contribution& c = picture.contributions[k];
    c.effect = model.effects()[effects[k]];
    c.named = std::any_of(d.causes.begin(), d.causes.end(), [&](const Cause& cause) {
      return cause.effect == c.effect.name && cause.family == c.effect.family;
    });
    const Explanation without = without_effect(best.explanation, effects[k]);
    const Refit anew = refit(model, without, whitening);
    c.held = signals_of(best_mean - predicted(without));
    c.refitted = signals_of(best_mean - predicted(anew.explanation));
    c.delta_chi2 = anew.chi2 - best.chi2;
  });
  picture.alternatives = alternatives_of(model, d);
  for (const Effect& effect : model.effects())
    if (effect.scatter && std::any_of(d.causes.begin(), d.causes.end(), [&](const Cause& cause) {
          return cause.effect == effect.name;
        }))
      picture.scatter = effect;
  return picture;
}

}  // namespace umov::gap::scan
