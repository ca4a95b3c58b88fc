// A reduced measurement in memory: polarised BRDF, DOLP and DHR with uncertainties (brdf.h5).
#pragma once

#include <cstddef>
#include <optional>
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

  /// Mueller BRDF by direction: the linear 3 × 3 part (I, Q, U), or all 4 × 4 elements.
  struct Mueller {
    int side = 3;  ///< 3 or 4
    std::vector<double> theta_i_deg, theta_r_deg, phi_r_deg, wavelength_nm;
    /// Elements row by row, side² a direction, 1/sr; NaN where the states do not determine one.
    std::vector<double> mueller;
    std::vector<double> mueller_u;  ///< of the same shape: all that is uncertain, one sigma
    /// Covariance of a direction's elements in (1/sr)², its upper triangle row by row, side² (side²
    /// + 1)/2 a direction; rows and columns of undetermined elements are NaN. Empty: unknown, or
    /// none beside the diagonal.
    std::vector<double> covariance;
    std::vector<double> condition;  ///< of the states' design for the determined elements
    std::vector<double> chi2, dof;  ///< of the overdetermined fit; dof 0 = nothing to compare
    /// Least eigenvalue of the coherency matrix over its own standard error, at the best completion
    /// to 4 × 4: below zero the table is no physical Mueller matrix by so many standard errors. NaN
    /// where elements are missing.
    std::vector<double> realisable_z;

    std::size_t size() const { return theta_i_deg.size(); }
    std::size_t elements() const { return static_cast<std::size_t>(side * side); }
    std::size_t packed() const { return elements() * (elements() + 1) / 2; }
    /// Place of element (row, column) of the covariance of direction `n`.
    std::size_t covariance_at(std::size_t n, std::size_t row, std::size_t column) const;
  };
  std::optional<Mueller> mueller;
};

}  // namespace umov::formats
