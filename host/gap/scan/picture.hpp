// What a page or a figure shows of a diagnosis: for every record what was measured, what the base
// and the best explanation say, and what each cause does.
#pragma once

#include <string>
#include <vector>

#include "host/gap/engine/alternatives.hpp"
#include "host/gap/engine/diagnosis.hpp"
#include "host/gap/scan/record.hpp"
#include "host/gap/scan/scan_model.hpp"

namespace umov::gap::scan {

/// In phase and quadrature of every record, volts referred to range 1.
struct Signals {
  std::vector<double> x_v, y_v;
};

/// What an effect of the best explanation does: the best prediction less one without the effect.
struct Contribution {
  Effect effect;
  bool named = false;  ///< among the diagnosis' causes; others fit but are not sure enough
  /// All else as it is in the best explanation: what the effect does by itself.
  Signals held;
  /// All else fitted anew without the effect: what nothing but the effect explains.
  Signals refitted;
  double delta_chi2 = 0;  ///< lost without it, all else fitted anew
};

struct Picture {
  std::vector<double> wavelengths_nm;
  /// Every record of the scans that the simulation can foretell; saturated ones, which the
  /// diagnosis does not use, are among them.
  std::vector<Record> records;
  Signals measured, base, best;
  /// Standard deviation of a record with all its noise, the slow part included.
  Signals sigma;
  std::vector<Contribution> contributions;
  std::vector<Alternative> alternatives;
  /// The cause that scatters, where one is named.
  std::optional<Effect> scatter;
};

Picture picture_of(const ScanModel& model, const Diagnosis& diagnosis, int threads);

}  // namespace umov::gap::scan
