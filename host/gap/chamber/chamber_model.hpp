// A measured luminance map of a luminaire against its simulation: what of the luminaire or its
// materials the simulation has wrong, from the map alone.
//
// Linear about the simulation: a map plus the sum of its changes (map_signatures.hpp).
#pragma once

#include <memory>
#include <vector>

#include "host/gap/chamber/map_signatures.hpp"

namespace umov::gap {

class ChamberModel : public ForwardModel {
 public:
  /// `measured`: taken with the camera of the signatures and joined as they are, its standard
  /// errors those of the measurement. Throws umov::Error for a map of another size.
  ChamberModel(std::shared_ptr<const MapSignatures> signatures, const chamber::Map& measured);

  const Observations& observations() const override { return observations_; }
  const std::vector<Parameter>& base() const override { return base_; }
  const std::vector<Effect>& effects() const override { return effects_; }
  void predict(const Explanation& explanation, Eigen::VectorXd& mean, Eigen::MatrixXd* jacobian,
               const std::vector<bool>& wanted = {}) const override;
  NoiseShape noise(const Eigen::VectorXd& mean) const override;
  const MapSignatures& signatures() const { return *signatures_; }

 private:
  std::shared_ptr<const MapSignatures> signatures_;
  Observations observations_;
  std::vector<Parameter> base_;
  std::vector<Effect> effects_;
  Eigen::VectorXd sigma_;
};

}  // namespace umov::gap
