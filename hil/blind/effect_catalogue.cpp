// The effects of the diagnosis' catalogue as settings of the plant.
#include <algorithm>

#include "hil/blind/effect_table.hpp"

namespace umov::blind {
namespace {

using Parameters = std::vector<Named>;

Parameters none(Random&, const EffectContext&) {
  return {};
}

EffectKind eccentricity() {
  return {"detector_eccentricity",
          true,
          1e-4,
          1.0,
          false,
          "amplitude_deg",
          [](Random& r, const EffectContext&) {
            return Parameters{{"phase_deg", r.between(-180.0, 180.0)}};
          },
          [](const Parameters& p, const EffectContext&) {
            return Parameters{{"axis.detector.eccentricity_deg", p[0].second},
                              {"axis.detector.eccentricity_phase_deg", p[1].second}};
          },
          "arm's axle beside the circle's centre"};
}

EffectKind dark_offset() {
  return {"dark_offset",
          true,
          1e-9,
          1e-2,
          true,
          "offset_v",
          [](Random& r, const EffectContext&) {
            return Parameters{{"y_fraction", r.chance(0.3) ? 0.0 : r.between(-1.0, 1.0)}};
          },
          [](const Parameters& p, const EffectContext&) {
            return Parameters{{"amplifier.pickup_v", p[0].second},
                              {"amplifier.pickup_y_fraction", p[1].second}};
          },
          "modulation picked up without light"};
}

EffectKind stray_forward() {
  return {"stray_forward",
          true,
          1e-8,
          0.3,
          false,
          "level_per_sr",
          [](Random& r, const EffectContext&) {
            return Parameters{{"width_deg", r.between(6.0, 25.0)}};
          },
          [](const Parameters& p, const EffectContext&) {
            return Parameters{{"collection.stray_forward_per_sr", p[0].second},
                              {"collection.stray_forward_width_deg", p[1].second}};
          },
          "light that passes the sample and scatters towards the detector at forward grazing"};
}

EffectKind gain_ratio_error() {
  return {"gain_ratio_error",
          true,
          1e-5,
          0.1,
          true,
          "error_10",
          [](Random& r, const EffectContext&) {
            return Parameters{{"error_100", r.between(-1.5, 1.5)},
                              {"error_1000", r.between(-1.5, 1.5)}};
          },
          [](const Parameters& p, const EffectContext&) {
            return Parameters{{"amplifier.gain_error_10", p[0].second},
                              {"amplifier.gain_error_100", p[1].second},
                              {"amplifier.gain_error_1000", p[2].second}};
          },
          "amplifier ranges not in the ratios they are labelled with",
          3};
}

EffectKind laser_drift() {
  return {"laser_drift",
          true,
          1e-5,
          0.3,
          true,
          "total",
          none,
          [](const Parameters& p, const EffectContext& context) {
            Parameters all;
            for (std::size_t i = 0; i < plant::laser_count; ++i) {
              all.emplace_back(laser_prefix(i) + "drift_per_hour",
                               p[0].second * 3600.0 / context.duration_s);
            }
            return all;
          },
          "light on the sample drifts behind the monitor's pick-off"};
}

EffectKind laser_warmup() {
  return {"laser_warmup",
          true,
          1e-5,
          0.5,
          false,
          "amplitude",
          [](Random& r, const EffectContext& context) {
            return Parameters{
                {"tau_s", r.log_between(context.duration_s / 15.0, context.duration_s / 3.0)}};
          },
          [](const Parameters& p, const EffectContext&) {
            Parameters all;
            for (std::size_t i = 0; i < plant::laser_count; ++i) {
              all.emplace_back(laser_prefix(i) + "warmup", p[0].second);
              all.emplace_back(laser_prefix(i) + "warmup_tau_s", p[1].second);
            }
            return all;
          },
          "light on the sample is short at the start, unseen by the monitor"};
}

EffectKind wavelength_error() {
  return {
      "wavelength_error",
      true,
      1e-2,
      15.0,
      true,
      "shift_nm",
      [](Random& r, const EffectContext&) {
        return Parameters{{"wavelength_nm",
                           static_cast<double>(plant::laser_names[r.below(plant::laser_count)])}};
      },
      [](const Parameters& p, const EffectContext&) {
        return Parameters{
            {laser_prefix(laser_of(p[1].second)) + "wavelength_error_nm", p[0].second}};
      },
      "a laser off its wavelength"};
}

EffectKind laser_crosstalk() {
  return {"laser_crosstalk",
          true,
          1e-5,
          0.05,
          false,
          "fraction",
          [](Random& r, const EffectContext&) {
            const std::size_t into = r.below(plant::laser_count);
            const std::size_t from =
                (into + 1 + r.below(plant::laser_count - 1)) % plant::laser_count;
            return Parameters{{"into_nm", static_cast<double>(plant::laser_names[into])},
                              {"from_nm", static_cast<double>(plant::laser_names[from])}};
          },
          [](const Parameters& p, const EffectContext& context) {
            const std::size_t into = laser_of(p[1].second);
            const std::size_t from = laser_of(p[2].second);
            // The fraction is of the monitored light; the plant's share of the other's full power.
            const double share = p[0].second / (1.0 - p[0].second) * context.monitor_v[into] /
                                 context.monitor_v[from];
            return Parameters{
                {laser_prefix(into) + "crosstalk_from_" + std::to_string(plant::laser_names[from]),
                 share}};
          },
          "another laser leaks into the beam"};
}

EffectKind dust() {
  return {"dust",
          true,
          1e-6,
          0.5,
          false,
          "optical_depth_633",
          [](Random& r, const EffectContext&) {
            return Parameters{{"g", r.between(0.4, 0.8)},
                              {"single_scattering_albedo", r.between(0.6, 0.98)}};
          },
          [](const Parameters& p, const EffectContext&) {
            return Parameters{{"dust.optical_depth_633", p[0].second},
                              {"dust.g", p[1].second},
                              {"dust.single_scattering_albedo", p[2].second}};
          },
          "dust on the sample"};
}

EffectKind water_film() {
  return {"water_film",
          true,
          1e-5,
          0.95,
          false,
          "coverage",
          [](Random& r, const EffectContext& context) {
            // Slope of the film's own surface over the sample's; no film is flatter than .01.
            const double flattest = std::min(1.0, 0.01 / std::max(1e-3, context.slope_rms));
            return Parameters{{"smoothing", std::max(flattest, r.between(0.2, 0.6))}};
          },
          [](const Parameters& p, const EffectContext& context) {
            return Parameters{{"film.coverage", p[0].second},
                              {"film.slope_rms", p[1].second * context.slope_rms}};
          },
          "a film of water that levels the surface where it lies"};
}

EffectKind water_drops() {
  return {"water_drops",
          true,
          1e-5,
          0.8,
          false,
          "coverage",
          [](Random& r, const EffectContext&) {
            return Parameters{{"contact_angle_deg", r.between(10.0, 80.0)}};
          },
          [](const Parameters& p, const EffectContext&) {
            return Parameters{{"drops.coverage", p[0].second},
                              {"drops.contact_angle_deg", p[1].second}};
          },
          "drops of water"};
}

EffectKind near_specular_lobe() {
  return {
      "near_specular_lobe",
      true,
      1e-6,
      0.8,
      false,
      "weight",
      [](Random& r, const EffectContext& context) {
        return Parameters{
            {"sigma_slope", std::max(0.012, context.slope_rms * r.between(0.15, 0.45))}};
      },
      [](const Parameters& p, const EffectContext&) {
        return Parameters{{"marks.lobe_weight", p[0].second}, {"marks.lobe_slope", p[1].second}};
      },
      "a smoother part of the surface"};
}

EffectKind retroreflection_peak() {
  return {"retroreflection_peak",
          true,
          1e-6,
          3.0,
          false,
          "peak_per_sr",
          [](Random& r, const EffectContext&) {
            return Parameters{{"width_deg", r.log_between(1.0, 6.0)}};
          },
          [](const Parameters& p, const EffectContext&) {
            return Parameters{{"marks.retro_peak_per_sr", p[0].second},
                              {"marks.retro_width_deg", p[1].second}};
          },
          "light sent back where it came from"};
}

}  // namespace

std::vector<EffectKind> catalogue_effects() {
  const auto one = [](const char* name, const char* parameter, const char* setting, double smallest,
                      double largest, bool both_signs, const char* about) {
    return single_parameter(name, true, parameter, setting, smallest, largest, both_signs, about);
  };
  return {one("incidence_zero", "zero_deg", "axis.incidence.zero_deg", 1e-4, 1.0, true,
              "zero of the incidence stage"),
          one("detector_zero", "zero_deg", "axis.detector.zero_deg", 1e-4, 1.0, true,
              "zero of the detector's arm"),
          one("sample_tilt_in_plane", "tilt_deg", "mount.tilt_in_plane_deg", 1e-4, 1.0, true,
              "sample's normal leans along the plane of incidence"),
          one("sample_tilt_out_of_plane", "tilt_deg", "mount.tilt_out_of_plane_deg", 1e-3, 2.5,
              true, "sample's normal leans out of the plane of incidence"),
          eccentricity(),
          one("backlash", "gap_deg", "axis.detector.backlash_deg", 1e-4, 2.0, false,
              "play between motor and arm"),
          one("polarizer_leakage", "extinction", "polarizer.extinction", 1e-8, 0.3, false,
              "polariser passes crossed light"),
          one("analyzer_leakage", "extinction", "analyzer.extinction", 1e-8, 0.3, false,
              "analyser passes crossed light"),
          one("polarizer_rotation", "angle_deg", "axis.polarizer.zero_deg", 1e-3, 6.0, true,
              "polariser's axis turned in its carrier"),
          one("analyzer_rotation", "angle_deg", "axis.analyzer.zero_deg", 1e-3, 6.0, true,
              "analyser's axis turned in its carrier"),
          one("detector_polarization_bias", "bias", "detector.polarization_bias", 1e-5, 0.3, true,
              "photodiode favours s or p"),
          one("detector_nonlinearity", "kappa_per_v", "detector.nonlinearity_per_v", 1e-5, 5.0,
              false, "photodiode responds less than in proportion"),
          one("detector_saturation", "inverse_knee_per_v", "detector.inverse_knee_per_v", 1e-2,
              100.0, false, "photodiode flattens above a knee"),
          dark_offset(),
          one("stray_light", "level_per_sr", "collection.stray_per_sr", 1e-8, 0.1, false,
              "even stray light, with the laser"),
          stray_forward(),
          one("low_signal_pedestal", "pedestal_adc_v", "amplifier.pedestal_adc_v", 1e-5, 0.3, false,
              "rectified remainder at the ADC"),
          gain_ratio_error(),
          one("lockin_phase", "phase_deg", "amplifier.phase_deg", 1e-4, 20.0, true,
              "phase between reference and signal"),
          one("finite_aperture", "half_angle_deg", "collection.half_angle_deg", 2e-2, 3.0, false,
              "detector's disc averages the lobe"),
          one("beam_divergence", "rms_deg", "beam.divergence_rms_deg", 1e-2, 2.0, false,
              "beam's angles average the lobe"),
          laser_drift(),
          laser_warmup(),
          wavelength_error(),
          laser_crosstalk(),
          one("beam_overfill", "beam_over_sample", "beam.over_sample", 0.1, 1.5, false,
              "beam wider than the sample at grazing incidence"),
          one("detector_underfill", "beam_over_field", "collection.beam_over_field", 0.1, 1.5,
              false, "lit spot wider than the detector's field"),
          one("retro_occlusion", "half_angle_deg", "collection.retro_half_angle_deg", 1e-3, 12.0,
              false, "source optics before the detector at retro"),
          dust(),
          water_film(),
          water_drops(),
          near_specular_lobe(),
          retroreflection_peak(),
          one("fluorescence", "yield_532", "marks.fluorescence_yield_532", 1e-6, 0.5, false,
              "light emitted at longer wavelengths"),
          one("speckle", "contrast", "speckle.contrast", 1e-5, 0.2, false,
              "coherent granularity of the light")};
}

}  // namespace umov::blind
