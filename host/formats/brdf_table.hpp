// A reduced measurement in memory: polarised BRDF, DOLP and DHR with uncertainties (brdf.h5).
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace umov::formats {

/// One-sigma uncertainties `*_u` hold the part that is independent from point to point; what
/// calibration couples is in `factors`.
struct BrdfTable {
  std::vector<std::pair<std::string, std::string>> keys;  ///< provenance and header keys

  struct Points {
    std::vector<double> theta_i_deg, theta_r_deg, phi_r_deg, wavelength_nm;
    std::vector<double> polarizer_deg, analyzer_deg;  ///< formats::open_axis = open
    std::vector<double> brdf_per_sr, brdf_u;          ///< 1/sr
    std::vector<int> used;  ///< 0: flagged (saturated, below the noise …)
    std::size_t size() const { return brdf_per_sr.size(); }
  } points;

  /// Low-rank covariance: cov = diag(brdf_u^2) + sum_k F_k F_k^T; each F_k has one entry a point,
  /// in 1/sr, for one standard deviation of the calibration quantity named.
  struct Factor {
    std::string name;  ///< such as "gain 532 nm"
    std::vector<double> per_point;
  };
  std::vector<Factor> factors;

  struct Dolp {
    std::vector<double> theta_i_deg, theta_r_deg, phi_r_deg, wavelength_nm, dolp, dolp_u;
  } dolp;

  struct Dhr {
    std::vector<double> wavelength_nm, theta_i_deg, dhr, dhr_u;
  } dhr;
};

}  // namespace umov::formats
