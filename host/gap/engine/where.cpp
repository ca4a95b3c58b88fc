#include "host/gap/engine/where.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "host/gap/engine/orthonormal.hpp"

namespace umov::gap {
namespace {

constexpr std::size_t most_bins = 18;
constexpr std::size_t fewest_members = 6;

/// Edges of bins: the values themselves where there are few, else equal shares.
std::vector<std::pair<double, double>> bins_of(const std::vector<double>& value) {
  std::vector<double> sorted = value;
  std::sort(sorted.begin(), sorted.end());
  std::vector<double> distinct = sorted;
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  std::vector<std::pair<double, double>> bins;
  if (distinct.size() <= most_bins) {
    for (const double v : distinct) bins.emplace_back(v, v);
    return bins;
  }
  double from = sorted.front();
  for (std::size_t b = 1; b <= most_bins; ++b) {
    const double to = sorted[std::min(sorted.size() - 1, b * sorted.size() / most_bins)];
    if (to > from || b == most_bins) bins.emplace_back(from, to);
    from = to;
  }
  return bins;
}

std::vector<Cell> all_cells(const Observations& observations) {
  std::vector<Cell> cells;
  for (const Axis& axis : observations.axes) {
    const auto bins = bins_of(axis.value);
    if (bins.size() < 2) continue;
    const int channels = static_cast<int>(observations.channels.size());
    for (int channel = -1; channel < channels; ++channel) {
      if (channel >= 0 && channels == 1) break;
      for (std::size_t b = 0; b < bins.size(); ++b) {
        const auto [from, to] = bins[b];
        Cell cell{axis.name, axis.unit, from, to, {}, {}, {}};
        if (channel >= 0) cell.channel = observations.channels[static_cast<std::size_t>(channel)];
        const bool last = b + 1 == bins.size();
        for (std::size_t i = 0; i < axis.value.size(); ++i) {
          const double v = axis.value[i];
          const bool inside = v >= from && (v < to || (v == to && (last || from == to)));
          if (inside && (channel < 0 || observations.channel[i] == channel))
            cell.members.push_back(static_cast<Eigen::Index>(i));
        }
        if (cell.members.size() >= fewest_members) cells.push_back(std::move(cell));
      }
    }
  }
  return cells;
}

/// Mean and mean square of a cell, as numbers of standard deviations of white noise.
double badness(const Eigen::VectorXd& residual, const Cell& cell) {
  double sum = 0, square = 0;
  for (const Eigen::Index i : cell.members) {
    sum += residual[i];
    square += residual[i] * residual[i];
  }
  const double n = static_cast<double>(cell.members.size());
  const double mean = sum / std::sqrt(n);
  // Wilson and Hilferty: the cube root of χ²/n is near normal, also far out.
  const double cube = std::cbrt(square / n);
  const double spread = (cube - (1 - 2 / (9 * n))) / std::sqrt(2 / (9 * n));
  return std::abs(mean) > spread ? mean : spread;
}

}  // namespace

Where find_where(const ForwardModel& model, const Refit& fit, int draws, std::uint64_t seed) {
  std::vector<Cell> cells = all_cells(model.observations());
  const Eigen::Index n = fit.residual.size();
  for (Cell& cell : cells) cell.z = badness(fit.residual, cell);
  std::sort(cells.begin(), cells.end(),
            [](const Cell& a, const Cell& b) { return std::abs(a.z) > std::abs(b.z); });

  const Eigen::MatrixXd q = orthonormal(fit.jacobian(Eigen::all, fit.free));
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::vector<double> worst;
  Eigen::VectorXd draw(n);
  for (int d = 0; d < draws; ++d) {
    for (double& x : draw) x = normal(random);
    draw -= q * (q.transpose() * draw);
    double most = 0;
    for (const Cell& cell : cells) most = std::max(most, std::abs(badness(draw, cell)));
    worst.push_back(most);
  }
  std::sort(worst.begin(), worst.end());

  Where where;
  for (Cell& cell : cells) {
    const auto above = worst.end() - std::lower_bound(worst.begin(), worst.end(), std::abs(cell.z));
    cell.p_global = (1.0 + static_cast<double>(above)) / (1.0 + static_cast<double>(draws));
    if (&cell == &cells.front()) where.p_global = cell.p_global;
    if (cell.p_global > 0.05 || where.cells.size() == 12) break;
    where.cells.push_back(std::move(cell));
  }
  return where;
}

}  // namespace umov::gap
