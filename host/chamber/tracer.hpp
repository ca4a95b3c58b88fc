// Paths through a luminaire, in luminance: from the eye to the sources, or from the sources out.
//
// Faces are found by the project's one ray engine (host/trace/geometry.hpp); a path carries one
// number, or one a band. Random numbers come from seed, path and meeting alone, so that no order of
// work can change a result.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "host/chamber/luminaire.hpp"
#include "host/chamber/source_choice.hpp"

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
  double first_hit = 0;              ///< met a face that is not black before anything else
  std::vector<double> incident;      ///< by material number: arrived at its front, all bounces
  std::vector<double> taken;         ///< by material number: absorbed there
  std::vector<double> spectrum_out;  ///< what left, by band, W/nm
  Work work;

  /// All of it, in an order of its own.
  std::vector<double> numbers() const;
  /// Adds numbers() of a fate in the same luminaire.
  void add(std::span<const double> numbers);
};

/// May be shared by threads.
class Tracer {
 public:
  /// Throws umov::Error where spectra and surfaces do not fit the luminaire's bands.
  explicit Tracer(const Luminaire& luminaire);

  /// One estimate of the luminance in cd/m² that is seen from `origin` along `direction`, in a
  /// luminaire without bands.
  double luminance(const Vec3& origin, const Vec3& direction, Estimator estimator,
                   std::uint64_t seed, std::uint64_t path, Work& work) const;
  /// The same in a luminaire with bands: spectral radiance in W/(m² sr nm), one number a band, all
  /// of one path.
  void radiance(const Vec3& origin, const Vec3& direction, Estimator estimator, std::uint64_t seed,
                std::uint64_t path, std::span<double> bands, Work& work) const;

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
  template <class Light>
  void see(const Vec3& origin, const Vec3& direction, Estimator estimator, std::uint64_t seed,
           std::uint64_t path, Light& light, Work& work) const;
  template <class Facing, class Light>
  void next_event(const Place& place, const Facing& facing, Estimator estimator, double u1,
                  double u2, double u3, Light& light, Work& work) const;
  template <class Light>
  std::optional<Exit> follow(const Vec3& origin, const Vec3& direction, double launched_lm,
                             std::uint64_t seed, std::uint64_t path, Light& light,
                             Fate& fate) const;
  std::optional<trace::Hit> nearest(const Vec3& origin, const Vec3& direction, double limit) const;

  const Luminaire& luminaire_;
  trace::Geometry geometry_;
  SourceChoice choice_;
  /// By emitter.
  struct Source {
    double area_mm2, lm_per_m2;
  };
  std::vector<Source> sources_;
};

}  // namespace umov::chamber
