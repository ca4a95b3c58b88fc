// Paths of polarised light through a scene, from one launch to all its exits.
//
// A path carries one 4 × 4 Mueller matrix for each wavelength, in the basis of its present
// direction. Wavelengths travel together until a face refracts them differently; from there each
// has a path of its own. Bounces are unlimited: a path ends when it leaves, when nothing is left of
// it, or by Russian roulette, which pays survivors what it takes.
#pragma once

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

/// Where exits go.
class Collector {
 public:
  virtual ~Collector() = default;
  virtual void collect(const Exit& exit) = 0;
};

/// What became of launched light (m00, one value a wavelength), and how much work it was.
struct Ledger {
  std::vector<double> launched, above, below, absorbed, lost;
  std::uint64_t rays = 0;             ///< searches for the nearest face
  std::uint64_t behind_opaque = 0;    ///< paths that met an opaque face from behind: a leak
  std::uint64_t in_wrong_medium = 0;  ///< paths that met an interface from a medium it has not
                                      ///< there: faces that overlap, or a leak
  std::uint64_t endless = 0;          ///< paths given up after 10⁶ meetings or periods

  explicit Ledger(std::size_t wavelengths);
  void add(const Ledger& other);
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
      std::size_t first, count;  // wavelengths
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
  std::vector<char> dispersive_;     // by material
};

}  // namespace umov::trace
