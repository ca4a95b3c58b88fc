#include "hil/blind/case_draw.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <utility>

#include "hil/blind/record_noise.hpp"

namespace umov::blind {
namespace {

constexpr double open = std::numeric_limits<double>::quiet_NaN();
constexpr int most_attempts = 60;

/// Effects that another one of the catalogue imitates in a scan of this style.
std::vector<std::string> confounded_in(Style style) {
  std::vector<std::string> names = {"finite_aperture", "beam_divergence"};
  const bool one_way = style == Style::one_way || style == Style::pm45;
  const bool axes_only = style == Style::one_way || style == Style::serpentine;
  if (style != Style::full) {
    names.insert(names.end(), {"incidence_zero", "detector_zero", "sample_tilt_in_plane",
                               "dark_offset", "stray_light"});
  }
  if (one_way) names.emplace_back("backlash");
  if (axes_only) {
    names.insert(names.end(), {"polarizer_leakage", "analyzer_leakage", "polarizer_rotation",
                               "analyzer_rotation"});
  }
  return names;
}

}  // namespace

bool needs_blocks(const std::string& effect) {
  // Seen with the shutter closed only, and behind the long-pass filter only (without it the same as
  // the base's own albedo).
  return effect == "shutter_leak" || effect == "fluorescence";
}

namespace {

std::vector<std::string> candidates(CaseClass kind, Style style, const CaseOptions& options) {
  if (options.only_effect) return {*options.only_effect};
  if (kind == CaseClass::confounded) return confounded_in(style);
  std::vector<std::string> names;
  for (const EffectKind& k : effect_kinds()) {
    if (k.in_catalogue == (kind == CaseClass::foreign)) continue;
    if (needs_blocks(k.name) && style != Style::full) continue;
    names.push_back(k.name);
  }
  return names;
}

/// One effect of a drawn kind with a drawn ρ, of none of the kinds in `taken`.
std::optional<Effect> draw_one(const ChangeMeter& meter, const std::vector<std::string>& names,
                               const std::set<std::string>& taken, const CaseOptions& options,
                               CaseClass kind, Random& random) {
  for (int attempt = 0; attempt < most_attempts; ++attempt) {
    const double target = random.log_between(options.rho_from, options.rho_to);
    // The same ρ for other kinds: what is hard to reach must not thin out the large ones.
    for (int redraw = 0; redraw < 8; ++redraw) {
      const std::string& name = names[random.below(names.size())];
      if (taken.contains(name)) continue;
      const EffectKind& k = effect_kind(name);
      Effect trial =
          draw_effect(k, random, meter.world().context, std::sqrt(k.smallest * k.largest));
      if (kind == CaseClass::confounded && name == "dark_offset") trial.parameters[1].second = 0.0;
      if (auto effect = sized(meter, trial, target)) return effect;
      if (names.size() == 1 && redraw >= 2) return std::nullopt;
    }
  }
  return std::nullopt;
}

/// ρ of each beside the others.
void rate_together(const ChangeMeter& meter, std::vector<Effect>& effects) {
  std::vector<std::vector<double>> parts;
  for (const Effect& e : effects) {
    parts.push_back(e.name == "speckle" ? std::vector<double>{} : meter.left({&e, 1}));
  }
  for (std::size_t i = 0; i < effects.size(); ++i) {
    Subspace others = meter.refit();
    for (std::size_t j = 0; j < effects.size(); ++j) {
      if (j != i && !parts[j].empty()) others.add(parts[j]);
    }
    effects[i].rho_given_others = parts[i].empty() ? effects[i].rho : length(others.rest(parts[i]));
  }
}

void sort_by_rho(std::vector<Effect>& effects) {
  std::stable_sort(effects.begin(), effects.end(),
                   [](const Effect& a, const Effect& b) { return a.rho > b.rho; });
}

Effect usual(const char* name, std::vector<Named> parameters) {
  Effect effect;
  effect.name = name;
  effect.parameters = std::move(parameters);
  return effect;
}

/// The sizes of a good real bench: those of the plant's `realistic` preset, and a little dust and
/// speckle. The lock-in's phase is trimmed, and source optics hardly reach into the retro
/// direction: in the preset's size each of them is larger than all others together.
std::vector<Effect> usual_effects(const EffectContext& context) {
  return {
      usual("incidence_zero", {{"zero_deg", 0.03}}),
      usual("detector_zero", {{"zero_deg", 0.02}}),
      usual("sample_tilt_in_plane", {{"tilt_deg", 0.03}}),
      usual("sample_tilt_out_of_plane", {{"tilt_deg", 0.04}}),
      usual("detector_eccentricity", {{"amplitude_deg", 0.02}, {"phase_deg", 117.0}}),
      usual("backlash", {{"gap_deg", 0.02}}),
      usual("polarizer_leakage", {{"extinction", 1e-4}}),
      usual("analyzer_leakage", {{"extinction", 1e-4}}),
      usual("polarizer_rotation", {{"angle_deg", 0.15}}),
      usual("analyzer_rotation", {{"angle_deg", 0.10}}),
      usual("detector_polarization_bias", {{"bias", 0.004}}),
      usual("detector_nonlinearity", {{"kappa_per_v", 1.5e-4}}),
      usual("detector_saturation", {{"inverse_knee_per_v", 0.1}}),
      usual("dark_offset", {{"offset_v", 4e-7}, {"y_fraction", 0.5}}),
      usual("stray_light", {{"level_per_sr", 2e-5}}),
      usual("stray_forward", {{"level_per_sr", 5e-5}, {"width_deg", 10.0}}),
      usual("low_signal_pedestal", {{"pedestal_adc_v", 5e-5}}),
      usual("gain_ratio_error",
            {{"error_10", 0.0010}, {"error_100", -0.0015}, {"error_1000", 0.0020}}),
      usual("lockin_phase", {{"phase_deg", 0.01}}),
      usual("finite_aperture", {{"half_angle_deg", 0.3233}}),
      usual("beam_divergence", {{"rms_deg", 0.03}}),
      usual("laser_drift", {{"total", 0.002}}),
      usual("laser_warmup", {{"amplitude", 0.002}, {"tau_s", context.duration_s / 6.0}}),
      usual("wavelength_error", {{"shift_nm", 0.6}, {"wavelength_nm", 814.0}}),
      usual("laser_crosstalk", {{"fraction", 1e-4}, {"into_nm", 532.0}, {"from_nm", 633.0}}),
      usual("beam_overfill", {{"beam_over_sample", 0.25}}),
      usual("detector_underfill", {{"beam_over_field", 0.3}}),
      usual("retro_occlusion", {{"half_angle_deg", 0.02}}),
      usual("dust", {{"optical_depth_633", 3e-4}, {"g", 0.6}, {"single_scattering_albedo", 0.85}}),
      usual("speckle", {{"contrast", 3e-4}})};
}

}  // namespace

CasePlan draw_plan(Random& random, const CaseOptions& options) {
  CasePlan plan;
  const double pick = random.uniform();
  plan.style = pick < 0.5   ? Style::one_way
               : pick < 0.7 ? Style::serpentine
               : pick < 0.9 ? Style::pm45
                            : Style::full;
  if (options.only_effect && needs_blocks(*options.only_effect)) plan.style = Style::full;
  if (options.only_style) plan.style = *options.only_style;
  const std::vector<std::vector<double>> incidences = {
      {10, 30, 45, 60}, {5, 30, 55, 70}, {15, 40, 65}, {20, 45, 70}, {10, 25, 40, 55}, {30, 60}};
  plan.theta_i_deg = incidences[random.below(incidences.size())];
  const double steps_deg[] = {2.0, 2.0, 2.0, 2.5, 4.0};
  plan.theta_r_step_deg = steps_deg[random.below(std::size(steps_deg))];
  plan.theta_r_from_deg = random.chance(0.7) ? -80.0 : -70.0;
  plan.theta_r_to_deg = 80.0;
  plan.states = {{0, 0}, {0, 90}, {0, open}, {90, 0}, {90, 90}};
  const bool one_more = random.chance(0.3);
  const bool with_blocks = plan.style == Style::pm45 || plan.style == Style::full;
  if (one_more && !with_blocks) plan.states.push_back({90, open});
  // Blocks take their share of some six thousand records.
  if (plan.style == Style::full) plan.theta_r_step_deg = std::max(plan.theta_r_step_deg, 2.5);
  return plan;
}

plant::PlantConfig draw_instrument(Random& random, CaseTruth& truth) {
  plant::PlantConfig config = plant::ideal_config();
  const Acquisition acquisition;
  const RecordNoise unit(config, acquisition);
  truth.relative_noise = random.log_between(0.0012, 0.008);
  truth.additive_noise_v = random.log_between(5e-8, 1e-6);
  config.amplifier.input_noise_v = truth.additive_noise_v * std::sqrt(0.5 * acquisition.samples());
  // A lock-in's Y is steadier than its X.
  config.modulation.jitter_deg =
      optics::degrees(random.between(0.1, 0.4) * truth.relative_noise / unit.jitter_share());
  for (std::size_t i = 0; i < plant::laser_count; ++i) {
    plant::LaserConfig& l = config.laser[i];
    l.gain_constant_v = random.between(500.0, 1500.0);
    l.monitor_v = random.between(1.1, 1.8);
    l.jitter = truth.relative_noise / unit.jitter_share();
    // What the monitor sees cancels.
    l.power_noise = 0.002;
    l.power_drift_per_hour = random.between(-0.01, 0.01);
    truth.stated_gain_v[i] =
        l.gain_constant_v * (1.0 + stated_gain_u * std::clamp(random.normal(), -2.5, 2.5));
  }
  return config;
}

std::optional<Effect> sized(const ChangeMeter& meter, const Effect& effect, double target) {
  const EffectKind& kind = effect_kind(effect.name);
  constexpr int most_steps = 20;
  constexpr double close = 0.02;  // in the logarithm
  // Where ρ jumps with the size (a record changes its range), the nearest will do.
  constexpr double close_enough = 0.15;
  constexpr double largest_step = 5.0;  // in the logarithm
  const double smallest = std::log(kind.smallest);
  const double largest = std::log(kind.largest);
  // Secant steps in logarithms, kept within what is known to be too small and too large.
  double too_small = smallest;
  double too_large = largest;
  double power = 1.0;  // ρ goes with this power of the size
  double last_log_size = 0.0;
  double last_log_rho = 0.0;
  Effect now = effect;
  Effect nearest;
  double nearest_missing = close_enough;
  for (int step = 0; step < most_steps; ++step) {
    now.rho = meter.rho({&now, 1});
    const double log_size = std::log(std::abs(now.size()));
    const double log_rho = std::log(std::max(now.rho, 1e-9));
    const double missing = std::log(target) - log_rho;
    if (std::abs(missing) < close) return now;
    if (std::abs(missing) < nearest_missing) {
      nearest_missing = std::abs(missing);
      nearest = now;
    }
    if (missing > 0.0 && log_size > largest - 1e-9) return std::nullopt;
    if (missing < 0.0 && log_size < smallest + 1e-9) return std::nullopt;
    (missing > 0.0 ? too_small : too_large) = log_size;
    if (step > 0 && std::abs(log_size - last_log_size) > 1e-6) {
      power = std::clamp((log_rho - last_log_rho) / (log_size - last_log_size), 0.4, 40.0);
    }
    last_log_size = log_size;
    last_log_rho = log_rho;
    double wanted = log_size + std::clamp(missing / power, -largest_step, largest_step);
    const bool may_try_limit = (wanted <= smallest && too_small == smallest) ||
                               (wanted >= largest && too_large == largest);
    if (may_try_limit) {
      wanted = std::clamp(wanted, smallest, largest);
    } else if (wanted <= too_small || wanted >= too_large) {
      wanted = 0.5 * (too_small + too_large);
    }
    now = scaled(now, std::exp(wanted - log_size));
  }
  if (nearest_missing < close_enough) return nearest;
  return std::nullopt;
}

std::optional<std::vector<Effect>> draw_effects(const ChangeMeter& meter, CaseClass kind,
                                                Style style, const CaseOptions& options,
                                                Random& random) {
  int count = 1;
  if (kind == CaseClass::none) count = 0;
  if (kind == CaseClass::two) count = 2;
  if (kind == CaseClass::triple) count = 3;
  std::vector<Effect> effects;
  std::set<std::string> taken;
  const std::vector<std::string> names = candidates(kind, style, options);
  for (int i = 0; i < count; ++i) {
    auto effect = draw_one(meter, names, taken, options, kind, random);
    if (!effect) return std::nullopt;
    taken.insert(effect->name);
    effects.push_back(std::move(*effect));
  }
  rate_together(meter, effects);
  sort_by_rho(effects);
  return effects;
}

Crowd draw_crowd(Random& random, const plant::PlantConfig& bare, const EffectContext& context) {
  Crowd crowd;
  const plant::PlantConfig real = plant::realistic_config();
  crowd.config = bare;
  plant::PlantConfig& c = crowd.config;
  for (std::size_t i = 0; i < plant::axis_count; ++i) {
    c.axis[i] = real.axis[i];
    c.axis[i].standstill_deg = 0.0;  // 1e-5 deg: nothing but new angles at every arrival
    c.axis[i].backlash_deg =
        0.0;  // in scans that come from one side a zero error under another name
  }
  // These have canonical names and come as effects.
  c.axis[0].zero_deg = c.axis[1].zero_deg = c.axis[3].zero_deg = c.axis[4].zero_deg = 0.0;
  c.axis[1].eccentricity_deg = 0.0;
  for (std::size_t i = 0; i < plant::laser_count; ++i) {
    c.laser[i].line_width_nm = real.laser[i].line_width_nm;
    c.laser[i].sample_noise = real.laser[i].sample_noise;
    c.laser[i].polarization = real.laser[i].polarization;
    c.laser[i].polarization_deg = real.laser[i].polarization_deg;
    c.laser[i].unseen_noise = 1e-4;
  }
  c.filter = real.filter;
  c.monitor = real.monitor;
  c.monitor.noise_v = bare.monitor.noise_v;
  c.monitor.polarization_bias = 5e-5;  // has no name in the catalogue and must not lead
  c.detector.shot_noise_v = real.detector.shot_noise_v;
  c.amplifier.offset_v = real.amplifier.offset_v;
  c.shutter = real.shutter;
  crowd.small = usual_effects(context);
  for (Effect& effect : crowd.small) {
    const EffectKind& kind = effect_kind(effect.name);
    effect = scaled(effect, random.between(0.3, 1.5));
    if (!kind.both_signs) continue;
    const double sign = random.sign();
    for (std::size_t i = 0; i < kind.scaled_together; ++i) effect.parameters[i].second *= sign;
  }
  return crowd;
}

std::optional<std::vector<Effect>> enlarge_one(const ChangeMeter& meter, std::vector<Effect> small,
                                               Random& random) {
  for (Effect& effect : small) effect.rho = meter.rho({&effect, 1});
  // One that stands out when enlarged: drawn until it leads the others.
  for (int attempt = 0; attempt < most_attempts; ++attempt) {
    const std::size_t chosen = random.below(small.size());
    const EffectKind& kind = effect_kind(small[chosen].name);
    const double factor = random.log_between(5.0, 20.0);
    if (std::abs(small[chosen].size()) * factor > kind.largest) continue;
    std::vector<Effect> effects = small;
    effects[chosen] = scaled(effects[chosen], factor);
    effects[chosen].enlarged = true;
    effects[chosen].rho = meter.rho({&effects[chosen], 1});
    double largest_other = 0.0;
    for (std::size_t i = 0; i < effects.size(); ++i) {
      if (i != chosen) largest_other = std::max(largest_other, effects[i].rho);
    }
    if (effects[chosen].rho < 1.5 * largest_other) continue;
    rate_together(meter, effects);
    sort_by_rho(effects);
    return effects;
  }
  return std::nullopt;
}

}  // namespace umov::blind
