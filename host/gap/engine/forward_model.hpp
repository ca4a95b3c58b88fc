// What the diagnosis needs of a simulation: its parameters, the effects it could have but leaves
// out, its prediction with any of them switched on, and the measurement it is compared with.
//
// The engine in this folder knows nothing else. A goniometer scan, a telescope's pointing run, a
// luminance map are adapters: classes that implement ForwardModel.
#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "host/gap/engine/noise.hpp"

namespace umov::gap {

/// One number of the base model or of an effect.
struct Parameter {
  std::string name, unit, meaning;
  double absent = 0;  ///< an effect does nothing here; of a base parameter the value to start from
  double lo = -std::numeric_limits<double>::infinity();
  double hi = std::numeric_limits<double>::infinity();
  /// One sigma of what is known beforehand about `absent`: for an effect its size on benches of the
  /// kind, for a base parameter a certificate. Infinite: nothing (base parameters only).
  double prior_u = std::numeric_limits<double>::infinity();
  /// Does nothing by itself: a phase, a width of what another parameter scales.
  bool shape = false;
  /// One of a few values that the probes name (a wavelength): never fitted.
  bool choice = false;
};

/// A vector of parameter values of one effect, small enough that the effect is near linear there.
using Probe = std::vector<double>;

/// A cause that the base model leaves out.
struct Effect {
  std::string name;     ///< canonical, as in files and on command lines
  std::string stage;    ///< where it sits: geometry, polarisation, detector …
  std::string physics;  ///< a sentence or two
  std::string source;
  std::vector<Parameter> parameters;  ///< the principal one first
  /// Members of one family share `name`; this tells them apart ("ggx"). Empty for most.
  std::string family = {};
  /// Part of the model's own structure rather than a small error: tried before all others where the
  /// base misses by far.
  bool structural = false;
  /// Of what is measured, not of the instrument.
  bool of_object = false;
  /// Grows in proportion to its parameters from where it is absent: its derivatives there are its
  /// signatures.
  bool linear = false;
  /// Adds to the scatter and nothing to the mean: errors in proportion to the signal, fixed to the
  /// place that is looked at and independent from place to place. One parameter, their standard
  /// deviation over the signal; no probes.
  bool scatter = false;
  /// The effect's possible signatures. Probes of one group act together (sine and cosine of an
  /// unknown phase); groups are alternatives (values of a parameter that shapes the signature).
  std::vector<std::vector<Probe>> probes = {};
};

/// The base model with some effects switched on.
struct Explanation {
  std::vector<std::size_t> effects;  ///< numbers in ForwardModel::effects(), ascending
  std::vector<double> base;
  std::vector<std::vector<double>> alpha;  ///< parameter values, one vector an effect
};

/// A coordinate along which a gap may lie, such as an angle or the time.
struct Axis {
  std::string name, unit;
  std::vector<double> value;  ///< one an observation
};

/// Something that an observation was made under and that no effect's size should depend on: the
/// time, a setting, a direction of travel.
struct Circumstance {
  Axis axis;
  /// What is measured (not the instrument) may well depend on it.
  bool of_object = false;
  /// Stage whose errors may repeat many times over its range (gears, graduations); empty: none.
  std::string repeats_in = {};
  /// Values that are names rather than numbers ("open").
  std::vector<std::pair<double, std::string>> names = {};
};

struct Observations {
  Eigen::VectorXd value;
  /// Observations with the same number are neighbours that share errors (a row of a scan): they are
  /// withheld together.
  std::vector<int> row;
  std::vector<Axis> axes;
  std::vector<int> channel;           ///< such as the polarisation channel
  std::vector<std::string> channels;  ///< their names
  std::vector<Circumstance> circumstances;
};

/// Immutable while a diagnosis runs.
class ForwardModel {
 public:
  virtual ~ForwardModel() = default;
  virtual const Observations& observations() const = 0;
  virtual const std::vector<Parameter>& base() const = 0;
  virtual const std::vector<Effect>& effects() const = 0;
  /// Base parameters to start fits from, besides the declared ones: a base may have several minima.
  virtual std::vector<std::vector<double>> further_starts() const { return {}; }
  /// What the measurement should read. `jacobian`, where asked for: one row an observation, columns
  /// base parameters, then those of each effect in order. Columns that `wanted` (one flag each,
  /// empty: all) does not ask for are zero.
  virtual void predict(const Explanation& explanation, Eigen::VectorXd& mean,
                       Eigen::MatrixXd* jacobian, const std::vector<bool>& wanted = {}) const = 0;
  /// The same model looking at about `most` of its observations, spread evenly, to find the way by;
  /// null where it is not larger than that.
  virtual std::unique_ptr<ForwardModel> thinned(std::size_t most) const {
    static_cast<void>(most);
    return nullptr;
  }
  /// Do predictions with derivatives cost so little that every refit may have its own?
  virtual bool is_quick() const { return false; }
  /// Noise of the observations whose expectation is `mean`.
  virtual NoiseShape noise(const Eigen::VectorXd& mean) const = 0;
  /// False: the white part of noise() is right up to a common factor, which the engine estimates
  /// from what the whole catalogue together leaves.
  virtual bool noise_is_known() const { return true; }
};

}  // namespace umov::gap
