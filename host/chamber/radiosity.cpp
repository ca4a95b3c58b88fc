#include "host/chamber/radiosity.hpp"

#include <algorithm>
#include <cmath>

#include "host/optics/angles.hpp"

namespace umov::chamber {
namespace {

using optics::pi;

struct Node {
  double place, weight;  ///< height or radius; share of the zone's length
};

/// Gauss-Legendre on [0, 1] by Newton's method.
std::vector<Node> gauss(std::size_t count) {
  std::vector<Node> nodes;
  const double n = static_cast<double>(count);
  for (std::size_t i = 0; i < count; ++i) {
    double x = std::cos(pi * (static_cast<double>(i) + 0.75) / (n + 0.5));
    double slope = 1.0;
    for (int turn = 0; turn < 50; ++turn) {
      double p0 = 1.0;
      double p1 = x;
      for (std::size_t k = 2; k <= count; ++k) {
        const double kk = static_cast<double>(k);
        const double p2 = ((2.0 * kk - 1.0) * x * p1 - (kk - 1.0) * p0) / kk;
        p0 = p1;
        p1 = p2;
      }
      if (count == 1) p0 = 1.0;
      slope = n * (x * p1 - p0) / (x * x - 1.0);
      const double step = p1 / slope;
      x -= step;
      if (std::abs(step) < 1e-15) break;
    }
    nodes.push_back({0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope)});
  }
  return nodes;
}

/// A ring of equal patches.
struct Ring {
  bool wall;
  double radius, z;
  double area;      ///< of one patch
  double from, to;  ///< heights or radii that it reaches between
  std::size_t zone;
};

struct Point {
  double x, y, z, nx, ny, nz;
};

Point point_on(const Ring& ring, double phi) {
  const double c = std::cos(phi);
  const double s = std::sin(phi);
  if (ring.wall) return {ring.radius * c, ring.radius * s, ring.z, -c, -s, 0.0};
  return {ring.radius * c, ring.radius * s, 0.0, 0.0, 0.0, 1.0};
}

/// cos cos/(π d²).
double exchange(const Point& a, const Point& b) {
  const double x = b.x - a.x;
  const double y = b.y - a.y;
  const double z = b.z - a.z;
  const double d2 = x * x + y * y + z * z;
  const double here = x * a.nx + y * a.ny + z * a.nz;
  const double there = -(x * b.nx + y * b.ny + z * b.nz);
  if (!(here > 0.0) || !(there > 0.0)) return 0.0;
  return here * there / (pi * d2 * d2);
}

/// What a point sees of a patch at azimuth `phi`; near patches are cut into pieces.
double view_of(const Point& here, const Ring& ring, double phi, double turn) {
  const Point middle = point_on(ring, phi);
  const double x = middle.x - here.x;
  const double y = middle.y - here.y;
  const double z = middle.z - here.z;
  const double away = std::sqrt(x * x + y * y + z * z);
  const double size = std::max(ring.radius * turn, ring.to - ring.from);
  const int pieces = away * 24.0 > 3.0 * size ? static_cast<int>(std::ceil(3.0 * size / away)) : 24;
  double sum = 0.0;
  double whole = 0.0;
  Ring piece = ring;
  for (int i = 0; i < pieces; ++i) {
    const double place = ring.from + (ring.to - ring.from) * (i + 0.5) / pieces;
    (ring.wall ? piece.z : piece.radius) = pieces == 1 ? (ring.wall ? ring.z : ring.radius) : place;
    const double weight = ring.wall ? 1.0 : piece.radius;
    for (int k = 0; k < pieces; ++k) {
      const double at = phi + turn * ((k + 0.5) / pieces - 0.5);
      const Point there = point_on(piece, at);
      whole += weight;
      const double dx = there.x - here.x;
      const double dy = there.y - here.y;
      const double dz = there.z - here.z;
      if (dx * dx + dy * dy + dz * dz < 1e-12 * ring.radius * ring.radius) continue;
      sum += weight * exchange(here, there);
    }
  }
  return sum / whole * ring.area;
}

/// What an element of a cylinder's wall sees of the disc that closes it, `away` along the axis.
double wall_to_disc(double radius, double away) {
  const double z = away / (2.0 * radius);
  return (z * z + 0.5) / std::sqrt(z * z + 1.0) - z;
}

/// What an element at `offset` from the axis sees of a parallel disc opposite.
double element_to_disc(double offset, double radius, double away) {
  const double a2 = offset * offset;
  const double h2 = away * away;
  const double r2 = radius * radius;
  const double sum = a2 + h2 + r2;
  return 0.5 * (1.0 - (a2 + h2 - r2) / std::sqrt(sum * sum - 4.0 * a2 * r2));
}

/// Irradiance per lm of a disc below its hole.
double direct(const DiffuseChamber::Hole& hole, const Point& at) {
  constexpr int radii = 12;
  constexpr int turns = 24;
  double sum = 0.0;
  for (int i = 0; i < radii; ++i) {
    for (int k = 0; k < turns; ++k) {
      const double r = hole.radius_mm * std::sqrt((i + 0.5) / radii);
      const double phi = 2.0 * pi * (k + 0.5 * (i % 2)) / turns;
      const Point from{hole.x_mm + r * std::cos(phi),
                       hole.y_mm + r * std::sin(phi),
                       -hole.depth_mm,
                       0.0,
                       0.0,
                       1.0};
      if (hole.depth_mm > 0.0) {
        const double t = hole.depth_mm / (at.z + hole.depth_mm);
        const double x = from.x + t * (at.x - from.x) - hole.x_mm;
        const double y = from.y + t * (at.y - from.y) - hole.y_mm;
        if (x * x + y * y > hole.radius_mm * hole.radius_mm) continue;
      }
      sum += exchange(at, from);
    }
  }
  return sum / (radii * turns);
}

}  // namespace

Radiosity solve_radiosity(const DiffuseChamber& chamber, const Zones& zones) {
  const std::size_t around = zones.around;
  const double turn = 2.0 * pi / static_cast<double>(around);
  std::vector<Ring> rings;
  const std::vector<Node> nodes = gauss(zones.nodes);
  const auto lay = [&](const std::vector<double>& edges, bool wall) {
    for (std::size_t zone = 0; zone + 1 < edges.size(); ++zone) {
      const double length = edges[zone + 1] - edges[zone];
      double from = edges[zone];
      for (const Node& node : nodes) {
        const double place = edges[zone] + length * node.place;
        const double radius = wall ? chamber.radius_mm : place;
        const double to = from + length * node.weight;
        rings.push_back({wall, radius, wall ? place : 0.0, radius * turn * length * node.weight,
                         from, to, zone});
        from = to;
      }
    }
  };
  lay(zones.wall_mm, true);
  lay(zones.base_mm, false);
  const std::size_t count = rings.size();

  // Share of each patch of the base that no hole takes: squares of 9 × 9 points about its middle.
  std::vector<double> solid(count * around, 1.0);
  std::vector<double> irradiance(count * around, 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t a = 0; a < around; ++a) {
      const double phi = turn * static_cast<double>(a);
      if (rings[i].wall) {
        for (const auto& hole : chamber.holes) {
          irradiance[i * around + a] += hole.flux_lm * direct(hole, point_on(rings[i], phi));
        }
        continue;
      }
      int free = 0;
      for (int k = 0; k < 81; ++k) {
        const double r = rings[i].from + (rings[i].to - rings[i].from) * ((k % 9) + 0.5) / 9.0;
        const double at = phi + turn * ((k / 9) - 4) / 9.0;
        bool open = true;
        for (const auto& hole : chamber.holes) {
          const double x = r * std::cos(at) - hole.x_mm;
          const double y = r * std::sin(at) - hole.y_mm;
          open = open && x * x + y * y > hole.radius_mm * hole.radius_mm;
        }
        free += open ? 1 : 0;
      }
      solid[i * around + a] = free / 81.0;
    }
  }

  // What a patch of ring i sees of ring j's patch `a` steps on; scaled by closed forms for wall and
  // base apart.
  std::vector<double> sees(count * count * around);
  std::vector<double> opening(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Ring& ring = rings[i];
    const Point here = point_on(ring, 0.0);
    const double up = chamber.height_mm - ring.z;
    opening[i] = ring.wall ? wall_to_disc(chamber.radius_mm, up)
                           : element_to_disc(ring.radius, chamber.radius_mm, chamber.height_mm);
    const double to_base = ring.wall ? wall_to_disc(chamber.radius_mm, ring.z) : 0.0;
    const double to_wall = 1.0 - opening[i] - to_base;
    double wall = 0.0;
    double base = 0.0;
    for (std::size_t j = 0; j < count; ++j) {
      for (std::size_t a = 0; a < around; ++a) {
        const double f = view_of(here, rings[j], turn * static_cast<double>(a), turn);
        sees[(i * count + j) * around + a] = f;
        (rings[j].wall ? wall : base) += f;
      }
    }
    for (std::size_t j = 0; j < count; ++j) {
      const double scale = rings[j].wall ? to_wall / wall : (base > 0.0 ? to_base / base : 0.0);
      for (std::size_t a = 0; a < around; ++a) sees[(i * count + j) * around + a] *= scale;
    }
  }

  const std::vector<double> first = irradiance;
  std::vector<double> exitance(count * around);
  for (int round = 0; round < 2000; ++round) {
    for (std::size_t i = 0; i < count; ++i) {
      const double rho = rings[i].wall ? chamber.wall_rho : chamber.base_rho;
      for (std::size_t a = 0; a < around; ++a) {
        exitance[i * around + a] = rho * solid[i * around + a] * irradiance[i * around + a];
      }
    }
    double change = 0.0;
    double largest = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t a = 0; a < around; ++a) {
        double sum = first[i * around + a];
        for (std::size_t j = 0; j < count; ++j) {
          const double* f = &sees[(i * count + j) * around];
          const double* m = &exitance[j * around];
          double part = 0.0;
          for (std::size_t k = 0; k < around - a; ++k) part += f[k] * m[a + k];
          for (std::size_t k = around - a; k < around; ++k) part += f[k] * m[a + k - around];
          sum += part;
        }
        double& value = irradiance[i * around + a];
        change = std::max(change, std::abs(sum - value));
        largest = std::max(largest, sum);
        value = sum;
      }
    }
    if (change <= 1e-10 * largest) break;
  }

  Radiosity result;
  result.wall_lx.assign(zones.wall_mm.size() - 1, 0.0);
  result.base_lx.assign(zones.base_mm.size() - 1, 0.0);
  std::vector<double> wall_area(result.wall_lx.size(), 0.0);
  std::vector<double> base_area(result.base_lx.size(), 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    const double rho = rings[i].wall ? chamber.wall_rho : chamber.base_rho;
    for (std::size_t a = 0; a < around; ++a) {
      const std::size_t patch = i * around + a;
      const double area = rings[i].area * solid[patch];
      const double lm = irradiance[patch] * area;
      (rings[i].wall ? result.wall_lx : result.base_lx)[rings[i].zone] += lm;
      (rings[i].wall ? wall_area : base_area)[rings[i].zone] += area;
      result.out_lm += rho * lm * opening[i];
      result.first_hit_lm += first[patch] * area;
      result.into_holes_lm += irradiance[patch] * (rings[i].area - area);
    }
  }
  constexpr double mm2_per_m2 = 1e6;
  for (std::size_t z = 0; z < wall_area.size(); ++z) result.wall_lx[z] *= mm2_per_m2 / wall_area[z];
  for (std::size_t z = 0; z < base_area.size(); ++z) result.base_lx[z] *= mm2_per_m2 / base_area[z];
  // Straight out of the holes: what leaves each less what the wall gets of it.
  for (const auto& hole : chamber.holes) {
    const double through =
        hole.depth_mm > 0.0 ? [&] {
          // Disc to disc of equal radii.
          const double x = hole.depth_mm / hole.radius_mm;
          const double s = 2.0 + x * x;
          return 0.5 * (s - std::sqrt(s * s - 4.0));
        }()
                            : 1.0;
    result.out_lm += hole.flux_lm * through;
  }
  result.out_lm -= result.first_hit_lm;
  return result;
}

}  // namespace umov::chamber
