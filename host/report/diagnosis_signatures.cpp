// What each effect of the best explanation does, laid over what is measured.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>

#include <Eigen/Dense>

#include "host/gap/answer/words.hpp"
#include "host/report/diagnosis_parts.hpp"
#include "host/report/json_parts.hpp"
#include "host/report/numbers.hpp"

namespace umov::report {

namespace {

using gap::scan::Contribution;
using gap::scan::Picture;

constexpr std::size_t most_lines = 4;
constexpr std::size_t most_points = 240;
constexpr std::size_t trend_points = 40;
/// Share of a contribution that must follow time or signal for it to be shown along that axis.
constexpr double follows = 0.8;

double value_of(const gap::scan::Signals& s, std::size_t i, bool quadrature) {
  return quadrature ? s.y_v[i] : s.x_v[i];
}

/// Records of one wavelength, channel and angle of incidence: what lies along θr.
struct Line {
  std::vector<std::size_t> records;
  bool quadrature = false;
  double chi2 = 0;
};

std::vector<Line> strongest_lines(const Scene& scene, const Contribution& c) {
  const Picture& p = *scene.picture;
  std::map<std::tuple<bool, std::size_t, std::size_t, std::size_t, double, int>, Line> lines;
  for (std::size_t i = 0; i < p.records.size(); ++i) {
    const gap::scan::Record& r = p.records[i];
    if (r.saturated) continue;
    for (const bool quadrature : {false, true}) {
      Line& line = lines[{quadrature, scene.setup[i], scene.channel[i], r.wavelength,
                          scene.theta_i_deg(i), scene.direction[i]}];
      const double z = value_of(c.refitted, i, quadrature) / value_of(p.sigma, i, quadrature);
      line.records.push_back(i);
      line.quadrature = quadrature;
      line.chi2 += z * z;
    }
  }
  std::vector<Line> sorted;
  for (auto& [key, line] : lines)
    if (line.records.size() > 2) sorted.push_back(std::move(line));
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Line& a, const Line& b) { return a.chi2 > b.chi2; });
  if (sorted.size() > most_lines) sorted.resize(most_lines);
  for (Line& line : sorted) {
    std::stable_sort(line.records.begin(), line.records.end(), [&](std::size_t a, std::size_t b) {
      return scene.theta_r_deg(a) < scene.theta_r_deg(b);
    });
    const std::size_t stride = (line.records.size() + most_points - 1) / most_points;
    std::vector<std::size_t> thinned;
    for (std::size_t k = 0; k < line.records.size(); k += stride)
      thinned.push_back(line.records[k]);
    line.records = std::move(thinned);
  }
  return sorted;
}

Json line_json(const Scene& scene, const Contribution& c, const Line& line) {
  const Picture& p = *scene.picture;
  std::vector<double> x, scale;
  std::array<std::vector<double>, 2> points, curve;
  for (const std::size_t i : line.records) {
    const double sigma = value_of(p.sigma, i, line.quadrature);
    const double left = normalised(p, i, line.quadrature, true);
    x.push_back(scene.theta_r_deg(i));
    scale.push_back(percent_per_sigma(p, i, line.quadrature));
    for (const std::size_t way : {0, 1}) {
      const double z = value_of(way == 0 ? c.refitted : c.held, i, line.quadrature) / sigma;
      curve[way].push_back(z);
      points[way].push_back(left + z);
    }
  }
  const std::size_t first = line.records.front();
  const gap::scan::Record& r = p.records[first];
  std::string label =
      fmt::format("{} nm, {}, θi = {}°", plain(p.wavelengths_nm[r.wavelength]),
                  scene.channels[scene.channel[first]], plain(scene.theta_i_deg(first)));
  if (scene.setup[first] != 0) label += ", " + scene.setups[scene.setup[first]];
  if (scene.direction[first] != 0)
    label += scene.direction[first] > 0 ? ", moving up" : ", moving down";
  if (line.quadrature) label += ", quadrature";
  return {{"label", label},
          {"wavelength_nm", rounded(p.wavelengths_nm[r.wavelength], 6)},
          {"theta_i_deg", scene.theta_i_deg(first)},
          {"chi2", rounded(line.chi2, 3)},
          {"x", rounded(x, 5)},
          {"scale", rounded(scale, 3)},
          {"refitted", {{"points", rounded(points[0], 3)}, {"line", rounded(curve[0], 4)}}},
          {"held", {{"points", rounded(points[1], 3)}, {"line", rounded(curve[1], 4)}}}};
}

/// Share of the contribution's weighted square that a smooth factor along `x` (in −1 … 1) makes.
double share_along(const std::vector<double>& x, const std::vector<double>& relative,
                   const std::vector<double>& steepness) {
  constexpr Eigen::Index terms = 5;
  const auto n = static_cast<Eigen::Index>(x.size());
  Eigen::MatrixXd basis(n, terms);
  Eigen::VectorXd value(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    double power = steepness[k];
    for (Eigen::Index t = 0; t < terms; ++t, power *= x[k]) basis(i, t) = power;
    value[i] = relative[k] * steepness[k];
  }
  const double whole = value.squaredNorm();
  if (!(whole > 0)) return 0;
  const Eigen::VectorXd fit = basis * basis.householderQr().solve(value);
  return 1 - (value - fit).squaredNorm() / whole;
}

/// Along time or signal, where the contribution is a factor that follows one of them; null where it
/// is not.
Json trend_json(const Scene& scene, const Contribution& c) {
  const Picture& p = *scene.picture;
  std::vector<std::size_t> used;
  std::vector<double> order, log_signal, relative, steepness;
  double in_quadrature = 0, in_phase = 0;
  for (std::size_t i = 0; i < p.records.size(); ++i) {
    const double signal = p.best.x_v[i];
    if (p.records[i].saturated) continue;
    const double zx = c.refitted.x_v[i] / p.sigma.x_v[i];
    const double zy = c.refitted.y_v[i] / p.sigma.y_v[i];
    in_phase += zx * zx;
    in_quadrature += zy * zy;
    if (!(signal > 3 * p.sigma.x_v[i])) continue;
    used.push_back(i);
    order.push_back(static_cast<double>(i));
    log_signal.push_back(std::log10(signal));
    relative.push_back(c.refitted.x_v[i] / signal);
    steepness.push_back(signal / p.sigma.x_v[i]);
  }
  if (used.size() < 4 * trend_points || in_quadrature > in_phase) return nullptr;
  const auto centred = [](std::vector<double> x) {
    const auto [low, high] = std::minmax_element(x.begin(), x.end());
    const double middle = 0.5 * (*low + *high), half = std::max(0.5 * (*high - *low), 1e-12);
    for (double& v : x) v = (v - middle) / half;
    return x;
  };
  const double by_time = share_along(centred(order), relative, steepness);
  const double by_signal = share_along(centred(log_signal), relative, steepness);
  if (std::max(by_time, by_signal) < follows) return nullptr;
  const bool time = by_time >= by_signal;
  const std::vector<double>& axis = time ? order : log_signal;
  std::vector<std::size_t> sorted(used.size());
  for (std::size_t k = 0; k < sorted.size(); ++k) sorted[k] = k;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [&](std::size_t a, std::size_t b) { return axis[a] < axis[b]; });
  std::vector<double> x, u;
  std::array<std::vector<double>, 2> points, curve;
  for (std::size_t bin = 0; bin < trend_points; ++bin) {
    const std::size_t from = bin * sorted.size() / trend_points;
    const std::size_t to = (bin + 1) * sorted.size() / trend_points;
    double weight = 0, place = 0;
    std::array<double, 2> sum{}, left{};
    for (std::size_t k = from; k < to; ++k) {
      const std::size_t at = sorted[k], i = used[at];
      weight += steepness[at] * steepness[at];
      place += axis[at];
      for (const std::size_t way : {0, 1}) {
        const double z = (way == 0 ? c.refitted : c.held).x_v[i] / p.sigma.x_v[i];
        sum[way] += steepness[at] * z;
        left[way] += steepness[at] * (normalised(p, i, false, true) + z);
      }
    }
    place /= static_cast<double>(to - from);
    x.push_back(time ? place + 1 : std::pow(10.0, place));
    u.push_back(100 / std::sqrt(weight));
    for (const std::size_t way : {0, 1}) {
      points[way].push_back(100 * left[way] / weight);
      curve[way].push_back(100 * sum[way] / weight);
    }
  }
  return {{"axis", time ? "record" : "signal"},
          {"x", rounded(x, 5)},
          {"u", rounded(u, 3)},
          {"refitted", {{"points", rounded(points[0], 4)}, {"line", rounded(curve[0], 4)}}},
          {"held", {{"points", rounded(points[1], 4)}, {"line", rounded(curve[1], 4)}}}};
}

}  // namespace

Json signatures(const Scene& scene) {
  std::vector<const Contribution*> sorted;
  for (const Contribution& c : scene.picture->contributions) sorted.push_back(&c);
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto* a, const auto* b) {
    return std::pair(a->named, a->delta_chi2) > std::pair(b->named, b->delta_chi2);
  });
  Json out = Json::array();
  for (const Contribution* c : sorted) {
    Json lines = Json::array();
    for (const Line& line : strongest_lines(scene, *c)) lines.push_back(line_json(scene, *c, line));
    Json entry{{"effect", c->effect.name},
               {"family", c->effect.family},
               {"plain", gap::plain_name(c->effect.name)},
               {"physics", c->effect.physics},
               {"named", c->named},
               {"delta_chi2", plain(c->delta_chi2, 3)},
               {"lines", std::move(lines)}};
    if (Json trend = trend_json(scene, *c); !trend.is_null()) entry["trend"] = std::move(trend);
    out.push_back(std::move(entry));
  }
  return out;
}

}  // namespace umov::report
