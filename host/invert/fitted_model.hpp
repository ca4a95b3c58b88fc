// A fit as an instrument of prediction: what it says in any direction, with 95 % intervals.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "host/brdf/model.hpp"
#include "host/formats/fit_file.hpp"
#include "host/invert/coordinates.hpp"
#include "host/invert/kernel.hpp"
#include "host/invert/limited_profile.hpp"

namespace umov::invert {

/// A predicted number. `u` is one sigma without regard to limits, lo and hi the 95 % interval with.
struct Predicted {
  double value = 0, u = 0, lo = 0, hi = 0;
};

class FittedModel {
 public:
  /// Throws umov::Error where the fit lacks a parameter of its model.
  explicit FittedModel(const formats::FitResult& fit);

  /// Index of a wavelength of the fit. Throws umov::Error listing them where there is none such.
  std::size_t wavelength(double nm) const;
  bool has_wavelength(double nm) const;
  const std::vector<double>& wavelengths_nm() const { return wavelengths_nm_; }

  /// Without uncertainty, in 1/sr.
  double value(std::size_t wavelength, const View& view, const Channel& channel) const;
  /// With it. Calibration errors common to all points are in the interval.
  Predicted brdf(std::size_t wavelength, const View& view, const Channel& channel) const;
  /// (P4): (f_PP − f_PS)/(f_PP + f_PS), incident light polarised in the plane of incidence. NaN
  /// where nothing is reflected.
  Predicted dolp(std::size_t wavelength, const View& view) const;
  /// One sigma of a BRDF alone: cheap enough for hemispheres.
  double sigma(std::size_t wavelength, const View& view, const Channel& channel,
               double& value) const;

 private:
  struct Active {
    std::vector<int> parameters;     ///< of the model, with a row in the covariance
    std::vector<Eigen::Index> rows;  ///< that row
    std::vector<double> slopes;      ///< dp/dx
  };
  Predicted predicted(double value, const Eigen::VectorXd& by_x) const;
  /// Values of channels and their gradients by the coordinates (one column a channel).
  Eigen::MatrixXd gradients(std::size_t wavelength, const View& view,
                            std::span<const Channel> channels, std::span<double> f) const;

  brdf::Model model_;
  std::vector<double> wavelengths_nm_;
  std::vector<std::vector<double>> values_;  ///< [wavelength][parameter]
  std::vector<Active> active_;
  Eigen::MatrixXd covariance_;  ///< of the coordinates
  LimitedProfile profile_;
};

}  // namespace umov::invert
