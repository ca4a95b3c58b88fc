// Records of a diagnosis sorted into channels, set-ups and rows.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "host/optics/angles.hpp"
#include "host/report/diagnosis_parts.hpp"
#include "host/report/numbers.hpp"

namespace umov::report {

namespace {

using gap::scan::Picture;
using gap::scan::Record;

std::string channel_label(const Record& r) {
  const auto letter = [](bool open, double axis) {
    return open ? std::string("U") : axis_name(std::round(optics::degrees(axis) * 1e6) / 1e6);
  };
  return letter(r.polarizer_open, r.polarizer) + " → " + letter(r.analyzer_open, r.analyzer);
}

std::string setup_label(const Record& r) {
  std::vector<std::string> parts;
  if (!r.shutter_open) parts.push_back("shutter closed");
  if (r.sample_flipped) parts.push_back("sample turned by 180°");
  if (r.sample_removed) parts.push_back("sample taken away");
  if (r.long_pass) parts.push_back("long-pass filter");
  if (r.iris_fraction != 1) parts.push_back("aperture × " + plain(r.iris_fraction, 3));
  if (std::abs(r.phi_r) > 1e-9)
    parts.push_back("φr = " + plain(std::round(optics::degrees(r.phi_r) * 1e4) / 1e4) + "°");
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::size_t number_of(std::vector<std::string>& known, const std::string& label) {
  const auto at = std::find(known.begin(), known.end(), label);
  const auto number = static_cast<std::size_t>(at - known.begin());
  if (at == known.end()) known.push_back(label);
  return number;
}

}  // namespace

double Scene::theta_i_deg(std::size_t record) const {
  return std::round(optics::degrees(picture->records[record].theta_i) * 1e4) / 1e4;
}

double Scene::theta_r_deg(std::size_t record) const {
  return std::round(optics::degrees(picture->records[record].theta_r) * 1e4) / 1e4;
}

Scene scene_of(const Picture& picture) {
  Scene scene;
  scene.picture = &picture;
  scene.setups.emplace_back();
  using Line = std::tuple<std::size_t, std::size_t, std::size_t, double>;
  std::map<Line, std::array<double, 2>> moves;
  const auto line_of = [&](std::size_t i) {
    return Line{scene.setup[i], scene.channel[i], picture.records[i].wavelength,
                scene.theta_i_deg(i)};
  };
  for (std::size_t i = 0; i < picture.records.size(); ++i) {
    const Record& r = picture.records[i];
    scene.channel.push_back(number_of(scene.channels, channel_label(r)));
    scene.setup.push_back(number_of(scene.setups, setup_label(r)));
    moves[line_of(i)][r.direction > 0 ? 1 : 0] += 1;
  }
  // The move to a row's first angle does not make it a row of both directions.
  const auto both = [](const std::array<double, 2>& count) {
    return std::min(count[0], count[1]) > 0.2 * (count[0] + count[1]);
  };
  const auto rows = std::count_if(moves.begin(), moves.end(),
                                  [&](const auto& entry) { return both(entry.second); });
  const bool throughout = 2 * static_cast<std::size_t>(rows) >= moves.size();
  for (std::size_t i = 0; i < picture.records.size(); ++i)
    scene.direction.push_back(throughout && both(moves[line_of(i)]) ? picture.records[i].direction
                                                                    : 0);
  return scene;
}

double normalised(const Picture& p, std::size_t i, bool quadrature, bool after) {
  const gap::scan::Signals& model = after ? p.best : p.base;
  return quadrature ? (p.measured.y_v[i] - model.y_v[i]) / p.sigma.y_v[i]
                    : (p.measured.x_v[i] - model.x_v[i]) / p.sigma.x_v[i];
}

double percent_per_sigma(const Picture& p, std::size_t i, bool quadrature) {
  const double sigma = quadrature ? p.sigma.y_v[i] : p.sigma.x_v[i];
  const double signal = std::abs(p.best.x_v[i]);
  if (!(signal > 0.3 * p.sigma.x_v[i])) return std::numeric_limits<double>::quiet_NaN();
  return 100 * sigma / signal;
}

}  // namespace umov::report
