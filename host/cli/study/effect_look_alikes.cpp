#include "host/cli/study/effect_look_alikes.hpp"

#include <array>

namespace umov::study {
namespace {

constexpr std::string_view zero_sign = "true angle = commanded angle + zero";
constexpr std::string_view flip_tells =
    "the sample turned by 180° (`flip`): a lean turns with it, a zero does not";
constexpr std::string_view pm45_tells =
    "polariser and analyser at ±45° (`pm45`), where a rotation acts in its first power";

constexpr std::array table{
    LookAlikes{"incidence_zero", zero_sign, "`detector_zero`, `sample_tilt_in_plane`", flip_tells},
    LookAlikes{"detector_zero", zero_sign,
               "`incidence_zero`, `sample_tilt_in_plane`; in a one-way scan `backlash` exactly",
               "the sample turned by 180° (`flip`), the other direction of travel (`serpentine`)"},
    LookAlikes{"sample_tilt_in_plane",
               "positive leans the normal to the mirror side: θi + δ, θr − δ",
               "`incidence_zero` with `detector_zero`, exactly in the plane", flip_tells},
    LookAlikes{"sample_tilt_out_of_plane", "positive leans the normal to +y",
               "roughness and index of the base; it goes with the tilt's square in the plane",
               "directions out of the plane (`oop`), ±45° channels (`pm45`)"},
    LookAlikes{"detector_eccentricity", "true angle = commanded + A sin(θr + phase)",
               "`detector_zero`, where the range of θr is short",
               "a white tile (`white_tile`) and a wider range of angles"},
    LookAlikes{"backlash", "whole play; the arm lags by half of it against the last move",
               "`detector_zero` where all rows were measured in one direction",
               "every second row in the other direction (`serpentine`, `reverse`)"},
    LookAlikes{"polarizer_leakage", "", "`polarizer_rotation`, `analyzer_leakage`", pm45_tells},
    LookAlikes{"analyzer_leakage", "", "`analyzer_rotation`, `polarizer_leakage`", pm45_tells},
    LookAlikes{"polarizer_rotation", "added to the commanded axis, from p towards s",
               "`polarizer_leakage`: both go into the crossed channels, as sin² of the angle",
               pm45_tells},
    LookAlikes{"analyzer_rotation", "added to the commanded axis, from p towards s",
               "`analyzer_leakage`", pm45_tells},
    LookAlikes{"detector_polarization_bias", "positive: the detector favours s",
               "`laser_drift`, where channels follow one another in time",
               "another order of the channels (`repeat`)"},
    LookAlikes{"detector_nonlinearity", "positive: bright signals read too low",
               "`detector_saturation`, `gain_ratio_error`", "several powers of the source (`nd`)"},
    LookAlikes{"detector_saturation", "", "`detector_nonlinearity`",
               "several powers of the source (`nd`)"},
    LookAlikes{"dark_offset", "added to X; its quadrature is `y_fraction` of it",
               "`stray_light` at one power of the source",
               "the shutter closed (`shutter`): an offset stays, stray light goes"},
    LookAlikes{"stray_light", "", "`dark_offset`, diffuse light of the base",
               "the shutter closed (`shutter`), no sample (`no_sample`)"},
    LookAlikes{"stray_forward", "", "`dust` that scatters forwards", "no sample (`no_sample`)"},
    LookAlikes{"low_signal_pedestal", "", "`stray_light`, `dark_offset`",
               "the shutter closed (`shutter`) with neutral density (`nd`)"},
    LookAlikes{"gain_ratio_error", "positive: the range reads too high; range 1 is exact",
               "`detector_nonlinearity`", "the same points in both ranges (`nd`)"},
    LookAlikes{"lockin_phase", "X + iY turns by the angle",
               "a gain, where only X was recorded; nothing where Y was", ""},
    LookAlikes{"finite_aperture", "the base sees a point; ΔΩ is kept",
               "`beam_divergence`, roughness", "a smaller aperture (`iris`)"},
    LookAlikes{"beam_divergence", "", "`finite_aperture`, roughness, `near_specular_lobe`",
               "a smaller aperture (`iris`), which leaves it as it is"},
    LookAlikes{"laser_drift", "positive: brighter at the end; what the monitor sees is none",
               "gains and polarisation bias, where channels follow one another in time",
               "reference points measured again (`repeat`)"},
    LookAlikes{"laser_warmup", "positive: darker at the start", "`laser_drift`",
               "reference points measured again (`repeat`)"},
    LookAlikes{"wavelength_error", "true minus stated wavelength", "`laser_crosstalk`", ""},
    LookAlikes{"laser_crosstalk", "", "`wavelength_error`", ""},
    LookAlikes{"beam_overfill", "", "`dust`, `detector_underfill`", "a smaller beam"},
    LookAlikes{"detector_underfill", "", "`beam_overfill`, fading diffuse light", "a smaller beam"},
    LookAlikes{"retro_occlusion", "", "nothing: a hole about θr = −θi", ""},
    LookAlikes{"dust", "", "`stray_forward`, `beam_overfill`, albedo and index of the base",
               "cleaning and measuring again; no sample (`no_sample`)"},
    LookAlikes{"water_film", "", "albedo, index and roughness of the base",
               "drying and measuring again"},
    LookAlikes{"water_drops", "", "a second roughness, `water_film`", "drying and measuring again"},
    LookAlikes{"near_specular_lobe", "", "`beam_divergence` in part",
               "a smaller aperture (`iris`)"},
    LookAlikes{"retroreflection_peak", "", "nothing: a peak about θr = −θi", ""},
    LookAlikes{"speckle", "",
               "noise that is new in every record and that neither the monitor nor the scatter "
               "within a record sees (`unseen_noise`)",
               "the same places measured again (`repeat`, `reverse`): speckle comes back"},
    LookAlikes{"fluorescence", "", "diffuse light of the base at the shortest wavelength, exactly",
               "a long-pass filter before the detector (`long_pass`)"},
    LookAlikes{"sample_model", "",
               "instrument effects that broaden or move the lobe; both then stand in one set",
               "another sample on the same instrument (`white_tile`)"},
};

}  // namespace

const LookAlikes* look_alikes_of(std::string_view effect) {
  for (const LookAlikes& entry : table)
    if (entry.effect == effect) return &entry;
  return nullptr;
}

}  // namespace umov::study
