// Effects of the cases: the catalogue's names, and what each does to the signals of a scan.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>
#include <string>

#include "hil/blind/change.hpp"
#include "hil/plant/parameter_list.hpp"
#include "hil/plant/rough_surface.hpp"

namespace umov::blind {
namespace {

/// A scan that shows every effect: all states and blocks, a glossy material.
World world(const std::string& family = "gaussian_facets", Style style = Style::full) {
  World w;
  Random random(12);
  w.material = draw_material(random, family);
  CasePlan plan;
  plan.style = style;
  plan.theta_i_deg = {15, 40, 65};
  plan.theta_r_step_deg = 5.0;
  const double open = std::nan("");
  plan.states = {{0, 0}, {0, 90}, {0, open}, {90, 0}, {90, 90}};
  w.blocks = own_blocks(plan);
  w.config = plant::ideal_config();
  w.config.amplifier.input_noise_v = 1e-5;
  for (plant::LaserConfig& l : w.config.laser) l.jitter = 0.012;
  w.context.slope_rms = w.material.slope_rms();
  Bench bench(w.config, w.material.sample(), w.seed, w.acquisition);
  bench.clean(w.blocks);
  w.context.duration_s = bench.time_s();
  return w;
}

Effect effect(const std::string& name, std::vector<Named> parameters) {
  Effect e;
  e.name = name;
  e.parameters = std::move(parameters);
  return e;
}

TEST(EffectKinds, HaveTheNamesAndParametersOfTheCatalogue) {
  const std::map<std::string, std::vector<std::string>> expected = {
      {"incidence_zero", {"zero_deg"}},
      {"detector_zero", {"zero_deg"}},
      {"sample_tilt_in_plane", {"tilt_deg"}},
      {"sample_tilt_out_of_plane", {"tilt_deg"}},
      {"detector_eccentricity", {"amplitude_deg", "phase_deg"}},
      {"backlash", {"gap_deg"}},
      {"polarizer_leakage", {"extinction"}},
      {"analyzer_leakage", {"extinction"}},
      {"polarizer_rotation", {"angle_deg"}},
      {"analyzer_rotation", {"angle_deg"}},
      {"detector_polarization_bias", {"bias"}},
      {"detector_nonlinearity", {"kappa_per_v"}},
      {"detector_saturation", {"inverse_knee_per_v"}},
      {"dark_offset", {"offset_v", "y_fraction"}},
      {"stray_light", {"level_per_sr"}},
      {"stray_forward", {"level_per_sr", "width_deg"}},
      {"low_signal_pedestal", {"pedestal_adc_v"}},
      {"gain_ratio_error", {"error_10", "error_100", "error_1000"}},
      {"lockin_phase", {"phase_deg"}},
      {"finite_aperture", {"half_angle_deg"}},
      {"beam_divergence", {"rms_deg"}},
      {"laser_drift", {"total"}},
      {"laser_warmup", {"amplitude", "tau_s"}},
      {"wavelength_error", {"shift_nm", "wavelength_nm"}},
      {"laser_crosstalk", {"fraction", "into_nm", "from_nm"}},
      {"beam_overfill", {"beam_over_sample"}},
      {"detector_underfill", {"beam_over_field"}},
      {"retro_occlusion", {"half_angle_deg"}},
      {"dust", {"optical_depth_633", "g", "single_scattering_albedo"}},
      {"water_film", {"coverage", "smoothing"}},
      {"water_drops", {"coverage", "contact_angle_deg"}},
      {"near_specular_lobe", {"weight", "sigma_slope"}},
      {"retroreflection_peak", {"peak_per_sr", "width_deg"}},
      {"fluorescence", {"yield_532"}},
      {"speckle", {"contrast"}}};
  std::map<std::string, std::vector<std::string>> found;
  Random random(1);
  int foreign = 0;
  for (const EffectKind& kind : effect_kinds()) {
    if (!kind.in_catalogue) {
      ++foreign;
      EXPECT_FALSE(expected.contains(kind.name)) << kind.name;
      continue;
    }
    for (const auto& [name, value] : draw_effect(kind, random, {}, kind.smallest).parameters) {
      found[kind.name].push_back(name);
    }
  }
  EXPECT_EQ(found, expected);
  EXPECT_GE(foreign, 10);
}

TEST(EveryEffect, ChangesTheScanAndAtSizeZeroNotAtAll) {
  const ChangeMeter meter(world());
  const ChangeMeter absorbing(world("he_torrance"));
  for (const EffectKind& kind : effect_kinds()) {
    Random random(3);
    Effect e = draw_effect(kind, random, meter.world().context, kind.largest);
    if (kind.name == "speckle") {
      EXPECT_GT(meter.rho({&e, 1}), 1.0);
      continue;
    }
    // A facet surface has no wavelengths in it.
    const ChangeMeter& used = kind.name == "wavelength_error" ? absorbing : meter;
    EXPECT_NE(used.signals({&e, 1}), used.base_signals()) << kind.name;
    Effect none = scaled(e, 0.0);
    EXPECT_EQ(used.signals({&none, 1}), used.base_signals()) << kind.name;
  }
}

TEST(EveryEffect, MayBeAskedForAtItsSmallestAndItsLargestSize) {
  for (const EffectKind& kind : effect_kinds()) {
    for (const double size : {kind.smallest, kind.largest}) {
      for (std::uint64_t seed = 1; seed < 4; ++seed) {
        Random random(seed);
        const EffectContext context;
        plant::PlantConfig config = plant::ideal_config();
        EXPECT_NO_THROW(apply(draw_effect(kind, random, context, size), context, config))
            << kind.name;
      }
    }
  }
}

/// Ratio of X with the effect to X without, at one geometry and state.
class Look {
 public:
  Look() : meter_(world("gaussian_facets", Style::one_way)) {}
  double ratio(const Effect& e, double ti, double tr, double polarizer, double analyzer, int laser,
               bool y_over_x = false) const {
    const Signals with = meter_.signals({&e, 1});
    const auto& rows = meter_.world().blocks[0].rows;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const Row& r = rows[i];
      if (r.theta_i_deg == ti && r.theta_r_deg == tr && r.laser == laser &&
          r.state.polarizer_deg == polarizer && r.state.analyzer_deg == analyzer) {
        return y_over_x ? with[2 * i + 1] / with[2 * i]
                        : with[2 * i] / meter_.base_signals()[2 * i];
      }
    }
    ADD_FAILURE() << "no such row";
    return 0.0;
  }
  double duration_s() const { return meter_.world().context.duration_s; }

 private:
  ChangeMeter meter_;
};

TEST(LockinPhase, TurnsXIntoYByItsAngleAndNothingElse) {
  const Look look;
  const Effect e = effect("lockin_phase", {{"phase_deg", 2.0}});
  for (const double tr : {-40.0, 40.0}) {
    EXPECT_NEAR(look.ratio(e, 40, tr, 0, 0, 1, true), std::tan(optics::radians(2.0)), 1e-9);
    EXPECT_NEAR(look.ratio(e, 40, tr, 0, 0, 1), std::cos(optics::radians(2.0)), 1e-9);
  }
}

TEST(LaserCrosstalk, TakesItsFractionOfTheMonitoredLight) {
  const Look look;
  const Effect e =
      effect("laser_crosstalk", {{"fraction", 0.1}, {"into_nm", 633}, {"from_nm", 814}});
  EXPECT_EQ(look.ratio(e, 40, -20, 0, 0, 0), 1.0);
  EXPECT_EQ(look.ratio(e, 40, -20, 0, 0, 2), 1.0);
  // x/m = (1 - f) own + f other's.
  World w = world("gaussian_facets", Style::one_way);
  const ChangeMeter meter(w);
  const auto& rows = meter.world().blocks[0].rows;
  double own = 0.0, other = 0.0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].theta_i_deg != 40 || rows[i].theta_r_deg != -20) continue;
    if (rows[i].state.polarizer_deg != 0 || rows[i].state.analyzer_deg != 0) continue;
    const double ratio = meter.base_signals()[2 * i] /
                         w.config.laser[static_cast<std::size_t>(rows[i].laser)].monitor_v;
    if (rows[i].laser == 1) own = ratio;
    if (rows[i].laser == 2) other = ratio;
  }
  EXPECT_NEAR(look.ratio(e, 40, -20, 0, 0, 1), 0.9 + 0.1 * other / own, 1e-9);
}

TEST(StrayLight, AddsMoreWhereTheSignalIsSmall) {
  const Look look;
  const Effect e = effect("stray_light", {{"level_per_sr", 1e-3}});
  EXPECT_GT(look.ratio(e, 40, -80, 0, 0, 1), look.ratio(e, 40, 40, 0, 0, 1));
  EXPECT_GT(look.ratio(e, 40, 40, 0, 0, 1), 1.0);
}

TEST(BeamOverfill, LosesLightAtGrazingIncidenceAlone) {
  const Look look;
  const Effect e = effect("beam_overfill", {{"beam_over_sample", 0.7}});
  EXPECT_LT(look.ratio(e, 65, 20, 0, 0, 1), look.ratio(e, 15, 20, 0, 0, 1));
  EXPECT_NEAR(look.ratio(e, 65, 20, 0, 0, 1), look.ratio(e, 65, -60, 0, 0, 1), 1e-12);
}

TEST(DetectorSaturation, FlattensTheStrongSignalsOnly) {
  const Look look;
  const Effect e = effect("detector_saturation", {{"inverse_knee_per_v", 60.0}});
  EXPECT_LT(look.ratio(e, 65, 65, 90, 90, 1), 0.99);
  EXPECT_NEAR(look.ratio(e, 40, -60, 0, 90, 1), 1.0, 1e-4);
}

TEST(PolarizerRotation, LeaksIntoTheCrossedState) {
  const Look look;
  const Effect e = effect("polarizer_rotation", {{"angle_deg", 5.0}});
  EXPECT_GT(look.ratio(e, 65, 65, 0, 90, 1) - 1.0,
            3.0 * std::abs(look.ratio(e, 65, 65, 90, 90, 1) - 1.0));
}

TEST(LaserDrift, GrowsToItsTotalAtTheEndOfTheScan) {
  const ChangeMeter meter(world("gaussian_facets", Style::one_way));
  const Effect e = effect("laser_drift", {{"total", 0.02}});
  const Signals with = meter.signals({&e, 1});
  const std::size_t last = with.size() - 2;
  EXPECT_NEAR(with[last] / meter.base_signals()[last], 1.02, 1e-5);
  EXPECT_NEAR(with[0] / meter.base_signals()[0], 1.0, 1e-4);
}

TEST(GainRatioError, StepsWhereTheRangeChanges) {
  const ChangeMeter meter(world("gaussian_facets", Style::one_way));
  const Effect e =
      effect("gain_ratio_error", {{"error_10", 0.01}, {"error_100", -0.02}, {"error_1000", 0.03}});
  const Signals with = meter.signals({&e, 1});
  std::set<long> steps;
  for (std::size_t i = 0; i < with.size(); i += 2) {
    steps.insert(std::lround(1e4 * (with[i] / meter.base_signals()[i] - 1.0)));
  }
  for (const long step : steps)
    EXPECT_TRUE(step == 0 || step == 100 || step == -200 || step == 300) << step;
  EXPECT_GE(steps.size(), 2u);
}

TEST(NoEffect, ChangesMaterialOrGainsWhichARefitFollows) {
  const World w = world("gaussian_facets", Style::one_way);
  const ChangeMeter meter(w);
  // One per mille of gain, of index and of diffuse reflectance, each hundreds of noises in all.
  for (const char* key : {"n", "slope", "rho_d1"}) {
    World changed = w;
    for (auto& [name, values] : changed.material.numbers) {
      if (name == key) values[0] *= 1.001;
    }
    const ChangeMeter other(changed);
    const auto whitened = meter.whitened(other.base_signals(), meter.base_signals());
    EXPECT_LT(length(meter.refit().rest(whitened)), 0.02 * length(whitened) + 0.01) << key;
  }
}

TEST(Subspace, LeavesWhatIsOrthogonal) {
  Subspace s;
  s.add({1, 1, 0});
  s.add({2, 2, 0});
  EXPECT_EQ(s.size(), 1u);
  const auto rest = s.rest({1, 0, 3});
  EXPECT_NEAR(rest[0], 0.5, 1e-15);
  EXPECT_NEAR(rest[1], -0.5, 1e-15);
  EXPECT_NEAR(rest[2], 3.0, 1e-15);
}

}  // namespace
}  // namespace umov::blind
