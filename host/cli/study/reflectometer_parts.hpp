// The parts of the study `reflectometer`, one section of the page each.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/calibrate/campaign.hpp"
#include "host/calibrate/reduce.hpp"
#include "host/cli/study/bench.hpp"
#include "host/cli/study/page.hpp"
#include "host/cli/study/study.hpp"
#include "host/formats/brdf_table.hpp"

namespace umov::study {

/// A scan of the study: its file's name, the plan and the sample.
struct StudyScan {
  const char* name;
  const char* plan;
  const char* sample;
  double share;  ///< of all measuring
};

/// What the operator of such a bench would declare of it from data sheets and alignment, one
/// standard deviation each, and the size of the detector disc.
calibrate::DeclaredDoubts declared_doubts();

/// The calibrated instrument, with the scans that were measured on it.
struct CalibratedBench {
  Bench& bench;
  calibrate::Campaign campaign;       ///< white standard with its certified table
  calibrate::Calibration lambertian;  ///< the paper's way: the standard counts as Lambertian
  std::vector<Target> targets;        ///< filled by the sections

  /// A scan by its name, reduced with the campaign's calibration.
  formats::BrdfTable reduced(const std::string& name,
                             const calibrate::ReduceOptions& options = {}) const;
};

/// Table 2 and figure 6: reflectance standards and instrument function.
void add_standards(Page& page, CalibratedBench& at);
/// Polariser axes and extinction from the germanium wafer, reciprocity.
void add_polarizers_and_reciprocity(Page& page, CalibratedBench& at);
/// Figure 8: BRDF and DOLP of three black paints.
void add_black_paints(Page& page, CalibratedBench& at);
/// Tables 3 and 4, figures 9 and 11, and the fitted model against the truth. `progress` and
/// `threads` of the options.
void add_red_paint(Page& page, CalibratedBench& at, const Options& options);

/// "1.23 %"
std::string percent(double share, int digits = 2);
/// A reflectance with so many decimals and without the leading zero's noise: "0.653".
std::string fixed(double value, int digits = 3);
/// "0.653 ± 0.002"
std::string with_u(double value, double u, int digits = 3);

}  // namespace umov::study
