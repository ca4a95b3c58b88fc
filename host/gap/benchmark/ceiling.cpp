#include "host/gap/benchmark/ceiling.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "host/parallel/for_each_index.hpp"

namespace umov::gap {

NamingRates& NamingRates::operator+=(const NamingRates& other) {
  drawn += other.drawn;
  named += other.named;
  in_set += other.in_set;
  set_size += other.set_size;
  for (const auto& [pair, n] : other.taken_for) taken_for[pair] += n;
  return *this;
}

NamingCeiling::NamingCeiling(const ForwardModel& model, const Refit& at, const Whitening& whitening,
                             int threads)
    : model_(model), view_(model, at, whitening, {}, true, threads), root_(view_.root_of_pulls()) {
  for (std::size_t c = 0; c < view_.candidates().size(); ++c) {
    const Candidate& candidate = view_.candidates()[c];
    const bool seen = std::all_of(candidate.columns.begin(), candidate.columns.end(),
                                  [&](Eigen::Index i) { return view_.gram()(i, i) > 0; });
    if (seen && !model.effects()[candidate.effect].structural) shown_.push_back(c);
  }
}

NamingRates NamingCeiling::trial(std::size_t effect, double rho, int trials,
                                 std::uint64_t seed) const {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::vector<std::size_t> own;
  for (const std::size_t c : shown_)
    if (view_.candidates()[c].effect == effect) own.push_back(c);
  NamingRates rates;
  Eigen::VectorXd noise(root_.cols());
  for (int t = 0; t < trials && !own.empty(); ++t) {
    const std::size_t drawn = own[random() % own.size()];
    const std::vector<Eigen::Index>& columns = view_.candidates()[drawn].columns;
    // A direction within the candidate (the phase of a harmonic), then its size.
    Eigen::VectorXd mix(static_cast<Eigen::Index>(columns.size()));
    for (double& m : mix) m = normal(random);
    if (view_.one_sided(drawn)) mix = mix.cwiseAbs();
    const Eigen::MatrixXd block = view_.gram()(columns, columns);
    mix *= rho / std::sqrt(mix.dot(block * mix));
    for (double& x : noise) x = normal(random);
    const Eigen::VectorXd pull = view_.gram()(Eigen::all, columns) * mix + root_ * noise;
    std::map<std::size_t, double> best;  // by effect
    for (const std::size_t c : shown_) {
      const std::size_t one[] = {c};
      const double value = view_.fit(one, pull).ln_evidence;
      const auto [place, fresh] = best.emplace(view_.candidates()[c].effect, value);
      if (!fresh) place->second = std::max(place->second, value);
    }
    const auto first = std::max_element(
        best.begin(), best.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
    const auto near = [&](double value) { return 2 * (first->second - value) < ambiguous; };
    ++rates.drawn;
    if (first->first == effect) {
      ++rates.named;
    } else {
      ++rates.taken_for[{model_.effects()[effect].name, model_.effects()[first->first].name}];
    }
    if (near(best[effect])) ++rates.in_set;
    for (const auto& [e, value] : best) rates.set_size += near(value) ? 1 : 0;
  }
  return rates;
}

NamingRates NamingCeiling::rates(double rho, int trials, std::uint64_t seed, int threads) const {
  std::vector<NamingRates> parts(model_.effects().size());
  for_each_index(parts.size(), threads,
                 [&](std::size_t e) { parts[e] = trial(e, rho, trials, seed + 1000 * e); });
  NamingRates sum;
  for (const NamingRates& part : parts) sum += part;
  return sum;
}

}  // namespace umov::gap
