// Where an altitude-azimuth telescope points against where its encoders say: the classical terms,
// each of which can belong to the base model or stand as an effect that the base leaves out.
//
// Errors are true minus encoder, in arc seconds on the sky: altitude E, and azimuth A times cos E.
// Terms as in the pointing models of the field (P. Wallace, "TPOINT"; J. Meeks, "Pointing
// corrections").
#pragma once

#include <string>
#include <vector>

#include "host/formats/pointing_run.hpp"
#include "host/gap/engine/forward_model.hpp"

namespace umov::gap {

class PointingModel : public ForwardModel {
 public:
  /// Offsets of both encoders are always in the base; `base_terms` names further terms that are
  /// (names()), all others are effects. Throws umov::Error for a name that does not exist and for
  /// runs of fewer than 12 stars.
  PointingModel(const formats::PointingRun& run, const std::vector<std::string>& base_terms);

  /// All terms but the encoders' offsets.
  static std::vector<std::string> names();

  const Observations& observations() const override { return observations_; }
  const std::vector<Parameter>& base() const override { return base_; }
  const std::vector<Effect>& effects() const override { return effects_; }
  void predict(const Explanation& explanation, Eigen::VectorXd& mean, Eigen::MatrixXd* jacobian,
               const std::vector<bool>& wanted = {}) const override;
  NoiseShape noise(const Eigen::VectorXd& mean) const override;
  /// A run states no noise: 1 arc second stands for an unknown one.
  bool noise_is_known() const override { return false; }

 private:
  Observations observations_;
  std::vector<Parameter> base_;
  std::vector<Effect> effects_;
  Eigen::MatrixXd base_columns_;                 ///< error for one arc second of each parameter
  std::vector<Eigen::MatrixXd> effect_columns_;  ///< likewise, one matrix an effect
};

}  // namespace umov::gap
