// A polished wafer or metal mirror: Fresnel reflection in the mirror direction and nothing else.
#pragma once

#include <string>
#include <vector>

#include "hil/plant/sample.hpp"
#include "host/optics/refractive_index.hpp"

namespace umov::plant {

class MirrorSample final : public Sample {
 public:
  MirrorSample(std::string name, optics::IndexTable index);

  const std::string& name() const override { return name_; }
  Mueller brdf(const Beam& in, const Beam& out, double wavelength_nm) const override;
  /// Throws umov::Error outside the range of the index table.
  Mueller mirror(const Beam& in, const Beam& out, double wavelength_nm) const override;
  std::vector<Truth> truth(double wavelength_nm) const override;

 private:
  std::string name_;
  optics::IndexTable index_;
};

}  // namespace umov::plant
