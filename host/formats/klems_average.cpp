// The azimuths of an isotropic source enter by their difference only: the two integrals over
// azimuth become one over Δφ, weighted with the length over which two patches overlap when one is
// turned against the other (a trapezium). What is left are three dimensions, θi, θr and Δφ, which
// are halved where a third-order and a second-order Gauss rule disagree most.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numbers>
#include <queue>
#include <tuple>

#include "host/errors/error.hpp"
#include "host/formats/klems_matrix.hpp"

namespace umov::formats {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double absolute_accuracy = 1e-6;    ///< 1/sr
constexpr double reporting_floor = 1e-3;      ///< 1/sr
constexpr std::size_t most_boxes = 60'000;    ///< of one pair of patches
constexpr double fine_cell = 2.5 * pi / 180;  ///< where a mirror or retro lobe may lie
constexpr double coarse_cell = 10 * pi / 180;
constexpr double ridge = 0.5 * pi / 180;  ///< first cell beside the azimuth of a lobe
constexpr double lobe_reach = 10 * pi / 180;

constexpr std::array<double, 2> nodes2{-0.5773502691896257, 0.5773502691896257};
constexpr std::array<double, 2> weights2{1.0, 1.0};
constexpr std::array<double, 3> nodes3{-0.7745966692414834, 0.0, 0.7745966692414834};
constexpr std::array<double, 3> weights3{5.0 / 9, 8.0 / 9, 5.0 / 9};

/// Two patches of an isotropic source, reduced to what the integral depends on.
struct Pair {
  const KlemsPatch* incident;
  const KlemsPatch* exit;
  double offset;  ///< azimuth of the exit centre from the incident centre, 0 to pi
};

struct Box {
  std::array<double, 3> low, high;  ///< θi, θr, Δφ − offset
  double value = 0, error = 0;
  bool operator<(const Box& other) const { return error < other.error; }
};

class PairIntegral {
 public:
  PairIntegral(const KlemsSource& source, const Pair& pair) : source_(source), pair_(pair) {
    const double a = pair.incident->phi_half_width, b = pair.exit->phi_half_width;
    narrow_ = 2 * std::min(a, b);
    full_circle_ = std::max(a, b) > 0.999 * pi;
    reach_ = full_circle_ ? pi : a + b;
    flat_ = full_circle_ ? pi : std::abs(a - b);
  }

  /// Mean over both patches and its estimated error.
  std::pair<double, double> mean(double relative_accuracy) {
    const double norm =
        pair_.incident->projected_solid_angle() * pair_.exit->projected_solid_angle();
    std::priority_queue<Box> boxes;
    double value = 0, error = 0;
    const auto add = [&](Box box) {
      estimate(box);
      value += box.value;
      error += box.error;
      boxes.push(box);
    };
    for (const Box& box : first_boxes()) add(box);
    while (error > std::max(relative_accuracy * value, absolute_accuracy * norm) &&
           boxes.size() < most_boxes) {
      const Box worst = boxes.top();
      boxes.pop();
      value -= worst.value;
      error -= worst.error;
      const std::size_t d = widest(worst);
      Box half = worst;
      half.high[d] = 0.5 * (worst.low[d] + worst.high[d]);
      add(half);
      half = worst;
      half.low[d] = 0.5 * (worst.low[d] + worst.high[d]);
      add(half);
    }
    return {value / norm, error / norm};
  }

 private:
  double overlap(double t) const {
    if (full_circle_) return narrow_;
    return std::min(narrow_, reach_ - std::abs(t));
  }

  double integrand(double theta_i, double theta_r, double t) const {
    const double f = source_.brdf(theta_i, theta_r, std::remainder(pair_.offset + t, 2 * pi));
    if (!(f >= 0) || !std::isfinite(f))
      throw Error("the source is " + std::to_string(f) + " /sr at theta_i " +
                      std::to_string(theta_i * 180 / pi) + " deg, theta_r " +
                      std::to_string(theta_r * 180 / pi) + " deg",
                  "patch averages need a BRDF that is finite and not negative");
    return f * std::sin(theta_i) * std::cos(theta_i) * std::sin(theta_r) * std::cos(theta_r) *
           overlap(t);
  }

  template <std::size_t N>
  double rule(const Box& box, const std::array<double, N>& nodes,
              const std::array<double, N>& weights) const {
    std::array<double, 3> centre{}, half{};
    for (std::size_t d = 0; d < 3; ++d) {
      centre[d] = 0.5 * (box.low[d] + box.high[d]);
      half[d] = 0.5 * (box.high[d] - box.low[d]);
    }
    double sum = 0;
    for (std::size_t i = 0; i < N; ++i)
      for (std::size_t j = 0; j < N; ++j)
        for (std::size_t k = 0; k < N; ++k)
          sum += weights[i] * weights[j] * weights[k] *
                 integrand(centre[0] + half[0] * nodes[i], centre[1] + half[1] * nodes[j],
                           centre[2] + half[2] * nodes[k]);
    return sum * half[0] * half[1] * half[2];
  }

  void estimate(Box& box) const {
    box.value = rule(box, nodes3, weights3);
    box.error = std::abs(box.value - rule(box, nodes2, weights2));
  }

  /// Lengths on the sphere, so that azimuth near the normal is not split for nothing.
  std::size_t widest(const Box& box) const {
    const double arc = (box.high[2] - box.low[2]) * std::sin(std::max(box.high[0], box.high[1]));
    const double i = box.high[0] - box.low[0], r = box.high[1] - box.low[1];
    if (arc >= i && arc >= r) return 2;
    return i >= r ? 0 : 1;
  }

  bool lobe_may_lie_here() const {
    const double gap = std::max(pair_.incident->theta_lower - pair_.exit->theta_upper,
                                pair_.exit->theta_lower - pair_.incident->theta_upper);
    if (gap > lobe_reach) return false;
    const double arc = std::sin(std::max(pair_.incident->theta_upper, pair_.exit->theta_upper));
    const double from_mirror = std::max(0.0, pair_.offset - reach_) * arc;
    const double from_retro = std::max(0.0, pi - pair_.offset - reach_) * arc;
    return std::min(from_mirror, from_retro) <= lobe_reach;
  }

  static std::vector<double> cut(std::vector<double> edges, double cell) {
    std::sort(edges.begin(), edges.end());
    std::vector<double> cuts{edges.front()};
    for (std::size_t n = 1; n < edges.size(); ++n) {
      const double from = cuts.back(), width = edges[n] - from;
      if (width < 1e-9) continue;
      const int parts = std::max(1, static_cast<int>(std::ceil(width / cell - 1e-9)));
      for (int p = 1; p <= parts; ++p)
        cuts.push_back(p == parts ? edges[n] : from + width * p / parts);
    }
    return cuts;
  }

  std::vector<Box> first_boxes() const {
    const double cell = lobe_may_lie_here() ? fine_cell : coarse_cell;
    const auto thetas_i = cut({pair_.incident->theta_lower, pair_.incident->theta_upper}, cell);
    const auto thetas_r = cut({pair_.exit->theta_lower, pair_.exit->theta_upper}, cell);
    const double arc =
        std::max(std::sin(std::max(pair_.incident->theta_upper, pair_.exit->theta_upper)), 0.05);
    // A narrow lobe is a ridge along θi = θr at Δφ = 0 or π. Equal cells put nodes on the first,
    // narrow cells bring them close to the second; from there on the error estimate leads.
    std::vector<double> edges{-reach_, reach_, -flat_, flat_};
    for (const double lobe : {-pair_.offset, pi - pair_.offset, -pi - pair_.offset})
      for (const double edge : {lobe - ridge / arc, lobe, lobe + ridge / arc})
        if (std::abs(edge) < reach_) edges.push_back(edge);
    const auto azimuths = cut(std::move(edges), 2 * cell / arc);
    std::vector<Box> boxes;
    for (std::size_t i = 0; i + 1 < thetas_i.size(); ++i)
      for (std::size_t r = 0; r + 1 < thetas_r.size(); ++r)
        for (std::size_t t = 0; t + 1 < azimuths.size(); ++t)
          boxes.push_back({{thetas_i[i], thetas_r[r], azimuths[t]},
                           {thetas_i[i + 1], thetas_r[r + 1], azimuths[t + 1]}});
    return boxes;
  }

  const KlemsSource& source_;
  Pair pair_;
  double narrow_, reach_, flat_;
  bool full_circle_;
};

/// Mean of the mirror share over an incident patch, as a BRDF of the exit patch of the same number.
double mirror_value(const KlemsSource& source, const KlemsPatch& patch) {
  constexpr int steps = 32;
  const double low = std::pow(std::sin(patch.theta_lower), 2),
               high = std::pow(std::sin(patch.theta_upper), 2);
  double sum = 0;
  for (int s = 0; s < steps; ++s)
    sum += source.mirror(std::asin(std::sqrt(low + (high - low) * (s + 0.5) / steps)));
  return sum / steps / patch.projected_solid_angle();
}

}  // namespace

KlemsAverage klems_average(const KlemsSource& source, const KlemsBasis& basis,
                           double relative_accuracy,
                           const std::function<void(double, double)>& progress) {
  KlemsAverage average{{basis, basis, std::vector<double>(basis.size() * basis.size())}, 0};
  // Pairs that a turn or a mirror carries into one another share a value. In units of
  // 360 deg/(patches i × patches r) their offset is an integer.
  std::map<std::tuple<std::size_t, std::size_t, long>, double> known;
  for (std::size_t o = 0; o < basis.size(); ++o) {
    for (std::size_t i = 0; i < basis.size(); ++i) {
      const KlemsPatch& incident = basis.patch(i);
      const KlemsPatch& exit = basis.patch(o);
      const long ni = basis.rings()[incident.ring].patches, no = basis.rings()[exit.ring].patches;
      const long pi_index = static_cast<long>(i - basis.first_of(incident.ring));
      const long po_index = static_cast<long>(o - basis.first_of(exit.ring));
      long offset = ((po_index * ni - pi_index * no) % (ni * no) + ni * no) % (ni * no);
      offset = std::min(offset, ni * no - offset);
      const auto [entry, fresh] = known.try_emplace({incident.ring, exit.ring, offset}, 0.0);
      if (fresh) {
        const double turn = 2 * pi * static_cast<double>(offset) / static_cast<double>(ni * no);
        const auto [value, error] =
            PairIntegral(source, {&incident, &exit, turn}).mean(relative_accuracy);
        entry->second = value;
        average.largest_relative_error =
            std::max(average.largest_relative_error, error / std::max(value, reporting_floor));
      }
      average.matrix.at(o, i) = entry->second;
    }
    if (progress) progress(static_cast<double>(o + 1), static_cast<double>(basis.size()));
  }
  if (source.mirror)
    for (std::size_t p = 0; p < basis.size(); ++p)
      average.matrix.at(p, p) += mirror_value(source, basis.patch(p));
  return average;
}

}  // namespace umov::formats
