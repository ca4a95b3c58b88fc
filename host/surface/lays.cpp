#include "host/surface/lays.hpp"

#include <algorithm>
#include <utility>

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"

namespace umov::surface {
namespace {

// Launches that take several times as long as laying a thousand particles that are not crowded.
constexpr std::uint64_t preset_launches = 4096;
// The scatter of fewer says little.
constexpr std::uint64_t fewest_lays = 16;
// Steps of laying that take as long as a launch.
constexpr std::uint64_t steps_a_launch = 10;
// Share of the time of tracing that laying may take, where there are launches enough.
constexpr double laying_share = 0.25;
// Seeds that a lay may take one after the other.
constexpr int most_tries = 20;

}  // namespace

ReadSurface reader_of(const std::filesystem::path& path) {
  return [text = formats::read_whole_file(path), file = path.string()](const Reading& reading) {
    return surface_from_toml(text, file, reading);
  };
}

std::uint64_t lay_seed(std::uint64_t seed, std::uint64_t number) {
  if (number == 0) return seed;
  // SplitMix64 (Steele, Lea and Flood 2014): seeds that are near each other give others that are
  // not.
  std::uint64_t z = seed + number * 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

std::uint64_t launches_a_lay(const Surface& surface, std::uint64_t samples) {
  if (!surface.random) return 0;
  const std::uint64_t laying = surface.steps / steps_a_launch;  // in launches
  if (fewest_lays * laying > samples) return 0;
  const std::uint64_t few = (samples + fewest_lays - 1) / fewest_lays;
  const auto enough = static_cast<std::uint64_t>(static_cast<double>(laying) / laying_share);
  return std::min(few, std::max(preset_launches, enough));
}

Lays::Lay::Lay(Surface described)
    : surface(std::move(described)), geometry(surface.scene), tracer(surface.scene, geometry) {}

Lays::Lays(ReadSurface read, const Reading& reading)
    : read_(std::move(read)),
      reading_(reading),
      first_(std::make_shared<const Lay>(read_(reading))) {}

std::shared_ptr<const trace::PathTracer> Lays::tracer(std::uint64_t number) const {
  if (number == 0) return {first_, &first_->tracer};
  Reading reading = reading_;
  reading.like = &first_->surface;
  reading.seed = lay_seed(reading_.seed, number);
  for (int tries = 1;; ++tries) {
    try {
      const auto lay = std::make_shared<const Lay>(read_(reading));
      return {lay, &lay->tracer};
    } catch (const Error&) {
      // The first lay found room: so does this one, though not from every seed.
      if (tries == most_tries) throw;
      reading.seed = lay_seed(reading.seed, number);
    }
  }
}

trace::Result Lays::simulate(const trace::Hemisphere& hemisphere, trace::Request request,
                             std::uint64_t launches, const std::vector<double>& begun) const {
  if (launches == 0 || !first().random) {
    return trace::simulate(first_->tracer, hemisphere, request, begun);
  }
  request.block = launches;
  return trace::simulate([this](std::uint64_t number) { return tracer(number); }, hemisphere,
                         request, begun);
}

}  // namespace umov::surface
