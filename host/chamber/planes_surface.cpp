#include "host/chamber/planes_surface.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"
#include "host/optics/frames.hpp"

namespace umov::chamber {
namespace {

using optics::pi;

// Stored slopes, uniform in t/(t + half_way): the half of them below half_way, where lobes are.
constexpr std::size_t slopes = 1024;
constexpr double half_way = 0.25;
constexpr std::size_t lobes = 33;
// Beyond these a factor no longer mends a table: it would make up most of its light.
constexpr double least_factor = 0.25;
constexpr double most_factor = 4.0;

/// A normal among those that `v` sees (E. Heitz, "Sampling the GGX distribution of visible
/// normals", JCGT 2018).
Vec3 visible_normal(double width, const Vec3& v, double u1, double u2) {
  Vec3 s(width * v.x, width * v.y, v.z);
  s /= std::sqrt(optics::dot(s, s));
  const double across2 = s.x * s.x + s.y * s.y;
  const Vec3 t1 = across2 > 1e-24 ? Vec3(-s.y, s.x, 0.0) / std::sqrt(across2) : Vec3(1, 0, 0);
  const Vec3 t2 = optics::cross(s, t1);
  const double r = std::sqrt(u1);
  const Turn phi = turn(u2);
  const double p1 = r * phi.cosine;
  const double lift = 0.5 * (1.0 + s.z);
  const double p2 = (1.0 - lift) * std::sqrt(1.0 - p1 * p1) + lift * r * phi.sine;
  const double p3 = std::sqrt(std::max(0.0, 1.0 - p1 * p1 - p2 * p2));
  Vec3 n = p1 * t1 + p2 * t2 + p3 * s;
  n = Vec3(width * n.x, width * n.y, std::max(1e-12, n.z));
  return n / std::sqrt(optics::dot(n, n));
}

}  // namespace

PlanesSurface::PlanesSurface(const brdf::PlanesTable& table, std::size_t wavelength,
                             std::optional<double> total)
    : PlanesSurface(table, Between{wavelength, 0.0}, total) {}

PlanesSurface PlanesSurface::at_wavelength(const brdf::PlanesTable& table, double wavelength_um,
                                           std::optional<double> total) {
  const std::vector<double>& known = table.wavelengths_um();
  const auto above = std::upper_bound(known.begin(), known.end(), wavelength_um);
  if (above == known.begin()) return {table, Between{0, 0.0}, total};
  const auto lower = static_cast<std::size_t>(above - known.begin()) - 1;
  if (above == known.end()) return {table, Between{lower, 0.0}, total};
  return {table, Between{lower, (wavelength_um - known[lower]) / (*above - known[lower])}, total};
}

PlanesSurface::PlanesSurface(const brdf::PlanesTable& table, const Between& wavelength,
                             std::optional<double> total) {
  const std::size_t slices = table.incidences().size();
  for (const brdf::PlanesAtIncidence& slice : table.incidences())
    theta_i_deg_.push_back(slice.theta_i_deg);
  for (int degree = 0; degree <= 90; ++degree) {
    const auto above = std::upper_bound(theta_i_deg_.begin(), theta_i_deg_.end(), degree);
    below_.push_back(static_cast<std::size_t>(above - theta_i_deg_.begin()));
  }
  for (std::size_t k = 0; k <= slopes; ++k) {
    // The last entry stands for an endless slope.
    const double place = std::min(static_cast<double>(k) / slopes, 1.0 - 1e-9);
    const double tangent = half_way * place / (1.0 - place);
    for (std::size_t i = 0; i < slices; ++i) {
      const auto value = [&](double share, bool backward, bool left) {
        const brdf::PlanesTable::Facet facet{tangent, share, backward, left};
        const double low = table.at_facet(wavelength.lower, i, facet);
        if (wavelength.part == 0.0) return static_cast<float>(low);
        const double high = table.at_facet(wavelength.lower + 1, i, facet);
        return static_cast<float>(low + wavelength.part * (high - low));
      };
      values_.push_back({value(1.0, false, false), value(1.0, true, false),
                         value(0.0, false, false), value(0.0, false, true)});
    }
  }
  fit_lobes();
  keep_energy(total);
}

double PlanesSurface::interpolated(const Vec3& from, const Vec3& to, double theta_deg) const {
  // The slope of the facet that mirrors, times the sine of the incidence: along the light's way in
  // the plane of incidence, and across.
  const double scale = 1.0 / (from.z + to.z);
  const double hx = (from.x + to.x) * scale;
  const double hy = (from.y + to.y) * scale;
  double x = -(hx * from.x + hy * from.y);
  double y = hx * from.y - hy * from.x;
  double bent = from.z * y * y;
  if (!(from.x * from.x + from.y * from.y > 1e-24)) {
    x = hx;
    y = hy;
    bent = 0.0;  // x and y are not scaled by a sine here
  }
  const double along = x + bent;
  const double squares = along * along + y * y;
  const double share = squares > 0.0 ? along * along / squares : 1.0;
  const double tangent = std::sqrt(hx * hx + hy * hy);
  const double scaled = slopes * std::min(tangent / (half_way + tangent), 1.0 - 1e-9);
  const auto lower = static_cast<std::size_t>(scaled);
  const double weight = scaled - static_cast<double>(lower);
  const std::size_t slices = theta_i_deg_.size();
  const Values* rows = values_.data() + lower * slices;
  const std::size_t in_plane = along < 0.0 ? 1 : 0;
  const std::size_t across = y < 0.0 ? 3 : 2;
  const auto of_slice = [&](std::size_t slice) {
    const auto at = [&](std::size_t which) {
      const double low = rows[slice][which];
      return low + weight * (static_cast<double>(rows[slices + slice][which]) - low);
    };
    return share * at(in_plane) + (1.0 - share) * at(across);
  };
  std::size_t upper = below_[static_cast<std::size_t>(theta_deg)];
  while (upper < slices && theta_i_deg_[upper] <= theta_deg) ++upper;
  if (upper == 0) return of_slice(0);
  const double at_low = of_slice(upper - 1);
  if (upper == slices) return at_low;
  const double from_deg = theta_i_deg_[upper - 1];
  const double part = (theta_deg - from_deg) / (theta_i_deg_[upper] - from_deg);
  return at_low + part * (of_slice(upper) - at_low);
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
  const Mixture mixture(lobe_at(known.z), known);
  double sum = 0.0;
  for (int i = 0; i < count; ++i) {
    const Vec3 to =
        mixture.draw((i + 0.5) / count, std::fmod(golden * i, 1.0), std::fmod(plastic * i, 1.0));
    if (to.z > 1e-9) sum += interpolated(known, to, theta_i_deg) * to.z / mixture.density(to);
  }
  return sum / count;
}

void PlanesSurface::keep_energy(std::optional<double> total) {
  std::vector<double> rows;
  for (const double theta : theta_i_deg_) rows.push_back(interpolated_reflectance(theta));
  for (int degree = 0; degree < 90; ++degree) {
    const double theta = degree;
    std::size_t upper = 0;
    while (upper < theta_i_deg_.size() && theta_i_deg_[upper] <= theta) ++upper;
    double wanted = rows[std::min(upper, rows.size() - 1)];
    if (upper > 0 && upper < rows.size()) {
      const double from = theta_i_deg_[upper - 1];
      const double weight = (theta - from) / (theta_i_deg_[upper] - from);
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

PlanesSurface::Mixture::Mixture(const Lobe& lobe, const Vec3& known)
    : known_(known),
      share_(lobe.share),
      width_(lobe.width),
      width2_less_1_(lobe.width * lobe.width - 1.0),
      diffuse_((1.0 - lobe.share) / pi) {
  // Holds the share of the facets that the known direction sees, 2z/(z + √(z² + w² (1 - z²))) after
  // Smith, over 4z.
  const double z2 = known.z * known.z;
  const double width2 = lobe.width * lobe.width;
  facets_ = lobe.share * width2 / (2.0 * pi * (known.z + std::sqrt(z2 + width2 * (1.0 - z2))));
}

// Facets after Trowbridge and Reitz: w²/(π (1 + (w² - 1) cos²θh)²), with cos²θh as a fraction.
double PlanesSurface::Mixture::density(const Vec3& drawn) const {
  const double sum = known_.z + drawn.z;
  const double length2 = 2.0 * (1.0 + optics::dot(known_, drawn));
  const double spread = length2 / (length2 + width2_less_1_ * sum * sum);
  return diffuse_ * drawn.z + facets_ * spread * spread;
}

Vec3 PlanesSurface::Mixture::draw(double u1, double u2, double u3) const {
  if (!(u3 < share_)) return cosine_draw(u1, u2);
  const Vec3 half = visible_normal(width_, known_, u1, u2);
  return 2.0 * optics::dot(known_, half) * half - known_;
}

PlanesSurface::Facing::Facing(const PlanesSurface& surface, const Vec3& known, Sense sense)
    : surface_(surface), known_(known), sense_(sense), mixture_(surface.lobe_at(known.z), known) {}

double PlanesSurface::Facing::value(const Vec3& other) const {
  return sense_ == Sense::with_light ? surface_.value(known_, other)
                                     : surface_.value(other, known_);
}

std::optional<Drawn> PlanesSurface::Facing::draw(double u1, double u2, double u3) const {
  const Vec3 to = mixture_.draw(u1, u2, u3);
  if (!(to.z > 1e-9)) return std::nullopt;
  const double density = mixture_.density(to);
  return Drawn{to, value(to) * to.z / density, density};
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
        const Mixture mixture({share, width}, known);
        double spread = 0.0;
        for (const Place& p : places) {
          spread += p.light2 / mixture.density(p.direction) * p.solid_angle;
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
