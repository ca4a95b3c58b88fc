// Paths through a luminaire, in luminance: from the eye to the sources, or from the sources out.
//
// Faces are found by the project's one ray engine (host/trace/geometry.hpp); a path carries one
// number. Random numbers come from seed, path and meeting alone, so that no order of work can
// change a result.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "host/chamber/luminaire.hpp"

namespace umov::chamber {

/// How paths from the eye find the light.
enum class Estimator {
  unidirectional,  ///< only where a path happens to meet a source
  next_event,      ///< at every bounce a point of a source; sources met by a diffuse bounce count 0
  mis              ///< both, weighted by the squares of their densities (Veach 1997)
};

/// Counts of one thread.
struct Work {
  std::uint64_t rays = 0;     ///< searches for the nearest face
  std::uint64_t endless = 0;  ///< paths given up after 10⁵ bounces
};

/// What became of light that was launched by the sources, in lumen.
struct Fate {
  double launched = 0, out = 0, absorbed = 0, behind = 0, lost = 0;
  double first_hit = 0;          ///< met a face that is not black before anything else
  std::vector<double> incident;  ///< by material number: arrived at its front, all bounces
  std::vector<double> taken;     ///< by material number: absorbed there
  Work work;
};

/// May be shared by threads.
class Tracer {
 public:
  explicit Tracer(const Luminaire& luminaire);

  /// One estimate of the luminance in cd/m² that is seen from `origin` along `direction`.
  double luminance(const Vec3& origin, const Vec3& direction, Estimator estimator,
                   std::uint64_t seed, std::uint64_t path, Work& work) const;

  /// Light that leaves the luminaire for good.
  struct Exit {
    Vec3 direction;
    double flux_lm;
  };
  /// Part of [0, 1), the sources one after the other by their share of the flux.
  struct Stratum {
    double from = 0.0, width = 1.0;
  };
  /// Launches `flux_lm` from the sources, in proportion to their flux, out of a stratum.
  std::optional<Exit> launch(double flux_lm, const Stratum& stratum, std::uint64_t seed,
                             std::uint64_t path, Fate& fate) const;

  const Luminaire& luminaire() const { return luminaire_; }
  const trace::Geometry& geometry() const { return geometry_; }
  trace::Geometry& geometry() { return geometry_; }
  Fate empty_fate() const;

 private:
  struct Place;
  double next_event(const Place& place, Estimator estimator, const std::array<double, 4>& u,
                    Work& work) const;
  std::optional<trace::Hit> nearest(const Vec3& origin, const Vec3& direction, double limit) const;
  double choice_of(const Vec3& position, const Vec3& normal, std::size_t emitter) const;
  std::size_t emitter_at(double share) const;

  const Luminaire& luminaire_;
  trace::Geometry geometry_;
  std::vector<double> flux_up_to_;  ///< by emitter, as a share of all
  std::vector<double> area_mm2_;    ///< by emitter
};

}  // namespace umov::chamber
