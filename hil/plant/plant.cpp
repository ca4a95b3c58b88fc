#include "hil/plant/plant.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <cstddef>
#include <utility>

#include "hil/plant/coating.hpp"
#include "hil/plant/noise.hpp"
#include "host/errors/error.hpp"

namespace umov::plant {
namespace {

constexpr double pi = optics::pi;
/// A square wave of half-step a has the fundamental 4a/π.
constexpr double swing_per_fundamental = pi / 4.0;
/// Slow quantities (drift, warm-up, shutter travel, settling) are held over so many samples,
/// counted from the stream's start and not from a block's.
constexpr std::uint64_t slow_interval = 128;
constexpr std::array<double, 4> nominal_gain = {1.0, 10.0, 100.0, 1000.0};

/// A channel whose fundamental is `volts` at the ADC, turned by `phase_deg`.
ChannelWave channel(double volts, double phase_deg, double codes_per_v) {
  const double swing = swing_per_fundamental * codes_per_v * volts;
  ChannelWave wave;
  wave.in_phase = swing * std::cos(optics::radians(phase_deg));
  wave.quadrature = swing * std::sin(optics::radians(phase_deg));
  wave.light = 2.0 * swing;
  return wave;
}

/// Photodiode law in volts at range 1. Daylight `ambient_v` that the modulation rides on shifts the
/// operating point.
double detected(const PlantConfig& config, double volts, double ambient_v) {
  const DetectorConfig& detector = config.detector;
  double s = volts;
  if (ambient_v != 0.0) {
    const double kappa = config.daylight.compression_per_v;
    s /= (1.0 + kappa * ambient_v) * (1.0 + kappa * (ambient_v + volts));
  }
  if (detector.nonlinearity_per_v != 0.0) s /= 1.0 + detector.nonlinearity_per_v * s;
  if (detector.inverse_knee_per_v != 0.0) {
    s /= std::pow(1.0 + std::pow(s * detector.inverse_knee_per_v, 4.0), 0.25);
  }
  return s;
}

/// A gamma deviate of mean 1 and the given contrast (Wilson & Hilferty 1931: its cube root is
/// normal).
double gamma_deviate(double contrast, double normal) {
  const double v = contrast * contrast / 9.0;
  const double root = std::max(0.0, 1.0 - v + std::sqrt(v) * normal);
  return root * root * root;
}

/// Of all that is new whenever the instrument is switched on.
std::uint64_t chance_seed(const PlantSetup& setup) {
  return setup.session == 0 ? setup.seed : derive_key(setup.seed, 1000 + setup.session);
}

}  // namespace

/// Fundamentals in volts at range 1 at one moment.
struct Plant::Beams {
  double signal = 0.0;  ///< behind the photodiode
  double monitor = 0.0;
  double sample_noise = 0.0;  ///< relative power noise per ADC sample
  double jitter = 0.0;        ///< relative noise of the signal per slow interval
};

Plant::Plant(PlantSetup setup)
    : config_(std::move(setup.config)),
      own_sample_(std::move(setup.sample)),
      noise_seed_(derive_key(chance_seed(setup), 100)),
      speckle_seed_(derive_key(setup.seed, 101)),
      chopper_(config_.chopper, derive_key(chance_seed(setup), 200)) {
  if (!own_sample_) throw Error("the instrument has no sample", "give a sample by name or file");
  set_sample(own_sample_);
  for (std::size_t i = 0; i < axis_count; ++i) {
    stages_.emplace_back(setup.travel[i], config_.axis[i], derive_key(setup.seed, i));
  }
  for (std::size_t i = 0; i < laser_count; ++i) {
    power_.emplace_back(config_.laser[i], derive_key(chance_seed(setup), 10 + i));
  }
}

void Plant::set_sample(std::shared_ptr<const Sample> clean) {
  waves_of_.reset();
  const bool own = clean == own_sample_;
  humid_.reset();
  if (config_.humidity.slope_change != 0.0) {
    if (auto swollen = clean->with_slopes(1.0 + config_.humidity.slope_change)) {
      humid_ = own ? coated(std::move(swollen), config_) : std::move(swollen);
    }
  }
  sample_ = own ? coated(std::move(clean), config_) : std::move(clean);
  memory_.clear();
  present_.fill(nullptr);
}

void Plant::stage_moved(int axis) {
  waves_of_.reset();
  const bool steers = (axis == 3 && config_.polarizer.wedge_deg != 0.0) ||
                      (axis == 4 && config_.analyzer.wedge_deg != 0.0);
  if (axis < 3 || steers) present_.fill(nullptr);
}

void Plant::step(int axis, int direction, double time_s) {
  stages_[static_cast<std::size_t>(axis)].step(direction, time_s);
  stage_moved(axis);
}

void Plant::turn_to(int axis, std::int64_t target_steps, double time_s) {
  Stage& stage = stages_[static_cast<std::size_t>(axis)];
  const std::int64_t distance = target_steps - stage.steps();
  if (distance == 0) return;
  stage.step(distance > 0 ? 1 : -1, time_s, std::abs(distance));
  stage_moved(axis);
}

AxisSwitches Plant::switches(int axis) const {
  return stages_[static_cast<std::size_t>(axis)].switches();
}

void Plant::set_laser(int laser, bool on, double) {
  waves_of_.reset();
  laser_on_[static_cast<std::size_t>(laser)] = on;
}

void Plant::set_shutter(bool open, double time_s) {
  if (open == shutter_open_) return;
  waves_of_.reset();
  shutter_open_ = open;
  shutter_changed_s_ = time_s;
}

void Plant::set_gain(int range, double time_s) {
  if (range == range_) return;
  waves_of_.reset();
  range_ = range;
  range_changed_s_ = time_s;
}

void Plant::set_reference(std::uint32_t phase_step) {
  phase_step_ = phase_step;
}

void Plant::place_sample(std::shared_ptr<const Sample> sample) {
  if (!sample) throw Error("the instrument has no sample", "give a sample by name or file");
  set_sample(std::move(sample));
}

void Plant::arrange(const Setup& setup) {
  waves_of_.reset();
  setup_ = setup;
  memory_.clear();
  present_.fill(nullptr);
}

double Plant::true_angle_deg(int axis) const {
  return stages_[static_cast<std::size_t>(axis)].true_deg();
}

Geometry Plant::geometry() const {
  Geometry g{optics::radians(true_angle_deg(0)), optics::radians(true_angle_deg(1)),
             optics::radians(true_angle_deg(2))};
  const auto steer = [this](int axis, double wedge_deg, double& towards_p, double& towards_s) {
    if (wedge_deg == 0.0 || stages_[static_cast<std::size_t>(axis)].motor_deg() >= open_from_deg)
      return;
    const double turn = optics::radians(true_angle_deg(axis));
    towards_p = optics::radians(wedge_deg) * std::cos(turn);
    towards_s = optics::radians(wedge_deg) * std::sin(turn);
  };
  steer(3, config_.polarizer.wedge_deg, g.steer_in_p, g.steer_in_s);
  steer(4, config_.analyzer.wedge_deg, g.steer_out_p, g.steer_out_s);
  return g;
}

double Plant::humidity(double time_s) const {
  return std::pow(std::sin(pi * time_s / config_.humidity.period_s), 2.0);
}

Throughput Plant::throughput(int laser, double time_s) const {
  const auto i = static_cast<std::size_t>(laser);
  const LaserConfig& l = config_.laser[i];
  const auto of = [&](const Sample& sample, const Geometry& g) {
    return collect(sample, config_, setup_, g, l.wavelength_nm + l.wavelength_error_nm,
                   l.line_width_nm);
  };
  if (present_[i] == nullptr) {
    const Geometry g = geometry();
    CollectionMemory::Entry& entry = memory_.at(laser, g);
    if (!entry.dry) entry.dry = of(*sample_, g);
    if (humid_ && !entry.humid) entry.humid = of(*humid_, g);
    // The memory may have begun anew: entries of other lasers are looked up again.
    present_.fill(nullptr);
    present_[i] = &entry;
  }
  Throughput now = *present_[i]->dry;
  if (humid_) {
    const double share = humidity(time_s);
    const Throughput& humid = *present_[i]->humid;
    now.diffuse += share * (humid.diffuse - now.diffuse);
    now.mirror += share * (humid.mirror - now.mirror);
  }
  return now;
}

double Plant::speckle(int laser) const {
  if (config_.speckle.contrast == 0.0) return 1.0;
  std::uint64_t pattern = derive_key(speckle_seed_, static_cast<std::uint64_t>(laser));
  for (std::size_t axis = 0; axis < 5; ++axis) {
    pattern = derive_key(pattern, static_cast<std::uint64_t>(stages_[axis].steps()));
  }
  pattern = derive_key(pattern, std::bit_cast<std::uint64_t>(setup_.sample_shift_mm));
  pattern = derive_key(pattern, std::bit_cast<std::uint64_t>(setup_.sample_azimuth_deg));
  return gamma_deviate(config_.speckle.contrast, gaussian_of(pattern, 0));
}

double Plant::filter_transmittance() const {
  // Six holders at 60°; between them the wheel is opaque.
  const double place = true_angle_deg(5) / 60.0;
  const double nearest = std::round(place);
  if (std::abs(place - nearest) > 1.0 / 3.0) return 0.0;
  const double holder = nearest - 6.0 * std::floor(nearest / 6.0);
  return std::pow(10.0, -holder * (1.0 + config_.filter.density_error));
}

double Plant::shutter_opening(double time_s) const {
  double moved = 1.0;
  if (config_.shutter.travel_s > 0.0) {
    moved = std::clamp((time_s - shutter_changed_s_) / config_.shutter.travel_s, 0.0, 1.0);
  }
  const double opening = shutter_open_ ? moved : 1.0 - moved;
  return config_.shutter.leak == 0.0 ? opening : opening + config_.shutter.leak * (1.0 - opening);
}

double Plant::gain_at_adc() const {
  const AmplifierConfig& a = config_.amplifier;
  const std::array<double, 4> error = {0.0, a.gain_error_10, a.gain_error_100, a.gain_error_1000};
  const auto i = static_cast<std::size_t>(range_);
  return nominal_gain[i] * (1.0 + error[i]);
}

Stokes Plant::beam_behind_filter(int laser, double time_s) const {
  // Power of this laser's light: its own when enabled, and its share in the beams of the others.
  double enabled = 0.0;
  for (std::size_t i = 0; i < laser_count; ++i) {
    if (!laser_on_[i]) continue;
    const auto source = static_cast<std::size_t>(laser);
    enabled += i == source ? 1.0 : config_.laser[i].crosstalk_from[source];
  }
  if (!interlock_closed_ || enabled == 0.0) return Stokes(0.0);
  const LaserConfig& l = config_.laser[static_cast<std::size_t>(laser)];
  Stokes beam = source_stokes(l.polarization, l.polarization_deg);
  const double polarizer_deg = true_angle_deg(3);
  if (stages_[3].motor_deg() < open_from_deg) {
    beam = optics::apply(polarizer_mueller(polarizer_deg, config_.polarizer.extinction), beam);
  }
  return enabled * l.monitor_v * power_[static_cast<std::size_t>(laser)].seen(time_s) *
         filter_transmittance() * beam;
}

double Plant::long_pass_transmittance(int laser) const {
  if (!setup_.long_pass) return 1.0;
  const LaserConfig& l = config_.laser[static_cast<std::size_t>(laser)];
  const LongPassConfig& filter = config_.long_pass;
  return l.wavelength_nm + l.wavelength_error_nm < filter.edge_nm ? filter.leak
                                                                  : filter.transmittance;
}

Stokes Plant::detection_row(int laser) const {
  Stokes row = photodiode_row(config_.detector.polarization_bias);
  const LaserConfig& l = config_.laser[static_cast<std::size_t>(laser)];
  if (l.filter_diattenuation != 0.0) {
    // Half the difference over half the sum of what passes along and across, mean 1.
    const double d = l.filter_diattenuation;
    const Mueller filter = polarizer_mueller(l.filter_axis_deg, (1.0 - d) / (1.0 + d));
    row = (1.0 + d) * row_times(row, filter);
  }
  if (stages_[4].motor_deg() < open_from_deg) {
    row = row_times(row, polarizer_mueller(true_angle_deg(4), config_.analyzer.extinction));
  }
  const CollectionConfig& o = config_.collection;
  if (o.window_retardance_deg != 0.0) {
    row = row_times(row, retarder_mueller(o.window_axis_deg, o.window_retardance_deg));
  }
  return row;
}

Plant::Beams Plant::beams_at(double time_s) const {
  const Stokes monitor_row = photodiode_row(config_.monitor.polarization_bias);
  const double opening = shutter_opening(time_s);
  Beams beams;
  double noise_power = 0.0;
  double jittering = 0.0;
  for (int laser = 0; laser < laser_count; ++laser) {
    const auto i = static_cast<std::size_t>(laser);
    const Stokes beam = beam_behind_filter(laser, time_s);
    if (beam[0] == 0.0) continue;
    const double monitor = optics::dot(Vec3(monitor_row[0], monitor_row[1], monitor_row[2]),
                                       Vec3(beam[0], beam[1], beam[2]));
    beams.monitor += monitor;
    noise_power += monitor * config_.laser[i].sample_noise;
    if (opening > 0.0) {
      const Throughput through = throughput(laser, time_s);
      const Stokes row = detection_row(laser);
      const double reflected = long_pass_transmittance(laser) *
                               optics::contract(row, through.total(), beam) * speckle(laser);
      // Light of longer wavelengths passes the long-pass filter.
      const double emitted = through.emitted * row[0] * beam[0] *
                             (setup_.long_pass ? config_.long_pass.transmittance : 1.0);
      const double light = opening * config_.laser[i].gain_constant_v * power_[i].unseen(time_s) *
                           (reflected + emitted);
      beams.signal += light;
      jittering += light * config_.laser[i].jitter;
    }
  }
  if (beams.signal > 0.0) beams.jitter = jittering / beams.signal;
  double ambient_v = 0.0;
  if (config_.daylight.level_v != 0.0) {
    // Clouds let the light come and go in half a period each, with edges.
    const double swing = std::sin(2.0 * pi * time_s / config_.daylight.period_s);
    ambient_v = config_.daylight.level_v * std::clamp(0.5 + 1.5 * swing, 0.0, 1.0);
  }
  beams.signal = detected(config_, std::max(0.0, beams.signal), ambient_v);
  if (beams.monitor > 0.0) beams.sample_noise = noise_power / beams.monitor;
  return beams;
}

ExpectedSignal Plant::expected(double time_s) const {
  const Beams beams = beams_at(time_s);
  const AmplifierConfig& a = config_.amplifier;
  const double gain = gain_at_adc();
  const double nominal = nominal_gain[static_cast<std::size_t>(range_)];
  const double amplitude = std::hypot(beams.signal * gain, a.pedestal_adc_v) / nominal;
  const double wander_deg = phase_wander_deg(time_s);
  const double phase = optics::radians(a.phase_deg + wander_deg);
  const double pickup = a.pickup_v * gain / nominal;
  const std::complex<double> signal{
      amplitude * std::cos(phase) + pickup + motor_pickup_v() * gain / nominal,
      amplitude * std::sin(phase) + pickup * a.pickup_y_fraction};
  const auto monitor =
      std::polar(beams.monitor, optics::radians(config_.monitor.phase_deg + wander_deg));
  const std::complex<double> chopped =
      chopper_.present()
          ? std::polar(chopper_.fundamental(), optics::radians(config_.chopper.phase_deg))
          : 1.0;
  return {(signal * chopped).real(), (signal * chopped).imag(), (monitor * chopped).real()};
}

double Plant::phase_wander_deg(double time_s) const {
  const ModulationConfig& m = config_.modulation;
  return m.wander_deg == 0.0 ? 0.0 : m.wander_deg * std::sin(2.0 * pi * time_s / m.wander_period_s);
}

double Plant::motor_pickup_v() const {
  const double amplitude_v = config_.amplifier.motor_pickup_v;
  return amplitude_v == 0.0 ? 0.0 : amplitude_v * std::sin(optics::radians(true_angle_deg(1)));
}

Plant::Waves Plant::waves_of(const WavesOf& where) const {
  const AmplifierConfig& a = config_.amplifier;
  const double codes_per_v = 4096.0 / config_.adc.full_scale_v;
  const double gain = gain_at_adc();
  const std::uint64_t stream_key =
      derive_key(noise_seed_, std::bit_cast<std::uint64_t>(where.start_time_s));
  const std::uint64_t jitter_key = derive_key(stream_key, 2);
  const std::uint64_t phase_key = derive_key(stream_key, 3);
  const double time_s = where.start_time_s +
                        static_cast<double>(where.interval * slow_interval) / where.sample_rate_hz;

  Beams beams = beams_at(time_s);
  Waves waves;
  waves.keys = {derive_key(stream_key, 0), derive_key(stream_key, 1), beams.sample_noise};
  if (beams.jitter != 0.0) {
    beams.signal *= 1.0 + beams.jitter * gaussian_of(jitter_key, where.interval);
  }
  double wander_deg = phase_wander_deg(time_s);
  if (config_.modulation.jitter_deg != 0.0) {
    wander_deg += config_.modulation.jitter_deg * gaussian_of(phase_key, where.interval);
  }

  const double electronics =
      a.output_noise_v * a.output_noise_v + std::pow(gain * a.input_noise_v, 2.0);
  const double shot = gain * gain * config_.detector.shot_noise_v * beams.signal;
  const double since_change = std::max(0.0, time_s - range_changed_s_);
  const double pickup = gain * a.pickup_v;
  ChannelWave& s = waves.signal;
  s = channel(std::hypot(beams.signal * gain, a.pedestal_adc_v), a.phase_deg + wander_deg,
              codes_per_v);
  s.in_phase += swing_per_fundamental * codes_per_v * (pickup + gain * motor_pickup_v());
  s.quadrature += swing_per_fundamental * codes_per_v * pickup * a.pickup_y_fraction;
  s.offset = codes_per_v * (a.offset_v + a.settle_v * std::exp(-since_change / a.settle_tau_s));
  s.noise_dark = codes_per_v * std::sqrt(electronics);
  s.noise_lit = codes_per_v * std::sqrt(electronics + shot);

  ChannelWave& m = waves.monitor;
  m = channel(beams.monitor, config_.monitor.phase_deg + wander_deg, codes_per_v);
  m.offset = codes_per_v * config_.monitor.offset_v;
  m.noise_dark = m.noise_lit = codes_per_v * config_.monitor.noise_v;
  return waves;
}

void Plant::sample(double start_time_s, double sample_rate_hz, std::uint64_t first,
                   std::span<std::uint16_t> signal, std::span<std::uint16_t> monitor) {
  for (std::size_t done = 0; done < signal.size();) {
    const std::uint64_t n = first + done;
    const std::uint64_t interval = n / slow_interval;
    const auto left = static_cast<std::size_t>((interval + 1) * slow_interval - n);
    const std::size_t count = std::min(left, signal.size() - done);
    const WavesOf where{start_time_s, sample_rate_hz, interval};
    const Waves waves = waves_of(where);
    if (chopper_.present()) {
      for (std::size_t i = done; i < done + count; ++i) {
        const bool light = static_cast<std::uint32_t>((first + i) * phase_step_) < 0x8000'0000u;
        sample_chopped(waves, where, first + i, light, signal[i], monitor[i]);
      }
      done += count;
      continue;
    }
    synthesize(waves.signal, waves.monitor, waves.keys, phase_step_, n, signal.subspan(done, count),
               monitor.subspan(done, count));
    done += count;
  }
}

void Plant::sample_chopped(const Waves& waves, const WavesOf& where, std::uint64_t number,
                           bool light, std::uint16_t& signal, std::uint16_t& monitor) const {
  const double time_s = where.start_time_s + static_cast<double>(number) / where.sample_rate_hz;
  const double open = light ? chopper_.opening(time_s) : -1.0;
  const double ahead = light ? chopper_.opening(time_s, 0.25) : -1.0;
  synthesize_chopped(waves.signal, waves.monitor, waves.keys, number, open, ahead, signal, monitor);
}

void Plant::sample_driven(double start_time_s, double sample_rate_hz, std::uint64_t number,
                          bool light, std::uint16_t& signal, std::uint16_t& monitor) {
  const WavesOf where{start_time_s, sample_rate_hz, number / slow_interval};
  if (waves_of_ != where) {
    waves_ = waves_of(where);
    waves_of_ = where;
  }
  if (chopper_.present()) return sample_chopped(waves_, where, number, light, signal, monitor);
  const bool ahead = driven_.quarter_ahead(number, light);
  synthesize(waves_.signal, waves_.monitor, waves_.keys, number, light, ahead, signal, monitor);
}

}  // namespace umov::plant
