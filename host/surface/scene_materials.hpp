// The materials of a scene file.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "host/toml/scene_table.hpp"
#include "host/trace/scene.hpp"

namespace umov::surface {

/// A material as [substrate] and [materials.NAME] describe it: `model` is one of the library, or
/// `fresnel`, a smooth opaque body of index n + iκ. All throw umov::Error with file and line.
/// `prepared`: what the same table gave before; its samplers, if it has any, are taken over.
trace::Material read_material(SceneTable& table, const std::vector<double>& wavelengths_um,
                              const trace::Material* prepared = nullptr);

/// n and κ of a table: `index`, the name of an embedded one, or `n` and `kappa`; else those of
/// `preset`, where that is not empty.
trace::Medium read_index(SceneTable& table, const std::vector<double>& wavelengths_um,
                         const std::string& preset = {});

/// The same of a liquid: n >= 1, water unless said otherwise.
trace::Medium read_liquid(SceneTable& table, const std::vector<double>& wavelengths_um);

/// Soils that every scene knows: dry_soil, wet_soil.
std::vector<std::string> known_soils();
trace::Material soil(const std::string& name, const std::vector<double>& wavelengths_um);

/// data/spectra/soil_reflectance.csv: columns dry_soil and wet_soil.
extern const char* const embedded_soils;

}  // namespace umov::surface
