// Klems' angle bases: the hemisphere in rings of patches, as the Window-6 XML of BSDF data has
// them.
//
// A ring spans two polar angles and is cut into equal patches; patch p of a ring with n patches is
// centred on the azimuth 360 p/n deg. Patches are numbered ring by ring from the normal outwards.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace umov::formats {

struct KlemsRing {
  double lower_deg = 0, upper_deg = 0;  ///< polar angles, lower < upper
  int patches = 1;                      ///< 1 only for the cap about the normal
};

/// One patch in radians.
struct KlemsPatch {
  double theta_lower, theta_upper;
  double phi_centre, phi_half_width;
  std::size_t ring;
  /// ∫ cos θ dω over the patch.
  double projected_solid_angle() const;
};

class KlemsBasis {
 public:
  static constexpr std::size_t max_rings = 64;
  static constexpr int max_patches = 1024;  ///< of a whole basis

  /// Rings from 0 to 90 deg without gaps. Throws umov::Error otherwise.
  KlemsBasis(std::string name, std::vector<KlemsRing> rings);
  /// "LBNL/Klems Full" (145 patches), "LBNL/Klems Half" (73), "LBNL/Klems Quarter" (41) with the
  /// rings that WINDOW gives them; nullopt for another name. Upper and lower case are alike.
  static std::optional<KlemsBasis> by_name(std::string_view name);

  const std::string& name() const { return name_; }
  const std::vector<KlemsRing>& rings() const { return rings_; }
  /// Number of the first patch of a ring.
  std::size_t first_of(std::size_t ring) const { return first_[ring]; }
  std::size_t size() const { return patches_.size(); }
  const KlemsPatch& patch(std::size_t index) const { return patches_[index]; }

  /// Ring that holds a polar angle in radians; the last ring beyond 90 deg.
  std::size_t ring_of(double theta) const;
  /// Patch that holds a direction in radians, any azimuth.
  std::size_t patch_of(double theta, double phi) const;

 private:
  std::string name_;
  std::vector<KlemsRing> rings_;
  std::vector<std::size_t> first_;
  std::vector<KlemsPatch> patches_;
};

}  // namespace umov::formats
