#include "host/invert/starts.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>

#include "host/formats/order_statistics.hpp"
#include "host/invert/box_quadratic.hpp"
#include "host/optics/angles.hpp"
#include "host/parallel/for_each_index.hpp"

namespace umov::invert {
namespace {

constexpr double no_lobe_slope = 0.3;

/// Standard normal and uniform draws from a fixed recipe, so that a seed means the same everywhere.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : engine_(seed) {}
  double uniform() { return static_cast<double>(engine_() >> 11) * 0x1.0p-53; }
  double normal() {
    const double radius = std::sqrt(-2 * std::log(1 - uniform()));
    return radius * std::cos(2 * optics::pi * uniform());
  }

 private:
  std::mt19937_64 engine_;
};

/// Full width at half maximum (above the median) of the peak of a sorted in-plane row, in radians;
/// 0 where there is none.
double peak_width(const std::vector<std::pair<double, double>>& row, double theta_i) {
  if (row.size() < 8) return 0;
  std::vector<double> values;
  for (const auto& [angle, value] : row) values.push_back(value);
  const double base = std::max(formats::median(std::move(values)), 0.0);
  std::size_t top = row.size();
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (std::abs(row[i].first - theta_i) > optics::radians(25)) continue;
    if (top == row.size() || row[i].second > row[top].second) top = i;
  }
  if (top == row.size() || row[top].second < 3 * base || row[top].second <= 0) return 0;
  const double half = 0.5 * (row[top].second + base);
  const auto crossing = [&](long step) {
    for (long i = static_cast<long>(top); i + step >= 0 && i + step < static_cast<long>(row.size());
         i += step) {
      const auto& [a, fa] = row[static_cast<std::size_t>(i)];
      const auto& [b, fb] = row[static_cast<std::size_t>(i + step)];
      if (fb <= half) return std::abs(a + (b - a) * (fa - half) / (fa - fb) - row[top].first);
    }
    return -1.0;
  };
  const double below = crossing(-1), above = crossing(1);
  if (below < 0 && above < 0) return 0;
  if (below < 0) return 2 * above;
  if (above < 0) return 2 * below;
  return below + above;
}

/// What a parameter of this name should be near, for surfaces whose 1-D rms slope is known; 0 where
/// the slope says nothing about it.
double value_for_slope(const std::string& name, double slope_rms, double sigma_um) {
  if (name == "slope_rms") return slope_rms;
  if (name == "alpha" || name == "alpha_x" || name == "alpha_y") return std::sqrt(2) * slope_rms;
  if (name == "tau_um" || name == "correlation_um") return std::sqrt(2) * sigma_um / slope_rms;
  // cos^e about the mirror direction, where the lobe is twice as wide as in the half angle.
  if (name == "exponent") return 0.25 / (slope_rms * slope_rms);
  return 0;
}

double drawn_value(const std::string& name, const Coordinate& k, double initial, Draw& draw) {
  const double a = draw.uniform(), b = draw.normal();
  if (name == "kappa") {
    const double top = std::clamp(8.0, std::min(k.lo + 1e-2, k.hi), std::max(k.hi, 1e-2));
    return std::clamp(std::exp(std::log(1e-2) + a * (std::log(top) - std::log(1e-2))), k.lo, k.hi);
  }
  if (name == "n") {
    return std::clamp(b > -0.5 ? initial + 0.2 * b : k.lo + a * (std::min(k.hi, 3.0) - k.lo), k.lo,
                      k.hi);
  }
  if (k.scale == Scale::logarithmic) return std::clamp(initial * std::exp(1.2 * b), k.lo, k.hi);
  return k.lo + a * (k.hi - k.lo);
}

}  // namespace

double lobe_slope(const Observations& data) {
  std::vector<double> slopes;
  for (const Spectrum& spectrum : data.spectra) {
    std::map<std::size_t, std::vector<std::pair<double, double>>> rows;
    std::map<std::size_t, double> incidence;
    for (const Site& site : spectrum.sites) {
      const auto& g = site.view.geometry;
      const double across = std::abs(std::sin(g.phi_r));
      if (across > 1e-6) continue;  // the mirror lobe is cut through its middle in plane only
      const double theta_r = std::cos(g.phi_r) > 0 ? g.theta_r : -g.theta_r;
      for (std::size_t i = site.first; i < site.first + site.count; ++i) {
        rows[spectrum.points[i].row].emplace_back(theta_r, spectrum.points[i].brdf_per_sr);
        incidence[spectrum.points[i].row] = g.theta_i;
      }
    }
    for (auto& [row, curve] : rows) {
      std::sort(curve.begin(), curve.end());
      const double width = peak_width(curve, incidence[row]);
      // The half vector moves half as far as the detector; 2.355 widths of sigma make one FWHM.
      if (width > 0) slopes.push_back(std::tan(std::min(width / 2 / 2.355, 1.0)));
    }
  }
  if (slopes.empty()) return no_lobe_slope;
  return formats::median(std::move(slopes));
}

std::vector<bool> linear_parameters(const Layout& layout, const Observations& data) {
  const auto& list = layout.model().parameters();
  std::vector<bool> linear(list.size(), false);
  // A handful of geometries through the data.
  std::vector<View> views;
  for (const Spectrum& spectrum : data.spectra) {
    const std::size_t step = std::max<std::size_t>(1, spectrum.sites.size() / 6);
    for (std::size_t s = 0; s < spectrum.sites.size() && views.size() < 8; s += step) {
      views.push_back(spectrum.sites[s].view);
    }
  }
  std::vector<Channel> channels{channel_of(0, 0), channel_of(0, 90), channel_of(90, 90)};
  const std::vector<double> base = layout.values(0, layout.start_x());
  std::vector<int> set;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const auto slot = layout.slot(0, i);
    if (!slot || layout.free()[*slot].coordinate.scale != Scale::linear) continue;
    std::vector<int> trial = set;
    trial.push_back(static_cast<int>(i));
    std::vector<double> here = base, there = base;
    for (std::size_t t = 0; t < trial.size(); ++t) {
      const auto p = static_cast<std::size_t>(trial[t]);
      const double span = list[p].max - list[p].min;
      here[p] = list[p].min + span * 0.11;
      there[p] = list[p].min + span * (0.23 + 0.05 * static_cast<double>(t));
    }
    bool same = true;
    for (const View& view : views) {
      std::vector<double> f(3), a(3 * trial.size()), b(3 * trial.size());
      evaluate_channels(layout.model(), here, trial, layout.wavelength_um(0), view, channels, f, a);
      evaluate_channels(layout.model(), there, trial, layout.wavelength_um(0), view, channels, f,
                        b);
      for (std::size_t j = 0; j < a.size(); ++j) {
        same = same && std::abs(a[j] - b[j]) <= 1e-9 * (std::abs(a[j]) + std::abs(b[j])) + 1e-300;
      }
    }
    if (same) set = trial;
  }
  for (const int i : set) linear[static_cast<std::size_t>(i)] = true;
  return linear;
}

std::vector<double> with_linear_solved(const Layout& layout, const Observations& data,
                                       const std::vector<bool>& linear, std::vector<double> x) {
  std::vector<Eigen::Index> columns;
  for (std::size_t i = 0; i < layout.size(); ++i) {
    if (linear[layout.free()[i].parameter] && !layout.free()[i].user_start) {
      columns.push_back(static_cast<Eigen::Index>(i));
    }
  }
  if (columns.empty()) return x;
  const Linearisation at = linearise(layout, data, x, {}, {});
  if (!at.r.allFinite() || !at.by_x.allFinite()) return x;
  const Eigen::MatrixXd j = at.by_x(Eigen::all, columns);
  const auto count = static_cast<Eigen::Index>(columns.size());
  Eigen::VectorXd lo(count), hi(count), p(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto free = static_cast<std::size_t>(columns[static_cast<std::size_t>(i)]);
    lo[i] = layout.free()[free].coordinate.lo_x();
    hi[i] = layout.free()[free].coordinate.hi_x();
    p[i] = x[free];
  }
  const Eigen::MatrixXd a = j.transpose() * j;
  const Eigen::VectorXd b = j.transpose() * at.r - a * p;
  const Eigen::VectorXd best = minimum_in_box(a, b, lo, hi, p);
  for (Eigen::Index i = 0; i < count; ++i) {
    x[static_cast<std::size_t>(columns[static_cast<std::size_t>(i)])] = best[i];
  }
  return x;
}

std::vector<std::vector<double>> starting_points(const Layout& layout, const Observations& thinned,
                                                 double slope_rms, int count, std::uint64_t seed,
                                                 int threads) {
  const auto& list = layout.model().parameters();
  const std::vector<bool> linear = linear_parameters(layout, thinned);
  const auto candidates = static_cast<std::size_t>(std::max(24, 5 * count));
  std::vector<std::vector<double>> points(candidates);
  std::vector<double> merit(candidates);
  for_each_index(candidates, threads, [&](std::size_t index) {
    Draw draw(seed * 0x9E3779B97F4A7C15ULL + index);
    std::vector<double> x = layout.start_x();
    std::map<std::size_t, double> drawn;    // by parameter: wavelengths start from the same value
    std::map<std::string, double> heights;  // sigma of each summand, for its correlation length
    for (std::size_t i = 0; i < layout.size(); ++i) {
      const FreeParameter& free = layout.free()[i];
      const std::string& name = list[free.parameter].name;
      const std::string bare = bare_name(name);
      const std::string part = name.substr(0, name.size() - bare.size());
      const Coordinate& k = free.coordinate;
      double value = free.start;
      if (!free.user_start) {
        if (!drawn.contains(free.parameter)) {
          const auto fixed_sigma = [&] {
            for (std::size_t j = 0; j < list.size(); ++j) {
              if (list[j].name == part + "sigma_um") return layout.values(0, x)[j];
            }
            return 1.0;
          };
          const double sigma = heights.contains(part) ? heights[part] : fixed_sigma();
          const double near = value_for_slope(bare, slope_rms, sigma);
          const double spread = index < 2 ? 0 : 0.4;
          if (near > 0) {
            // Summands of one kind start apart: a lobe each.
            const double apart = part.empty() || part == "0." ? 1 : 3;
            drawn[free.parameter] =
                near * std::exp(spread * draw.normal()) * (bare == "exponent" ? 1 / apart : apart);
          } else {
            drawn[free.parameter] =
                index == 0 ? free.start : drawn_value(bare, k, list[free.parameter].initial, draw);
          }
        }
        value = drawn[free.parameter];
        // Reflection is even in kappa: its derivative at 0 would hide the parameter.
        if (bare == "kappa") value = std::max(value, 0.03);
        value = std::clamp(value, k.lo, k.hi);
      }
      if (bare == "sigma_um") heights[part] = value;
      x[i] = k.to_x(value);
    }
    x = with_linear_solved(layout, thinned, linear, std::move(x));
    points[index] = x;
    Eigen::VectorXd r(static_cast<Eigen::Index>(thinned.size()));
    Eigen::Index first = 0;
    for (std::size_t w = 0; w < thinned.spectra.size(); ++w) {
      const auto part = residuals(layout, thinned, w, x, {}, {}, false);
      r.segment(first, part.r.size()) = part.r;
      first += part.r.size();
    }
    merit[index] =
        r.allFinite() ? residual_scale(r, 4, layout.size()) : std::numeric_limits<double>::max();
  });
  std::vector<std::size_t> order(candidates);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin() + 1, order.end(),
                   [&](std::size_t a, std::size_t b) { return merit[a] < merit[b]; });
  order.resize(static_cast<std::size_t>(std::max(1, count)));
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return merit[a] < merit[b]; });
  std::vector<std::vector<double>> out;
  for (const std::size_t i : order) out.push_back(points[i]);
  return out;
}

}  // namespace umov::invert
