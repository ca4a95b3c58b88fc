// umov diagnose MAP --luminaire SCENE: what a simulation misses of a measured luminance map.
#pragma once

#include <string>
#include <vector>

#include "host/cli/command.hpp"
#include "host/gap/engine/forward_model.hpp"

namespace umov::cli {

struct LuminaireDiagnosis {
  std::string map;           ///< sim.h5, OpenEXR or CSV
  std::string scene;         ///< of the luminaire, with the camera that took the map
  std::string json, report;  ///< files to write; empty: none
  std::vector<std::string> without;
  bool quick = false;
};

/// The answer goes to the files that are named, and to the terminal.
void diagnose_luminaire(const LuminaireDiagnosis& asked, const Common& common);

/// What a diagnosis of maps of this scene can name.
std::vector<gap::Effect> luminaire_effects(const std::string& scene);

}  // namespace umov::cli
