// The effects of a gonioreflectometer scan by number, and how the signal chain asks for them.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "host/gap/engine/forward_model.hpp"

namespace umov::gap::scan {

enum class EffectId : std::size_t {
  incidence_zero,
  detector_zero,
  sample_tilt_in_plane,
  sample_tilt_out_of_plane,
  detector_eccentricity,
  backlash,
  polarizer_leakage,
  analyzer_leakage,
  polarizer_rotation,
  analyzer_rotation,
  detector_polarization_bias,
  detector_nonlinearity,
  detector_saturation,
  dark_offset,
  stray_light,
  stray_forward,
  low_signal_pedestal,
  gain_ratio_error,
  lockin_phase,
  finite_aperture,
  beam_divergence,
  laser_drift,
  laser_warmup,
  wavelength_error,
  laser_crosstalk,
  beam_overfill,
  detector_underfill,
  retro_occlusion,
  dust,
  water_film,
  water_drops,
  near_specular_lobe,
  retroreflection_peak,
  fluorescence,
  speckle,
  long_tails,
  wave_lobe,
  second_roughness,
  forward_lobe,
  volume_diffuse,
  interface_diffuse,
  polarised_diffuse,
  free_slopes,
  fine_slopes,
  free_lobe,
  spectral_lobe,
  free_diffuse,
  spectral_diffuse,
  azimuthal_diffuse,
  anisotropic_slopes,
  count
};

inline constexpr std::size_t effect_count = static_cast<std::size_t>(EffectId::count);

constexpr std::size_t number(EffectId id) {
  return static_cast<std::size_t>(id);
}

/// Series whose sum is all that their coefficients act by.
enum class SeriesId : std::size_t {
  slopes,
  fine_slopes,
  growth,
  spectral_lobe,
  diffuse_shape,
  kept,
  spectral_diffuse,
  count
};

inline constexpr std::size_t series_count = static_cast<std::size_t>(SeriesId::count);

/// Parameter values of the effects that are switched on; null elsewhere.
template <class T>
struct Switched {
  std::array<const T*, effect_count> values{};
  /// Added to the sum of a series: its derivative is that of every coefficient, over its term.
  std::array<const T*, series_count> lift{};
  std::size_t wavelengths = 0;  ///< of the scan: effects with a number for each begin with these
  const T* operator[](EffectId id) const { return values[number(id)]; }
};

/// What probes must be sized for.
struct Scale {
  std::vector<double> wavelengths_nm;
  double largest_signal_v = 1;  ///< referred to range 1
  double typical_adc_v = 0.1;   ///< median size of a signal at the ADC
  double duration_s = 3600;
  double slope_rms = 0.1;     ///< of the base's lobe
  bool out_of_plane = false;  ///< some directions leave the plane of incidence
};

/// All effects in the order of EffectId.
std::vector<Effect> catalogue(const Scale& scale);

/// The canonical name of the members of the catalogue that make the reflectance model itself
/// richer; their own names are its families.
inline constexpr const char* sample_model = "sample_model";

}  // namespace umov::gap::scan
