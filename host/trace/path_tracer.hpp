// Paths of polarised light through a scene, from one launch to all its exits.
//
// A path carries one 4 × 4 Mueller matrix for each wavelength, in the basis of its present
// direction. Wavelengths travel together until a face refracts them differently; from there each
// has a path of its own. Bounces are unlimited: a path ends when it leaves, when nothing is left of
// it, or by Russian roulette, which pays survivors what it takes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/optics/frames.hpp"
#include "host/trace/geometry.hpp"

namespace umov::trace {

/// Light that leaves the scene.
struct Exit {
  Vec3 direction;                  ///< unit length; z > 0 above, z <= 0 below
  std::size_t wavelength;          ///< number in the scene
  std::uint32_t meetings;          ///< with faces, since the launch
  optics::Mueller<double> weight;  ///< share of the launched power; bases as docs/physics.md, 1
};

/// Light that stays in the scene.
struct Absorbed {
  std::size_t owner;            ///< a MaterialId, or materials.size() + a MediumId
  std::size_t wavelength;       ///< number in the scene
  std::array<double, 4> power;  ///< for launched Stokes (I, Q, U, V): a row, as m00 … m03
};

/// Where light ends.
class Collector {
 public:
  /// absorb() is called if `watches_absorption`.
  explicit Collector(bool watches_absorption = false) : watches_absorption_(watches_absorption) {}
  virtual ~Collector() = default;
  virtual void collect(const Exit& exit) = 0;
  virtual void absorb(const Absorbed&) {}
  bool watches_absorption() const { return watches_absorption_; }

 private:
  bool watches_absorption_;
};

/// What became of launched light (m00, one value a wavelength), and how much work it was.
struct Ledger {
  std::vector<double> launched, above, below, absorbed, lost;
  std::uint64_t rays = 0;             ///< searches for the nearest face
  std::uint64_t behind_opaque = 0;    ///< paths that met an opaque face from behind: a leak
  std::uint64_t in_wrong_medium = 0;  ///< paths that left a body they had not entered, or
                                      ///< the scene without leaving a body: a leak
  std::uint64_t endless = 0;          ///< paths given up after 10⁶ meetings or periods
  std::uint64_t creases = 0;          ///< times a path began behind a face by less than 1e-7 of the
                                      ///< scene, where faces meet, and was let through; not lost

  explicit Ledger(std::size_t wavelengths);
  void add(const Ledger& other);
  /// All members, for whoever sends or keeps a ledger.
  std::array<std::vector<double>*, 5> sums() {
    return {&launched, &above, &below, &absorbed, &lost};
  }
  std::array<std::uint64_t*, 5> counts() {
    return {&rays, &behind_opaque, &in_wrong_medium, &endless, &creases};
  }
};

/// May be shared by threads, which need a Workspace each.
class PathTracer {
 public:
  PathTracer(const Scene& scene, const Geometry& geometry);

  /// Memory of one thread.
  class Workspace {
   public:
    explicit Workspace(const PathTracer& tracer);

   private:
    friend class PathTracer;
    struct Path {
      Vec3 origin;
      optics::Beam<double> beam;
      MediumId medium;
      std::array<std::uint16_t, most_media> inside;  // bodies the path is in, by medium
      std::size_t first, count;                      // wavelengths
      std::uint32_t meetings, periods;
    };
    std::vector<optics::Mueller<double>> weight;  // by wavelength
    std::vector<optics::FresnelReflection<double>> reflection;
    std::vector<Path> open;
  };

  /// Launches unit power at every wavelength from `origin` along `beam`, in vacuum. `seed` and
  /// `sample` decide all that is random.
  void trace(const Vec3& origin, const optics::Beam<double>& beam, std::uint64_t seed,
             std::uint64_t sample, Workspace& workspace, Collector& collector,
             Ledger& ledger) const;

  const Scene& scene() const { return scene_; }
  const Geometry& geometry() const { return geometry_; }

 private:
  struct Run;
  const Scene& scene_;
  const Geometry& geometry_;
  std::vector<double> attenuation_;  // by medium and wavelength: 4πκ/λ
  std::vector<char> dispersive_;     // by medium and medium
};

}  // namespace umov::trace
