#include "host/invert/descent.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "host/invert/box_quadratic.hpp"
#include "host/invert/starts.hpp"

namespace umov::invert {
namespace {

constexpr std::size_t sites_per_scan = 16;
constexpr std::array<double, 2> blurs{0.3, 0.05};
/// A line search counts as a gain from this share of the objective on.
constexpr double worthwhile = 0.01;
constexpr int most_rounds = 6;

/// Trial values across a coordinate's range.
std::vector<double> trials(const Coordinate& k) {
  std::vector<double> out;
  const double lo = k.lo_x(), hi = k.hi_x();
  if (k.scale == Scale::square) {
    for (const double p :
         {0.0, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 10.0, 30.0}) {
      if (p >= k.lo && p <= k.hi) out.push_back(k.to_x(p));
    }
    return out;
  }
  const int count = k.scale == Scale::logarithmic ? 25 : 13;
  for (int i = 0; i < count; ++i) out.push_back(lo + (hi - lo) * (i + 0.5) / count);
  return out;
}

}  // namespace

Descent::Descent(const Problem& problem) : problem_(problem) {
  const Layout& layout = problem.layout;
  linear_ = linear_parameters(layout, problem.data);
  terms_ = terms_with_shapes(layout, problem.data, linear_);
  few_ = thinned(problem.data, sites_per_scan, 0);
  for (const double blur : blurs) blurred_.push_back(thinned(problem.data, sites_per_scan, blur));
  std::vector<std::size_t> all(layout.wavelengths_nm().size());
  for (std::size_t w = 0; w < all.size(); ++w) all[w] = w;
  for (std::size_t i = 0; i < layout.size(); ++i) {
    const FreeParameter& free = layout.free()[i];
    if (linear_[free.parameter] && (free.wavelength || all.size() == 1)) continue;
    Line line{{i}, free.wavelength ? std::vector{*free.wavelength} : all, trials(free.coordinate)};
    lines_.push_back(std::move(line));
    const std::string& name = layout.parameter_name(i);
    if (bare_name(name) != "sigma_um" || free.wavelength) continue;
    // Height and correlation length together: the slope stays.
    const std::string length = name.substr(0, name.size() - 8) + "tau_um";
    for (std::size_t j = 0; j < layout.size(); ++j) {
      if (layout.parameter_name(j) != length || layout.free()[j].wavelength) continue;
      Line both{{i, j}, all, {}};
      for (int step = -12; step <= 12; ++step) {
        if (step != 0) both.values.push_back(0.5 * step);
      }
      lines_.push_back(std::move(both));
    }
  }
}

double Descent::solve_linear(const Observations& data, std::size_t w,
                             std::vector<double>& x) const {
  const Layout& layout = problem_.layout;
  const Spectrum& spectrum = data.spectra[w];
  std::vector<int> columns;
  std::vector<std::size_t> slots;
  for (const int parameter : layout.active(w)) {
    const auto p = static_cast<std::size_t>(parameter);
    const std::size_t free = *layout.slot(w, p);
    if (!linear_[p] || (!layout.free()[free].wavelength && data.spectra.size() > 1)) continue;
    columns.push_back(parameter);
    slots.push_back(free);
  }
  const auto count = static_cast<Eigen::Index>(columns.size());
  const std::vector<double> values = layout.values(w, x);
  Eigen::VectorXd now(count), lo(count), hi(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Coordinate& k = layout.free()[slots[static_cast<std::size_t>(i)]].coordinate;
    now[i] = x[slots[static_cast<std::size_t>(i)]];
    lo[i] = k.lo_x();
    hi[i] = k.hi_x();
  }
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(count, count);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(count), row(count);
  double sum = 0;
  std::vector<double> f, by;
  for (const Site& site : spectrum.sites) {
    f.assign(site.count, 0.0);
    by.assign(site.count * columns.size(), 0.0);
    evaluate_channels(layout.model(), values, columns, layout.wavelength_um(w), site.view,
                      std::span(spectrum.channels).subspan(site.first, site.count), f, by);
    for (std::size_t i = 0; i < site.count; ++i) {
      const Observation& point = spectrum.points[site.first + i];
      for (Eigen::Index j = 0; j < count; ++j) {
        row[j] = by[i * columns.size() + static_cast<std::size_t>(j)] / point.sigma;
      }
      const double r = (f[i] - point.brdf_per_sr) / point.sigma;
      a.noalias() += row * row.transpose();
      b += r * row;
      sum += r * r;
    }
  }
  if (!std::isfinite(sum) || !a.allFinite()) return std::numeric_limits<double>::infinity();
  const Eigen::VectorXd step =
      minimum_in_box(a, b, lo - now, hi - now, Eigen::VectorXd::Zero(count));
  for (Eigen::Index i = 0; i < count; ++i) {
    x[slots[static_cast<std::size_t>(i)]] = std::clamp(now[i] + step[i], lo[i], hi[i]);
  }
  return sum + (2 * b + a * step).dot(step);
}

bool Descent::sweep(const Observations& data, std::vector<double>& x) const {
  const Layout& layout = problem_.layout;
  const std::size_t wavelengths = data.spectra.size();
  std::vector<double> parts(wavelengths);
  for (std::size_t w = 0; w < wavelengths; ++w) parts[w] = solve_linear(data, w, x);
  bool gained = false;
  for (const Line& line : lines_) {
    double before = 0;
    for (const std::size_t w : line.wavelengths) before += parts[w];
    double total = 0;
    for (const double part : parts) total += part;
    std::vector<double> best = x, best_parts = parts;
    double least = before;
    for (const double value : line.values) {
      std::vector<double> trial = x, trial_parts = parts;
      bool inside = true;
      for (const std::size_t i : line.members) {
        const Coordinate& k = layout.free()[i].coordinate;
        trial[i] = line.members.size() == 1 ? value : x[i] + value;
        inside = inside && trial[i] >= k.lo_x() && trial[i] <= k.hi_x();
      }
      if (!inside) continue;
      double sum = 0;
      for (const std::size_t w : line.wavelengths) {
        trial_parts[w] = solve_linear(data, w, trial);
        sum += trial_parts[w];
        if (!(sum < least)) break;
      }
      if (!(sum < least)) continue;
      least = sum;
      best = std::move(trial);
      best_parts = std::move(trial_parts);
    }
    if (least < before) {
      gained = gained || before - least > worthwhile * total;
      x = std::move(best);
      parts = std::move(best_parts);
    }
  }
  return gained;
}

Solution Descent::from_near(std::vector<double> x, std::vector<double> c, Stop stop) const {
  int iterations = 0;
  if (few_.size() < problem_.data.size() / 2) {
    Solution rough = least_squares(
        {problem_.layout, few_, problem_.priors, problem_.weighting}, std::move(x), {}, linear_,
        {.max_iterations = stop.max_iterations, .function_tolerance = 1e-3});
    iterations = rough.iterations;
    x = std::move(rough.x);
    stop.first_damping = 1e-7;
  }
  Solution out = least_squares(problem_, std::move(x), std::move(c), linear_, stop);
  out.iterations += iterations;
  return out;
}

bool Descent::search_lines(std::vector<double>& x) const {
  return sweep(blurred_.back(), x);
}

Solution Descent::from(std::vector<double> x) const {
  const std::vector<double> no_factors;
  int iterations = 0;
  for (const Observations& data : blurred_) {
    for (int round = 0; round < most_rounds; ++round) {
      const bool gained = sweep(data, x);
      if (!gained && round > 0) break;
      Solution part = least_squares({problem_.layout, data, problem_.priors}, x, no_factors,
                                    linear_, {.max_iterations = 40, .function_tolerance = 1e-4});
      iterations += part.iterations;
      x = std::move(part.x);
    }
  }
  Solution out =
      least_squares(problem_, x, std::vector<double>(problem_.data.factor_names.size(), 0.0),
                    linear_, {.max_iterations = 200, .function_tolerance = 1e-10});
  out = with_idle_terms_offered(problem_, linear_, terms_, std::move(out), {200, 1e-10});
  out.iterations += iterations;
  return out;
}

}  // namespace umov::invert
