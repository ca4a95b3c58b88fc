#include "host/surface/particles.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"
#include "host/trace/random_stream.hpp"

namespace umov::surface {
namespace {

constexpr std::uint64_t most_tries = 2'000'000;

// Finds the discs near a place, over the edges too.
class Lattice {
 public:
  Lattice(double size, double largest)
      : size_(size),
        largest_(largest),
        side_(std::clamp<long>(static_cast<long>(size / (2.0 * largest)), 1, 4096)),
        cells_(static_cast<std::size_t>(side_ * side_)) {}

  void add(const Disc& disc) { cell(place(disc.x), place(disc.y)).push_back(disc); }

  bool is_free(const Disc& disc) const {
    const long reach =
        static_cast<long>(std::ceil((disc.radius + largest_) / size_ * static_cast<double>(side_)));
    const long span = std::min(reach, (side_ - 1) / 2 + 1);
    for (long i = -span; i <= span; ++i) {
      for (long j = -span; j <= span; ++j) {
        for (const Disc& other : cell(place(disc.x) + i, place(disc.y) + j)) {
          const double dx = std::remainder(disc.x - other.x, size_);
          const double dy = std::remainder(disc.y - other.y, size_);
          const double apart = disc.radius + other.radius;
          if (dx * dx + dy * dy < apart * apart) return false;
        }
      }
    }
    return true;
  }

 private:
  long place(double x) const { return static_cast<long>(x / size_ * static_cast<double>(side_)); }
  std::size_t index(long i, long j) const {
    const auto wrapped = [&](long k) { return ((k % side_) + side_) % side_; };
    return static_cast<std::size_t>(wrapped(j) * side_ + wrapped(i));
  }
  std::vector<Disc>& cell(long i, long j) { return cells_[index(i, j)]; }
  const std::vector<Disc>& cell(long i, long j) const { return cells_[index(i, j)]; }

  double size_, largest_;
  long side_;
  std::vector<std::vector<Disc>> cells_;
};

// Radii whose discs together cover the area, the last one only if that comes nearer to it.
std::vector<double> draw_radii(const Sizes& sizes, double area, std::uint64_t seed) {
  std::vector<double> radii;
  double covered = 0.0;
  for (std::uint64_t i = 0;; ++i) {
    const auto u = trace::uniforms(seed, i, 1);
    const double normal =
        std::clamp(std::sqrt(-2.0 * std::log(u[0])) * std::cos(2.0 * optics::pi * u[1]), -2.0, 2.0);
    const double radius = 0.5 * sizes.median * std::pow(sizes.spread, normal);
    const double disc = optics::pi * radius * radius;
    if (covered + 0.5 * disc > area) break;
    covered += disc;
    radii.push_back(radius);
  }
  std::sort(radii.begin(), radii.end(), std::greater<>());
  return radii;
}

}  // namespace

void scatter(std::vector<Disc>& placed, const Sizes& sizes, double coverage, double size,
             std::uint64_t seed) {
  if (!(coverage > 0.0 && coverage < 1.0)) {
    throw Error(fmt::format("a coverage of {}", coverage), "choose above 0 and below 1");
  }
  if (!(sizes.median > 0.0) || !(sizes.spread >= 1.0)) {
    throw Error(
        fmt::format("particles of median diameter {} and spread {}", sizes.median, sizes.spread),
        "the diameter must be above 0, the spread at least 1");
  }
  const double widest = sizes.median * sizes.spread * sizes.spread;
  if (4.0 * widest / 2.0 > size) {
    throw Error(fmt::format("particles up to {} wide in a period of {}", widest, size),
                "make the period at least twice as long");
  }
  const std::vector<double> radii = draw_radii(sizes, coverage * size * size, seed);
  if (radii.empty()) {
    throw Error(fmt::format("a coverage of {} is less than half a particle", coverage),
                "make the period longer");
  }
  double largest = radii.front();
  for (const Disc& disc : placed) largest = std::max(largest, disc.radius);
  Lattice lattice(size, largest);
  double before = 0.0;
  for (const Disc& disc : placed) {
    lattice.add(disc);
    before += optics::pi * disc.radius * disc.radius;
  }
  double covered = 0.0;
  std::uint64_t trial = 0;
  for (const double radius : radii) {
    for (std::uint64_t tries = 0;; ++tries, ++trial) {
      if (tries == most_tries) {
        throw Error(
            fmt::format("particles that are to cover {} find no more room at {:.3f}, beside "
                        "{:.3f} of others",
                        coverage, covered / (size * size), before / (size * size)),
            "at random without overlap, equal ones cover at most about half of the ground");
      }
      const auto u = trace::uniforms(seed, trial, 2);
      const Disc disc{u[0] * size, u[1] * size, radius};
      if (!lattice.is_free(disc)) continue;
      lattice.add(disc);
      placed.push_back(disc);
      covered += optics::pi * radius * radius;
      ++trial;
      break;
    }
  }
}

}  // namespace umov::surface
