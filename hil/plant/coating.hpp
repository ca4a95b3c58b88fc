// What lies on a sample: a Sample that wraps another one and passes on what it does not change.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "hil/plant/plant_config.hpp"
#include "hil/plant/sample.hpp"

namespace umov::plant {

class Coating : public Sample {
 public:
  explicit Coating(std::shared_ptr<const Sample> below) : below_(std::move(below)) {}

  const std::string& name() const override { return below_->name(); }
  Mueller mirror(const Beam& in, const Beam& out, double wavelength_nm) const override {
    return below_->mirror(in, out, wavelength_nm);
  }
  std::vector<Truth> truth(double wavelength_nm) const override {
    return below_->truth(wavelength_nm);
  }
  double feature_width_rad() const override { return below_->feature_width_rad(); }
  double emission(const Beam& in, const Beam& out, double wavelength_nm) const override {
    return below_->emission(in, out, wavelength_nm);
  }
  double slope_rms() const override { return below_->slope_rms(); }
  double surface_index(double wavelength_nm) const override {
    return below_->surface_index(wavelength_nm);
  }

 protected:
  const Sample& below() const { return *below_; }

 private:
  std::shared_ptr<const Sample> below_;
};

/// The sample with everything on it that the configuration names: marks of its surface, then water,
/// then dust. The very same object where nothing is.
std::shared_ptr<const Sample> coated(std::shared_ptr<const Sample> sample,
                                     const PlantConfig& config);

}  // namespace umov::plant
