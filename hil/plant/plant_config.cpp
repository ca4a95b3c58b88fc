#include "hil/plant/plant_config.hpp"

#include <cmath>
#include <cstddef>

#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"

namespace umov::plant {

PlantConfig ideal_config() {
  PlantConfig config;
  // Detection chains differ as photodiodes and coatings do between green and near infrared; powers
  // are set so that the unpolarised beam gives a good 1.5 V at the monitor, whose clipping limit
  // is 2.1 V.
  constexpr std::array<double, laser_count> gain_constant_v = {760.0, 820.0, 800.0};
  constexpr std::array<double, laser_count> monitor_v = {1.60, 1.50, 1.55};
  for (std::size_t i = 0; i < laser_count; ++i) {
    config.laser[i].wavelength_nm = laser_names[i];
    config.laser[i].gain_constant_v = gain_constant_v[i];
    config.laser[i].monitor_v = monitor_v[i];
  }
  return config;
}

PlantConfig realistic_config() {
  PlantConfig config = ideal_config();
  // A stepper stage measured against its resolver: one sharp error of 20.6 µm at four cycles per
  // motor turn, under 1.5 µm at other harmonics, 12–20 nm of standstill noise. Taken at the 100 mm
  // pitch radius of a worm wheel: 0.0118°, 0.00086°, 9e-6°.
  constexpr double radius_um = 100e3;
  const auto angle_deg = [](double length_um) { return optics::degrees(length_um / radius_um); };
  for (std::size_t i = 0; i < axis_count; ++i) {
    AxisErrors& axis = config.axis[i];
    axis.gear_deg = angle_deg(20.6);
    axis.encoder_deg = angle_deg(1.4);
    axis.eccentricity_deg = angle_deg(1.4);
    axis.standstill_deg = angle_deg(0.016);
    // Phases are arbitrary; they only must not agree between axes.
    axis.gear_phase_deg = 37.0 + 71.0 * static_cast<double>(i);
    axis.encoder_phase_deg = 110.0 + 53.0 * static_cast<double>(i);
    axis.eccentricity_phase_deg = 20.0 + 97.0 * static_cast<double>(i);
    axis.backlash_deg = 0.02;
  }
  // Alignment of a bench whose angular resolution is better than 1°: a few hundredths of a degree.
  config.axis[0].zero_deg = 0.03;
  config.axis[1].zero_deg = -0.02;
  config.axis[1].eccentricity_deg = 0.02;
  config.axis[2].zero_deg = 0.05;
  config.axis[3].zero_deg = 0.15;
  config.axis[4].zero_deg = -0.10;
  config.mount.tilt_in_plane_deg = 0.03;
  config.mount.tilt_out_of_plane_deg = -0.04;

  constexpr std::array<double, laser_count> wavelength_error_nm = {0.1, -0.2, 0.6};
  constexpr std::array<double, laser_count> line_width_nm = {0.05, 0.3, 0.8};
  // Source .23 % of a BRDF budget, over a scan of about an hour.
  constexpr std::array<double, laser_count> drift_per_hour = {0.0023, -0.0015, 0.0010};
  constexpr std::array<double, laser_count> polarization = {0.05, 0.03, 0.04};
  for (std::size_t i = 0; i < laser_count; ++i) {
    LaserConfig& laser = config.laser[i];
    laser.wavelength_error_nm = wavelength_error_nm[i];
    laser.line_width_nm = line_width_nm[i];
    laser.drift_per_hour = drift_per_hour[i];
    laser.power_drift_per_hour = -0.01;
    laser.warmup = 0.002;
    laser.power_warmup = 0.02;
    laser.power_noise = 0.003;
    laser.unseen_noise = 0.003;  // reproducibility .33 % of a BRDF budget
    laser.sample_noise = 0.001;
    laser.polarization = polarization[i];  // behind a depolarising fibre
    laser.polarization_deg = 25.0;
  }
  config.beam.divergence_rms_deg = 0.03;
  config.beam.over_sample = 0.25;
  config.polarizer.extinction = 1e-4;  // wideband sheet or wire grid
  config.analyzer.extinction = 1e-4;
  config.filter.density_error = 0.02;
  config.long_pass.transmittance = 0.91;  // coloured glass, reflection at two faces
  config.long_pass.leak = 1e-5;
  config.monitor.polarization_bias = 0.005;
  config.monitor.phase_deg = -0.2;
  config.monitor.offset_v = 0.004;
  config.monitor.noise_v = 6e-4;

  // π sin²(half-angle) = ΔΩ: aperture of .9° full angle at 1 m, .8 to 3 % of the signal at a gloss
  // peak.
  config.collection.half_angle_deg =
      optics::degrees(std::asin(std::sqrt(config.collection.solid_angle_sr / optics::pi)));
  config.collection.beam_over_field = 0.3;
  config.collection.stray_per_sr = 2e-5;
  config.collection.stray_forward_per_sr = 5e-5;
  config.collection.retro_half_angle_deg = 2.5;
  // A goniospectrometer's head: s/p from .86 at 450 nm to .99 at 750 nm; with a depolariser a tenth
  // of it.
  config.detector.polarization_bias = -0.004;
  // Silicon photodiodes: .01–.02 % at usual signals, here at 1 V.
  config.detector.nonlinearity_per_v = 1.5e-4;
  config.detector.inverse_knee_per_v = 0.1;
  // 60 nA give 19 mV: √(2 q I B) over 50 kHz is then 10 µV a sample.
  config.detector.shot_noise_v = 5e-9;
  config.amplifier.gain_error_10 = 0.0010;
  config.amplifier.gain_error_100 = -0.0015;
  config.amplifier.gain_error_1000 = 0.0020;
  config.amplifier.phase_deg = -0.3;
  config.amplifier.input_noise_v = 15e-6;  // thermal noise of 300 kΩ over 50 kHz
  config.amplifier.output_noise_v = 6e-4;
  config.amplifier.offset_v = 0.006;
  config.amplifier.pickup_v = 4e-7;
  config.amplifier.pickup_y_fraction = 0.5;
  config.amplifier.pedestal_adc_v = 5e-5;
  config.amplifier.settle_v = 0.02;
  config.shutter.travel_s = 0.004;
  return config;
}

PlantConfig preset_config(const std::string& name) {
  if (name == "ideal") return ideal_config();
  if (name == "realistic") return realistic_config();
  throw Error("no preset is called \"" + name + "\"", "presets are ideal and realistic");
}

}  // namespace umov::plant
