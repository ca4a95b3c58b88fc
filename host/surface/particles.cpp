#include "host/surface/particles.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"
#include "host/surface/coverage.hpp"
#include "host/surface/disc_lattice.hpp"
#include "host/trace/random_stream.hpp"

namespace umov::surface {
namespace {

constexpr double most_coverage = 0.95;
// Places tried for one disc.
constexpr std::uint64_t most_tries = 200'000;
// Discs that cover more find their places together, not one after the other.
constexpr double crowded = 0.5;
// Poisson disks, blown up so that they cover this much, do not overlap.
constexpr double spaced = 0.7;
constexpr int most_pushes = 6000;
// No discs of like sizes have been seen to find places at random beyond this.
constexpr double packed = 0.84;
// Of the radius: two that overlap by less touch.
constexpr double touching = 1e-6;
// Candidates for the place of an overlapping Poisson disk.
constexpr int candidates = 12;
// Steps in whose time a map of what is covered is made.
constexpr std::uint64_t a_coverage = 40'000;

// Streams of random numbers beside that of the sizes.
enum Stream : std::uint32_t { sizes = 1, places = 2, centres = 3 };

double area_of(const Disc& disc) {
  return optics::pi * disc.radius * disc.radius;
}

double draw_radius(const Sizes& wanted, std::uint64_t seed, std::uint64_t number) {
  const auto u = trace::uniforms(seed, number, Stream::sizes);
  const double normal =
      std::clamp(std::sqrt(-2.0 * std::log(u[0])) * std::cos(2.0 * optics::pi * u[1]), -2.0, 2.0);
  return 0.5 * wanted.median * std::pow(wanted.spread, normal);
}

// Radii whose discs together have the area, the last one only if that comes nearer to it; large
// ones first.
std::vector<double> draw_radii(const Sizes& wanted, double area, std::uint64_t seed) {
  std::vector<double> radii;
  double sum = 0.0;
  for (std::uint64_t i = 0;; ++i) {
    const double radius = draw_radius(wanted, seed, i);
    const double disc = optics::pi * radius * radius;
    if (sum + 0.5 * disc > area) break;
    sum += disc;
    radii.push_back(radius);
  }
  std::sort(radii.begin(), radii.end(), std::greater<>());
  return radii;
}

// One layer on its way to the ground.
class Layer {
 public:
  Layer(std::vector<Disc>& placed, const Laying& laying, double size, std::uint64_t seed)
      : placed_(placed),
        laying_(laying),
        size_(size),
        seed_(seed),
        first_(placed.size()),
        widest_(laying.sizes.median * laying.sizes.spread * laying.sizes.spread) {
    for (const Disc& disc : placed) before_ += area_of(disc) / (size * size);
  }

  std::uint64_t steps() const { return steps_; }

  void lay() {
    if (laying_.layout == Layout::grid) return on_grid();
    if (laying_.overlap) return overlapping();
    const std::vector<double> radii =
        draw_radii(laying_.sizes, laying_.coverage * size_ * size_, seed_);
    if (radii.empty()) too_few();
    if (laying_.coverage + before_ > packed) no_room();
    if (laying_.layout == Layout::cluster) return one_by_one(radii);
    if (laying_.layout == Layout::poisson_disk) {
      const double inflation = std::max(1.0, std::sqrt(spaced / (laying_.coverage + before_)));
      return together(radii, inflation);
    }
    if (laying_.coverage + before_ > crowded) return together(radii, 1.0);
    one_by_one(radii);
  }

 private:
  [[noreturn]] void no_room() const {
    double covered = 0.0;
    for (std::size_t i = first_; i < placed_.size(); ++i) covered += area_of(placed_[i]);
    throw Error(fmt::format("particles that are to cover {} find no more room at {:.3f}, beside "
                            "{:.3f} of others",
                            laying_.coverage, covered / (size_ * size_), before_),
                "let them overlap (overlap = true), or let them cover less: equal ones without "
                "overlap cover about .8 at random, .5 in clusters, .78 on a grid");
  }
  [[noreturn]] void too_few() const {
    throw Error(fmt::format("a coverage of {} is less than half a particle", laying_.coverage),
                "make the period longer");
  }

  double wrapped(double x) const {
    x -= size_ * std::floor(x / size_);
    return x < size_ ? x : 0.0;
  }
  double distance2(const Disc& a, const Disc& b) const {
    const double dx = std::remainder(a.x - b.x, size_);
    const double dy = std::remainder(a.y - b.y, size_);
    return dx * dx + dy * dy;
  }

  // A place at random, or about a centre at random.
  Disc draw_place(std::uint64_t trial, double radius) {
    const auto u = trace::uniforms(seed_, trial, Stream::places);
    if (laying_.layout != Layout::cluster) return {u[0] * size_, u[1] * size_, radius};
    if (cluster_count_ == 0) {
      const double disc = optics::pi * 0.25 * laying_.sizes.median * laying_.sizes.median;
      const double total = laying_.overlap ? -std::log(1.0 - laying_.coverage) : laying_.coverage;
      const double particles = total * size_ * size_ / disc;
      cluster_count_ = std::max<std::uint64_t>(
          1, static_cast<std::uint64_t>(std::lround(particles / laying_.cluster_size)));
      cluster_radius_ = laying_.cluster_radius > 0.0
                            ? laying_.cluster_radius
                            : 0.5 * laying_.sizes.median * std::sqrt(laying_.cluster_size);
    }
    const auto which = static_cast<std::uint64_t>(u[0] * static_cast<double>(cluster_count_));
    const auto centre = trace::uniforms(seed_, which, Stream::centres);
    const double reach = cluster_radius_ * std::sqrt(-2.0 * std::log(u[1]));
    return {wrapped(centre[0] * size_ + reach * std::cos(2.0 * optics::pi * u[2])),
            wrapped(centre[1] * size_ + reach * std::sin(2.0 * optics::pi * u[2])), radius};
  }

  DiscLattice lattice_of_placed(double largest) const {
    for (const Disc& disc : placed_) largest = std::max(largest, disc.radius);
    DiscLattice lattice(size_, largest);
    for (std::size_t i = 0; i < placed_.size(); ++i) lattice.add(i, placed_[i].x, placed_[i].y);
    return lattice;
  }

  // Large ones first, each at the first free place.
  void one_by_one(const std::vector<double>& radii) {
    DiscLattice lattice = lattice_of_placed(radii.front());
    std::uint64_t trial = 0;
    for (const double radius : radii) {
      for (std::uint64_t tries = 0;; ++tries) {
        if (tries == most_tries) no_room();
        ++steps_;
        const Disc disc = draw_place(trial++, radius);
        const bool free = lattice.each_near(disc.x, disc.y, disc.radius, [&](std::size_t n) {
          const double apart = disc.radius + placed_[n].radius;
          return distance2(disc, placed_[n]) >= apart * apart;
        });
        if (!free) continue;
        lattice.add(placed_.size(), disc.x, disc.y);
        placed_.push_back(disc);
        break;
      }
    }
  }

  // All at random, then those that overlap push each other apart. `inflation` of the radii keeps
  // those of this layer apart by more than touching.
  void together(const std::vector<double>& radii, double inflation) {
    const std::vector<Disc> earlier = placed_;
    for (std::size_t i = 0; i < radii.size(); ++i) {
      const auto u = trace::uniforms(seed_, i, Stream::places);
      placed_.push_back({u[0] * size_, u[1] * size_, radii[i]});
    }
    const auto reach = [&](std::size_t n) {
      return placed_[n].radius * (n >= first_ ? inflation : 1.0);
    };
    // They are pushed to where they are clear of each other by a little: exactly touching is
    // approached without end.
    const double slack =
        std::clamp(std::sqrt(packed / (laying_.coverage + before_)) - 1.0, 1e-10, 0.01);
    double largest = 0.0;
    for (std::size_t n = 0; n < placed_.size(); ++n) largest = std::max(largest, reach(n));
    largest *= 1.0 + slack;
    DiscLattice lattice(size_, largest);
    std::vector<double> move_x(placed_.size()), move_y(placed_.size());
    for (int push = 0; push < most_pushes; ++push) {
      steps_ += placed_.size();
      lattice.clear();
      for (std::size_t n = 0; n < placed_.size(); ++n) lattice.add(n, placed_[n].x, placed_[n].y);
      std::fill(move_x.begin(), move_x.end(), 0.0);
      std::fill(move_y.begin(), move_y.end(), 0.0);
      double worst = 0.0;
      for (std::size_t n = 0; n < placed_.size(); ++n) {
        lattice.each_near(
            placed_[n].x, placed_[n].y, reach(n) * (1.0 + slack), [&](std::size_t other) {
              if (other == n || (placed_[n].may_overlap && placed_[other].may_overlap)) return true;
              const double apart = reach(n) + reach(other);
              const double clear = apart * (1.0 + slack);
              const double d2 = distance2(placed_[n], placed_[other]);
              if (d2 >= clear * clear) return true;
              const double d = std::max(std::sqrt(d2), 1e-9 * apart);
              worst = std::max(worst, (apart - d) / apart);
              // Half of what is missing each.
              const double part = 0.5 * (clear - d);
              move_x[n] += part * std::remainder(placed_[n].x - placed_[other].x, size_) / d;
              move_y[n] += part * std::remainder(placed_[n].y - placed_[other].y, size_) / d;
              return true;
            });
      }
      if (worst <= touching) return;
      for (std::size_t n = 0; n < placed_.size(); ++n) {
        placed_[n].x = wrapped(placed_[n].x + move_x[n]);
        placed_[n].y = wrapped(placed_[n].y + move_y[n]);
      }
    }
    placed_ = earlier;
    no_room();
  }

  void on_grid() {
    const double disc = optics::pi * 0.25 * laying_.sizes.median * laying_.sizes.median;
    auto side =
        static_cast<std::size_t>(std::lround(std::sqrt(laying_.coverage * size_ * size_ / disc)));
    if (side == 0) too_few();
    for (;; ++side) {
      placed_.resize(first_);
      Coverage covered(size_);
      steps_ += a_coverage + side * side;
      const double step = size_ / static_cast<double>(side);
      for (std::size_t i = 0; i < side * side; ++i) {
        const Disc next{(static_cast<double>(i % side) + 0.5) * step,
                        (static_cast<double>(i / side) + 0.5) * step,
                        draw_radius(laying_.sizes, seed_, i)};
        placed_.push_back(next);
        covered.add(next);
      }
      if (!laying_.overlap || covered.share() >= laying_.coverage) break;
    }
    if (laying_.overlap) {
      for (std::size_t n = first_; n < placed_.size(); ++n) placed_[n].may_overlap = true;
      return;
    }
    const DiscLattice lattice = lattice_of_placed(widest_);
    for (std::size_t n = first_; n < placed_.size(); ++n) {
      const bool free =
          lattice.each_near(placed_[n].x, placed_[n].y, placed_[n].radius, [&](std::size_t other) {
            const double apart = (placed_[n].radius + placed_[other].radius) * (1.0 - touching);
            return other == n || distance2(placed_[n], placed_[other]) >= apart * apart;
          });
      if (!free) {
        placed_.resize(first_);
        no_room();
      }
    }
  }

  // One after the other until they cover enough together.
  void overlapping() {
    Coverage covered(size_);
    steps_ += a_coverage;
    DiscLattice lattice(size_, 0.5 * widest_);
    std::uint64_t trial = 0;
    const double last = 0.5 * area_of({0.0, 0.0, 0.5 * laying_.sizes.median}) / (size_ * size_);
    for (std::uint64_t i = 0; covered.share() + last * (1.0 - covered.share()) < laying_.coverage;
         ++i) {
      const double radius = draw_radius(laying_.sizes, seed_, i);
      Disc best = draw_place(trial++, radius);
      if (laying_.layout == Layout::poisson_disk) {
        // The candidate farthest from its neighbours (Mitchell 1991).
        double farthest = -1.0;
        for (int c = 0; c < candidates; ++c) {
          const Disc candidate = draw_place(trial++, radius);
          double nearest = std::numeric_limits<double>::infinity();
          lattice.each_near(candidate.x, candidate.y, 2.0 * widest_, [&](std::size_t n) {
            nearest = std::min(nearest, distance2(candidate, placed_[n]));
            return true;
          });
          if (nearest > farthest) {
            farthest = nearest;
            best = candidate;
          }
        }
      }
      steps_ += laying_.layout == Layout::poisson_disk ? candidates : 1;
      best.may_overlap = true;
      lattice.add(placed_.size(), best.x, best.y);
      placed_.push_back(best);
      covered.add(best);
    }
    if (placed_.size() == first_) too_few();
  }

  std::vector<Disc>& placed_;
  const Laying& laying_;
  const double size_;
  const std::uint64_t seed_;
  const std::size_t first_;
  const double widest_;
  double before_ = 0.0;
  std::uint64_t steps_ = 0;
  std::uint64_t cluster_count_ = 0;
  double cluster_radius_ = 0.0;
};

}  // namespace

std::uint64_t lay(std::vector<Disc>& placed, const Laying& laying, double size,
                  std::uint64_t seed) {
  const Sizes& sizes = laying.sizes;
  if (!(laying.coverage > 0.0 && laying.coverage <= most_coverage)) {
    throw Error(fmt::format("a coverage of {}", laying.coverage),
                fmt::format("choose above 0 and up to {}", most_coverage));
  }
  if (!(sizes.median > 0.0) || !(sizes.spread >= 1.0)) {
    throw Error(
        fmt::format("particles of median diameter {} and spread {}", sizes.median, sizes.spread),
        "the diameter must be above 0, the spread at least 1");
  }
  if (!(laying.cluster_size >= 1.0) || !(laying.cluster_radius >= 0.0)) {
    throw Error(fmt::format("clusters of {} particles, {} wide", laying.cluster_size,
                            laying.cluster_radius),
                "the size must be at least 1, the radius at least 0");
  }
  const double widest = sizes.median * sizes.spread * sizes.spread;
  if (2.0 * widest > size) {
    throw Error(fmt::format("particles up to {} wide in a period of {}", widest, size),
                "make the period at least twice as long");
  }
  Layer layer(placed, laying, size, seed);
  layer.lay();
  return layer.steps();
}

}  // namespace umov::surface
