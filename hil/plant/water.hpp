// Water on a sample: a film that levels the surface, or drops.
//
// Under water the sample is `immersed` where it knows how, seen in refracted directions: f_wet =
// T_r f(θi', θr') T_i / n², T the Fresnel transmission matrices of the water's surface, 1/n² the
// narrowing of solid angles. Light thrown back by the water from inside meets the sample again;
// from the second meeting on it is taken as diffuse (J. Lekner, M. C. Dorf, Appl. Opt. 27, 1278
// (1988)): ρ² R / (1 - ρ R) with R the internal diffuse reflectance and ρ the sample's diffuse
// albedo, read off its BRDF far from the mirror direction. The water's own surface adds Gaussian
// facets (film) or the normals of a spherical cap (drops), Fresnel with the index of water at 25 °C
// (Hale & Querry 1973). Light that a drop focuses past its rim, or that runs inside it more than
// once, is left out.
#pragma once

#include <vector>

#include "hil/plant/coating.hpp"
#include "host/optics/refractive_index.hpp"

namespace umov::plant {

/// What water makes of the sample below, seen through a water surface with a given normal.
class Wetted {
 public:
  explicit Wetted(std::shared_ptr<const Sample> sample);

  double index(double wavelength_nm) const;
  /// BRDF through a surface whose normal is `normal_i` where the light enters and `normal_r` where
  /// it leaves. Zero where a ray would not meet the sample.
  Mueller through(const Beam& in, const Vec3& normal_i, const Beam& out, const Vec3& normal_r,
                  double wavelength_nm) const;
  /// The part that has met the sample more than once, through a level surface, 1/sr.
  double diffuse(double cos_i, double cos_r, double wavelength_nm) const;

 private:
  std::shared_ptr<const Sample> immersed_;
  optics::IndexTable water_;
};

class WaterFilm final : public Coating {
 public:
  WaterFilm(std::shared_ptr<const Sample> below, const FilmConfig& config);
  Mueller brdf(const Beam& in, const Beam& out, double wavelength_nm) const override;
  Mueller mirror(const Beam& in, const Beam& out, double wavelength_nm) const override;

 private:
  Wetted wetted_;
  FilmConfig config_;
};

class WaterDrops final : public Coating {
 public:
  WaterDrops(std::shared_ptr<const Sample> below, const DropsConfig& config);
  Mueller brdf(const Beam& in, const Beam& out, double wavelength_nm) const override;
  Mueller mirror(const Beam& in, const Beam& out, double wavelength_nm) const override;

 private:
  Wetted wetted_;
  DropsConfig config_;
  std::vector<Vec3> normals_;  ///< of a cap, equal shares of its solid angle
};

}  // namespace umov::plant
