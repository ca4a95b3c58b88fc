#include "hil/plant/parameter_list.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <limits>

#include "hil/plant/parameter_setting.hpp"
#include "host/errors/error.hpp"

namespace umov::plant {
namespace {

/// Collects entries under a common prefix.
class Collector {
 public:
  explicit Collector(std::vector<Parameter>& list) : list_(list) {}
  void enter(std::string prefix) { prefix_ = std::move(prefix); }
  void add(const char* name, double& value, double low, double high, const char* unit,
           const char* meaning) {
    list_.push_back({prefix_ + name, &value, low, high, unit, meaning});
  }

 private:
  std::vector<Parameter>& list_;
  std::string prefix_;
};

void add_axis(Collector& c, AxisErrors& a) {
  c.add("zero_deg", a.zero_deg, -30, 30, "deg", "zero offset: true = commanded + zero");
  c.add("backlash_deg", a.backlash_deg, 0, 10, "deg",
        "play; error -direction/2 of it once taken up");
  c.add("eccentricity_deg", a.eccentricity_deg, -10, 10, "deg",
        "amplitude, one cycle a stage turn");
  c.add("eccentricity_phase_deg", a.eccentricity_phase_deg, -360, 720, "deg",
        "error = A sin(angle + phase)");
  c.add("encoder_deg", a.encoder_deg, -10, 10, "deg", "amplitude, two cycles a stage turn");
  c.add("encoder_phase_deg", a.encoder_phase_deg, -360, 720, "deg",
        "error = A sin(2 angle + phase)");
  c.add("gear_deg", a.gear_deg, -1, 1, "deg", "amplitude at gear_cycles a motor turn");
  c.add("gear_phase_deg", a.gear_phase_deg, -360, 720, "deg", "its phase");
  c.add("gear_cycles", a.gear_cycles, 0, 1000, "1", "cycles a motor turn");
  c.add("gear_ratio", a.gear_ratio, 1, 10000, "1", "motor turns a stage turn");
  c.add("standstill_deg", a.standstill_deg, 0, 1, "deg", "rms random offset, new at each arrival");
  c.add("windup_deg", a.windup_deg, -10, 10, "deg", "elastic lag that builds up after a reversal");
  c.add("windup_travel_deg", a.windup_travel_deg, 0.01, 360, "deg",
        "travel over which it builds up");
  c.add("slip_deg", a.slip_deg, -30, 30, "deg", "the coupling slips by this, once");
  c.add("slip_time_s", a.slip_time_s, 0, 1e6, "s", "in the first move after this moment");
}

void add_laser(Collector& c, LaserConfig& l) {
  c.add("wavelength_nm", l.wavelength_nm, 300, 2000, "nm", "nominal wavelength");
  c.add("gain_constant_v", l.gain_constant_v, 1, 1e5, "V",
        "signal per BRDF cos(theta_r) solid angle monitor");
  c.add("monitor_v", l.monitor_v, 1e-3, 2.1, "V",
        "monitor with polariser and filter out of the beam");
  c.add("wavelength_error_nm", l.wavelength_error_nm, -50, 50, "nm",
        "true minus nominal wavelength");
  c.add("line_width_nm", l.line_width_nm, 0, 50, "nm", "rms width of the line");
  c.add("drift_per_hour", l.drift_per_hour, -1, 1, "1/h", "relative drift that the monitor misses");
  c.add("power_drift_per_hour", l.power_drift_per_hour, -1, 1, "1/h",
        "relative drift that it sees");
  c.add("warmup", l.warmup, -1, 1, "1", "relative lack at time 0 that the monitor misses");
  c.add("power_warmup", l.power_warmup, -1, 1, "1", "relative lack at time 0 that it sees");
  c.add("warmup_tau_s", l.warmup_tau_s, 1e-3, 1e6, "s", "time constant of both");
  c.add("power_noise", l.power_noise, 0, 1, "1", "rms slow (1/f) power noise, seen by the monitor");
  c.add("unseen_noise", l.unseen_noise, 0, 1, "1", "rms slow (1/f) noise that the monitor misses");
  c.add("sample_noise", l.sample_noise, 0, 1, "1",
        "rms white power noise an ADC sample, seen by it");
  c.add("jitter", l.jitter, 0, 1, "1",
        "rms noise that the monitor misses, new every 128 ADC samples");
  c.add("polarization", l.polarization, 0, 1, "1", "degree of polarisation before the polariser");
  c.add("polarization_deg", l.polarization_deg, -180, 180, "deg", "its axis, from p towards s");
  c.add("crosstalk_from_532", l.crosstalk_from[0], 0, 1, "1",
        "share of the 532 nm laser in this beam");
  c.add("crosstalk_from_633", l.crosstalk_from[1], 0, 1, "1",
        "share of the 633 nm laser in this beam");
  c.add("crosstalk_from_814", l.crosstalk_from[2], 0, 1, "1",
        "share of the 814 nm laser in this beam");
  c.add("filter_diattenuation", l.filter_diattenuation, 0, 0.99, "1",
        "wrong filter before the detector: (1+d)/(1-d) along over across");
  c.add("filter_axis_deg", l.filter_axis_deg, -180, 180, "deg", "its axis, from p towards s");
}

void add_collection(Collector& c, CollectionConfig& o) {
  c.add("solid_angle_sr", o.solid_angle_sr, 1e-8, 0.1, "sr", "detector's solid angle");
  c.add("half_angle_deg", o.half_angle_deg, 0, 10, "deg", "detector disc; 0 = point");
  c.add("beam_over_field", o.beam_over_field, 0, 10, "1",
        "beam radius over field radius; 0 = sees all");
  c.add("stray_per_sr", o.stray_per_sr, 0, 10, "1/sr", "even stray light, BRDF cos equivalent");
  c.add("stray_forward_per_sr", o.stray_forward_per_sr, 0, 10, "1/sr",
        "stray light at forward grazing");
  c.add("stray_forward_width_deg", o.stray_forward_width_deg, 0.1, 90, "deg", "rms angle of it");
  c.add("retro_half_angle_deg", o.retro_half_angle_deg, 0, 45, "deg",
        "optics that block the retro direction");
  c.add("window_retardance_deg", o.window_retardance_deg, -180, 180, "deg",
        "strained window before the analyser");
  c.add("window_axis_deg", o.window_axis_deg, -180, 180, "deg", "its fast axis, from p towards s");
}

void add_polarizer(Collector& c, PolarizerConfig& p) {
  c.add("extinction", p.extinction, 0, 1, "1", "power ratio crossed/parallel");
  c.add("wedge_deg", p.wedge_deg, -5, 5, "deg", "deviation towards the axis; turns with it");
}

void add_surroundings(Collector& c, PlantConfig& p) {
  c.enter("ghost.");
  c.add("share", p.ghost.share, 0, 1, "1", "filter ghost: share of light from another direction");
  c.add("angle_deg", p.ghost.angle_deg, -45, 45, "deg", "that direction, forward of the detector");
  c.enter("modulation.");
  c.add("jitter_deg", p.modulation.jitter_deg, 0, 90, "deg",
        "rms phase noise of the light, new every 128 ADC samples");
  c.add("wander_deg", p.modulation.wander_deg, -90, 90, "deg", "slow swing of the light's phase");
  c.add("wander_period_s", p.modulation.wander_period_s, 1, 1e6, "s", "its period");
  c.enter("chopper.");
  c.add("frequency_hz", p.chopper.frequency_hz, 0, 50000, "Hz",
        "chopper that turns by itself and gives the reference; 0 = none");
  c.add("wander", p.chopper.wander, 0, 0.5, "1", "slow swing of its frequency, relative");
  c.add("wander_period_s", p.chopper.wander_period_s, 0.1, 1e6, "s", "its period");
  c.add("jitter_deg", p.chopper.jitter_deg, 0, 90, "deg",
        "rms of the photo-interrupter's edges, each on its own");
  c.add("edge_share", p.chopper.edge_share, 0, 0.5, "1",
        "of a period that the blade's edge takes to cross the beam");
  c.add("phase_deg", p.chopper.phase_deg, -180, 180, "deg",
        "by which the light comes on before the edge");
  c.add("stops_s", p.chopper.stops_s, 0, 1e6, "s", "when it stands still");
  c.enter("daylight.");
  c.add("level_v", p.daylight.level_v, 0, 100, "V", "unmodulated light at its brightest");
  c.add("compression_per_v", p.daylight.compression_per_v, 0, 10, "1/V",
        "S/(1 + kappa S) for signal and daylight together");
  c.add("period_s", p.daylight.period_s, 1, 1e6, "s", "of the clouds");
  c.enter("humidity.");
  c.add("slope_change", p.humidity.slope_change, -0.9, 10, "1",
        "relative change of the surface's slopes when humid");
  c.add("period_s", p.humidity.period_s, 1, 1e6, "s", "from dry to dry");
}

void add_surface(Collector& c, PlantConfig& p) {
  c.enter("dust.");
  c.add("optical_depth_633", p.dust.optical_depth_633, 0, 10, "1",
        "at 633 nm, goes with 1/wavelength");
  c.add("g", p.dust.g, -0.99, 0.99, "1", "mean cosine of the scattering angle");
  c.add("single_scattering_albedo", p.dust.single_scattering_albedo, 0, 1, "1",
        "scattered share of the extinction");
  c.enter("film.");
  c.add("coverage", p.film.coverage, 0, 1, "1", "share of the sample under a film of water");
  c.add("slope_rms", p.film.slope_rms, 0.002, 1, "1", "1-D rms slope of the film's own surface");
  c.enter("drops.");
  c.add("coverage", p.drops.coverage, 0, 1, "1", "share of the sample under drops of water");
  c.add("contact_angle_deg", p.drops.contact_angle_deg, 1, 90, "deg", "of the spherical caps");
  c.enter("marks.");
  MarksConfig& m = p.marks;
  c.add("lobe_weight", m.lobe_weight, 0, 1, "1", "near-specular lobe: share of a smoother surface");
  c.add("lobe_slope", m.lobe_slope, 0.001, 1, "1", "its 1-D rms slope");
  c.add("retro_peak_per_sr", m.retro_peak_per_sr, 0, 100, "1/sr", "retroreflection peak");
  c.add("retro_width_deg", m.retro_width_deg, 0.01, 30, "deg", "rms angle of it");
  c.add("fluorescence_yield_532", m.fluorescence_yield_532, 0, 1, "1",
        "light emitted at longer wavelengths, as an albedo");
  c.add("fringe_contrast", m.fringe_contrast, 0, 1, "1", "interference in a clear coat");
  c.add("fringe_thickness_um", m.fringe_thickness_um, 0.1, 1000, "um", "thickness of the coat");
  c.add("gradient_per_mm", m.gradient_per_mm, -1, 1, "1/mm",
        "relative change of the reflectance along the plate");
  c.add("beam_offset_mm", m.beam_offset_mm, -20, 20, "mm",
        "the beam meets the plate at this over cos(theta_i)");
  c.enter("speckle.");
  c.add("contrast", p.speckle.contrast, 0, 1, "1", "standard deviation over mean of the light");
}

void add_electronics(Collector& c, PlantConfig& p) {
  c.enter("detector.");
  DetectorConfig& d = p.detector;
  c.add("polarization_bias", d.polarization_bias, -1, 1, "1", "response to Q, + favours s");
  c.add("nonlinearity_per_v", d.nonlinearity_per_v, 0, 10, "1/V", "S/(1 + kappa S)");
  c.add("inverse_knee_per_v", d.inverse_knee_per_v, 0, 1000, "1/V", "saturation law; 0 = none");
  c.add("shot_noise_v", d.shot_noise_v, 0, 1, "V", "variance per volt of signal, an ADC sample");
  c.enter("amplifier.");
  AmplifierConfig& a = p.amplifier;
  c.add("gain_error_10", a.gain_error_10, -0.5, 0.5, "1", "relative error of range 10");
  c.add("gain_error_100", a.gain_error_100, -0.5, 0.5, "1", "relative error of range 100");
  c.add("gain_error_1000", a.gain_error_1000, -0.5, 0.5, "1", "relative error of range 1000");
  c.add("phase_deg", a.phase_deg, -180, 180, "deg", "X + iY turns by it; a lag is negative");
  c.add("input_noise_v", a.input_noise_v, 0, 1, "V",
        "white noise times the range, rms an ADC sample");
  c.add("output_noise_v", a.output_noise_v, 0, 1, "V",
        "white noise in every range, rms an ADC sample");
  c.add("offset_v", a.offset_v, -1.6, 1.6, "V", "constant voltage at the ADC");
  c.add("pickup_v", a.pickup_v, -1, 1, "V", "X without light");
  c.add("pickup_y_fraction", a.pickup_y_fraction, -100, 100, "1", "Y over X of it");
  c.add("pedestal_adc_v", a.pedestal_adc_v, 0, 1, "V",
        "amplitude A at the ADC becomes hypot(A, p)");
  c.add("motor_pickup_v", a.motor_pickup_v, -1, 1, "V",
        "X from the arm motor's current, times sin of the arm's angle");
  c.add("settle_v", a.settle_v, -3, 3, "V", "step at the ADC after a change of range");
  c.add("settle_tau_s", a.settle_tau_s, 1e-6, 10, "s", "its decay time");
  c.enter("adc.");
  c.add("full_scale_v", p.adc.full_scale_v, 0.1, 100, "V", "voltage of 4096 codes");
  c.enter("shutter.");
  c.add("travel_s", p.shutter.travel_s, 0, 10, "s", "from closed to open and back");
  c.add("leak", p.shutter.leak, 0, 1, "1", "share of the light that passes when closed");
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substitution = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({substitution, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

std::string number_text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.4g", value);
  return buffer;
}

}  // namespace

std::vector<Parameter> parameters(PlantConfig& config) {
  std::vector<Parameter> list;
  Collector c(list);
  for (std::size_t i = 0; i < axis_count; ++i) {
    c.enter(std::string("axis.") + axis_names[i] + ".");
    add_axis(c, config.axis[i]);
  }
  for (std::size_t i = 0; i < laser_count; ++i) {
    c.enter("laser." + std::to_string(laser_names[i]) + ".");
    add_laser(c, config.laser[i]);
  }
  c.enter("beam.");
  c.add("divergence_rms_deg", config.beam.divergence_rms_deg, 0, 10, "deg", "rms an axis");
  c.add("over_sample", config.beam.over_sample, 0, 10, "1",
        "beam radius over sample radius; 0 = all light lands");
  c.enter("polarizer.");
  add_polarizer(c, config.polarizer);
  c.enter("analyzer.");
  add_polarizer(c, config.analyzer);
  c.enter("filter.");
  c.add("density_error", config.filter.density_error, -0.9, 10, "1",
        "relative error of optical densities");
  c.enter("long_pass.");
  c.add("edge_nm", config.long_pass.edge_nm, 300, 2000, "nm",
        "filter before the detector: blocks shorter wavelengths");
  c.add("transmittance", config.long_pass.transmittance, 0, 1, "1", "above its edge");
  c.add("leak", config.long_pass.leak, 0, 1, "1", "below it");
  c.enter("monitor.");
  c.add("polarization_bias", config.monitor.polarization_bias, -1, 1, "1",
        "response to Q, + favours s");
  c.add("phase_deg", config.monitor.phase_deg, -180, 180, "deg", "X + iY turns by it");
  c.add("noise_v", config.monitor.noise_v, 0, 1, "V", "rms an ADC sample");
  c.add("offset_v", config.monitor.offset_v, -1.6, 1.6, "V", "constant voltage at the ADC");
  c.enter("mount.");
  c.add("tilt_in_plane_deg", config.mount.tilt_in_plane_deg, -30, 30, "deg",
        "> 0 leans the normal to +x");
  c.add("tilt_out_of_plane_deg", config.mount.tilt_out_of_plane_deg, -30, 30, "deg",
        "> 0 leans it to +y");
  c.add("sag_deg", config.mount.sag_deg, -5, 5, "deg",
        "bends with the incidence: further lean to +x times sin(theta_i)");
  c.enter("collection.");
  add_collection(c, config.collection);
  add_electronics(c, config);
  add_surroundings(c, config);
  add_surface(c, config);
  return list;
}

void set_parameter(PlantConfig& config, std::string_view name, double value, const Place& place) {
  const auto list = parameters(config);
  const Parameter* nearest = nullptr;
  std::size_t distance = std::numeric_limits<std::size_t>::max();
  for (const Parameter& parameter : list) {
    if (parameter.name == name) {
      if (!(value >= parameter.low && value <= parameter.high)) {
        throw Error(place,
                    "\"" + parameter.name + "\" = " + number_text(value) + " is out of range",
                    "give a value from " + number_text(parameter.low) + " to " +
                        number_text(parameter.high) + " " + parameter.unit);
      }
      *parameter.value = value;
      return;
    }
    const std::size_t d = edit_distance(parameter.name, name);
    if (d < distance) {
      distance = d;
      nearest = &parameter;
    }
  }
  throw Error(place, "unknown plant parameter \"" + std::string(name) + "\"",
              "the nearest known one is \"" + nearest->name + "\"");
}

void apply_override(PlantConfig& config, std::string_view assignment) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string_view::npos) {
    throw Error("\"" + std::string(assignment) + "\" is not of the form name=value",
                "write for example axis.detector.zero_deg=0.1");
  }
  const std::string_view name = assignment.substr(0, equals);
  const std::string_view text = assignment.substr(equals + 1);
  double value = 0.0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
    throw Error(
        "\"" + std::string(text) + "\" in \"" + std::string(assignment) + "\" is not a number",
        "write for example axis.detector.zero_deg=0.1");
  }
  set_parameter(config, name, value, {});
}

PlantConfig make_config(const std::string& preset, std::span<const std::string> overrides) {
  PlantConfig config = preset_config(preset);
  for (const std::string& assignment : overrides) apply_override(config, assignment);
  return config;
}

std::string parameter_reference() {
  PlantConfig ideal = ideal_config();
  PlantConfig realistic = realistic_config();
  const auto a = parameters(ideal);
  const auto b = parameters(realistic);
  std::string text = "| name | unit | ideal | realistic | meaning |\n|---|---|---|---|---|\n";
  for (std::size_t i = 0; i < a.size(); ++i) {
    text += "| `" + a[i].name + "` | " + a[i].unit + " | " + number_text(*a[i].value) + " | " +
            number_text(*b[i].value) + " | " + a[i].meaning + " |\n";
  }
  return text;
}

}  // namespace umov::plant
