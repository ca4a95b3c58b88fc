// Which model of the library foretells rows that it has not seen?
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/invert/invert.hpp"

namespace umov::invert {

/// One model (or the plain interpolation) on the same training and held-out rows.
struct Contender {
  std::string model;
  std::size_t parameters = 0;  ///< free numbers, all wavelengths
  /// Of the held-out points: mean z² with z over the measured noise; relative error by size; mean
  /// logarithm of the predictive density (noise, widened where the training rows ask for it, and
  /// the fit's own uncertainty; natural logarithm, of z's unit so that it does not depend on the
  /// BRDF's unit).
  double chi2_per_point = 0;
  double median_relative = 0, p90_relative = 0;
  double log_density = 0;
  /// N ln s² + k ln N with the robust residual scale s of the N training points. None for the
  /// interpolation, which has no parameters.
  std::optional<double> bic;
  double scale = 1;  ///< s
  double seconds = 0;
  std::string failure;                    ///< why there is no result; empty where there is one
  std::optional<formats::FitResult> fit;  ///< to the training rows
};

struct Comparison {
  std::size_t training_points = 0, held_out_points = 0;
  std::vector<Contender> contenders;  ///< best log_density first, failures last
};

/// Names for `all`: every model that needs no file, each lobe with each diffuse term, sums of two
/// lobes with a diffuse term, and lobes over light from below with a Lambertian rest.
std::vector<std::string> library_models();

/// Marks of the rows kept from training: one in five (of rows of the same incidence, wavelength,
/// azimuth and polarisation states).
std::vector<bool> every_fifth_row(const formats::BrdfTable& table);

/// Fits each model to the used points of `table` that are not `held_out` (one mark a point) and
/// judges it on those that are. `options` apply to each fit except its model; settings of
/// parameters that a model lacks make it fail alone. `interpolation` stands at the end of the names
/// where asked for. Parallel over models; the result does not depend on threads, except `seconds`.
/// Throws umov::Error where either set is empty.
Comparison compare_models(const formats::BrdfTable& table, const std::vector<bool>& held_out,
                          const std::vector<std::string>& models, const Options& options);

}  // namespace umov::invert
