// A BRDF as a file of Klems patches should show it: the yardstick for such a file.
#pragma once

#include <cstddef>
#include <map>
#include <mutex>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "host/brdf/table.hpp"
#include "host/formats/klems_basis.hpp"

namespace umov::formats {

/// The means of a source over pairs of patches, weighted with cos θi cos θr and over wavelength as
/// the band Visible is, by quasi-Monte Carlo: independent of the cubature that files are written
/// with. What a model reflects exactly in the mirror direction counts to the mirror patches.
///
/// Values are found when they are asked for and kept. A mean takes 1024 points and more, until
/// doubling them changes it by less than .1 % or there are `most_points`; with 4096, lobes of a
/// tenth of a patch still come out with some percent of noise. Safe to share by threads.
class KlemsMeans final : public brdf::Table {
 public:
  /// `source` must outlive this. One wavelength stands for the band alone.
  KlemsMeans(const brdf::Table& source, KlemsBasis basis, const std::vector<double>& wavelengths_um,
             std::size_t most_points = 4096);

  /// The mean over the patches that hold the geometry, and over the azimuth of incidence, as
  /// KlemsTable::at() gives it. The wavelength has no meaning.
  optics::Mueller<double> at(double wavelength_um,
                             const brdf::Geometry<double>& geometry) const override;
  const std::vector<double>& wavelengths_um() const override { return wavelengths_um_; }
  bool polarised() const override { return false; }
  std::string description() const override { return source_.description(); }

  /// Mean of the source's directional-hemispherical reflectance over the ring that holds `theta_i`
  /// (radians), mirror part included.
  double reflectance(double theta_i) const;

 private:
  double mean_of(std::size_t incident, std::size_t exit) const;
  double sampled(const KlemsPatch& incident, const KlemsPatch& exit) const;
  double mirror(double theta_i) const;

  const brdf::Table& source_;
  KlemsBasis basis_;
  std::vector<std::pair<double, double>> bands_;  ///< wavelength in micrometres, share
  std::vector<double> wavelengths_um_;
  std::size_t most_points_;
  mutable std::mutex guard_;
  /// By rings and the offset of the exit patch in 360 deg/(patches i × patches r).
  mutable std::map<std::tuple<std::size_t, std::size_t, long>, double> known_;
};

}  // namespace umov::formats
