// Scene files: a rough, dirty or wet surface in TOML. Keys: host/surface/README.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/trace/scene.hpp"

namespace umov::surface {

/// One [[particles]] or [[drops]] of a file, as it was laid.
struct Layer {
  std::string kind;  ///< sphere, drop
  std::size_t count;
  double coverage;             ///< area seen from above over that of the ground
  trace::MaterialId material;  ///< of its spheres
};

/// Thermal light, after Kirchhoff's law.
struct Emission {
  /// By who absorbs and emits: materials, then media (trace::Absorbed::owner). Kelvin.
  std::vector<double> temperature_k;
  double sky_k = 0.0;  ///< of a black sky of one temperature; 0: none
  /// Irradiance on a face that looks at the sun [W/m²/µm], by wavelength; empty: no sun.
  std::vector<double> sun;
  double sun_theta_deg = 0.0, sun_phi_deg = 0.0;  ///< where the sun stands, φ as exit directions
};

/// When a simulation may end; 0: not by this. Errors are 1 σ, of every wavelength.
struct Stop {
  double dhr_relative_error = 0.0;
  double cell_relative_error = 0.0;
  /// Which cells: the percentile of all of them, or the one that holds a direction (θr and φr in
  /// degrees).
  double cell_percentile = 50.0;
  std::optional<std::array<double, 2>> cell_deg;
  double rays = 0.0;
};

struct Surface {
  trace::Scene scene;  ///< lengths in µm
  std::vector<Layer> layers;
  double covered = 0.0;             ///< by all layers together, seen from above
  std::vector<double> theta_i_deg;  ///< as the file has them; may be empty
  trace::MaterialId ground = 0;     ///< of the substrate
  std::optional<Emission> emission;
  Stop stop;
  bool film = false;        ///< there is one
  bool random = false;      ///< another seed would lay it otherwise
  std::uint64_t steps = 0;  ///< that laying and building it takes, of some .2 µs
};

/// Which part of what a file describes.
enum class Part {
  whole,
  bare,        ///< the substrate (and a film) without particles and drops
  contaminant  ///< nothing but one layer: flat ground of its material; for drops, a film of it on
               ///< the substrate
};

struct Reading {
  std::uint64_t seed = 1;  ///< lays particles and makes rough ground
  Part part = Part::whole;
  std::size_t layer = 0;        ///< of Part::contaminant, particles first
  double coverage_scale = 1.0;  ///< of every layer
  /// Of the same text and part, with another seed: its materials, media and measured coverages
  /// are taken over, not made again.
  const Surface* like = nullptr;
};

/// `file` names the text in errors, and files beside it are looked for there. Throws umov::Error,
/// with the line where there is one, for what is unknown, missing, out of range or cannot be laid.
Surface surface_from_toml(std::string_view text, const std::string& file, const Reading& reading);

/// The same from a file.
Surface read_surface(const std::filesystem::path& path, const Reading& reading);

}  // namespace umov::surface
