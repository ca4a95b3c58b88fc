// Helmholtz reciprocity (P6) of a reduced measurement: directions exchanged, polarisation too.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "host/formats/brdf_table.hpp"

namespace umov::calibrate {

/// Two measured points that reciprocity makes equal; rows of the table.
struct ReciprocalPair {
  std::size_t forth = 0, back = 0;
  double deviation = 0;    ///< ln(f_forth/f_back)
  double deviation_u = 0;  ///< what the two points do not share
};

struct Reciprocity {
  std::string sample;
  double wavelength_nm = 0;  ///< 0 = all together
  std::size_t pairs = 0;
  double mean = 0, mean_u = 0;  ///< relative deviation, forth over back (larger θi first)
  double mean_absolute = 0;     ///< what a "mean error" usually means
  double rms = 0;
  double rms_expected = 0;  ///< that the uncertainties alone would give
  double largest = 0;       ///< of either sign
  double largest_theta_i_deg = 0, largest_theta_r_deg = 0;
  double chi2 = 0;  ///< with the full covariance of the differences, `pairs` degrees of freedom
};

struct ReciprocityOptions {
  double within_deg = 60;       ///< largest polar angle of either direction
  double tolerance_deg = 0.05;  ///< within which directions count as the same
};

/// Pairs of used points with exchanged directions and states: f^{jk}(θi → θr, φ) and f^{kj}(θr →
/// θi, φ), j and k the axes of polariser and analyser; an axis other than p and s counts with its
/// sign turned, as U does, and only in plane. Points without a counterpart and points in the plane
/// of exchange (θi = |θr|, equal to themselves) have no pair. An open beam pairs with an open
/// analyser only.
std::vector<ReciprocalPair> reciprocal_pairs(const formats::BrdfTable& table,
                                             const ReciprocityOptions& options = {});

/// Deviations of all pairs together and by wavelength (first entry: all); empty without pairs.
/// Uncertainties follow from noise and the factors of the table: what both points share drops out.
std::vector<Reciprocity> check_reciprocity(const formats::BrdfTable& table,
                                           const ReciprocityOptions& options = {});

/// Departure of a standard from Lambert's law, found from its own scan that was reduced as if it
/// obeyed it. The instrument function then holds the standard's fall towards grazing exit and takes
/// it out of all light that leaves, but not out of the light that arrives: exchanged directions
/// disagree by ln(1 + a s(θi)) - ln(1 + a s(θr)), s = ReferenceStandard::shape, whatever the
/// standard's BRDF and the instrument function are.
struct StandardShape {
  double amplitude = 0;  ///< a
  double u = 0;          ///< scatter of the pairs, and a tenth of |a| as the true curve is another
  std::size_t pairs = 0;
};

/// `prior_u`: what is known of a beforehand, about zero. nullopt with fewer than ten pairs.
std::optional<StandardShape> find_standard_shape(const formats::BrdfTable& table, double prior_u);

}  // namespace umov::calibrate
