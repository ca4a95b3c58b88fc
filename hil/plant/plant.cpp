#include "hil/plant/plant.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <utility>

#include "hil/plant/noise.hpp"
#include "hil/plant/waveform.hpp"
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

/// Photodiode law in volts at range 1.
double detected(const DetectorConfig& detector, double volts) {
  double s = volts;
  if (detector.nonlinearity_per_v != 0.0) s /= 1.0 + detector.nonlinearity_per_v * s;
  if (detector.inverse_knee_per_v != 0.0) {
    s /= std::pow(1.0 + std::pow(s * detector.inverse_knee_per_v, 4.0), 0.25);
  }
  return s;
}

}  // namespace

/// Fundamentals in volts at range 1 at one moment.
struct Plant::Beams {
  double signal = 0.0;  ///< behind the photodiode
  double monitor = 0.0;
  double sample_noise = 0.0;  ///< relative power noise per ADC sample
};

Plant::Plant(PlantSetup setup)
    : config_(std::move(setup.config)),
      sample_(std::move(setup.sample)),
      noise_seed_(derive_key(setup.seed, 100)) {
  if (!sample_) throw Error("the instrument has no sample", "give a sample by name or file");
  for (std::size_t i = 0; i < axis_count; ++i) {
    stages_.emplace_back(setup.travel[i], config_.axis[i], derive_key(setup.seed, i));
  }
  for (std::size_t i = 0; i < laser_count; ++i) {
    power_.emplace_back(config_.laser[i], derive_key(setup.seed, 10 + i));
  }
}

void Plant::step(int axis, int direction, double) {
  stages_[static_cast<std::size_t>(axis)].step(direction);
  if (axis < 3) geometry_changed();
}

AxisSwitches Plant::switches(int axis) const {
  return stages_[static_cast<std::size_t>(axis)].switches();
}

void Plant::set_laser(int laser, bool on, double) {
  laser_on_[static_cast<std::size_t>(laser)] = on;
}

void Plant::set_shutter(bool open, double time_s) {
  if (open == shutter_open_) return;
  shutter_open_ = open;
  shutter_changed_s_ = time_s;
}

void Plant::set_gain(int range, double time_s) {
  if (range == range_) return;
  range_ = range;
  range_changed_s_ = time_s;
}

void Plant::set_reference(std::uint32_t phase_step) {
  phase_step_ = phase_step;
}

void Plant::place_sample(std::shared_ptr<const Sample> sample) {
  if (!sample) throw Error("the instrument has no sample", "give a sample by name or file");
  sample_ = std::move(sample);
  geometry_changed();
}

void Plant::arrange(const Setup& setup) {
  setup_ = setup;
  geometry_changed();
}

double Plant::true_angle_deg(int axis) const {
  return stages_[static_cast<std::size_t>(axis)].true_deg();
}

void Plant::geometry_changed() {
  throughput_known_.fill(false);
}

const Throughput& Plant::throughput(int laser) const {
  const auto i = static_cast<std::size_t>(laser);
  if (!throughput_known_[i]) {
    const Geometry geometry{optics::radians(true_angle_deg(0)), optics::radians(true_angle_deg(1)),
                            optics::radians(true_angle_deg(2))};
    const LaserConfig& l = config_.laser[i];
    throughput_[i] = collect(*sample_, config_, setup_, geometry,
                             l.wavelength_nm + l.wavelength_error_nm, l.line_width_nm);
    throughput_known_[i] = true;
  }
  return throughput_[i];
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
  return shutter_open_ ? moved : 1.0 - moved;
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

Plant::Beams Plant::beams_at(double time_s) const {
  Stokes row = photodiode_row(config_.detector.polarization_bias);
  if (stages_[4].motor_deg() < open_from_deg) {
    row = row_times(row, polarizer_mueller(true_angle_deg(4), config_.analyzer.extinction));
  }
  const Stokes monitor_row = photodiode_row(config_.monitor.polarization_bias);
  const double opening = shutter_opening(time_s);
  Beams beams;
  double noise_power = 0.0;
  for (int laser = 0; laser < laser_count; ++laser) {
    const auto i = static_cast<std::size_t>(laser);
    const Stokes beam = beam_behind_filter(laser, time_s);
    if (beam[0] == 0.0) continue;
    const double monitor = optics::dot(Vec3(monitor_row[0], monitor_row[1], monitor_row[2]),
                                       Vec3(beam[0], beam[1], beam[2]));
    beams.monitor += monitor;
    noise_power += monitor * config_.laser[i].sample_noise;
    if (opening > 0.0) {
      beams.signal += opening * long_pass_transmittance(laser) * config_.laser[i].gain_constant_v *
                      power_[i].unseen(time_s) *
                      optics::contract(row, throughput(laser).total(), beam);
    }
  }
  beams.signal = detected(config_.detector, std::max(0.0, beams.signal));
  if (beams.monitor > 0.0) beams.sample_noise = noise_power / beams.monitor;
  return beams;
}

ExpectedSignal Plant::expected(double time_s) const {
  const Beams beams = beams_at(time_s);
  const AmplifierConfig& a = config_.amplifier;
  const double gain = gain_at_adc();
  const double nominal = nominal_gain[static_cast<std::size_t>(range_)];
  const double amplitude = std::hypot(beams.signal * gain, a.pedestal_adc_v) / nominal;
  const double phase = optics::radians(a.phase_deg);
  const double pickup = a.pickup_v * gain / nominal;
  return {amplitude * std::cos(phase) + pickup,
          amplitude * std::sin(phase) + pickup * a.pickup_y_fraction,
          beams.monitor * std::cos(optics::radians(config_.monitor.phase_deg))};
}

void Plant::sample(double start_time_s, double sample_rate_hz, std::uint64_t first,
                   std::span<std::uint16_t> signal, std::span<std::uint16_t> monitor) {
  const AmplifierConfig& a = config_.amplifier;
  const double codes_per_v = 4096.0 / config_.adc.full_scale_v;
  const double gain = gain_at_adc();
  const std::uint64_t stream_key =
      derive_key(noise_seed_, std::bit_cast<std::uint64_t>(start_time_s));
  NoiseKeys keys{derive_key(stream_key, 0), derive_key(stream_key, 1), 0.0};

  for (std::size_t done = 0; done < signal.size();) {
    const std::uint64_t n = first + done;
    const std::uint64_t interval = n / slow_interval;
    const double time_s =
        start_time_s + static_cast<double>(interval * slow_interval) / sample_rate_hz;
    const auto left = static_cast<std::size_t>((interval + 1) * slow_interval - n);
    const std::size_t count = std::min(left, signal.size() - done);
    const Beams beams = beams_at(time_s);
    keys.light_rms = beams.sample_noise;

    const double electronics =
        a.output_noise_v * a.output_noise_v + std::pow(gain * a.input_noise_v, 2.0);
    const double shot = gain * gain * config_.detector.shot_noise_v * beams.signal;
    const double since_change = std::max(0.0, time_s - range_changed_s_);
    const double pickup = gain * a.pickup_v;
    ChannelWave s =
        channel(std::hypot(beams.signal * gain, a.pedestal_adc_v), a.phase_deg, codes_per_v);
    s.in_phase += swing_per_fundamental * codes_per_v * pickup;
    s.quadrature += swing_per_fundamental * codes_per_v * pickup * a.pickup_y_fraction;
    s.offset = codes_per_v * (a.offset_v + a.settle_v * std::exp(-since_change / a.settle_tau_s));
    s.noise_dark = codes_per_v * std::sqrt(electronics);
    s.noise_lit = codes_per_v * std::sqrt(electronics + shot);

    ChannelWave m = channel(beams.monitor, config_.monitor.phase_deg, codes_per_v);
    m.offset = codes_per_v * config_.monitor.offset_v;
    m.noise_dark = m.noise_lit = codes_per_v * config_.monitor.noise_v;

    synthesize(s, m, keys, phase_step_, n, signal.subspan(done, count),
               monitor.subspan(done, count));
    done += count;
  }
}

}  // namespace umov::plant
