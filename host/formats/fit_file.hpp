// The result of an inversion in memory and as fit.json: parameters with intervals, what the data
// could not determine, directional-hemispherical reflectance, and how the fit was made.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace umov::formats {

/// A number with its 95 % interval.
struct Estimate {
  double value = 0;
  double lo = 0;
  double hi = 0;
  /// Linearised, with the calibration's share; 0 where fixed. In the file null where at_bound.
  double standard_error = 0;
  std::string at_bound;  ///< "", "lower" or "upper": the optimum lies on this limit
  /// The data pin this number down by itself: farther than four sigma from its limits, an interval
  /// well inside the allowed range, and no other parameter can take its place.
  bool identifiable = true;
};

/// One parameter of the model, or a quantity derived from parameters.
struct FitParameter {
  std::string name;
  std::string unit;                 ///< "1", "um", "deg", "1/sr" …
  bool shared = true;               ///< one value for all wavelengths; otherwise one each
  bool fixed = false;               ///< held at the user's value
  std::vector<Estimate> estimates;  ///< one where shared, else in the order of wavelengths_nm
  const Estimate& at(std::size_t wavelength) const { return estimates[shared ? 0 : wavelength]; }
};

/// What `umov invert` found. All angles in degrees, wavelengths in nm.
struct FitResult {
  std::string model;
  std::vector<double> wavelengths_nm;
  std::vector<FitParameter> parameters;  ///< in the model's own order
  std::vector<FitParameter> derived;     ///< such as "slope_2sigma_over_tau", "k_udf+k_uds"

  std::vector<std::string> at_bound;  ///< "k_fs 532 nm" or, shared, "sigma_um"

  /// Parameters that stand in for one another (|coefficient| > 0.95 given the calibration).
  struct Correlation {
    std::string first, second;  ///< parameter names without wavelength
    double coefficient = 0;
    std::optional<double> first_wavelength_nm, second_wavelength_nm;  ///< absent where shared
  };
  std::vector<Correlation> correlations;
  std::vector<std::string> identifiability;  ///< sentences
  std::vector<std::string> notes;            ///< sentences: misfit, outliers, convergence
  std::vector<std::string> priors;           ///< knowledge put in, "n = 1.5 ± 0.02"

  /// What more data would do for numbers that these data confuse or leave open, by the linearised
  /// fit with hypothetical points added.
  struct Remedy {
    std::vector<std::string> parameters;  ///< one or two, as in at_bound
    std::string data;                     ///< "rows out of the plane of incidence"
    std::size_t points = 0;               ///< added
    double sigma_ratio = 1;  ///< standard deviation then over now, of the one that gains most
    std::optional<double> correlation_now, correlation_then;  ///< of two parameters
  };
  std::vector<Remedy> remedies;

  struct Dhr {
    double wavelength_nm = 0, theta_i_deg = 0;
    double value = 0, lo = 0, hi = 0;  ///< mirror part included
    double mirror = 0;                 ///< of value, what leaves in the mirror direction
  };
  std::vector<Dhr> dhr;  ///< unpolarised incidence

  /// Common errors of the calibration that were marginalised: value in standard deviations.
  struct Factor {
    std::string name;
    double value = 0;
    double standard_error = 1;
  };
  std::vector<Factor> factors;

  /// Covariance of the free parameters (linearised, calibration included, interval_scale applied).
  struct Covariance {
    std::vector<std::string> names;  ///< as in at_bound
    std::vector<double> values;      ///< row by row, names.size()² numbers

    /// The coordinate x in which the fit moved: x = p, ln p or p². Intervals near limits are those
    /// of a normal distribution in x between lo and hi whose optimum without limits lies at
    /// at + centre.
    struct Coordinate {
      std::string scale = "linear";  ///< or "logarithmic", "square"
      double at = 0, lo = 0, hi = 0, centre = 0;
    };
    std::vector<Coordinate> coordinates = {};  ///< one a name; none in files of version 0.1.0
    /// A prior order among parameters: adds max(0, value + slope·d)² to chi² at the offset d in x.
    struct Order {
      double value = 0;
      std::vector<double> slope;  ///< one a name
    };
    std::vector<Order> orders = {};
  } covariance;

  std::string objective_kind = "noise-weighted";  ///< or "paper"
  double objective = 0;       ///< minimised: robust chi² with the factors' priors, or F of (P12)
  double chi2 = 0;            ///< sum of squared normalised residuals and factors, no robust loss
  std::size_t dof = 0;        ///< points minus free parameters
  double interval_scale = 1;  ///< intervals are this much wider than the noise alone explains
  double robust_scale_sigma = 0;      ///< residuals beyond this many sigma count linearly; 0: none
  double floor_relative = 0;          ///< relative model discrepancy added to the noise
  std::size_t points = 0;             ///< used points
  std::size_t outliers = 0;           ///< of these, beyond the robust scale
  std::optional<double> g2_held_out;  ///< mean(z²) − 1 over rows kept from a second fit
  std::size_t iterations = 0;         ///< of the winning start, all stages
  std::size_t starts = 0;             ///< starting points tried
  std::size_t starts_agreeing = 0;    ///< of these, ended at the best objective within 1 in 1000
  bool converged = false;
  std::uint64_t seed = 1;
  double seconds = 0;
  std::vector<std::pair<std::string, double>> phase_seconds;
  std::string data_file, data_sha256, program, command;

  /// Values of all parameters at wavelength `index`, in the model's order, as evaluate() wants
  /// them.
  std::vector<double> values_at(std::size_t index) const;
  /// Index of a wavelength (within 0.01 nm); nullopt where it was not fitted.
  std::optional<std::size_t> wavelength_index(double wavelength_nm) const;
  /// A parameter or derived quantity by name; nullptr where there is none.
  const FitParameter* find(const std::string& name) const;
};

/// JSON text of a fit. Numbers keep 17 significant digits, NaN becomes null.
std::string fit_to_json(const FitResult& fit);
/// The reverse; `file` names the source in errors. Throws umov::Error on malformed text, on missing
/// members and on lists whose length is not the number of wavelengths.
FitResult fit_from_json(const std::string& text, const std::string& file);

/// Writes by way of a temporary file beside `path`, so that a failure leaves an old file whole.
void write_fit(const std::string& path, const FitResult& fit);
FitResult read_fit(const std::string& path);

}  // namespace umov::formats
