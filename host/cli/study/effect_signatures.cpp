#include "host/cli/study/effect_signatures.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "host/parallel/for_each_index.hpp"

namespace umov::study {
namespace {

/// What a projection leaves of a vector that lies in its space.
constexpr double rounding = 1e-4;
/// Length in σ from which what is left could be seen at all.
constexpr double visible = 1;
/// Cosine from which two signatures are called alike.
constexpr double alike_from = 0.9;

/// The effect at one sigma of its usual size; what shapes it as one of its probes has it.
std::vector<double> usual_size(const gap::Effect& effect, gap::Probe alpha) {
  for (std::size_t i = 0; i < alpha.size(); ++i) {
    const gap::Parameter& p = effect.parameters[i];
    if (!p.shape && !p.choice) alpha[i] = std::min(p.hi, p.absent + p.prior_u);
  }
  return alpha;
}

}  // namespace

std::string full_name(const gap::Effect& effect) {
  return effect.family.empty() ? effect.name : effect.name + " (" + effect.family + ")";
}

std::vector<EffectSignature> effect_signatures(const gap::scan::ScanModel& model,
                                               const gap::Refit& at,
                                               const gap::Whitening& whitening, int threads) {
  const Eigen::Index observations = at.residual.size();
  const Eigen::MatrixXd followed = gap::followed_directions(at);

  const auto& effects = model.effects();
  std::vector<EffectSignature> all(effects.size());
  for_each_index(effects.size(), threads, [&](std::size_t e) {
    EffectSignature& best = all[e];
    best.effect = &effects[e];
    // Of its possible shapes, or of the lasers it may concern, the one that shows most. What
    // scatters has no shape: one pattern of many.
    std::vector<std::vector<gap::Probe>> groups = effects[e].probes;
    if (effects[e].scatter) groups = {{gap::Probe(effects[e].parameters.size(), 0.0)}};
    for (const auto& group : groups) {
      EffectSignature s;
      s.effect = &effects[e];
      s.alpha = usual_size(effects[e], group.front());
      Eigen::VectorXd change;
      if (effects[e].scatter) {
        std::mt19937_64 random(1);
        std::normal_distribution<double> normal;
        change = s.alpha.front() * model.noise(at.mean).relative;
        for (double& c : change) c *= normal(random);
      } else {
        Eigen::VectorXd shifted;
        model.predict(gap::with_effect(at.explanation, e, s.alpha), shifted, nullptr);
        change = shifted - at.mean;
      }
      s.alone = whitening.apply(change);
      Eigen::VectorXd padded = Eigen::VectorXd::Zero(followed.rows());
      padded.head(observations) = s.alone;
      s.left = (padded - followed * (followed.transpose() * padded)).head(observations);
      s.size = s.left.norm();
      if (s.size < rounding * s.alone.norm()) {
        s.left.setZero();
        s.size = 0;
      }
      const auto shows = [](const EffectSignature& one) {
        return std::pair(one.size > visible ? one.size : 0.0, one.alone.norm());
      };
      if (best.alpha.empty() || shows(s) > shows(best)) best = std::move(s);
    }
  });
  for (EffectSignature& s : all) {
    for (const EffectSignature& other : all) {
      if (&other == &s || !(s.size > visible) || !(other.size > visible)) continue;
      const double cosine = std::abs(s.left.dot(other.left)) / (s.size * other.size);
      if (cosine >= alike_from) s.alike.push_back({full_name(*other.effect), cosine});
    }
    std::stable_sort(s.alike.begin(), s.alike.end(),
                     [](const auto& a, const auto& b) { return a.cosine > b.cosine; });
    if (s.alike.size() > 3) s.alike.resize(3);
  }
  return all;
}

}  // namespace umov::study
