// The effects of a gonioreflectometer scan, declared once: names, parameters, physics, sources and
// the probes their signatures are taken at.
#include <algorithm>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "host/gap/scan/effect_list.hpp"
#include "host/gap/scan/effects/free_form.hpp"

namespace umov::gap::scan {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

Parameter signed_number(const char* name, const char* unit, const char* meaning, double usual,
                        double limit) {
  return {name, unit, meaning, 0.0, -limit, limit, usual};
}

Parameter one_sided(const char* name, const char* unit, const char* meaning, double usual,
                    double limit) {
  return {name, unit, meaning, 0.0, 0.0, limit, usual};
}

/// A parameter that only shapes what the first one scales: all of its range is as good.
Parameter shaping(const char* name, const char* unit, const char* meaning, double lo, double hi) {
  Parameter p{name, unit, meaning, 0.5 * (lo + hi), lo, hi, (hi - lo) / std::sqrt(12.0)};
  p.shape = true;
  return p;
}

Parameter choosing(const char* name, const char* unit, const char* meaning) {
  Parameter p{name, unit, meaning, 0.0};
  p.choice = true;
  return p;
}

std::vector<std::vector<Probe>> single(double size) {
  return {{{size}}};
}

/// One alternative for each value of a shaping parameter.
std::vector<std::vector<Probe>> alternatives(double size, std::initializer_list<double> shapes) {
  std::vector<std::vector<Probe>> groups;
  for (const double shape : shapes) groups.push_back({{size, shape}});
  return groups;
}

std::vector<std::vector<Probe>> sizes(std::initializer_list<double> values) {
  std::vector<std::vector<Probe>> groups;
  for (const double value : values) groups.push_back({{value}});
  return groups;
}

class Catalogue {
 public:
  explicit Catalogue(const Scale& scale) : scale_(scale), effects_(effect_count) {}

  std::vector<Effect> make() {
    geometry();
    polarisation();
    detector();
    background();
    source();
    footprint();
    contamination();
    lobes();
    scatter();
    reflectance();
    return std::move(effects_);
  }

 private:
  void add(EffectId id, const char* name, const char* stage, const char* physics,
           const char* source, std::vector<Parameter> parameters,
           std::vector<std::vector<Probe>> probes) {
    effects_[number(id)] = {name, stage, physics, source, std::move(parameters)};
    effects_[number(id)].of_object = std::string_view(stage) == "sample";
    effects_[number(id)].probes = std::move(probes);
  }

  void add_family(EffectId id, const char* family, const char* physics, const char* source,
                  std::vector<Parameter> parameters, std::vector<std::vector<Probe>> probes) {
    add(id, sample_model, "sample", physics, source, std::move(parameters), std::move(probes));
    effects_[number(id)].family = family;
  }

  void geometry() {
    const auto zero = [](const char* name, const char* meaning) {
      return signed_number(name, "deg", meaning, 0.1, 3);
    };
    add(EffectId::incidence_zero, "incidence_zero", "geometry",
        "The zero of the incidence stage is off: the lobe moves by the same angle at every "
        "wavelength, odd about the mirror direction.",
        "zero error of a rotary stage", {zero("zero_deg", "true minus commanded angle")},
        single(0.01));
    add(EffectId::detector_zero, "detector_zero", "geometry",
        "The zero of the detector arm is off.", "zero error of a rotary stage",
        {zero("zero_deg", "true minus commanded angle")}, single(0.01));
    add(EffectId::sample_tilt_in_plane, "sample_tilt_in_plane", "geometry",
        "The sample's normal leans in the plane of incidence: both angles change, oppositely.",
        "rigid-body geometry", {zero("tilt_deg", "lean of the normal towards the mirror side")},
        single(0.01));
    add(EffectId::sample_tilt_out_of_plane, "sample_tilt_out_of_plane", "geometry",
        "The normal leans out of the plane of incidence: the lobe's peak passes beside the "
        "detector, and the planes of polarisation turn.",
        "rigid-body geometry", {zero("tilt_deg", "lean of the normal towards +y")},
        // Odd in the polarisation channels at ±45°, even in all others: both must be seen.
        {{{0.2}}, {{-0.2}}});
    add(EffectId::detector_eccentricity, "detector_eccentricity", "geometry",
        "The arm's scale does not turn about its own centre: an angle error once a turn.",
        "eccentricity of a divided circle",
        {signed_number("amplitude_deg", "deg", "largest error", 0.1, 3),
         shaping("phase_deg", "deg", "error = amplitude · sin(angle + phase)", -180, 180)},
        {{{0.01, 0}, {0.01, 90}}});
    add(EffectId::backlash, "backlash", "geometry",
        "Play between motor and arm: the error has the sign of the last move.", "gear play",
        {one_sided("gap_deg", "deg", "whole play", 0.1, 3)}, single(0.01));
    add(EffectId::finite_aperture, "finite_aperture", "geometry",
        "The detector's disc averages the radiance over its solid angle: a second derivative at "
        "the lobe.",
        "ASTM E2387, detector aperture",
        {one_sided("half_angle_deg", "deg", "half angle of the detector disc", 0.5, 5)},
        single(0.3));
    add(EffectId::beam_divergence, "beam_divergence", "geometry",
        "The incident rays spread: the lobe is averaged over angles of incidence.", "Gaussian beam",
        {one_sided("rms_deg", "deg", "rms angle on each axis", 0.25, 3)}, single(0.15));
  }

  void polarisation() {
    const auto leak = one_sided("extinction", "1", "power ratio crossed to parallel", 3e-3, 0.3);
    const auto turn = signed_number("angle_deg", "deg", "axis minus command, p towards s", 0.5, 10);
    add(EffectId::polarizer_leakage, "polarizer_leakage", "polarisation",
        "The polariser passes some of the crossed polarisation: the strong channels leak into the "
        "crossed ones, most of all where the surface reflects.",
        "Malus' law with finite extinction", {leak}, single(1e-4));
    add(EffectId::analyzer_leakage, "analyzer_leakage", "polarisation",
        "The analyser passes some of the crossed polarisation.",
        "Malus' law with finite extinction", {leak}, single(1e-4));
    add(EffectId::polarizer_rotation, "polarizer_rotation", "polarisation",
        "The polariser's axis is turned: sin² of the angle in the crossed channels, linear only "
        "off the s and p axes.",
        "Malus' law", {turn}, {{{0.3}}, {{-0.3}}});
    add(EffectId::analyzer_rotation, "analyzer_rotation", "polarisation",
        "The analyser's axis is turned.", "Malus' law", {turn}, {{{0.3}}, {{-0.3}}});
  }

  void detector() {
    const double full = std::max(scale_.largest_signal_v, 1e-9);
    add(EffectId::detector_polarization_bias, "detector_polarization_bias", "detector",
        "The detector answers differently to s and p: a factor for each analyser position.",
        "Fresnel loss at a tilted detector window",
        {signed_number("bias", "1", "response to Stokes (1, δ, 0, 0), + favours s", 0.01, 0.5)},
        single(1e-3));
    add(EffectId::detector_nonlinearity, "detector_nonlinearity", "detector",
        "The response bends with the signal: S/(1 + κS).",
        "photodiode supralinearity, series "
        "resistance",
        {signed_number("kappa_per_v", "1/V", "κ at the signal of range 1", 0.01 / full, 1 / full)},
        single(1e-4 / full));
    add(EffectId::detector_saturation, "detector_saturation", "detector",
        "Above a knee the detector flattens although the converter does not clip.",
        "photodiode saturation",
        {one_sided("inverse_knee_per_v", "1/V", "inverse of the knee", 0.5 / full, 5 / full)},
        sizes({0.3 / full, 0.8 / full, 1.6 / full}));
    add(EffectId::gain_ratio_error, "gain_ratio_error", "electronics",
        "The amplifier's ranges are not exact decades: a step where the range changes.",
        "feedback resistor tolerance",
        {signed_number("error_10", "1", "relative error of range 10", 0.02, 0.2),
         signed_number("error_100", "1", "of range 100", 0.02, 0.2),
         signed_number("error_1000", "1", "of range 1000", 0.02, 0.2)},
        {{{1e-4, 0, 0}, {0, 1e-4, 0}, {0, 0, 1e-4}}});
    add(EffectId::lockin_phase, "lockin_phase", "electronics",
        "Reference and signal are not in phase: quadrature appears and the in-phase part shrinks.",
        "lock-in detection", {signed_number("phase_deg", "deg", "X + iY turns by it", 0.3, 45)},
        single(0.01));
  }

  void background() {
    const double adc = std::max(scale_.typical_adc_v, 1e-6);
    add(EffectId::dark_offset, "dark_offset", "electronics",
        "A constant adds to the lock-in's output, with the shutter closed too.",
        "electrical pick-up of the reference",
        {signed_number("offset_v", "V", "in-phase part, range 1", 3e-5, 0.1),
         shaping("y_fraction", "1", "its quadrature over it", -1, 1)},
        {{{1e-6, 0}}, {{1e-6, 0.5}}, {{1e-6, -0.5}}});
    add(EffectId::stray_light, "stray_light", "collection",
        "Light that reaches the detector by other ways than the sample, in proportion to the "
        "laser's power, unpolarised, even in angle.",
        "scatter in the enclosure",
        {one_sided("level_per_sr", "1/sr", "BRDF·cos equivalent", 3e-4, 0.1)}, single(1e-6));
    add(EffectId::stray_forward, "stray_forward", "collection",
        "Stray light about the forward grazing direction: the beam that passes the sample.",
        "beam skirts past the sample",
        {one_sided("level_per_sr", "1/sr", "BRDF·cos equivalent at its peak", 1e-3, 1),
         shaping("width_deg", "deg", "rms angle about the forward grazing direction", 2, 40)},
        alternatives(1e-6, {5, 10, 20}));
    add(EffectId::low_signal_pedestal, "low_signal_pedestal", "electronics",
        "Rectified noise lifts small signals: √(raw² + p²) at the converter.",
        "magnitude detection of noise",
        {one_sided("pedestal_adc_v", "V", "p at the converter", 0.02 * adc, adc)},
        sizes({0.01 * adc, 0.05 * adc}));
  }

  void source() {
    add(EffectId::laser_drift, "laser_drift", "source",
        "The light on the sample changes steadily through the scan, unseen by the monitor.",
        "pointing drift through a monitor pick-off",
        {signed_number("total", "1", "relative change over the scan", 0.01, 0.5)}, single(1e-3));
    add(EffectId::laser_warmup, "laser_warmup", "source",
        "The light approaches its final level exponentially, unseen by the monitor.",
        "thermal settling of a diode laser",
        {signed_number("amplitude", "1", "relative lack at the start", 0.01, 0.5),
         shaping("tau_s", "s", "time constant", 0.01 * scale_.duration_s, scale_.duration_s)},
        alternatives(1e-3,
                     {0.03 * scale_.duration_s, 0.1 * scale_.duration_s, 0.3 * scale_.duration_s}));
    std::vector<std::vector<Probe>> shifts, mixtures;
    const auto& nm = scale_.wavelengths_nm;
    for (const double own : nm) {
      if (nm.size() > 1) shifts.push_back({{0.1, own}});
      for (const double other : nm)
        if (own != other) mixtures.push_back({{1e-4, own, other}});
    }
    add(EffectId::wavelength_error, "wavelength_error", "source",
        "One laser's wavelength is not the stated one: the sample shows the reflectance of a "
        "neighbouring wavelength.",
        "diode laser tolerance",
        {signed_number("shift_nm", "nm", "true minus stated", 2, 30),
         choosing("wavelength_nm", "nm", "the laser concerned")},
        shifts);
    add(EffectId::laser_crosstalk, "laser_crosstalk", "source",
        "Some of another laser's light is in the beam.", "leakage of a source selector",
        {one_sided("fraction", "1", "share of the foreign light", 3e-3, 0.5),
         choosing("into_nm", "nm", "the laser selected"),
         choosing("from_nm", "nm", "the laser that leaks")},
        mixtures);
  }

  void footprint() {
    Parameter over =
        one_sided("beam_over_sample", "1", "1/e² radius over the sample's radius", 0.3, 3);
    Parameter under =
        one_sided("beam_over_field", "1", "1/e² radius over the field's radius", 0.3, 3);
    over.lo = over.absent = under.lo = under.absent = 0.05;
    add(EffectId::beam_overfill, "beam_overfill", "geometry",
        "At oblique incidence the footprint grows beyond the sample and light is lost.",
        "projected footprint", {over}, sizes({0.2, 0.25, 0.3, 0.36, 0.43, 0.55, 0.8, 1.1}));
    add(EffectId::detector_underfill, "detector_underfill", "geometry",
        "The footprint grows beyond the detector's field of view.", "projected footprint", {under},
        sizes({0.2, 0.25, 0.3, 0.36, 0.43, 0.55, 0.8, 1.1}));
    add(EffectId::retro_occlusion, "retro_occlusion", "geometry",
        "The detector's head stands in the beam: a hole about the way back to the source.",
        "shadow of the detector head",
        {one_sided("half_angle_deg", "deg", "of the head as seen from the sample", 1, 10),
         shaping("beam_rms_deg", "deg", "rms width of the beam at the head", 0.05, 3)},
        {{{0.1, 0.15}}, {{0.2, 0.4}}, {{0.5, 1.0}}, {{2.0, 0.3}}});
  }

  void contamination() {
    add(EffectId::dust, "dust", "sample",
        "A thin layer of particles takes light out of both beams and scatters some of it by "
        "itself.",
        "single scattering layer, Chandrasekhar; Henyey-Greenstein phase function",
        {one_sided("optical_depth_633", "1", "at 633 nm, in proportion to 1/λ", 3e-3, 0.5),
         shaping("g", "1", "asymmetry of the scattering", -0.2, 0.95),
         shaping("single_scattering_albedo", "1", "scattered part of what is taken out", 0.1, 1)},
        {{{1e-4, 0.2, 0.9}}, {{1e-4, 0.6, 0.8}}, {{1e-4, 0.85, 0.9}}, {{1e-4, 0.5, 0.3}}});
    add(EffectId::water_film, "water_film", "sample",
        "Water fills the roughness of part of the sample: a smoother lobe of index 1.33 and a "
        "darker base.",
        "Lekner and Dorf 1988",
        {one_sided("coverage", "1", "share of the area", 0.03, 1),
         shaping("smoothing", "1", "slope of the film over the dry surface's", 0.1, 1)},
        alternatives(1e-3, {0.2, 0.4, 0.7}));
    add(EffectId::water_drops, "water_drops", "sample",
        "Drops cover part of the sample: caps whose normals reach up to the contact angle.",
        "spherical caps",
        {one_sided("coverage", "1", "share of the area", 0.03, 1),
         shaping("contact_angle_deg", "deg", "at the rim", 5, 88)},
        alternatives(1e-3, {10, 25, 50, 80}));
  }

  void lobes() {
    const double narrow = std::max(scale_.slope_rms, 1e-3);
    add(EffectId::near_specular_lobe, "near_specular_lobe", "sample",
        "A narrow extra lobe about the mirror direction, the same at all wavelengths: a smooth "
        "part of the surface.",
        "two-scale roughness",
        {one_sided("weight", "1", "share of the facets", 0.03, 1),
         shaping("sigma_slope", "1", "rms slope", 0.05 * narrow, 0.6 * narrow)},
        alternatives(1e-4, {0.12 * narrow, 0.25 * narrow, 0.45 * narrow}));
    add(EffectId::retroreflection_peak, "retroreflection_peak", "sample",
        "A peak about the way back to the source: coherent backscatter or corner reflections.",
        "Hapke 1986",
        {one_sided("peak_per_sr", "1/sr", "height", 3e-3, 10),
         shaping("width_deg", "deg", "rms angle", 0.5, 30)},
        alternatives(1e-5, {1.5, 4, 10}));
    add(EffectId::fluorescence, "fluorescence", "sample",
        "The shortest wavelength excites longer ones that the detector sees too: unpolarised, "
        "Lambertian, behind a long-pass filter still there.",
        "fluorescent pigments",
        {one_sided("yield_532", "1", "albedo equivalent at the shortest wavelength", 3e-3, 1)},
        single(1e-5));
  }

  void scatter() {
    add(EffectId::speckle, "speckle", "sample",
        "Coherent light on a rough sample is granular: each place, wavelength and polarisation has "
        "its own deviation from the mean, the same again whenever it is measured again. The "
        "detector's disc averages the grains it holds, contrast 1/√(grains), beam area · solid "
        "angle / wavelength² of them: 1e4 for a bench.",
        "Goodman, Speckle Phenomena in Optics, 2007, ch. 4",
        {one_sided("contrast", "1", "standard deviation over mean of the light", 3e-3, 0.5)}, {});
    effects_[number(EffectId::speckle)].scatter = true;
  }

  /// One number a wavelength, tried together.
  void spectral_family(EffectId id, const char* family, const char* physics, const char* source,
                       double usual) {
    std::vector<Parameter> parameters;
    std::vector<Probe> probes;
    const std::size_t n = scale_.wavelengths_nm.size();
    for (std::size_t i = 0; i < n; ++i) {
      Parameter p = signed_number("", "1/sr", "size at this wavelength", usual, 10);
      p.name = fmt::format("weight_{:g}", scale_.wavelengths_nm[i]);
      parameters.push_back(p);
      Probe probe(n, 0.0);
      probe[i] = 1e-4;
      probes.push_back(probe);
    }
    add_family(id, family, physics, source, std::move(parameters), {std::move(probes)});
  }

  void forward_lobe() {
    std::vector<Parameter> parameters;
    for (const double nm : scale_.wavelengths_nm) {
      Parameter p = signed_number("", "1/sr", "height at this wavelength", 0.03, 10);
      p.name = fmt::format("peak_{:g}", nm);
      parameters.push_back(p);
    }
    parameters.push_back(shaping("width_deg", "deg", "rms angle", 2, 60));
    parameters.push_back(shaping("polarization", "1", "polarisation kept", 0, 1));
    parameters.push_back(choosing(
        "about_planes", "1", "polarisation kept about 0: the facet, 1: the planes of both beams"));
    std::vector<std::vector<Probe>> probes;
    for (const double width : {6.0, 15.0, 35.0}) {
      for (const auto& [kept, about] : {std::pair{0.1, 0.0}, {0.9, 0.0}, {0.9, 1.0}}) {
        std::vector<Probe> group;
        for (std::size_t i = 0; i < scale_.wavelengths_nm.size(); ++i) {
          Probe probe(parameters.size(), 0.0);
          probe[i] = 1e-4;
          probe[parameters.size() - 3] = width;
          probe[parameters.size() - 2] = kept;
          probe[parameters.size() - 1] = about;
          group.push_back(std::move(probe));
        }
        probes.push_back(std::move(group));
      }
    }
    add_family(EffectId::forward_lobe, "forward-lobe",
               "A broad lobe about the mirror direction from below the surface, its strength by "
               "wavelength (P11).",
               "Li and Torrance 2005", std::move(parameters), std::move(probes));
  }

  /// `usual`: of each term.
  void free_form(EffectId id, const char* family, const char* physics,
                 const std::vector<double>& usual) {
    std::vector<Parameter> parameters;
    std::vector<Probe> probes;
    for (std::size_t i = 0; i < usual.size(); ++i) {
      Parameter p = signed_number("", "1", "coefficient of the series", usual[i], 3);
      p.name = fmt::format("term_{}", i + 1);
      parameters.push_back(p);
      Probe probe(usual.size(), 0.0);
      probe[i] = 1e-3;
      probes.push_back(probe);
    }
    add_family(id, family, physics, "a smooth series", std::move(parameters), {std::move(probes)});
  }

  /// Sizes of a series of products: smooth ones are the rule, so that fine terms are small ones.
  static std::vector<double> falling(SeriesId id, double usual) {
    std::vector<double> sizes;
    for_each_product(id, [&](std::size_t, std::size_t k, std::size_t l) {
      sizes.push_back(usual / (1.0 + 0.25 * static_cast<double>(k * k + l * l)));
    });
    return sizes;
  }

  void free_forms() {
    const std::size_t wavelengths = scale_.wavelengths_nm.size();
    const auto joined = [](std::vector<double> sizes, std::size_t more, double usual) {
      sizes.insert(sizes.end(), more, usual);
      return sizes;
    };
    const auto repeated = [&](const std::vector<double>& sizes) {
      std::vector<double> all;
      for (std::size_t w = 0; w < wavelengths; ++w)
        all.insert(all.end(), sizes.begin(), sizes.end());
      return all;
    };
    free_form(EffectId::free_slopes, "free-slopes", "A density of slopes of any smooth shape.",
              std::vector<double>(slope_terms, 0.1));
    free_form(EffectId::fine_slopes, "fine-slopes",
              "A density of slopes with humps and edges: slopes that a finish prefers.",
              std::vector<double>(fine_slope_terms, 0.1));
    free_form(EffectId::free_lobe, "free-lobe",
              "A lobe whose shape and polarisation change with the angle between the beams, and "
              "its width by wavelength.",
              joined(falling(SeriesId::growth, 0.15), lobe_extra + wavelengths, 0.1));
    free_form(EffectId::spectral_lobe, "spectral-lobe",
              "A lobe whose height and shape follow the wavelength, as where roughness is not "
              "large against it.",
              repeated(falling(SeriesId::spectral_lobe, 0.05)));
    std::vector<double> diffuse = falling(SeriesId::diffuse_shape, 0.3);
    const std::vector<double> kept = falling(SeriesId::kept, 0.1);
    diffuse.insert(diffuse.end(), kept.begin(), kept.end());
    free_form(EffectId::free_diffuse, "free-diffuse",
              "Diffuse light of any smooth reciprocal shape, partly polarised.",
              joined(diffuse, diffuse_extra, 0.1));
    free_form(EffectId::spectral_diffuse, "spectral-diffuse",
              "Diffuse light whose shape follows the wavelength: the less is absorbed, the more "
              "often it is scattered.",
              repeated(falling(SeriesId::spectral_diffuse, 0.05)));
    free_form(EffectId::azimuthal_diffuse, "azimuthal-diffuse",
              "Diffuse light that out of the plane of incidence depends on either direction, not "
              "only on the angles between them and the half direction.",
              std::vector<double>(azimuthal_terms, 0.1));
    add_family(EffectId::anisotropic_slopes, "anisotropic",
               "Slopes larger along one direction of the surface than across it, as grinding "
               "leaves them.",
               "Gaussian slopes with two widths",
               {signed_number("ln_ratio", "1", "ln of the slope across over that along", 0.5, 2),
                shaping("turn_deg", "deg", "of the axis from the plane of incidence", -90, 90)},
               {{{0.02, 0.0}}, {{-0.02, 0.0}}, {{0.02, 45.0}}, {{0.02, -45.0}}});
    // In the plane of incidence there is nothing of one, and the other is a lobe like any other.
    if (!scale_.out_of_plane)
      for (const EffectId id : {EffectId::azimuthal_diffuse, EffectId::anisotropic_slopes})
        effects_[number(id)].probes.clear();
  }

  void reflectance() {
    add_family(EffectId::long_tails, "ggx",
               "Slopes with longer tails than a Gaussian's: part or all of the lobe has "
               "Trowbridge and Reitz's distribution of the same slope at its centre.",
               "Walter et al. 2007",
               {one_sided("share", "1", "part of the lobe that has long tails", 0.5, 1)},
               sizes({0.02}));
    add_family(EffectId::wave_lobe, "he-torrance",
               "Waves instead of facets: where heights are not large against the wavelength the "
               "lobe is wider at long wavelengths and towards grazing, and its shoulders are "
               "higher than a Gaussian's (P10).",
               "He, Torrance, Sillion and Greenberg 1991",
               {one_sided("share", "1", "part of the lobe that follows waves", 0.5, 1),
                shaping("inverse_height_per_um", "1/um", "1 over the rms height", 0.05, 8)},
               alternatives(0.05, {0.2, 0.6, 1.5, 4.0}));
    add_family(EffectId::second_roughness, "microfacet+microfacet", "Two roughnesses side by side.",
               "two-population surface",
               {signed_number("weight", "1", "share of the second roughness", 0.1, 1),
                shaping("slope_ratio", "1", "its slope over the first's", 0.2, 5)},
               alternatives(0.01, {0.4, 0.65, 1.5, 2.5}));
    forward_lobe();
    spectral_family(EffectId::volume_diffuse, "beard-maxwell",
                    "Diffuse light from below that grows towards grazing, 2/(cos θi + cos θr).",
                    "Maxwell and Beard 1973", 0.02);
    spectral_family(EffectId::interface_diffuse, "interface-diffuse",
                    "Diffuse light that crosses the surface twice and fades towards grazing.",
                    "Fresnel transmittance in both directions", 0.02);
    spectral_family(EffectId::polarised_diffuse, "polarised-diffuse",
                    "Diffuse light that keeps part of its polarisation.",
                    "few scatterings below the surface", 0.01);
    free_forms();
    for (const EffectId id :
         {EffectId::free_slopes, EffectId::fine_slopes, EffectId::free_lobe,
          EffectId::spectral_lobe, EffectId::free_diffuse, EffectId::spectral_diffuse,
          EffectId::azimuthal_diffuse, EffectId::anisotropic_slopes, EffectId::long_tails,
          EffectId::wave_lobe, EffectId::second_roughness, EffectId::forward_lobe,
          EffectId::volume_diffuse, EffectId::interface_diffuse, EffectId::polarised_diffuse})
      effects_[number(id)].structural = true;
    for (const EffectId id :
         {EffectId::free_slopes, EffectId::fine_slopes, EffectId::free_lobe,
          EffectId::spectral_lobe, EffectId::free_diffuse, EffectId::spectral_diffuse,
          EffectId::azimuthal_diffuse, EffectId::volume_diffuse, EffectId::interface_diffuse,
          EffectId::polarised_diffuse})
      effects_[number(id)].linear = true;
  }

  const Scale& scale_;
  std::vector<Effect> effects_;
};

}  // namespace

std::vector<Effect> catalogue(const Scale& scale) {
  return Catalogue(scale).make();
}

}  // namespace umov::gap::scan
