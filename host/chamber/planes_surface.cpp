#include "host/chamber/planes_surface.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "host/chamber/fast_angle.hpp"
#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"
#include "host/optics/frames.hpp"

namespace umov::chamber {
namespace {

using optics::pi;

constexpr std::size_t slopes = 4096;
constexpr std::size_t lobes = 33;
// Beyond these a factor no longer mends a table: it would make up most of its light.
constexpr double least_factor = 0.25;
constexpr double most_factor = 4.0;

/// Trowbridge and Reitz: density of facets' normals by solid angle, and the share of them that
/// `v` sees (Smith).
double facet_density(double width, const Vec3& half) {
  const double w2 = width * width;
  const double d = half.z * half.z * (w2 - 1.0) + 1.0;
  return w2 / (pi * d * d);
}

double visible_share(double width, const Vec3& v) {
  const double z2 = v.z * v.z;
  const double tan2 = (1.0 - z2) / z2;
  return 2.0 / (1.0 + std::sqrt(1.0 + width * width * tan2));
}

/// A normal among those that `v` sees (E. Heitz, "Sampling the GGX distribution of visible
/// normals", JCGT 2018).
Vec3 visible_normal(double width, const Vec3& v, double u1, double u2) {
  Vec3 s(width * v.x, width * v.y, v.z);
  s /= std::sqrt(optics::dot(s, s));
  const double across2 = s.x * s.x + s.y * s.y;
  const Vec3 t1 = across2 > 1e-24 ? Vec3(-s.y, s.x, 0.0) / std::sqrt(across2) : Vec3(1, 0, 0);
  const Vec3 t2 = optics::cross(s, t1);
  const double r = std::sqrt(u1);
  const double phi = 2.0 * pi * u2;
  const double p1 = r * std::cos(phi);
  const double lift = 0.5 * (1.0 + s.z);
  const double p2 = (1.0 - lift) * std::sqrt(1.0 - p1 * p1) + lift * r * std::sin(phi);
  const double p3 = std::sqrt(std::max(0.0, 1.0 - p1 * p1 - p2 * p2));
  Vec3 n = p1 * t1 + p2 * t2 + p3 * s;
  n = Vec3(width * n.x, width * n.y, std::max(1e-12, n.z));
  return n / std::sqrt(optics::dot(n, n));
}

}  // namespace

PlanesSurface::PlanesSurface(const brdf::PlanesTable& table, std::size_t wavelength,
                             std::optional<double> total) {
  for (std::size_t i = 0; i < table.incidences().size(); ++i) {
    Slice slice{table.incidences()[i].theta_i_deg, {}, {}, {}, {}};
    for (std::size_t k = 0; k <= slopes; ++k) {
      // The last entry stands for an endless slope.
      const double place = std::min(static_cast<double>(k) / slopes, 1.0 - 1e-9);
      const double tangent = place / (1.0 - place);
      const auto value = [&](double share, bool backward, bool left) {
        return static_cast<float>(table.at_facet(wavelength, i, {tangent, share, backward, left}));
      };
      slice.forward.push_back(value(1.0, false, false));
      slice.backward.push_back(value(1.0, true, false));
      slice.right.push_back(value(0.0, false, false));
      slice.left.push_back(value(0.0, false, true));
    }
    slices_.push_back(std::move(slice));
  }
  fit_lobes();
  keep_energy(total);
}

double PlanesSurface::of_slice(const Slice& slice, double place, double in_plane_share,
                               bool backward, bool left) const {
  const double scaled = place * slopes;
  const auto lower = static_cast<std::size_t>(scaled);
  const double weight = scaled - static_cast<double>(lower);
  const auto at = [&](const std::vector<float>& values) {
    const double low = values[lower];
    return low + weight * (static_cast<double>(values[lower + 1]) - low);
  };
  return in_plane_share * at(backward ? slice.backward : slice.forward) +
         (1.0 - in_plane_share) * at(left ? slice.left : slice.right);
}

double PlanesSurface::interpolated(const Vec3& from, const Vec3& to, double theta_deg) const {
  const double scale = 1.0 / (from.z + to.z);
  const double hx = (from.x + to.x) * scale;
  const double hy = (from.y + to.y) * scale;
  const double sine2 = from.x * from.x + from.y * from.y;
  const double sine = std::sqrt(sine2);
  // x along the light's way in the plane of incidence.
  const double ex = sine > 1e-12 ? -from.x / sine : 1.0;
  const double ey = sine > 1e-12 ? -from.y / sine : 0.0;
  const double x = hx * ex + hy * ey;
  const double y = hy * ex - hx * ey;
  const double along = x + sine * from.z * y * y;
  const double squares = along * along + y * y;
  const double share = squares > 0.0 ? along * along / squares : 1.0;
  const double tangent = std::sqrt(x * x + y * y);
  const double place = std::min(tangent / (1.0 + tangent), 1.0 - 1e-9);
  std::size_t upper = 0;
  while (upper < slices_.size() && slices_[upper].theta_i_deg <= theta_deg) ++upper;
  const Slice& high = slices_[std::min(upper, slices_.size() - 1)];
  const Slice& low = slices_[upper == 0 ? 0 : upper - 1];
  const double at_low = of_slice(low, place, share, along < 0.0, y < 0.0);
  const double span = high.theta_i_deg - low.theta_i_deg;
  if (!(span > 0.0)) return at_low;
  const double weight = (theta_deg - low.theta_i_deg) / span;
  return at_low + weight * (of_slice(high, place, share, along < 0.0, y < 0.0) - at_low);
}

double PlanesSurface::value(const Vec3& from, const Vec3& to) const {
  const double theta_deg = angle_deg(from.z);
  return factor_at(theta_deg) * interpolated(from, to, theta_deg);
}

double PlanesSurface::factor_at(double theta) const {
  const std::size_t lower = std::min(static_cast<std::size_t>(theta), factors_.size() - 2);
  const double weight = std::min(1.0, theta - static_cast<double>(lower));
  return factors_[lower] + weight * (factors_[lower + 1] - factors_[lower]);
}

double PlanesSurface::interpolated_reflectance(double theta_i_deg) const {
  const double theta = optics::radians(theta_i_deg);
  const Vec3 known(-std::sin(theta), 0.0, std::cos(theta));
  // A lattice of draws, whose weights scatter little.
  constexpr int count = 6000;
  constexpr double golden = 0.6180339887498949;
  constexpr double plastic = 0.7548776662466927;
  double sum = 0.0;
  for (int i = 0; i < count; ++i) {
    const Vec3 to =
        draw(known, (i + 0.5) / count, std::fmod(golden * i, 1.0), std::fmod(plastic * i, 1.0));
    if (to.z > 1e-9) sum += interpolated(known, to, theta_i_deg) * to.z / density(known, to);
  }
  return sum / count;
}

void PlanesSurface::keep_energy(std::optional<double> total) {
  std::vector<double> rows;
  for (const Slice& slice : slices_) rows.push_back(interpolated_reflectance(slice.theta_i_deg));
  for (int degree = 0; degree < 90; ++degree) {
    const double theta = degree;
    std::size_t upper = 0;
    while (upper < slices_.size() && slices_[upper].theta_i_deg <= theta) ++upper;
    double wanted = rows[std::min(upper, rows.size() - 1)];
    if (upper > 0 && upper < rows.size()) {
      const double from = slices_[upper - 1].theta_i_deg;
      const double weight = (theta - from) / (slices_[upper].theta_i_deg - from);
      wanted = rows[upper - 1] + weight * (rows[upper] - rows[upper - 1]);
    }
    if (total) wanted = *total;
    const double found = interpolated_reflectance(theta);
    if (!(wanted > 0.0) && !(found > 0.0)) {
      factors_.push_back(1.0);  // black here
      continue;
    }
    if (!(wanted >= least_factor * found && wanted <= most_factor * found)) {
      throw Error(fmt::format("gives {:.3g} of the light that comes in at {}°, where {:.3g} is due",
                              found, degree, wanted),
                  total ? "check that `total` is of this surface; else add rows near that "
                          "incidence and angles where its lobe is"
                        : "add rows near that incidence and angles where its lobe is");
    }
    factors_.push_back(wanted / found);
  }
}

PlanesSurface::Lobe PlanesSurface::lobe_at(double cosine) const {
  const double scaled = std::clamp(cosine, 0.0, 1.0) * (lobes - 1);
  const std::size_t lower = std::min(static_cast<std::size_t>(scaled), lobes - 2);
  const double weight = scaled - static_cast<double>(lower);
  const Lobe& a = lobes_[lower];
  const Lobe& b = lobes_[lower + 1];
  return {a.share + weight * (b.share - a.share), a.width + weight * (b.width - a.width)};
}

double PlanesSurface::mixture(const Lobe& lobe, const Vec3& known, const Vec3& drawn) {
  Vec3 half = known + drawn;
  half /= std::sqrt(optics::dot(half, half));
  const double facets =
      facet_density(lobe.width, half) * visible_share(lobe.width, known) / (4.0 * known.z);
  return (1.0 - lobe.share) * drawn.z / pi + lobe.share * facets;
}

Vec3 PlanesSurface::draw(const Vec3& known, double u1, double u2, double u3) const {
  const Lobe lobe = lobe_at(known.z);
  if (u3 < lobe.share) {
    const Vec3 half = visible_normal(lobe.width, known, u1, u2);
    return 2.0 * optics::dot(known, half) * half - known;
  }
  const double sine = std::sqrt(u1);
  const double phi = 2.0 * pi * u2;
  return {sine * std::cos(phi), sine * std::sin(phi), std::sqrt(1.0 - u1)};
}

double PlanesSurface::density(const Vec3& known, const Vec3& drawn) const {
  return mixture(lobe_at(known.z), known, drawn);
}

// For each incidence the mixture with the least spread of weights, ∫ (f cos)²/p dω, among a few.
void PlanesSurface::fit_lobes() {
  constexpr std::array widths{0.03, 0.06, 0.12, 0.25, 0.5};
  constexpr std::array shares{0.02, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8};
  constexpr int azimuths = 16;
  constexpr int radii = 48;
  for (std::size_t i = 0; i < lobes; ++i) {
    const double cosine = std::clamp(static_cast<double>(i) / (lobes - 1), 0.01, 1.0);
    const Vec3 known(-std::sqrt(1.0 - cosine * cosine), 0.0, cosine);
    // Directions by the slopes of the facets that mirror to them, dense about the mirror direction.
    struct Place {
      Vec3 direction;
      double light2, solid_angle;
    };
    std::vector<Place> places;
    for (int a = 0; a < azimuths; ++a) {
      for (int r = 0; r < radii; ++r) {
        const double psi = pi * (a + 0.5) / azimuths;
        const double u = (r + 0.5) / radii;
        const double t = u * u / (1.0 - u * u);  // slope; dt = 2u/(1 - u²)² du
        const double cos_h = 1.0 / std::sqrt(1.0 + t * t);
        const Vec3 half(t * cos_h * std::cos(psi), t * cos_h * std::sin(psi), cos_h);
        const double cos_d = optics::dot(known, half);
        const Vec3 to = 2.0 * cos_d * half - known;
        if (!(cos_d > 0.0) || !(to.z > 0.0)) continue;
        const double area =
            t * (2.0 * u / ((1.0 - u * u) * (1.0 - u * u))) / radii * (2.0 * pi / azimuths);
        const double light = interpolated(known, to, angle_deg(cosine)) * to.z;
        places.push_back({to, light * light, 4.0 * cos_d * cos_h * cos_h * cos_h * area});
      }
    }
    Lobe best{shares.front(), widths.back()};
    double least = std::numeric_limits<double>::infinity();
    for (const double width : widths) {
      for (const double share : shares) {
        double spread = 0.0;
        for (const Place& p : places) {
          spread += p.light2 / mixture({share, width}, known, p.direction) * p.solid_angle;
        }
        if (spread < least) {
          least = spread;
          best = {share, width};
        }
      }
    }
    lobes_.push_back(best);
  }
}

}  // namespace umov::chamber
