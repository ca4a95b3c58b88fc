// What every effect of the catalogue does to a scan, and what of it a refit of the base leaves.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/gap/engine/forward_model.hpp"
#include "host/gap/engine/refit.hpp"
#include "host/gap/scan/scan_model.hpp"

namespace umov::study {

/// An effect at its usual size.
struct EffectSignature {
  const gap::Effect* effect = nullptr;
  std::vector<double> alpha;  ///< the size drawn
  /// Change of every observation in units of its noise: X of all records, then Y.
  Eigen::VectorXd alone;  ///< all else held; empty where this scan has no place for the effect
  Eigen::VectorXd left;   ///< base parameters fitted anew, to first order
  double size = 0;        ///< length of `left`; 0 where a refit takes up all of it
  /// Effects whose `left` points the same way, with the cosine, most alike first.
  struct Alike {
    std::string name;
    double cosine;
  };
  std::vector<Alike> alike;
};

/// In the order of the catalogue. `at`: the base fitted to the scan.
std::vector<EffectSignature> effect_signatures(const gap::scan::ScanModel& model,
                                               const gap::Refit& at,
                                               const gap::Whitening& whitening, int threads);

/// Name of an effect with its family: "sample_model (ggx)".
std::string full_name(const gap::Effect& effect);

}  // namespace umov::study
