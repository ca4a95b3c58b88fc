// A sample measured in and out of the plane of incidence: models are fitted to the in-plane rows
// alone and have to foretell the others, beside interpolations of the same rows.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host/cli/study/foretelling.hpp"
#include "host/cli/study/study.hpp"
#include "host/formats/brdf_table.hpp"
#include "host/formats/mueller_table.hpp"

namespace umov::study {

/// Unpolarised BRDF at one direction and wavelength, point by point.
struct TrialPoints {
  std::vector<double> wavelength_nm, brdf_per_sr, relative_u;
  std::vector<Direction> direction;
  std::vector<std::array<double, 16>>
      normalised;                     ///< m_ij/f11 where a polarimeter measured, or empty
  std::vector<std::size_t> in_plane;  ///< indices of the points that may be used
  std::vector<std::size_t>
      judged;  ///< out of plane; normal incidence, where that means nothing, not
  std::size_t size() const { return brdf_per_sr.size(); }
};

struct Trial {
  std::string name;  ///< "garnet red"
  TrialPoints points;
  /// In-plane rows as the fit takes them: of some wavelengths together, and, where the others are
  /// fitted alone with the shared parameters of that fit, of every wavelength.
  formats::BrdfTable joint;
  std::vector<formats::BrdfTable> alone;
  /// By wavelength, added to the uncertainties in quadrature; empty where the data's own stand.
  std::map<double, double> scatter_per_sr;
};

/// The four states PP, PS, SP, SS in plane at all wavelengths.
Trial polarimeter_trial(const std::string& name, const formats::MuellerTable& table);
/// Unpolarised rows; the joint fit takes every seventh wavelength, beginning with the second.
Trial unpolarised_trial(const std::string& name, const formats::BrdfTable& table);

/// A model of the library, or an interpolation, on a trial.
struct Attempt {
  std::string name;
  enum class Kind { no_lobe, one_lobe, several, interpolation } kind = Kind::no_lobe;
  std::size_t parameters = 0;          ///< of the joint fit
  std::optional<double> in_plane_bic;  ///< N ln s² + k ln N of the joint fit
  std::vector<double> foretold;        ///< one a point, 1/sr
  /// The same times what it leaves in plane, measured/fitted interpolated over (θh, θd).
  std::vector<double> with_remainder;
  std::vector<std::array<double, 16>> normalised;  ///< as in TrialPoints; may be empty
  std::string failure;                             ///< why there is no result
};

/// "no lobe", "one lobe", "several lobes", "interpolation".
const char* kind_name(Attempt::Kind kind);

/// Models that the study tries where the user names none.
std::vector<std::string> trial_models();
/// Fits one model. Deterministic for a seed; failures are in the attempt. Throws Stopped.
Attempt try_model(const Trial& trial, const std::string& model, const Options& options);
/// Nearest neighbours and plane in (θh, θd), curves over the angle to the mirror direction.
std::vector<Attempt> interpolations(const Trial& trial);

}  // namespace umov::study
