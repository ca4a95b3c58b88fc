// The parts of a diagnosis page's data. Included by .cpp files only.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/gap/scan/picture.hpp"
#include "host/report/diagnosis_page.hpp"

namespace umov::report {

using Json = nlohmann::ordered_json;

/// The records of a picture as figures sort them.
struct Scene {
  const gap::scan::Picture* picture = nullptr;
  std::vector<std::string> channels;  ///< "P → S", in the order of the first record of each
  std::vector<std::size_t> channel;   ///< one a record
  /// What differs from the plain scan in the plane of incidence: "φr = 30°", "sample turned". The
  /// first is the plain scan's and empty.
  std::vector<std::string> setups;
  std::vector<std::size_t> setup;  ///< one a record
  /// Of travel, where rows were measured in both directions, most of them; else 0. One a record.
  std::vector<int> direction;

  double theta_i_deg(std::size_t record) const;
  double theta_r_deg(std::size_t record) const;
};

Scene scene_of(const gap::scan::Picture& picture);

/// A record's residual in units of its noise: (measured − model)/σ, in phase or in quadrature.
double normalised(const gap::scan::Picture& picture, std::size_t record, bool quadrature,
                  bool after);
/// One σ in per cent of the signal in phase; NaN where there is next to no signal.
double percent_per_sigma(const gap::scan::Picture& picture, std::size_t record, bool quadrature);

/// {wavelengths_nm, channels, clip_sigma, clip_percent, sets:[{title, theta_r_deg:{fine, coarse},
/// rows, panels:[{wavelength_nm, channel, x:{fine:{before, after, scale}, coarse}, y,
/// saturated}]}]}: residuals over θi and θr, single records and neighbours joined.
Json residual_maps(const Scene& scene);
/// {record, before, after, u}: mean relative deviation in the order of measurement, per cent.
Json residual_trace(const Scene& scene);
/// What each effect of the best explanation does, along the axis where it shows best.
Json signatures(const Scene& scene);

/// Causes as bars, ambiguity sets as one; their parameters; rivals' parameters. `declared`: effects
/// among which are those of the causes, for their physics and meanings.
Json causes_json(const gap::Diagnosis& diagnosis, const std::vector<gap::Effect>& declared,
                 const std::vector<gap::Alternative>& alternatives);
/// A fact for the head of the page: the share of the gap that the causes close, with its interval.
Json closed_fact(const gap::Diagnosis& diagnosis);
/// [{menu, words, separates, separation, minutes}]
Json next_json(const gap::Diagnosis& diagnosis);

/// What the page has of every diagnosis, of whatever: program, verdict, gap, where, what is left,
/// base. `created`: UTC, ISO 8601; empty: now.
Json data_of_any(const gap::Diagnosis& diagnosis, const gap::AnswerSource& source,
                 const std::string& created);

}  // namespace umov::report
