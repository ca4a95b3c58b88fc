// Any model of the library as a face of a luminaire, unpolarised.
#pragma once

#include <optional>

#include "host/brdf/sampler.hpp"
#include "host/chamber/facing.hpp"

namespace umov::chamber {

/// Where the sampler holds several wavelengths, directions are drawn after their mean; values are
/// those of the first.
struct Modelled {
  brdf::Sampler sampler;

  class Facing {
   public:
    Facing(const Modelled& surface, const Vec3& known, Sense sense)
        : surface_(surface), known_(known), sense_(sense) {}
    double value(const Vec3& other, std::size_t wavelength = 0) const;
    double density(const Vec3& other) const;
    std::optional<Drawn> draw(double u1, double u2, double u3) const;
    double mirror(std::size_t wavelength = 0) const;
    double mirror_probability() const;

   private:
    const Modelled& surface_;
    const Vec3& known_;
    Sense sense_;
  };
};

}  // namespace umov::chamber
