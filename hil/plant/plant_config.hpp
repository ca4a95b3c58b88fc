// All parameters of the emulated instrument's physics, in one tree.
//
// Every imperfection is zero in `ideal_config()` and has the size of a real bench in
// `realistic_config()`. Units are in the names; "zero" in a comment says what the value 0 means
// where that is not plain. Volts are lock-in volts referred to amplifier range 1: the amplitude of
// the fundamental of the modulated signal. Names as in "laser.532.drift_per_hour"
// (parameter_list.hpp) set single values from files and command lines.
#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace umov::plant {

inline constexpr int axis_count = 6;
/// Names of the axes, in the order of the board's outputs.
inline constexpr std::array<const char*, axis_count> axis_names = {
    "incidence", "detector", "azimuth", "polarizer", "analyzer", "filter"};
inline constexpr int laser_count = 3;
inline constexpr std::array<int, laser_count> laser_names = {532, 633, 814};

/// Errors of a rotary stage: true angle = commanded angle + the sum of these.
struct AxisErrors {
  double zero_deg = 0.0;  ///< zero offset; of polariser and analyser it turns the axis, p towards s
  double backlash_deg =
      0.0;  ///< whole play between motor and stage; error -direction·play/2 once taken up
  double eccentricity_deg = 0.0;        ///< amplitude of one cycle per stage turn
  double eccentricity_phase_deg = 0.0;  ///< error = A sin(angle + phase)
  double encoder_deg = 0.0;             ///< amplitude of two cycles per stage turn
  double encoder_phase_deg = 0.0;
  double gear_deg = 0.0;  ///< amplitude of the sharp error at `gear_cycles` per motor turn
  double gear_phase_deg = 0.0;
  double gear_cycles = 4.0;     ///< cycles per motor turn
  double gear_ratio = 180.0;    ///< motor turns per stage turn
  double standstill_deg = 0.0;  ///< rms of a random offset drawn anew at each arrival
};

/// One laser with its fibre, polarisation and detection chain.
struct LaserConfig {
  double wavelength_nm = 633.0;      ///< nominal vacuum wavelength
  double gain_constant_v = 800.0;    ///< C_λ: signal per (BRDF·cos θr·ΔΩ·monitor)
  double monitor_v = 1.5;            ///< monitor signal with polariser and filter out of the beam
  double wavelength_error_nm = 0.0;  ///< true minus nominal
  double line_width_nm = 0.0;        ///< rms width of the line
  double drift_per_hour =
      0.0;  ///< relative change of the light on the sample that the monitor misses
  double power_drift_per_hour = 0.0;  ///< relative change of power that the monitor sees
  double warmup = 0.0;                ///< relative lack of power at time 0 that the monitor misses
  double power_warmup = 0.0;          ///< the same, seen by the monitor
  double warmup_tau_s = 600.0;        ///< its time constant
  double power_noise = 0.0;  ///< rms slow power noise, 1/f from 1e-4 to 20 Hz, seen by the monitor
  double unseen_noise =
      0.0;  ///< rms slow noise of the sample's light that the monitor misses (pointing)
  double sample_noise = 0.0;  ///< rms power noise per ADC sample, white, seen by the monitor
  double polarization =
      0.0;  ///< degree of linear polarisation before the polariser; 0 = unpolarised
  double polarization_deg = 0.0;  ///< its axis, from p towards s
  /// Share of the other lasers' light in this laser's beam, relative to their full power.
  std::array<double, laser_count> crosstalk_from = {0.0, 0.0, 0.0};
};

/// The beam between source and sample.
struct BeamConfig {
  double divergence_rms_deg = 0.0;  ///< per axis, Gaussian
  double over_sample = 0.0;  ///< 1/e² radius over the sample's radius; 0 = all light on the sample
};

/// Polariser or analyser. Axis errors are the axis' own.
struct PolarizerConfig {
  double extinction = 0.0;  ///< power ratio crossed/parallel
};

struct FilterConfig {
  double density_error =
      0.0;  ///< relative error of the optical densities (the monitor sees the true power)
};

/// The filter that an operator puts before the detector to tell fluorescence from reflection.
struct LongPassConfig {
  double edge_nm = 570.0;      ///< shorter wavelengths are blocked
  double transmittance = 1.0;  ///< above the edge
  double leak = 0.0;           ///< below it
};

struct MonitorConfig {
  double polarization_bias = 0.0;  ///< response to (1, δ, 0, 0), + favours s
  double phase_deg = 0.0;          ///< electronic phase, X + iY turns by it
  double noise_v = 0.0005;         ///< rms per ADC sample
  double offset_v = 0.0;           ///< of the ADC's mid-scale
};

struct MountConfig {
  double tilt_in_plane_deg = 0.0;      ///< > 0 leans the sample's normal to +x
  double tilt_out_of_plane_deg = 0.0;  ///< > 0 leans it to +y
};

/// What the detector's optics collect.
struct CollectionConfig {
  double solid_angle_sr = 1e-4;  ///< ΔΩ
  double half_angle_deg = 0.0;   ///< of the detector disc as seen from the sample; 0 = a point
  double beam_over_field = 0.0;  ///< 1/e² beam radius over the field's radius; 0 = sees all
  double stray_per_sr = 0.0;     ///< even stray light, BRDF·cos equivalent, unpolarised
  double stray_forward_per_sr =
      0.0;  ///< stray light about the forward grazing direction, same unit
  double stray_forward_width_deg = 10.0;  ///< rms angle of it
  double retro_half_angle_deg =
      0.0;  ///< half-angle of the source optics that block the retro direction
};

struct DetectorConfig {
  double polarization_bias = 0.0;   ///< response to (1, δ, 0, 0), + favours s
  double nonlinearity_per_v = 0.0;  ///< κ of S/(1 + κS)
  double inverse_knee_per_v = 0.0;  ///< S/(1 + (S·k)⁴)^¼ flattens above 1/k; 0 = never
  double shot_noise_v = 0.0;        ///< variance per volt of signal, V²/V, one ADC sample
};

struct AmplifierConfig {
  double gain_error_10 = 0.0;  ///< relative, ranges 10, 100, 1000; range 1 is exact
  double gain_error_100 = 0.0;
  double gain_error_1000 = 0.0;
  double phase_deg = 0.0;        ///< X + iY turns by it; a lag is negative
  double input_noise_v = 2e-6;   ///< white, rms per ADC sample, multiplied by the range
  double output_noise_v = 5e-4;  ///< white, rms per ADC sample, the same in every range
  double offset_v = 0.0;         ///< constant voltage at the ADC
  double pickup_v = 0.0;  ///< X that is there without light (modulation picked up electrically)
  double pickup_y_fraction = 0.0;  ///< its Y over its X
  double pedestal_adc_v = 0.0;     ///< amplitude A at the ADC becomes √(A² + p²)
  double settle_v = 0.0;           ///< step at the ADC after a change of range, decaying …
  double settle_tau_s = 0.002;     ///< … with this time constant
};

struct AdcConfig {
  double full_scale_v = 3.3;  ///< voltage of 4096 codes
};

struct ShutterConfig {
  double travel_s = 0.0;  ///< time from closed to open and back
};

struct PlantConfig {
  std::array<AxisErrors, axis_count> axis{};
  std::array<LaserConfig, laser_count> laser{};
  BeamConfig beam;
  PolarizerConfig polarizer;
  PolarizerConfig analyzer;
  FilterConfig filter;
  LongPassConfig long_pass;
  MonitorConfig monitor;
  MountConfig mount;
  CollectionConfig collection;
  DetectorConfig detector;
  AmplifierConfig amplifier;
  AdcConfig adc;
  ShutterConfig shutter;
};

/// No imperfection; a point aperture that still stands for ΔΩ = 1e-4 sr; white noise of 0.6 codes
/// rms at the ADC in ranges 1 to 100 and 2.6 codes in range 1000, so that quantisation is dithered.
PlantConfig ideal_config();

/// Sizes of a good real bench, each with its source in the definition.
PlantConfig realistic_config();

/// "ideal" or "realistic". Throws umov::Error for another name.
PlantConfig preset_config(const std::string& name);

}  // namespace umov::plant
