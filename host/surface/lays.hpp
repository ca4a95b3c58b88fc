// Lays of a surface: its particles strewn and its rough ground made anew, again and again, so that
// standard errors hold where things lie and not the rays alone.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

#include "host/surface/scene_file.hpp"
#include "host/trace/simulation.hpp"

namespace umov::surface {

/// Reads one described surface; safe to call from several threads.
using ReadSurface = std::function<Surface(const Reading&)>;

/// Of a scene file, whose text is read once, now. Throws umov::Error.
ReadSurface reader_of(const std::filesystem::path& path);

/// The seed of lay `number` of those that begin with `seed`, which is that of lay 0.
std::uint64_t lay_seed(std::uint64_t seed, std::uint64_t number);

/// Launches a lay where nobody chose: so many that tracing takes longer than laying, fewer in a run
/// of few `samples`, which needs sixteen lays. 0 (one lay for all) for a surface without anything
/// random in it, and where sixteen lays would take longer than `samples` launches do.
std::uint64_t launches_a_lay(const Surface& surface, std::uint64_t samples);

/// A described surface in as many lays as a simulation takes. May be shared by threads.
class Lays {
 public:
  /// `reading.seed` lays the first. Throws what `read` throws.
  Lays(ReadSurface read, const Reading& reading);

  const Surface& first() const { return first_->surface; }

  /// trace::simulate() with a new lay after every `launches`, so that errors are those of lays and
  /// rays; result.blocks() says how many there were. 0, or a surface without anything random: the
  /// first lay alone, and errors of rays.
  trace::Result simulate(const trace::Hemisphere& hemisphere, trace::Request request,
                         std::uint64_t launches, const std::vector<double>& begun = {}) const;

 private:
  struct Lay {
    explicit Lay(Surface described);
    Surface surface;
    trace::Geometry geometry;
    trace::PathTracer tracer;
  };
  std::shared_ptr<const trace::PathTracer> tracer(std::uint64_t number) const;

  ReadSurface read_;
  Reading reading_;
  std::shared_ptr<const Lay> first_;
};

}  // namespace umov::surface
