#include "hil/blind/case.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>
#include <utility>

#include "hil/blind/case_draw.hpp"
#include "hil/blind/lobe_fit.hpp"
#include "host/errors/error.hpp"
#include "host/formats/scan_csv.hpp"

namespace umov::blind {
namespace {

/// Between two scans the operator changes something; the lasers stay on.
constexpr double pause_s = 120.0;

std::string case_name(std::size_t number) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "case_%04zu", number);
  return buffer;
}

std::string number_text(double value, const char* format) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, format, value);
  return buffer;
}

formats::ScanTable with_header(formats::ScanTable table, const CaseTruth& truth, bool white) {
  table.set_key("format", "umov scan csv");
  table.set_key("sample", white ? "white-99" : "coupon");
  table.set_key("device", "gonioreflectometer");
  if (white) table.set_key("role", "white");
  table.set_key("solid_angle_sr", number_text(truth.config.collection.solid_angle_sr, "%g"));
  for (std::size_t i = 0; i < plant::laser_count; ++i) {
    table.set_key("gain_constant_" + std::to_string(plant::laser_names[i]),
                  number_text(truth.stated_gain_v[i], "%.5g"));
  }
  table.set_key("gain_constant_relative_u", "0.01");
  table.set_key("adc_step_v", number_text(truth.config.adc.full_scale_v / 4096.0, "%.6g"));
  table.set_key("adc_full_scale_v", number_text(truth.config.adc.full_scale_v, "%g"));
  if (white) {
    for (const int wavelength_nm : plant::laser_names) {
      table.set_key("reference_dhr_" + std::to_string(wavelength_nm), "0.99");
    }
    table.set_key("reference_dhr_u", "0.005");
  }
  formats::round_to_canonical(table);
  return table;
}

Bench bench_of(const CaseTruth& truth, double start_s) {
  return Bench(truth.config, truth.material.sample(), truth.seed, Acquisition{}, start_s);
}

std::uint64_t case_seed(std::uint64_t seed, std::size_t number) {
  return plant::derive_key(plant::derive_key(seed, 77), number);
}

}  // namespace

CaseClass class_named(std::string_view name) {
  std::string names;
  for (std::size_t i = 0; i < class_names.size(); ++i) {
    if (class_names[i] == name) return static_cast<CaseClass>(i);
    names += (names.empty() ? "" : ", ") + std::string(class_names[i]);
  }
  throw Error("no class of cases is called \"" + std::string(name) + "\"", "there are " + names);
}

std::string_view name_of(CaseClass c) {
  return class_names[static_cast<std::size_t>(c)];
}

std::vector<CaseClass> case_classes(std::size_t count, std::uint64_t seed,
                                    const CaseOptions& options) {
  if (options.only_effect && !options.only_class) {
    const bool known = effect_kind(*options.only_effect).in_catalogue;
    return std::vector<CaseClass>(count, known ? CaseClass::single : CaseClass::foreign);
  }
  if (options.only_class) return std::vector<CaseClass>(count, *options.only_class);
  // Whole parts first, then one more each to those with the largest remainders.
  std::array<std::size_t, class_count> share{};
  std::array<std::size_t, class_count> remainder{};
  std::size_t given = 0;
  for (std::size_t i = 0; i < class_count; ++i) {
    const std::size_t parts = count * static_cast<std::size_t>(cases_in_a_hundred[i]);
    share[i] = parts / 100;
    remainder[i] = parts % 100;
    given += share[i];
  }
  std::array<std::size_t, class_count> order{};
  for (std::size_t i = 0; i < class_count; ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return remainder[a] > remainder[b]; });
  for (std::size_t i = 0; given < count; ++i, ++given) ++share[order[i % class_count]];
  std::vector<CaseClass> classes;
  for (std::size_t i = 0; i < class_count; ++i) {
    classes.insert(classes.end(), share[i], static_cast<CaseClass>(i));
  }
  Random random(plant::derive_key(seed, 78));
  random.shuffle(std::span(classes));
  return classes;
}

namespace {

/// Streams of draws of one case: its own for each part, so that plan, material and instrument do
/// not depend on the class.
enum class Part : std::uint64_t { plan = 1, material, instrument, effects, look_alikes };

Random draws(const CaseTruth& truth, Part part, std::uint64_t attempt = 0) {
  const std::uint64_t key = plant::derive_key(truth.seed, static_cast<std::uint64_t>(part));
  return Random(attempt == 0 ? key : plant::derive_key(key, attempt));
}

/// The case without effects.
World bare_world(CaseTruth& truth) {
  Random instrument = draws(truth, Part::instrument);
  World world;
  world.config = draw_instrument(instrument, truth);
  world.material = truth.material;
  world.blocks = own_blocks(truth.plan);
  world.seed = truth.seed;
  world.context.slope_rms = truth.material.slope_rms();
  for (std::size_t i = 0; i < plant::laser_count; ++i) {
    world.context.monitor_v[i] = world.config.laser[i].monitor_v;
  }
  truth.records = 0;
  for (const RowBlock& block : world.blocks) truth.records += block.rows.size();
  Bench bench(world.config, world.material.sample(), truth.seed, world.acquisition);
  bench.clean(world.blocks);
  truth.duration_s = world.context.duration_s = bench.time_s();
  return world;
}

/// Puts effects of the case's class into it. False where this material does not allow it.
bool put_effects(CaseTruth& truth, World world, const CaseOptions& options, Random random) {
  const EffectContext context = world.context;
  const bool crowded = truth.kind == CaseClass::crowded;
  Crowd crowd;
  if (crowded) {
    crowd = draw_crowd(random, world.config, context);
    world.config = crowd.config;
  }
  const ChangeMeter meter(std::move(world));
  // A confounded case is drawn until another member of the catalogue explains it as well.
  const int tries = truth.kind == CaseClass::confounded ? 8 : 1;
  for (int i = 0; i < tries; ++i) {
    auto effects = crowded ? enlarge_one(meter, crowd.small, random)
                           : draw_effects(meter, truth.kind, truth.plan.style, options, random);
    if (!effects) return false;
    truth.effects = std::move(*effects);
    truth.look_alikes.clear();
    if (crowded) {
      truth.look_alikes = look_alikes(meter, {truth.effects.front()}, truth.seed);
    } else if (truth.kind == CaseClass::foreign || truth.kind == CaseClass::confounded) {
      truth.look_alikes = look_alikes(meter, truth.effects, truth.seed);
    }
    if (truth.kind != CaseClass::confounded || !truth.look_alikes.empty()) break;
  }
  if (truth.kind == CaseClass::confounded && truth.look_alikes.empty()) return false;
  truth.rho = truth.effects.empty() ? 0.0 : meter.rho(truth.effects);
  truth.config = meter.world().config;
  for (const Effect& effect : truth.effects) apply(effect, context, truth.config);
  return true;
}

}  // namespace

CaseTruth make_case(std::uint64_t seed, std::size_t number, CaseClass kind,
                    const CaseOptions& options) {
  CaseTruth truth;
  truth.name = case_name(number);
  truth.kind = kind;
  truth.seed = case_seed(seed, number);
  Random plan = draws(truth, Part::plan);
  truth.plan = draw_plan(plan, options);
  // Nearly always the first material will do; a single kind of effect may need another one.
  constexpr std::uint64_t most_materials = 25;
  for (std::uint64_t attempt = 0; attempt < most_materials; ++attempt) {
    Random material = draws(truth, Part::material, attempt);
    truth.material = draw_material(material);
    const World world = bare_world(truth);
    if (!put_effects(truth, world, options, draws(truth, Part::effects, attempt))) continue;
    truth.rho_beyond_one_gaussian_lobe = beyond_one_gaussian_lobe(world);
    return truth;
  }
  throw Error("no material and size of the wanted effect give the wanted ρ",
              "widen --rho-min and --rho-max, or ask for another effect or style");
}

formats::ScanTable own_scan(const CaseTruth& truth) {
  Bench bench = bench_of(truth, 0.0);
  return with_header(bench.measure(own_blocks(truth.plan)), truth, false);
}

formats::ScanTable further_scan(const CaseTruth& truth, const std::vector<RowBlock>& blocks) {
  const bool white = !blocks.empty() && blocks.front().white_tile;
  for (const RowBlock& block : blocks) {
    if (block.white_tile != white) {
      throw Error("a white tile and the sample in one scan", "take the tile's scan by itself");
    }
  }
  Bench bench = bench_of(truth, truth.duration_s + pause_s);
  return with_header(bench.measure(blocks), truth, white);
}

std::vector<LookAlike> look_alikes(const ChangeMeter& meter, const std::vector<Effect>& effects,
                                   std::uint64_t seed, double limit) {
  const std::vector<double> change = meter.left(effects);
  Random random(plant::derive_key(seed, static_cast<std::uint64_t>(Part::look_alikes)));
  std::vector<LookAlike> found;
  for (const EffectKind& kind : effect_kinds()) {
    const bool present = std::any_of(effects.begin(), effects.end(),
                                     [&](const Effect& e) { return e.name == kind.name; });
    if (!kind.in_catalogue || present || kind.name == "speckle") continue;
    Subspace family = meter.refit();
    const bool shaped = !kind.further(random, meter.world().context).empty();
    for (int draw = 0; draw < (shaped ? 3 : 1); ++draw) {
      const Effect trial =
          draw_effect(kind, random, meter.world().context, std::sqrt(kind.smallest * kind.largest));
      family.add(meter.left({&trial, 1}));
    }
    const double rest = length(family.rest(change));
    if (rest < limit) found.push_back({kind.name, rest});
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const LookAlike& a, const LookAlike& b) { return a.rho_left < b.rho_left; });
  return found;
}

}  // namespace umov::blind
