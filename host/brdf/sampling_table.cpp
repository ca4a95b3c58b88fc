#include "host/brdf/sampling_table.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "host/brdf/sampling_incidence_grid.hpp"

namespace umov::brdf {
namespace {

using optics::pi;
using optics::Vec3;

constexpr double cosine_share = 0.02;
/// Cells hold at least this share of their fullest neighbour: what peaks between samples spills.
constexpr double least_of_neighbour = 0.25;
/// Part of the borders that is spread evenly rather than after the light.
constexpr double even_share = 0.25;

/// ln(1 + t²/w²) at the horizon: what radius 1 stands for.
double radius_span(const Incidence& in, double cos_psi, double width) {
  const double t = horizon_slope(in, cos_psi) / width;
  return std::log1p(t * t);
}

/// Light per unit of radius and azimuth, for incidence 1.
double light(const TableLobe::Brdf& brdf, const Incidence& in, double width, double radius,
             double psi) {
  const double cos_psi = std::cos(psi);
  const double span = radius_span(in, cos_psi, width);
  const double growth = std::expm1(radius * span);
  const double t = width * std::sqrt(growth);
  const Vec3<double> to = mirrored(in, t * cos_psi, t * std::sin(psi));
  if (!(to.z > 0.0)) return 0.0;
  const Exit exit(in, to);
  // t dt = ½ (t² + w²) span d(radius).
  const double area = 0.5 * width * width * (growth + 1.0) * span;
  const double value = brdf(geometry_of(in.theta, to)) * to.z * exit.sr_per_slope_area() * area;
  return std::isfinite(value) && value > 0.0 ? value : 0.0;
}

/// Borders of `cells` cells over [0, end] that hold about equal parts of the sampled `profile`.
std::vector<double> equal_parts(std::span<const double> profile, std::size_t cells, double end) {
  double total = 0.0;
  for (const double x : profile) total += x;
  const auto count = static_cast<double>(profile.size());
  std::vector<double> borders(cells + 1, 0.0);
  double before = 0.0;
  std::size_t border = 1;
  for (std::size_t i = 0; i < profile.size(); ++i) {
    const double here = even_share / count + (total > 0.0 ? (1.0 - even_share) * profile[i] / total
                                                          : (1.0 - even_share) / count);
    while (border < cells) {
      const double wanted = static_cast<double>(border) / static_cast<double>(cells);
      if (wanted > before + here) break;
      borders[border++] = end * (static_cast<double>(i) + (wanted - before) / here) / count;
    }
    before += here;
  }
  for (; border <= cells; ++border) borders[border] = end;
  return borders;
}

/// Running sums of `amounts`, scaled to end at 1; even where there is nothing.
void accumulate(std::span<const double> amounts, std::span<double> shares) {
  double total = 0.0;
  for (const double x : amounts) total += x;
  shares[0] = 0.0;
  double sum = 0.0;
  for (std::size_t i = 0; i < amounts.size(); ++i) {
    sum += total > 0.0 ? amounts[i] / total : 1.0 / static_cast<double>(amounts.size());
    shares[i + 1] = sum;
  }
  shares[amounts.size()] = 1.0;
}

/// The last i with rising[i] <= x, at most size - 2.
std::size_t cell_of(std::span<const double> rising, double x) {
  const auto after = std::upper_bound(rising.begin(), rising.end() - 1, x);
  const auto index = static_cast<std::size_t>(after - rising.begin());
  return index == 0 ? 0 : std::min(index - 1, rising.size() - 2);
}

/// Cell and position from a uniform number, through the shares.
double invert(std::span<const double> borders, std::span<const double> shares, double u,
              std::size_t& cell) {
  cell = cell_of(shares, u);
  const double width = shares[cell + 1] - shares[cell];
  const double within = width > 0.0 ? (u - shares[cell]) / width : 0.5;
  return borders[cell] + (borders[cell + 1] - borders[cell]) * within;
}

}  // namespace

TableLobe::TableLobe(const Brdf& brdf) {
  for (std::size_t i = 0; i < IncidenceGrid::count; ++i) {
    nodes_.push_back(tabulate(brdf, IncidenceGrid::theta(i)));
  }
}

TableLobe::Node TableLobe::tabulate(const Brdf& brdf, double theta_i) const {
  const Incidence in(theta_i);

  // How wide is it? Half the slope within which half of the light lies, found on a scale that is
  // logarithmic from 1e-7 on.
  constexpr double narrowest = 1e-7;
  constexpr std::size_t scale_steps = 120, directions = 6;
  std::vector<double> slope_of(scale_steps, 0.0), within(scale_steps, 0.0);
  for (std::size_t j = 0; j < directions; ++j) {
    const double psi = pi * (static_cast<double>(j) + 0.5) / directions;
    for (std::size_t i = 0; i < scale_steps; ++i) {
      const double radius = (static_cast<double>(i) + 0.5) / scale_steps;
      within[i] += light(brdf, in, narrowest, radius, psi);
      slope_of[i] += narrowest *
                     std::sqrt(std::expm1(radius * radius_span(in, std::cos(psi), narrowest))) /
                     directions;
    }
  }
  double total = 0.0, sum = 0.0;
  for (const double x : within) total += x;
  double width = 0.3;
  for (std::size_t i = 0; i < scale_steps && total > 0.0; ++i) {
    sum += within[i];
    if (sum < 0.5 * total) continue;
    width = 0.5 * slope_of[i];
    break;
  }

  constexpr std::size_t fine_radii = 160, fine_azimuths = 48;
  std::vector<double> by_radius(fine_radii, 0.0), by_azimuth(fine_azimuths, 0.0);
  for (std::size_t j = 0; j < fine_azimuths; ++j) {
    // Alternating offsets: every azimuth sees a quarter of the radii.
    for (std::size_t i = j % 4; i < fine_radii; i += 4) {
      const double x = light(brdf, in, width, (static_cast<double>(i) + 0.5) / fine_radii,
                             pi * (static_cast<double>(j) + 0.5) / fine_azimuths);
      by_radius[i] += x;
      by_azimuth[j] += x;
    }
  }
  Node node;
  node.log_width = std::log(width);
  node.radius = equal_parts(by_radius, radii, 1.0);
  node.psi = equal_parts(by_azimuth, azimuths, pi);

  // Root mean square over each cell: the constant that makes the weights scatter least.
  std::vector<double> level(azimuths * radii);
  for (std::size_t j = 0; j < azimuths; ++j) {
    for (std::size_t i = 0; i < radii; ++i) {
      double squares = 0.0;
      for (int k = 0; k < 2; ++k) {
        const double a = 0.25 + 0.5 * k, b = (i + j) % 2 == 0 ? a : 1.0 - a;
        const double x =
            light(brdf, in, width, node.radius[i] + a * (node.radius[i + 1] - node.radius[i]),
                  node.psi[j] + b * (node.psi[j + 1] - node.psi[j]));
        squares += x * x;
      }
      level[j * radii + i] = std::sqrt(0.5 * squares);
    }
  }
  std::vector<double> ring(radii), sector(azimuths, 0.0);
  node.radius_share.resize(azimuths * (radii + 1));
  for (std::size_t j = 0; j < azimuths; ++j) {
    for (std::size_t i = 0; i < radii; ++i) {
      double fullest = 0.0;
      for (std::size_t b = j > 0 ? j - 1 : 0; b <= std::min(j + 1, azimuths - 1); ++b) {
        for (std::size_t a = i > 0 ? i - 1 : 0; a <= std::min(i + 1, radii - 1); ++a)
          fullest = std::max(fullest, level[b * radii + a]);
      }
      const double height = std::max(level[j * radii + i], least_of_neighbour * fullest);
      ring[i] = height * (node.radius[i + 1] - node.radius[i]) * (node.psi[j + 1] - node.psi[j]);
      sector[j] += ring[i];
    }
    accumulate(ring, std::span(node.radius_share).subspan(j * (radii + 1), radii + 1));
  }
  node.psi_share.resize(azimuths + 1);
  accumulate(sector, node.psi_share);
  return node;
}

Vec3<double> TableLobe::draw(const Incidence& in, double u1, double u2, double u3) const {
  if (u3 < cosine_share) {
    const double r = std::sqrt(u1);
    return {r * std::cos(2.0 * pi * u2), r * std::sin(2.0 * pi * u2), std::sqrt(1.0 - u1)};
  }
  const IncidenceGrid::Place place = IncidenceGrid::locate(in.theta);
  const double choice = (u3 - cosine_share) / (1.0 - cosine_share);
  const Node& node = nodes_[place.lower + (choice < place.share ? 1 : 0)];
  const double width = std::exp(nodes_[place.lower].log_width * (1.0 - place.share) +
                                nodes_[place.lower + 1].log_width * place.share);
  const bool left = u1 < 0.5;
  std::size_t sector = 0, ring = 0;
  const double psi = invert(node.psi, node.psi_share, left ? 2.0 * u1 : 2.0 * u1 - 1.0, sector);
  const double radius = invert(
      node.radius, std::span(node.radius_share).subspan(sector * (radii + 1), radii + 1), u2, ring);
  const double cos_psi = std::cos(psi);
  const double t = width * std::sqrt(std::expm1(radius * radius_span(in, cos_psi, width)));
  const double across = t * std::sin(psi);
  return mirrored(in, t * cos_psi, left ? across : -across);
}

double TableLobe::pdf(const Incidence& in, const Exit& exit) const {
  const IncidenceGrid::Place place = IncidenceGrid::locate(in.theta);
  const double width = std::exp(nodes_[place.lower].log_width * (1.0 - place.share) +
                                nodes_[place.lower + 1].log_width * place.share);
  const double t = std::sqrt(exit.tan2_h);
  const double span = radius_span(in, t > 0.0 ? exit.half_x / t : 1.0, width);
  const double relative2 = exit.tan2_h / (width * width);
  const double radius = std::min(1.0, std::log1p(relative2) / span);
  const double psi = std::atan2(std::abs(exit.half_y), exit.half_x);
  double density = 0.0;
  for (std::size_t k = 0; k < 2; ++k) {
    const double share = k == 0 ? 1.0 - place.share : place.share;
    if (!(share > 0.0)) continue;
    const Node& node = nodes_[place.lower + k];
    const std::size_t sector = cell_of(node.psi, psi);
    const std::size_t ring = cell_of(node.radius, radius);
    const double* shares = node.radius_share.data() + sector * (radii + 1);
    density +=
        share * (node.psi_share[sector + 1] - node.psi_share[sector]) *
        (shares[ring + 1] - shares[ring]) /
        ((node.psi[sector + 1] - node.psi[sector]) * (node.radius[ring + 1] - node.radius[ring]));
  }
  // Half of it on either side; area t dt dψ = ½ (t² + w²) span per radius and azimuth.
  const double area = width * width * (1.0 + relative2) * span;
  return cosine_share * exit.direction.z / pi +
         (1.0 - cosine_share) * density / (area * exit.sr_per_slope_area());
}

}  // namespace umov::brdf
