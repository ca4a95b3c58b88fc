// Surfaces of a scene file: inline, named in [surfaces.NAME], or `black`.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "host/chamber/bands.hpp"
#include "host/chamber/surface.hpp"
#include "host/toml/scene_table.hpp"

namespace umov::chamber {

class SceneMaterials {
 public:
  /// `file`: the scene file, for messages.
  explicit SceneMaterials(std::filesystem::path file) : file_(std::move(file)) {}

  /// From here on surfaces are made for these bands, and their numbers may be spectra.
  void use(const Bands& bands) { wavelengths_um_ = bands.wavelengths_um(); }
  /// Reads every [surfaces.NAME].
  void read_named(SceneTable& root);
  /// The surface under `key`: a name, "black", or a table of its own. Throws umov::Error with line.
  std::shared_ptr<const Surface> surface(SceneTable& table, std::string_view key);
  std::shared_ptr<const Surface> black() const { return black_; }

 private:
  std::shared_ptr<const Surface> from_table(SceneTable table, const std::string& name) const;

  std::filesystem::path file_;
  std::vector<double> wavelengths_um_;  ///< empty: no bands
  std::map<std::string, std::shared_ptr<const Surface>, std::less<>> named_;
  std::shared_ptr<const Surface> black_ = std::make_shared<Surface>("black", Lambertian{0.0});
};

}  // namespace umov::chamber
