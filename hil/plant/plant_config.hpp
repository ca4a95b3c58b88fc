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
  /// Elastic wind-up of the drive: after a reversal the stage lags more and more, up to this angle.
  double windup_deg = 0.0;
  double windup_travel_deg = 5.0;  ///< travel over which it builds up (1 - 1/e)
  double slip_deg = 0.0;     ///< the coupling slips by this angle, once, in the first move …
  double slip_time_s = 0.0;  ///< … after this moment
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
  /// rms noise of the sample's light that the monitor misses (pointing, air), drawn anew every 128
  /// ADC samples: white up to some 400 Hz at 100 kS/s.
  double jitter = 0.0;
  double polarization =
      0.0;  ///< degree of linear polarisation before the polariser; 0 = unpolarised
  double polarization_deg = 0.0;  ///< its axis, from p towards s
  /// Share of the other lasers' light in this laser's beam, relative to their full power.
  std::array<double, laser_count> crosstalk_from = {0.0, 0.0, 0.0};
  /// A wrong or tilted filter before the detector at this wavelength alone: it passes (1 + d)/(1 -
  /// d) as much light along its axis as across.
  double filter_diattenuation = 0.0;
  double filter_axis_deg = 90.0;  ///< from p towards s
};

/// The beam between source and sample.
struct BeamConfig {
  double divergence_rms_deg = 0.0;  ///< per axis, Gaussian
  double over_sample = 0.0;  ///< 1/e² radius over the sample's radius; 0 = all light on the sample
};

/// Polariser or analyser. Axis errors are the axis' own.
struct PolarizerConfig {
  double extinction = 0.0;  ///< power ratio crossed/parallel
  /// Deviation by a wedge that turns with the carrier, towards the transmission axis; the
  /// polariser's steers the beam, the analyser's the detector's line of sight. None when open.
  double wedge_deg = 0.0;
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
  /// The plate bends under its own weight as the incidence stage turns: a further lean to +x of
  /// this times sin θi, whichever way the sample lies on it.
  double sag_deg = 0.0;
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
  /// A strained window before the analyser: linear retardance and its fast axis, from p towards s.
  double window_retardance_deg = 0.0;
  double window_axis_deg = 45.0;
};

/// Second image by reflections inside the interference filter before the detector.
struct GhostConfig {
  double share = 0.0;      ///< of the light that comes in …
  double angle_deg = 6.0;  ///< … from this angle forward of the detector's direction
};

/// Wander and jitter of the modulation against the reference, the same in signal and monitor.
struct ModulationConfig {
  double jitter_deg = 0.0;       ///< rms phase noise, drawn anew every 128 ADC samples
  double wander_deg = 0.0;       ///< amplitude of a slow swing
  double wander_period_s = 900;  ///< its period
};

/// A chopper with a drive of its own in the beam behind the lasers: it lets the light pass for half
/// of each of its turns, and its photo-interrupter gives a rising edge where the light comes on.
struct ChopperConfig {
  double frequency_hz = 0.0;      ///< 0 = there is none
  double wander = 0.0;            ///< relative amplitude of a slow swing of the frequency …
  double wander_period_s = 20.0;  ///< … and its period
  double jitter_deg = 0.0;        ///< rms of the photo-interrupter's edges, each on its own
  double edge_share = 0.05;       ///< of a period that the blade's edge takes to cross the beam
  double phase_deg = 0.0;         ///< by which the light comes on before the edge
  double stops_s = 1e6;           ///< when it stands still
};

/// Unmodulated daylight on the photodiode: the lock-in does not see it, the photodiode's operating
/// point does.
struct DaylightConfig {
  double level_v = 0.0;            ///< at its brightest, in volts of range 1
  double compression_per_v = 0.0;  ///< κ of S/(1 + κS) for signal and daylight together
  double period_s = 1200;          ///< of the clouds
};

/// Humid air comes and goes and swells the sample's surface.
struct HumidityConfig {
  double slope_change = 0.0;  ///< relative change of the surface's slopes at the most humid moment
  double period_s = 5400;     ///< from dry to dry
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
  /// The arm motor's current coupled into the input: it holds the arm's weight, so it goes with the
  /// sine of the arm's angle.
  double motor_pickup_v = 0.0;
  double settle_v = 0.0;        ///< step at the ADC after a change of range, decaying …
  double settle_tau_s = 0.002;  ///< … with this time constant
};

struct AdcConfig {
  double full_scale_v = 3.3;  ///< voltage of 4096 codes
};

struct ShutterConfig {
  double travel_s = 0.0;  ///< time from closed to open and back
  double leak = 0.0;      ///< share of the light that passes when closed
};

/// Layer of dust on the sample: see dust_layer.hpp.
struct DustConfig {
  double optical_depth_633 = 0.0;  ///< extinction at normal passage and 633 nm; ∝ 1/wavelength
  double g = 0.6;                  ///< mean cosine of the scattering angle
  double single_scattering_albedo = 0.9;
};

/// Film of water on part of the sample: see water.hpp.
struct FilmConfig {
  double coverage = 0.0;
  double slope_rms = 0.03;  ///< of the film's own surface, 1-D
};

struct DropsConfig {
  double coverage = 0.0;
  double contact_angle_deg = 30.0;
};

/// What else a sample's surface may have: see surface_marks.hpp.
struct MarksConfig {
  double lobe_weight = 0.0;  ///< near-specular lobe: share of a smoother surface of the same binder
  double lobe_slope = 0.02;  ///< its 1-D rms slope
  double retro_peak_per_sr = 0.0;  ///< retroreflection peak
  double retro_width_deg = 1.0;    ///< rms angle of it
  double fluorescence_yield_532 =
      0.0;                       ///< albedo equivalent of the light emitted at longer wavelengths
  double fringe_contrast = 0.0;  ///< interference in a clear coat
  double fringe_thickness_um = 8.0;  ///< of the coat, index 1.5
  double gradient_per_mm = 0.0;      ///< relative change of the reflectance along the plate …
  double beam_offset_mm = 1.0;       ///< … on which the beam walks by this over cos θi
};

/// Coherent granularity of the light; see Plant.
struct SpeckleConfig {
  double contrast = 0.0;  ///< standard deviation over mean of the collected light
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
  GhostConfig ghost;
  ModulationConfig modulation;
  ChopperConfig chopper;
  DaylightConfig daylight;
  HumidityConfig humidity;
  DustConfig dust;
  FilmConfig film;
  DropsConfig drops;
  MarksConfig marks;
  SpeckleConfig speckle;
};

/// No imperfection; a point aperture that still stands for ΔΩ = 1e-4 sr; white noise of 0.6 codes
/// rms at the ADC in ranges 1 to 100 and 2.6 codes in range 1000, so that quantisation is dithered.
PlantConfig ideal_config();

/// Sizes of a good real bench, each with its source in the definition.
PlantConfig realistic_config();

/// "ideal" or "realistic". Throws umov::Error for another name.
PlantConfig preset_config(const std::string& name);

}  // namespace umov::plant
