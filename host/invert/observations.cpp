#include "host/invert/observations.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <tuple>

#include "host/errors/error.hpp"
#include "host/formats/scan_table.hpp"
#include "host/optics/angles.hpp"
#include "host/optics/mueller.hpp"

namespace umov::invert {
namespace {

/// Angles that agree to a millionth of a degree are the same geometry.
std::int64_t key_of(double angle_deg) {
  return std::isnan(angle_deg) ? std::numeric_limits<std::int64_t>::max()
                               : std::llround(angle_deg * 1e6);
}

void require_usable(const formats::BrdfTable::Points& p, std::size_t i) {
  const auto place = [&](const char* column) {
    return Place{"point " + std::to_string(i), 0, column};
  };
  for (const auto& [column, values] : {std::pair{"theta_i_deg", &p.theta_i_deg},
                                       {"theta_r_deg", &p.theta_r_deg},
                                       {"phi_r_deg", &p.phi_r_deg},
                                       {"wavelength_nm", &p.wavelength_nm},
                                       {"brdf_per_sr", &p.brdf_per_sr}}) {
    if (!std::isfinite((*values)[i])) {
      throw Error(place(column), "is not a finite number", "mark the point as unused");
    }
  }
  if (!(p.brdf_u[i] > 0) || !std::isfinite(p.brdf_u[i])) {
    throw Error(place("brdf_u"), "is not a positive uncertainty",
                "a weighted fit needs one for each used point");
  }
}

/// How far values stand off the straight lines between their neighbours along scan rows: sum of the
/// distances times `unit`, which makes them shifts of the BRDF in its uncertainties. `angle` need
/// not be in equal steps.
double roughness(const std::vector<std::vector<std::size_t>>& rows,
                 const std::vector<double>& angle, const std::vector<double>& values,
                 const std::vector<double>& unit) {
  double sum = 0;
  for (const auto& row : rows) {
    for (std::size_t i = 1; i + 1 < row.size(); ++i) {
      const std::size_t before = row[i - 1], here = row[i], after = row[i + 1];
      const double span = angle[after] - angle[before];
      const double t = span > 0 ? (angle[here] - angle[before]) / span : 0.5;
      const double line = (1 - t) * values[before] + t * values[after];
      sum += std::abs(values[here] - line) * unit[here];
    }
  }
  return sum;
}

/// A gain error was made from the noisy value, so factor/value is smooth along a row where the
/// factor itself carries the noise and the lobe; for an additive error it is the other way round.
/// Where a factor stands for itself alone (a drive's stop in one place) both are as rough, and the
/// error counts as a relative one: of an angle it comes from the slope of a noisy curve.
void classify(Spectrum& spectrum, CommonError& common) {
  std::map<std::size_t, std::vector<std::size_t>> by_row;
  for (std::size_t i = 0; i < spectrum.points.size(); ++i) {
    by_row[spectrum.points[i].row].push_back(i);
  }
  std::vector<double> theta_r(spectrum.points.size());
  for (const Site& site : spectrum.sites) {
    for (std::size_t i = site.first; i < site.first + site.count; ++i) {
      theta_r[i] = site.view.geometry.theta_r;
    }
  }
  std::vector<std::vector<std::size_t>> rows;
  for (auto& [row, members] : by_row) {
    std::sort(members.begin(), members.end(), [&](std::size_t a, std::size_t b) {
      return std::tie(theta_r[a], a) < std::tie(theta_r[b], b);
    });
    rows.push_back(members);
  }
  std::vector<double> ratio(spectrum.points.size(), 0.0);
  bool finite = true;
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
  for (std::size_t i = 0; i < ratio.size(); ++i) {
    if (common.per_point[i] == 0) continue;
    ratio[i] = common.per_point[i] / spectrum.points[i].brdf_per_sr;
    finite = finite && std::isfinite(ratio[i]);
    lowest = std::min(lowest, ratio[i]);
    highest = std::max(highest, ratio[i]);
  }
  if (!finite) return;
  const bool constant = highest - lowest <= 1e-9 * std::max(std::abs(highest), std::abs(lowest));
  std::vector<double> of_ratio, of_shift;
  for (const Observation& point : spectrum.points) {
    of_ratio.push_back(std::abs(point.brdf_per_sr) / point.sigma);
    of_shift.push_back(1 / point.sigma);
  }
  constexpr double as_rough = 1.2;
  if (constant || roughness(rows, theta_r, ratio, of_ratio) <
                      as_rough * roughness(rows, theta_r, common.per_point, of_shift)) {
    common.relative = true;
    common.per_point = std::move(ratio);
  }
}

}  // namespace

std::size_t Observations::size() const {
  std::size_t out = 0;
  for (const Spectrum& spectrum : spectra) out += spectrum.points.size();
  return out;
}

std::vector<double> Observations::wavelengths_nm() const {
  std::vector<double> out;
  for (const Spectrum& spectrum : spectra) out.push_back(spectrum.wavelength_nm);
  return out;
}

Channel channel_of(double polarizer_deg, double analyzer_deg) {
  using optics::Stokes;
  const Stokes<double> source = formats::is_open(polarizer_deg)
                                    ? optics::unpolarized<double>()
                                    : optics::polarizer_stokes<double>(polarizer_deg);
  const Stokes<double> analyser = formats::is_open(analyzer_deg)
                                      ? optics::unpolarized<double>()
                                      : optics::analyzer_stokes<double>(analyzer_deg);
  Channel channel;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      channel.weight[static_cast<std::size_t>(4 * row + column)] = analyser[row] * source[column];
    }
  }
  return channel;
}

View view_of(const formats::BrdfTable::Points& points, std::size_t index, double solid_angle_sr) {
  View view;
  view.geometry = {optics::radians(points.theta_i_deg[index]),
                   optics::radians(points.theta_r_deg[index]),
                   optics::radians(points.phi_r_deg[index])};
  const double theta_i = view.geometry.theta_i, theta_r = view.geometry.theta_r;
  const double towards_mirror =
      std::sin(theta_i) * std::sin(theta_r) * std::cos(view.geometry.phi_r) +
      std::cos(theta_i) * std::cos(theta_r);
  // A cap of half-angle a has the solid angle 2π (1 − cos a).
  if (1 - towards_mirror <= solid_angle_sr / (2 * optics::pi) && solid_angle_sr > 0) {
    view.mirror_per_sr = 1 / (std::cos(theta_r) * solid_angle_sr);
  }
  return view;
}

double solid_angle_sr(const formats::BrdfTable& table) {
  for (const auto& [key, value] : table.keys) {
    if (key == "solid_angle_sr") return std::strtod(value.c_str(), nullptr);
  }
  return 0;
}

Observations observations(const formats::BrdfTable& table, double floor_relative) {
  const auto& p = table.points;
  std::map<std::int64_t, std::vector<std::size_t>> by_wavelength;
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (p.used[i] == 0) continue;
    require_usable(p, i);
    by_wavelength[key_of(p.wavelength_nm[i])].push_back(i);
  }
  if (by_wavelength.empty()) {
    throw Error(
        p.size() == 0 ? "the table has no points" : "no point of the table is marked as used",
        "reduce a scan that has signal above its noise");
  }

  const double aperture = solid_angle_sr(table);
  Observations out;
  for (const auto& factor : table.factors) out.factor_names.push_back(factor.name);
  std::map<std::array<std::int64_t, 5>, std::size_t> row_numbers;
  for (auto& [wavelength, members] : by_wavelength) {
    Spectrum spectrum;
    spectrum.wavelength_nm = p.wavelength_nm[members.front()];
    const auto place = [&](std::size_t i) {
      return std::array{key_of(p.theta_i_deg[i]), key_of(p.phi_r_deg[i]), key_of(p.theta_r_deg[i])};
    };
    std::stable_sort(members.begin(), members.end(),
                     [&](std::size_t a, std::size_t b) { return place(a) < place(b); });
    for (const std::size_t i : members) {
      if (spectrum.points.empty() || place(spectrum.points.back().table_index) != place(i)) {
        spectrum.sites.push_back({view_of(p, i, aperture), spectrum.points.size(), 0});
      }
      ++spectrum.sites.back().count;
      const std::array row{key_of(p.theta_i_deg[i]), wavelength, key_of(p.phi_r_deg[i]),
                           key_of(p.polarizer_deg[i]), key_of(p.analyzer_deg[i])};
      Observation point;
      point.table_index = i;
      point.row = row_numbers.try_emplace(row, row_numbers.size()).first->second;
      point.brdf_per_sr = p.brdf_per_sr[i];
      point.sigma = std::hypot(p.brdf_u[i], floor_relative * p.brdf_per_sr[i]);
      spectrum.points.push_back(point);
      spectrum.channels.push_back(channel_of(p.polarizer_deg[i], p.analyzer_deg[i]));
    }
    for (const auto& factor : table.factors) {
      CommonError common;
      common.name = factor.name;
      common.per_point.reserve(spectrum.points.size());
      bool any = false;
      for (const Observation& point : spectrum.points) {
        common.per_point.push_back(factor.per_point[point.table_index]);
        any = any || common.per_point.back() != 0;
      }
      if (any) {
        classify(spectrum, common);
      } else {
        common.per_point.clear();
      }
      spectrum.common.push_back(std::move(common));
    }
    out.spectra.push_back(std::move(spectrum));
  }
  out.rows = row_numbers.size();
  return out;
}

Observations select(const Observations& all, const std::vector<std::vector<bool>>& keep) {
  Observations out;
  out.factor_names = all.factor_names;
  out.rows = all.rows;
  for (std::size_t w = 0; w < all.spectra.size(); ++w) {
    const Spectrum& from = all.spectra[w];
    Spectrum to;
    to.wavelength_nm = from.wavelength_nm;
    to.common.resize(from.common.size());
    for (std::size_t k = 0; k < from.common.size(); ++k) {
      to.common[k].name = from.common[k].name;
      to.common[k].relative = from.common[k].relative;
    }
    for (const Site& site : from.sites) {
      Site kept{site.view, to.points.size(), 0};
      for (std::size_t i = site.first; i < site.first + site.count; ++i) {
        if (!keep[w][i]) continue;
        to.points.push_back(from.points[i]);
        to.channels.push_back(from.channels[i]);
        for (std::size_t k = 0; k < from.common.size(); ++k) {
          if (!from.common[k].per_point.empty()) {
            to.common[k].per_point.push_back(from.common[k].per_point[i]);
          }
        }
        ++kept.count;
      }
      if (kept.count > 0) to.sites.push_back(kept);
    }
    out.spectra.push_back(std::move(to));
  }
  return out;
}

Observations thinned(const Observations& all, std::size_t per_scan, double floor_relative) {
  std::vector<std::vector<bool>> keep;
  for (const Spectrum& spectrum : all.spectra) {
    keep.emplace_back(spectrum.points.size(), false);
    std::map<std::int64_t, std::vector<std::size_t>> scans;  // sites by incidence
    for (std::size_t s = 0; s < spectrum.sites.size(); ++s) {
      scans[std::llround(spectrum.sites[s].view.geometry.theta_i * 1e8)].push_back(s);
    }
    for (const auto& [incidence, sites] : scans) {
      // Length along the curve: angle and log level, each as a share of its range in this scan.
      std::vector<double> level, angle;
      for (const std::size_t s : sites) {
        double largest = 0;
        for (std::size_t i = 0; i < spectrum.sites[s].count; ++i) {
          const Observation& point = spectrum.points[spectrum.sites[s].first + i];
          largest = std::max({largest, point.brdf_per_sr, point.sigma});
        }
        level.push_back(std::log(largest));
        angle.push_back(spectrum.sites[s].view.geometry.theta_r);
      }
      const auto span_of = [](const std::vector<double>& v) {
        const auto [a, b] = std::minmax_element(v.begin(), v.end());
        return std::max(*b - *a, 1e-9);
      };
      const double level_span = std::max(span_of(level), 1.0), angle_span = span_of(angle);
      std::vector<double> length(sites.size(), 0.0);
      for (std::size_t i = 1; i < sites.size(); ++i) {
        length[i] = length[i - 1] + std::abs(level[i] - level[i - 1]) / level_span +
                    std::abs(angle[i] - angle[i - 1]) / angle_span + 1e-6;
      }
      double next = 0;
      const double step =
          sites.size() <= per_scan ? 0 : length.back() / static_cast<double>(per_scan);
      const auto top =
          static_cast<std::size_t>(std::max_element(level.begin(), level.end()) - level.begin());
      for (std::size_t i = 0; i < sites.size(); ++i) {
        if (length[i] < next && i != top) continue;
        while (step > 0 && next <= length[i]) next += step;
        const Site& site = spectrum.sites[sites[i]];
        for (std::size_t j = site.first; j < site.first + site.count; ++j) keep.back()[j] = true;
      }
    }
  }
  Observations out = select(all, keep);
  for (Spectrum& spectrum : out.spectra) {
    for (Observation& point : spectrum.points) {
      point.sigma = std::hypot(point.sigma, floor_relative * point.brdf_per_sr);
    }
  }
  return out;
}

}  // namespace umov::invert
