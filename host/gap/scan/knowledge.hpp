// What is known before a diagnosis: of the instrument by its calibration, of its alignment by
// declared tolerances, of the sample by an earlier fit.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "host/calibrate/calibration.hpp"
#include "host/formats/fit_file.hpp"
#include "host/gap/engine/forward_model.hpp"
#include "host/gap/scan/effect_list.hpp"
#include "host/gap/scan/record.hpp"

namespace umov::gap::scan {

/// A declared limit of one parameter of an effect: how well the bench was aligned.
struct Tolerance {
  std::string effect, parameter;
  double u = 0;      ///< one standard deviation: the parameter's prior
  double limit = 0;  ///< sizes up to this one are within the tolerance
  std::string file;  ///< where it was declared, for messages
  std::size_t line = 0;
};

struct Knowledge {
  /// Gains, instrument function, dark, phase, ranges, detector law, stray light, polarisation.
  std::shared_ptr<const calibrate::Calibration> calibration;
  std::vector<Tolerance> tolerances;
  /// The simulation: its model, and values that the base parameters start from.
  std::shared_ptr<const formats::FitResult> fit;
  bool hold_fit = false;  ///< the base's parameters stay at the fit's values; gains are free
};

/// An effect that a calibration knows: on from the start, at its value at each wavelength of the
/// scan. Where it stands as a cause, its parameters say what goes beyond that, but for shapes,
/// which are held at what is known.
struct KnownEffect {
  std::size_t effect = 0;
  std::vector<std::vector<double>> value;  ///< by wavelength, one number a parameter
};

/// What a calibration knows of the effects, in the order of `effects`, whose priors become its
/// uncertainties, but no less than a tenth of what is usual (calibrations age) and no more than
/// that. Values that are less than two of their own uncertainties count as none. Declared doubts of
/// the bench become priors as they stand. `limits` gets what each may be off by: two uncertainties.
/// `records` get a note of what is known. Throws umov::Error where the calibration lacks a
/// wavelength of theirs.
std::vector<KnownEffect> know_effects(const calibrate::Calibration& calibration,
                                      ScanRecords& records, std::vector<Effect>& effects,
                                      std::vector<Tolerance>& limits);

/// Takes out of the records what acts on each of them by itself: dark signals, the instrument
/// function, what the monitor does not see of a polarisation. Records where the detector may stand
/// in the beam are left out. Gain constants and their uncertainties become the calibration's.
void correct_records(const calibrate::Calibration& calibration, ScanRecords& records);

/// A fit with the wavelengths of a scan, in their order. Throws umov::Error for a wavelength that
/// the fit does not have.
formats::FitResult fit_at(const formats::FitResult& fit, const std::vector<double>& wavelengths_nm);

/// Priors of the parameters become the declared ones. Throws umov::Error, with the names there are,
/// for an effect or a parameter that does not exist.
void apply_tolerances(const std::vector<Tolerance>& tolerances, std::vector<Effect>& effects);

/// Switches known effects on for a record of this wavelength: beside what `on` has, or added to it.
/// `store` keeps the values that `on` then points to.
template <class T>
void add_known(const std::vector<KnownEffect>& known, const std::vector<Effect>& effects,
               std::size_t wavelength, Switched<T>& on, std::vector<T>& store) {
  std::size_t size = 0;
  for (const KnownEffect& k : known) size += k.value[wavelength].size();
  store.resize(size);  // once: no pointer into it may move
  T* next = store.data();
  for (const KnownEffect& k : known) {
    const std::vector<double>& value = k.value[wavelength];
    const T* beyond = on.values[k.effect];
    on.values[k.effect] = next;
    for (std::size_t i = 0; i < value.size(); ++i, ++next) {
      if (beyond == nullptr) {
        *next = T(value[i]);
      } else {
        *next = effects[k.effect].parameters[i].shape ? beyond[i] : T(beyond[i] + value[i]);
      }
    }
  }
}

}  // namespace umov::gap::scan
