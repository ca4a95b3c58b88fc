// What a measurement of a luminaire leaves: sim.h5, and an image of it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/chamber/camera.hpp"
#include "host/chamber/goniophotometer.hpp"
#include "host/formats/provenance.hpp"

namespace umov::chamber {

/// Either may be missing.
struct Result {
  std::optional<Map> map;
  std::optional<Distribution> distribution;
  std::vector<std::pair<std::string, std::string>> keys;  ///< of the scene; kept as attributes
};

/// Groups /map and /lid as docs/formats/sim-h5.md says. Throws umov::Error.
void write_sim_h5(const std::filesystem::path& path, const Result& result,
                  const formats::Provenance& provenance);
/// Checksums verified. Throws umov::Error.
Result read_sim_h5(const std::filesystem::path& path);

/// Channels Y (luminance in cd/m²) and se, pixel for pixel, top row first.
void write_map_exr(const std::filesystem::path& path, const Map& map);

}  // namespace umov::chamber
