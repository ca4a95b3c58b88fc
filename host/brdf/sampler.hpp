// Importance sampling of a model: where does light that comes in at θi leave, with which
// probability, and what is it then worth?
//
// Made for ray tracing: a Sampler is prepared once (milliseconds; some .1 s for he-torrance,
// li-torrance and others that tabulate their lobes), then draws without allocating,
// and may be shared by any number of threads. Random numbers come from outside.
//
// Which model is drawn how, and how much its weights scatter: docs/models.md.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "host/brdf/facet.hpp"
#include "host/brdf/model.hpp"
#include "host/optics/mueller.hpp"

namespace umov::brdf {

/// A model's parameters at one wavelength.
struct SpectralValues {
  std::vector<double> values;  ///< in the order of model.parameters()
  double wavelength_um;        ///< vacuum wavelength
};

/// Light that leaves.
struct Sample {
  Geometry<double> geometry;       ///< θi as given, θr in [0, π/2), φr in (-π, π]; radians
  optics::Vec3<double> direction;  ///< the same as a unit vector; x in the plane of incidence
  bool mirror = false;             ///< exactly in the mirror direction: the mirror part alone
  double density = 0.0;            ///< per steradian; with `mirror`, a probability
  optics::Mueller<double> weight;  ///< BRDF · cos θr/density, or mirror reflectance/density
};

class Sampler {
 public:
  /// Throws umov::Error for values out of range and for a tabulated model without its table.
  Sampler(const Model& model, std::vector<double> values, double wavelength_um);
  /// One distribution of directions for several wavelengths, after the mean of their BRDFs: a ray
  /// can carry them all. `spectrum` must not be empty.
  Sampler(const Model& model, std::vector<SpectralValues> spectrum);

  /// `theta_i` in [0, π/2), radians; u1, u2, u3 independent and uniform in [0, 1): u1 and u2 place
  /// the direction, u3 chooses among the parts of the model (stratify it last). `weight` is for
  /// wavelength number `wavelength`.
  ///
  /// Nothing is returned when the drawn facet sends the light below the horizon (or the model
  /// reflects nothing): such a draw counts with weight 0, and then the mean of weight · Stokes over
  /// all draws is the reflected power, dhr() + mirror_dhr().
  std::optional<Sample> sample(double theta_i, double u1, double u2, double u3,
                               std::size_t wavelength = 0) const;

  /// Density per steradian with which sample() gives this direction other than as `mirror`. Over
  /// the hemisphere it integrates to 1 - mirror_probability() - the probability of nothing.
  double pdf(const Geometry<double>& geometry) const;
  /// Probability of a sample with `mirror` set.
  double mirror_probability(double theta_i) const;

  /// The weight of a sample at another wavelength.
  optics::Mueller<double> weight(const Sample& sample, std::size_t wavelength) const;

  const Model& model() const;
  const std::vector<SpectralValues>& spectrum() const;

 private:
  struct Prepared;
  std::shared_ptr<const Prepared> prepared_;
};

}  // namespace umov::brdf
