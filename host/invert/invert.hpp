// Joint inversion: all used points of a reduced measurement, every wavelength and polarisation
// state at once, against one model of the library.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/formats/brdf_table.hpp"
#include "host/formats/fit_file.hpp"

namespace umov::invert {

/// A user's word on one parameter; without a wavelength it holds at all of them.
struct Setting {
  std::string name;
  std::optional<double> wavelength_nm;
  double value = 0;
};

/// New limits for one parameter, in the parameter's own unit.
struct Limits {
  std::string name;
  std::optional<double> wavelength_nm;
  double lo = 0, hi = 0;
};

/// Knowledge from elsewhere about one parameter; one term of the objective, and of the intervals.
struct Prior {
  enum class Kind {
    normal,  ///< value ± u, one sigma, in the parameter's unit
    order,   ///< the extinction at one wavelength far exceeds that at the others: a half-normal
             ///< penalty on ratio² κ² − κ(strong)², u its scale
  };
  Kind kind = Kind::normal;
  std::string name;                     ///< for an order "kappa", or "0.kappa" in a sum
  std::optional<double> wavelength_nm;  ///< order: of the strong absorption; absent: the shortest
  double value = 0;
  double u = 0.01;
  double ratio = 3;
};

enum class Objective {
  noise_weighted,  ///< sum of squared residuals over their uncertainties, robust
  paper,           ///< (P12): relative squared deviations, minimised by BFGS
};

struct Options {
  std::string model = "li-torrance";
  std::vector<std::string> share;     ///< one value for all wavelengths, whatever the model says
  std::vector<std::string> spectral;  ///< one value for each wavelength
  std::vector<Setting> fix;
  std::vector<std::string> free;  ///< fit these although the model holds them by default
  std::vector<Setting> start;
  std::vector<Limits> bound;
  std::vector<Prior> priors;  ///< with the noise-weighted objective only

  Objective objective = Objective::noise_weighted;
  double robust_sigma = 4;  ///< Huber: beyond this many sigma a residual counts linearly; 0: never
  double floor_relative = 0;  ///< model discrepancy relative to the BRDF, added to the noise
  int starts = 12;            ///< starting points, at least 1
  int threads = 1;            ///< results do not depend on it; 0: all cores
  std::uint64_t seed = 1;
  int max_iterations = 200;
  bool held_out = true;                 ///< second fit without every fifth row, for g2_held_out
  bool dhr = true;                      ///< integrate the directional-hemispherical reflectance
  std::vector<double> dhr_theta_i_deg;  ///< empty: 0 and (at most ten) of the data
  /// Told the share of the work that is done, 0 … 1, and the present stage.
  std::function<void(double, const std::string&)> progress;
};

/// Fits. Throws umov::Error where there is nothing to fit (no used point, uncertainties that are
/// not positive), where the model or a parameter's name is unknown, and where settings contradict
/// each other. The result is reproducible for a given seed and does not depend on `threads`.
formats::FitResult invert(const formats::BrdfTable& table, const Options& options);

/// A parameter as the fit will treat it, for lists and reports.
struct StartingValue {
  std::string name, unit, meaning;
  bool shared = true, fixed = false;
  double lo = 0, hi = 0;
  std::vector<double> values;  ///< one, or one for each wavelength
};
/// The best starting values found from the data, without a fit.
std::vector<StartingValue> starting_values(const formats::BrdfTable& table, const Options& options);

}  // namespace umov::invert
