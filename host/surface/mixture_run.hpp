// The simulations behind a mixture analysis, one after the other.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "host/surface/lays.hpp"
#include "host/surface/mixture.hpp"

namespace umov::surface {

struct MixtureRequest {
  std::vector<double> theta_i_deg;
  std::vector<double> coverage_factors;  ///< of the scene's coverages
  trace::Request how;  ///< of every simulation but for θi and the seed's own part
  std::size_t rings = 18, strip = 180;
  double strip_half_width_deg = 2.0;
  /// Launches a lay, 0: one lay; nothing: as launches_a_lay() has it.
  std::optional<std::uint64_t> launches = {};
  /// Called before each simulation with its number and how many there are; gives the state() in
  /// which an earlier analysis left it, or nothing.
  std::function<std::vector<double>(std::size_t, std::size_t)> begin = {};
  /// Called with what each simulation, by number, came to.
  std::function<void(std::size_t, const trace::Result&)> ended = {};
};

/// All that was simulated at one angle.
struct MixtureAngle {
  double theta_i_deg;
  trace::Result bare;
  std::vector<trace::Result> contaminants;  ///< by layer
  std::vector<trace::Result> wholes;        ///< by coverage factor
  std::vector<MixturePoint> points;         ///< by coverage factor
  MixingLaw law;                            ///< of MixturePoint::effective
  std::vector<MixingLaw> band_laws;         ///< by wavelength
};

/// Random numbers and lays of every simulation are its own, so that errors are independent; with
/// one lay, all simulations of a coverage have it. Throws umov::Error for a scene without
/// particles. `how.stop` ends it at once, with the angles that are whole; given the states again,
/// it comes to the same bits as without the stop.
std::vector<MixtureAngle> analyse_mixture(const ReadSurface& read, const MixtureRequest& request);

}  // namespace umov::surface
