// Adaptive Gauss-Kronrod integration of a pair of functions at once.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

namespace umov::brdf {

using Pair = std::array<double, 2>;

struct Integral {
  Pair value{0.0, 0.0};
  double error = 0.0;  ///< estimate, of the worse of the two
};

/// One 15-point Kronrod rule with its 7-point Gauss rule on [from, to].
template <class Function>
Integral kronrod15(const Function& function, double from, double to) {
  constexpr std::array<double, 8> node{
      0.991455371120812639206854697526329, 0.949107912342758524526189684047851,
      0.864864423359769072789712788640926, 0.741531185599394439863864773280788,
      0.586087235467691130294144691258383, 0.405845151377397166906606412076961,
      0.207784955007898467600689403773245, 0.0};
  constexpr std::array<double, 8> kronrod{
      0.022935322010529224963732008058970, 0.063092092629978553290700663189204,
      0.104790010322250183839876322541518, 0.140653259715525918745189590510238,
      0.169004726639267902826583426598550, 0.190350578064785409913256402421014,
      0.204432940075298892414161999234649, 0.209482141084727828012999174891714};
  constexpr std::array<double, 4> gauss{
      0.129484966168869693270611432679082, 0.279705391489276667901467771423780,
      0.381830050505118944950369775488975, 0.417959183673469387755102040816327};
  const double centre = 0.5 * (from + to);
  const double half = 0.5 * (to - from);
  std::array<Pair, 15> sample;
  Pair fine{0.0, 0.0}, coarse{0.0, 0.0};
  std::array<double, 15> weight;
  std::size_t count = 0;
  for (std::size_t i = 0; i < 8; ++i) {
    for (const double side : {-1.0, 1.0}) {
      if (i == 7 && side > 0.0) continue;
      sample[count] = function(centre + side * half * node[i]);
      weight[count] = kronrod[i];
      for (std::size_t c = 0; c < 2; ++c) {
        fine[c] += kronrod[i] * sample[count][c];
        if (i % 2 == 1) coarse[c] += gauss[i / 2] * sample[count][c];
      }
      ++count;
    }
  }
  Integral result;
  for (std::size_t c = 0; c < 2; ++c) {
    double spread = 0.0;
    for (std::size_t i = 0; i < count; ++i)
      spread += weight[i] * std::abs(sample[i][c] - 0.5 * fine[c]);
    // The Gauss rule's error overstates the Kronrod rule's: the usual power of 3/2 of it, scaled by
    // the spread.
    double error = std::abs(fine[c] - coarse[c]);
    if (spread > 0.0) error = std::min(error, spread * std::pow(200.0 * error / spread, 1.5));
    result.value[c] = half * fine[c];
    result.error = std::max(result.error, std::abs(half) * error);
  }
  return result;
}

/// Integrates over the intervals between `breaks` (rising), halving the worst one until the
/// estimated error is below `tolerance`, absolute or relative to the first function's integral, or
/// `max_intervals` are in use.
template <class Function>
Integral integrate(const Function& function, std::span<const double> breaks, double tolerance,
                   std::size_t max_intervals = 400) {
  struct Piece {
    double from, to;
    Integral part;
    bool operator<(const Piece& other) const { return part.error < other.part.error; }
  };
  std::vector<Piece> pieces;
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
    pieces.push_back({breaks[i], breaks[i + 1], kronrod15(function, breaks[i], breaks[i + 1])});
  }
  std::make_heap(pieces.begin(), pieces.end());
  while (true) {
    Integral total;
    for (const Piece& piece : pieces) {
      for (std::size_t c = 0; c < 2; ++c) total.value[c] += piece.part.value[c];
      total.error += piece.part.error;
    }
    const double allowed = tolerance * std::max(1.0, std::abs(total.value[0]));
    if (total.error <= allowed || pieces.size() >= max_intervals) return total;
    std::pop_heap(pieces.begin(), pieces.end());
    const Piece worst = pieces.back();
    pieces.pop_back();
    const double middle = 0.5 * (worst.from + worst.to);
    for (const auto& [from, to] : {std::pair{worst.from, middle}, std::pair{middle, worst.to}}) {
      pieces.push_back({from, to, kronrod15(function, from, to)});
      std::push_heap(pieces.begin(), pieces.end());
    }
  }
}

}  // namespace umov::brdf
