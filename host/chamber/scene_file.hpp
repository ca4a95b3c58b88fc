// Scene files of `umov simulate chamber`: a luminaire and how it is measured, in TOML. Keys:
// host/chamber/README.md.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "host/chamber/camera.hpp"
#include "host/chamber/departure.hpp"
#include "host/chamber/figures.hpp"
#include "host/chamber/goniophotometer.hpp"
#include "host/chamber/luminaire.hpp"

namespace umov::chamber {

struct Job {
  Luminaire luminaire;
  std::optional<Camera> camera;
  MapRequest map;
  /// Part of the map that figures are told of, in mm of the map; else the whole map.
  std::optional<Region> region;
  std::optional<DistributionRequest> distribution;
  std::optional<Glare> glare;
  bool rings = false;                    ///< as in Described
  std::optional<double> least_depth_mm;  ///< as in Described
};

/// `file` names the text in errors and is where files it names are looked for first. Throws
/// umov::Error, with line, for what is unknown, missing, out of range or cannot be.
Job job_from_toml(std::string_view text, const std::filesystem::path& file,
                  const Departure& departure = {});

Job read_job(const std::filesystem::path& path);

/// The luminaire of a scene file before its camera, to be built with departures. Throws umov::Error
/// as job_from_toml() does, and for a scene without a [camera] or without light.
Described described_scene(const std::filesystem::path& path);

}  // namespace umov::chamber
