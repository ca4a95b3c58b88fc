// Spheres on a plane, both Lambertian, traced by the shortest program that does it: no
// polarisation, no Embree, no code of the library but the cells that exits are counted in. An
// independent truth.
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "host/formats/brdf_table.hpp"
#include "host/formats/scan_table.hpp"
#include "host/trace/hemisphere.hpp"

namespace umov::surface {

struct PlainSpheres {
  double period, radius, coverage;
  std::vector<double> ground, sphere;  // albedos by wavelength
  int most_bounces = 1000;

  using V = std::array<double, 3>;
  static V along(const V& a, double t, const V& k) {
    return {a[0] + t * k[0], a[1] + t * k[1], a[2] + t * k[2]};
  }
  static double dot(const V& a, const V& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

  /// Centres at random, apart from each other.
  std::vector<V> strewn(std::mt19937_64& random) const {
    std::uniform_real_distribution<double> place(0.0, period);
    const auto count =
        std::lround(coverage * period * period / (std::numbers::pi * radius * radius));
    std::vector<V> all;
    while (all.size() < static_cast<std::size_t>(count)) {
      const V c{place(random), place(random), radius};
      bool free = true;
      for (const V& other : all) {
        const double dx = std::remainder(c[0] - other[0], period);
        const double dy = std::remainder(c[1] - other[1], period);
        free = free && dx * dx + dy * dy >= 4.0 * radius * radius;
      }
      if (free) all.push_back(c);
    }
    return all;
  }

  /// Distance to the first sphere or the plane, and the normal there; negative: none. A ray that is
  /// all but horizontal would have copies without end: it is followed farther and farther.
  double nearest(const std::vector<V>& spheres, const V& from, const V& k, V& normal,
                 bool& on_sphere) const {
    const double leaves = (k[2] > 0.0 ? 2.0 * radius - from[2] : -from[2]) / k[2];
    for (double reach = 4.0 * period; reach < leaves; reach *= 4.0) {
      const double found = nearest_within(reach, spheres, from, k, normal, on_sphere);
      if (on_sphere && found < reach) return found;
    }
    return nearest_within(leaves, spheres, from, k, normal, on_sphere);
  }

  /// The same of the spheres and all their copies up to the distance `last`, one by one.
  double nearest_within(double last, const std::vector<V>& spheres, const V& from, const V& k,
                        V& normal, bool& on_sphere) const {
    double best = k[2] < 0.0 ? -from[2] / k[2] : -1.0;
    if (best >= 0.0) normal = {0.0, 0.0, 1.0};
    on_sphere = false;
    const auto copies = [&](double centre, double start, double slope, long& low, long& high) {
      const double a = std::min(start, start + last * slope) - radius - centre;
      const double b = std::max(start, start + last * slope) + radius - centre;
      low = static_cast<long>(std::ceil(a / period));
      high = static_cast<long>(std::floor(b / period));
    };
    for (const V& s : spheres) {
      long i0, i1, j0, j1;
      copies(s[0], from[0], k[0], i0, i1);
      copies(s[1], from[1], k[1], j0, j1);
      for (long i = i0; i <= i1; ++i) {
        for (long j = j0; j <= j1; ++j) {
          const V to{s[0] + static_cast<double>(i) * period - from[0],
                     s[1] + static_cast<double>(j) * period - from[1], s[2] - from[2]};
          const double b = dot(to, k);
          const double root2 = b * b - dot(to, to) + radius * radius;
          if (root2 <= 0.0) continue;
          const double t = b - std::sqrt(root2);
          if (t < 1e-7 * radius || (best >= 0.0 && t >= best)) continue;
          best = t;
          on_sphere = true;
          const V p = along({0.0, 0.0, 0.0}, t, k);
          normal = {(p[0] - to[0]) / radius, (p[1] - to[1]) / radius, (p[2] - to[2]) / radius};
        }
      }
    }
    return best;
  }

  /// What an instrument would measure of `batches` samples, each strewn anew, with its errors.
  formats::BrdfTable measured(const trace::Hemisphere& cells, double theta_i_deg,
                              const std::vector<double>& wavelength_nm, int batches, int launches,
                              std::uint64_t seed) const {
    const std::size_t bands = wavelength_nm.size();
    std::vector<double> sum(cells.cells() * bands), squares(sum.size()), batch(sum.size());
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    const double theta = theta_i_deg * std::numbers::pi / 180.0;
    std::vector<double> weight(bands);
    for (int n = 0; n < batches; ++n) {
      const std::vector<V> spheres = strewn(random);
      std::fill(batch.begin(), batch.end(), 0.0);
      for (int launch = 0; launch < launches; ++launch) {
        V at{period * uniform(random), period * uniform(random), 2.0 * radius};
        V k{std::sin(theta), 0.0, -std::cos(theta)};
        std::fill(weight.begin(), weight.end(), 1.0 / launches);
        for (int bounce = 0;; ++bounce) {
          V normal{};
          bool on_sphere = false;
          const double t = nearest(spheres, at, k, normal, on_sphere);
          if (t < 0.0) {
            if (bounce > most_bounces) break;
            const std::size_t cell = cells.find(trace::Vec3(k[0], k[1], k[2]));
            for (std::size_t w = 0; w < bands; ++w) {
              batch[cell * bands + w] += weight[w] / cells.cell(cell).projected;
            }
            break;
          }
          at = along(at, t, k);
          for (std::size_t w = 0; w < bands; ++w) weight[w] *= (on_sphere ? sphere : ground)[w];
          // A point on the unit sphere about the end of the normal: the cosine law.
          const double z = 2.0 * uniform(random) - 1.0;
          const double phi = 2.0 * std::numbers::pi * uniform(random);
          const double r = std::sqrt(1.0 - z * z);
          k = {normal[0] + r * std::cos(phi), normal[1] + r * std::sin(phi), normal[2] + z};
          const double length = std::sqrt(dot(k, k));
          for (double& x : k) x /= length;
        }
      }
      for (std::size_t i = 0; i < sum.size(); ++i) {
        sum[i] += batch[i];
        squares[i] += batch[i] * batch[i];
      }
    }
    formats::BrdfTable table;
    auto& p = table.points;
    const double count = batches;
    for (std::size_t i = 0; i < sum.size(); ++i) {
      const trace::Cell cell = cells.cell(i / bands);
      const double mean = sum[i] / count;
      const double error = std::sqrt((squares[i] / count - mean * mean) / (count - 1.0));
      if (!(error > 0.0)) continue;
      constexpr double degree = 180.0 / std::numbers::pi;
      p.theta_i_deg.push_back(theta_i_deg);
      p.theta_r_deg.push_back(0.5 * degree * (cell.theta_low + cell.theta_high));
      p.phi_r_deg.push_back(std::remainder(0.5 * degree * (cell.phi_low + cell.phi_high), 360.0));
      p.wavelength_nm.push_back(wavelength_nm[i % bands]);
      p.polarizer_deg.push_back(formats::open_axis);
      p.analyzer_deg.push_back(formats::open_axis);
      p.brdf_per_sr.push_back(mean);
      p.brdf_u.push_back(error);
      p.used.push_back(1);
    }
    return table;
  }
};

}  // namespace umov::surface
