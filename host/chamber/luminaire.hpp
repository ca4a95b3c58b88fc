// A luminaire as it is traced: faces, what they do to light, what shines.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/chamber/bands.hpp"
#include "host/chamber/emitter.hpp"
#include "host/chamber/surface.hpp"
#include "host/trace/geometry.hpp"
#include "host/trace/scene.hpp"

namespace umov::chamber {

/// Lengths in mm. Fronts of faces look into the light; what meets a face from behind is absorbed.
struct Luminaire {
  trace::Scene scene;  ///< geometry; its materials only number the faces
  /// By material number of the scene. A luminous face reflects with its surface as well.
  std::vector<std::shared_ptr<const Surface>> surfaces;
  std::vector<int> emitter_of;   ///< by material number; -1: dark
  std::vector<bool> inside_out;  ///< by material number: fronts are where spheres have their backs
  std::vector<Emitter> emitters;
  /// Where colours count: then emitters have spectra, and surfaces one band or as many as these.
  std::optional<Bands> bands;

  /// Luminous opening that LID files state and maps are centred on: at this height, this wide.
  double opening_z = 0.0;
  double opening_diameter_mm = 0.0;

  Luminaire();
  trace::MaterialId add(std::shared_ptr<const Surface> surface, bool turned = false);
  /// Adds faces and emitter. A disc lies flat and shines up or down (`half_u` along x, `half_v`
  /// along y or -y); a rectangle lies as its half edges say.
  void add_emitter(Emitter emitter, std::shared_ptr<const Surface> surface);
  /// A closed box; its fronts look inwards where `inward`.
  void add_box(const Vec3& from, const Vec3& to, bool inward, trace::MaterialId material,
               const std::vector<bool>& left_out = {});
  double flux_lm() const;
};

}  // namespace umov::chamber
