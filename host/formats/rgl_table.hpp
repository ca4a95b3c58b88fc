// Measured BRDFs in the adaptive parameterisation of Dupuy and Jakob (2018), as RGL publishes them
// and Mitsuba's `measured` plugin reads them: docs/formats/rgl.md.
//
// The value towards a direction is spectra(s)/cos θr, times ndf(u)/(4 sigma(ui)) where `jacobian`
// is set. u = (√(2θm/π), (φm + π)/2π) names the half vector m, its azimuth counted from the source;
// s is u sent through the cumulative distribution of `vndf` (columns given rows), which spreads the
// peak of a gloss over the whole of the regular grid `spectra`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "host/brdf/table.hpp"

namespace umov::formats {

/// Rows run over azimuth, columns over polar angle (ndf, sigma, vndf) or their warped counterparts
/// (luminance, spectra). All values are as stored.
struct RglData {
  std::string description;
  std::vector<float> phi_i;           ///< azimuths of incidence, radians: one or two, isotropic
  std::vector<float> theta_i;         ///< rising, radians
  std::vector<float> wavelengths_nm;  ///< rising; empty where `spectra` holds red, green, blue
  std::size_t ndf_rows = 0, ndf_columns = 0;
  std::vector<float> ndf;
  std::size_t sigma_rows = 0, sigma_columns = 0;
  std::vector<float> sigma;
  std::size_t vndf_rows = 0, vndf_columns = 0;
  std::vector<float> vndf;       ///< [phi_i][theta_i][rows][columns]
  std::size_t resolution = 0;    ///< rows and columns of luminance and spectra
  std::vector<float> luminance;  ///< [phi_i][theta_i][rows][columns]; for importance sampling only
  std::vector<float> spectra;    ///< [phi_i][theta_i][wavelength][rows][columns]
  std::vector<std::uint8_t> valid;  ///< bits of measured entries, as luminance; may be empty
  bool jacobian = true;

  std::size_t channels() const { return wavelengths_nm.empty() ? 3 : wavelengths_nm.size(); }
  bool operator==(const RglData&) const = default;
};

/// Calls `fail(field, entry, problem)` at the first thing that is wrong: shapes that disagree, an
/// axis that does not rise, a number that is not finite, a density that is negative or all 0.
void check_rgl(const RglData& data, const std::function<void(const char* field, std::size_t entry,
                                                             const std::string& problem)>& fail);

class RglTable final : public brdf::Table {
 public:
  /// Nearer to the horizon than this, values are divided by this instead of cos θr.
  static constexpr double lowest_cosine = 0.002;

  /// Throws umov::Error where check_rgl() finds fault. `origin` names the source.
  RglTable(RglData data, std::string origin);

  optics::Mueller<double> at(double wavelength_um,
                             const brdf::Geometry<double>& geometry) const override;
  const std::vector<double>& wavelengths_um() const override { return wavelengths_um_; }
  bool polarised() const override { return false; }
  std::string description() const override;

  const RglData& data() const { return data_; }
  const std::string& origin() const { return origin_; }

  /// A point of a unit square.
  struct Point {
    double x, y;
  };
  /// From s to u at the stored incidence number `incidence`: the reverse of what at() does. Where
  /// the density has gaps, their near end.
  Point unwarped(std::size_t incidence, Point s) const;
  /// ndf(u)/(4 sigma(u_i)), or 1 without jacobian.
  double scale(Point u, double theta_i) const;

 private:
  struct Slices;
  Slices slices_at(double theta_i) const;
  bool warp(const Slices& slices, Point& u) const;
  double channel_value(const Slices& slices, std::size_t channel, Point s) const;

  RglData data_;
  std::string origin_;
  std::vector<double> wavelengths_um_;
  std::vector<std::size_t> channels_;  ///< stored channel of each wavelength
  std::vector<double> inverse_total_;  ///< by slice: 1 over the integral of vndf
  std::vector<double> conditional_;    ///< cumulated along each row of vndf
  std::vector<double> marginal_;       ///< cumulated over rows
};

}  // namespace umov::formats
