// Effects that no catalogue of the diagnosis has.

#include "hil/blind/effect_table.hpp"

namespace umov::blind {
namespace {

using Parameters = std::vector<Named>;

EffectKind filter_ghost() {
  return {"filter_ghost",
          false,
          1e-7,
          0.5,
          false,
          "share",
          [](Random& r, const EffectContext&) {
            return Parameters{{"angle_deg", r.sign() * r.between(4.0, 18.0)}};
          },
          [](const Parameters& p, const EffectContext&) {
            return Parameters{{"ghost.share", p[0].second}, {"ghost.angle_deg", p[1].second}};
          },
          "second image by the interference filter before the detector"};
}

EffectKind rotator_hysteresis() {
  return {"rotator_hysteresis",
          false,
          1e-2,
          10.0,
          false,
          "windup_deg",
          [](Random& r, const EffectContext&) {
            return Parameters{{"travel_deg", r.between(20.0, 120.0)},
                              {"analyzer", r.chance(0.5) ? 1.0 : 0.0}};
          },
          [](const Parameters& p, const EffectContext&) {
            const std::string axis = p[2].second > 0.5 ? "axis.analyzer." : "axis.polarizer.";
            return Parameters{{axis + "windup_deg", p[0].second},
                              {axis + "windup_travel_deg", p[1].second}};
          },
          "rotator of a polariser winds up elastically"};
}

EffectKind coupling_slip() {
  return {"coupling_slip",
          false,
          1e-4,
          3.0,
          true,
          "slip_deg",
          [](Random& r, const EffectContext& context) {
            return Parameters{{"slip_time_s", context.duration_s * r.between(0.15, 0.75)}};
          },
          [](const Parameters& p, const EffectContext&) {
            return Parameters{{"axis.detector.slip_deg", p[0].second},
                              {"axis.detector.slip_time_s", p[1].second}};
          },
          "the arm's coupling slips once"};
}

EffectKind modulation_wander() {
  return {"modulation_wander",
          false,
          1e-4,
          30.0,
          true,
          "wander_deg",
          [](Random& r, const EffectContext& context) {
            return Parameters{{"period_s", context.duration_s * r.log_between(0.12, 0.7)}};
          },
          [](const Parameters& p, const EffectContext&) {
            return Parameters{{"modulation.wander_deg", p[0].second},
                              {"modulation.wander_period_s", p[1].second}};
          },
          "phase of the chopped light swings against the reference"};
}

EffectKind daylight() {
  return {"daylight",
          false,
          1e-5,
          5.0,
          false,
          "compression_per_v",
          [](Random& r, const EffectContext& context) {
            return Parameters{{"level_v", r.between(0.3, 1.5)},
                              {"period_s", context.duration_s * r.log_between(0.12, 0.7)}};
          },
          [](const Parameters& p, const EffectContext&) {
            return Parameters{{"daylight.compression_per_v", p[0].second},
                              {"daylight.level_v", p[1].second},
                              {"daylight.period_s", p[2].second}};
          },
          "daylight comes and goes and shifts the photodiode's operating point"};
}

EffectKind humid_gloss() {
  return {"humid_gloss",
          false,
          1e-4,
          0.8,
          true,
          "slope_change",
          [](Random& r, const EffectContext& context) {
            return Parameters{{"period_s", context.duration_s * r.log_between(0.4, 1.6)}};
          },
          [](const Parameters& p, const EffectContext&) {
            return Parameters{{"humidity.slope_change", p[0].second},
                              {"humidity.period_s", p[1].second}};
          },
          "the sample's gloss follows the humidity"};
}

EffectKind wrong_filter() {
  return {
      "wrong_filter",
      false,
      1e-5,
      0.5,
      false,
      "diattenuation",
      [](Random& r, const EffectContext&) {
        return Parameters{
            {"wavelength_nm", static_cast<double>(plant::laser_names[r.below(plant::laser_count)])},
            {"axis_deg", r.between(-90.0, 90.0)}};
      },
      [](const Parameters& p, const EffectContext&) {
        const std::string laser = laser_prefix(laser_of(p[1].second));
        return Parameters{{laser + "filter_diattenuation", p[0].second},
                          {laser + "filter_axis_deg", p[2].second}};
      },
      "a tilted filter before the detector at one wavelength"};
}

EffectKind gear_harmonic() {
  return {"gear_harmonic",
          false,
          1e-4,
          0.9,
          false,
          "gear_deg",
          [](Random& r, const EffectContext&) {
            return Parameters{{"cycles_per_turn", r.between(22.0, 70.0)},
                              {"phase_deg", r.between(-180.0, 180.0)}};
          },
          [](const Parameters& p, const EffectContext&) {
            return Parameters{{"axis.detector.gear_deg", p[0].second},
                              {"axis.detector.gear_cycles", 1.0},
                              {"axis.detector.gear_ratio", p[1].second},
                              {"axis.detector.gear_phase_deg", p[2].second}};
          },
          "teeth of the arm's gear"};
}

EffectKind window_strain() {
  return {"window_strain",
          false,
          0.05,
          60.0,
          true,
          "retardance_deg",
          [](Random& r, const EffectContext&) {
            return Parameters{{"axis_deg", r.between(15.0, 75.0)}};
          },
          [](const Parameters& p, const EffectContext&) {
            return Parameters{{"collection.window_retardance_deg", p[0].second},
                              {"collection.window_axis_deg", p[1].second}};
          },
          "strained window before the analyser"};
}

EffectKind coat_fringes() {
  return {"coat_fringes",
          false,
          1e-5,
          0.5,
          false,
          "contrast",
          [](Random& r, const EffectContext&) {
            return Parameters{{"thickness_um", r.between(3.0, 14.0)}};
          },
          [](const Parameters& p, const EffectContext&) {
            return Parameters{{"marks.fringe_contrast", p[0].second},
                              {"marks.fringe_thickness_um", p[1].second}};
          },
          "interference in a clear coat"};
}

EffectKind patchy_plate() {
  return {"patchy_plate",
          false,
          1e-5,
          0.4,
          true,
          "gradient_per_mm",
          [](Random& r, const EffectContext&) {
            return Parameters{{"beam_offset_mm", r.between(0.5, 2.0)}};
          },
          [](const Parameters& p, const EffectContext&) {
            return Parameters{{"marks.gradient_per_mm", p[0].second},
                              {"marks.beam_offset_mm", p[1].second}};
          },
          "reflectance changes along the plate and the beam walks on it"};
}

}  // namespace

std::vector<EffectKind> foreign_effects() {
  const auto one = [](const char* name, const char* parameter, const char* setting, double smallest,
                      double largest, bool both_signs, const char* about) {
    return single_parameter(name, false, parameter, setting, smallest, largest, both_signs, about);
  };
  return {filter_ghost(),
          rotator_hysteresis(),
          coupling_slip(),
          modulation_wander(),
          daylight(),
          humid_gloss(),
          wrong_filter(),
          one("plate_bend", "sag_deg", "mount.sag_deg", 1e-4, 3.0, true,
              "sample plate bends as the incidence turns"),
          one("motor_pickup", "amplitude_v", "amplifier.motor_pickup_v", 1e-9, 1e-2, true,
              "arm motor's current in the amplifier"),
          one("polarizer_wedge", "wedge_deg", "polarizer.wedge_deg", 1e-4, 2.0, true,
              "polariser steers the beam as it turns"),
          one("analyzer_wedge", "wedge_deg", "analyzer.wedge_deg", 1e-4, 2.0, true,
              "analyser steers the line of sight as it turns"),
          gear_harmonic(),
          window_strain(),
          one("monitor_polarization_bias", "bias", "monitor.polarization_bias", 1e-5, 0.3, true,
              "monitor favours s or p"),
          coat_fringes(),
          patchy_plate(),
          one("shutter_leak", "share", "shutter.leak", 1e-5, 0.2, false,
              "closed shutter passes light")};
}

}  // namespace umov::blind
