// umov diagnose BRDF --surface SCENE: what linear mixing leaves out of a measured surface.
#pragma once

#include <string>

#include "host/cli/command.hpp"

namespace umov::cli {

/// `brdf` is a brdf.h5 (also one of `umov simulate surface`), `scene` a scene file with its
/// wavelengths; the answer goes to the file `json`, where one is named, and to the terminal.
void diagnose_surface(const std::string& brdf, const std::string& scene, const std::string& json,
                      const Common& common);

}  // namespace umov::cli
