#include "hil/blind/bench.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "hil/plant/sample_catalog.hpp"

namespace umov::blind {
namespace {

constexpr double pi = optics::pi;
constexpr std::array<double, 4> gains = {1.0, 10.0, 100.0, 1000.0};
constexpr double open_deg = 200.0;  ///< where carriers park
constexpr double take_up_deg = 1.0;
/// Codes from mid-scale below which the next range is tried: a factor of ten and some room.
constexpr double step_up_codes = 0.07 * 2047.0;
constexpr double largest_codes = 0.97 * 2047.0;
const std::string tile_name = "white-99";

std::array<plant::AxisTravel, plant::axis_count> travel_from_zero() {
  auto travel = plant::reference_travel();
  for (plant::AxisTravel& t : travel) t.start_deg = 0.0;
  return travel;
}

double mean(std::span<const double> values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

double standard_error(std::span<const double> values) {
  const double m = mean(values);
  double sum = 0.0;
  for (const double v : values) sum += (v - m) * (v - m);
  const auto n = static_cast<double>(values.size());
  return std::sqrt(sum / (n - 1.0) / n);
}

/// Reference waves at the ADC's sampling points: the square wave, high for the first half of the
/// samples of a period, has its centre half a sample early.
struct References {
  std::vector<double> sine, cosine;
  double scale;  ///< sum over one period to volts at the ADC

  References(int samples_per_period, double volts_per_code) {
    for (int n = 0; n < samples_per_period; ++n) {
      const double phase = 2.0 * pi * (n + 0.5) / samples_per_period;
      sine.push_back(std::sin(phase));
      cosine.push_back(std::cos(phase));
    }
    // Harmonics that fold onto the fundamental raise 4/π to 4/(N sin(π/N)).
    const double x = pi / samples_per_period;
    scale = 2.0 / samples_per_period * volts_per_code * std::sin(x) / x;
  }
};

}  // namespace

Bench::Bench(plant::PlantConfig config, std::shared_ptr<const plant::Sample> sample,
             std::uint64_t seed, const Acquisition& acquisition, double start_s)
    : plant_({std::move(config), travel_from_zero(), sample, seed}),
      sample_(std::move(sample)),
      acquisition_(acquisition),
      time_s_(start_s) {
  const auto travel = travel_from_zero();
  for (std::size_t i = 0; i < plant::axis_count; ++i) {
    steps_per_deg_[i] = travel[i].steps_per_turn / 360.0;
  }
  plant_.set_reference(static_cast<std::uint32_t>(
      std::ceil(acquisition.reference_hz / acquisition.sample_rate_hz * 0x1p32)));
  plant_.set_shutter(true, -1.0);
}

void Bench::arrange(const RowBlock& block) {
  plant_.place_sample(block.white_tile
                          ? std::shared_ptr<const plant::Sample>(plant::make_sample(tile_name))
                          : sample_);
  plant_.arrange(block.setup);
}

void Bench::turn(int axis, double angle_deg, double speed_deg_per_s, double& longest_s) {
  const auto a = static_cast<std::size_t>(axis);
  const double distance = std::abs(angle_deg - at_deg_[a]);
  plant_.turn_to(axis, std::llround(angle_deg * steps_per_deg_[a]), time_s_);
  at_deg_[a] = angle_deg;
  longest_s = std::max(longest_s, distance / speed_deg_per_s);
}

void Bench::go_to(const Row& row) {
  const double speed = acquisition_.arm_speed_deg_per_s;
  const auto carrier = [](double axis_deg) { return std::isnan(axis_deg) ? open_deg : axis_deg; };
  double longest_s = 0.0;
  turn(0, row.theta_i_deg, speed, longest_s);
  turn(2, row.phi_r_deg, speed, longest_s);
  turn(3, carrier(row.state.polarizer_deg), 2.0 * speed, longest_s);
  turn(4, carrier(row.state.analyzer_deg), 2.0 * speed, longest_s);
  turn(5, 60.0 * row.density, 2.0 * speed, longest_s);
  // The arm comes in the wanted sense; where it has to turn back it goes past and takes up the
  // play.
  const double distance = row.theta_r_deg - at_deg_[1];
  if (distance * row.approach < 0.0) {
    double back_s = 0.0;
    turn(1, row.theta_r_deg - row.approach * take_up_deg, speed, back_s);
    time_s_ += back_s;
  }
  if (distance != 0.0) direction_ = row.approach;
  turn(1, row.theta_r_deg, speed, longest_s);
  time_s_ += longest_s;
  if (row.laser != laser_) {
    for (int i = 0; i < plant::laser_count; ++i) plant_.set_laser(i, i == row.laser, time_s_);
    laser_ = row.laser;
  }
  if (row.shutter_open != shutter_open_) {
    plant_.set_shutter(row.shutter_open, time_s_);
    shutter_open_ = row.shutter_open;
  }
  time_s_ += acquisition_.settle_s;
}

int Bench::choose_range(int range) const {
  const plant::PlantConfig& config = plant_.config();
  const plant::ExpectedSignal e = plant_.expected(time_s_);
  const double per_v = pi / 4.0 * 4096.0 / config.adc.full_scale_v;
  const auto peak = [&](int r) {
    const double gain = gains[static_cast<std::size_t>(r)];
    const double noise =
        4.0 * std::hypot(config.amplifier.output_noise_v, gain * config.amplifier.input_noise_v);
    // X and Y each are a square wave; their edges fall apart and their levels add.
    const double jitter = 1.0 + 4.0 * config.laser[static_cast<std::size_t>(laser_)].jitter;
    return per_v * (gain * (std::abs(e.x_v) + std::abs(e.y_v)) * jitter + noise);
  };
  while (range < 3 && peak(range) <= step_up_codes) ++range;
  while (range > 0 && peak(range) > largest_codes) --range;
  return range;
}

std::vector<CleanRecord> Bench::clean(std::span<const RowBlock> blocks) {
  std::vector<CleanRecord> records;
  for (const RowBlock& block : blocks) {
    arrange(block);
    for (const Row& row : block.rows) {
      go_to(row);
      range_ = choose_range(range_);
      plant_.set_gain(range_, time_s_ - acquisition_.settle_s);
      const double dwell_s = acquisition_.dwell_s();
      const plant::ExpectedSignal e = plant_.expected(time_s_ + 0.5 * dwell_s);
      records.push_back({e.x_v, e.y_v, e.monitor_v, range_});
      time_s_ += dwell_s;
    }
  }
  return records;
}

formats::ScanTable Bench::measure(std::span<const RowBlock> blocks) {
  const plant::PlantConfig& config = plant_.config();
  const double volts_per_code = config.adc.full_scale_v / 4096.0;
  const auto period = static_cast<std::size_t>(
      std::llround(acquisition_.sample_rate_hz / acquisition_.reference_hz));
  const References reference(static_cast<int>(period), volts_per_code);
  const auto periods = static_cast<std::size_t>(acquisition_.periods);
  const auto parts = static_cast<std::size_t>(acquisition_.scatter_blocks);
  const std::size_t periods_a_part = std::max<std::size_t>(1, periods / parts);
  std::vector<std::uint16_t> signal(period * periods_a_part), monitor(signal.size());
  std::vector<double> x(parts), y(parts), m(parts);

  formats::ScanTable table;
  for (const RowBlock& block : blocks) {
    arrange(block);
    const auto first = static_cast<std::int64_t>(table.size());
    for (const Row& row : block.rows) {
      go_to(row);
      range_ = choose_range(range_);
      bool clipped = false;
      for (;;) {
        plant_.set_gain(range_, time_s_ - acquisition_.settle_s);
        clipped = false;
        for (std::size_t part = 0; part < parts; ++part) {
          plant_.sample(time_s_, acquisition_.sample_rate_hz, part * signal.size(), signal,
                        monitor);
          double sx = 0.0, sy = 0.0, sm = 0.0;
          for (std::size_t n = 0; n < signal.size(); ++n) {
            const double s = static_cast<double>(signal[n]) - 2048.0;
            const std::size_t k = n % period;
            sx += s * reference.sine[k];
            sy += s * reference.cosine[k];
            sm += (static_cast<double>(monitor[n]) - 2048.0) * reference.sine[k];
            clipped = clipped || signal[n] == 0 || signal[n] == 4095;
          }
          const double scale = reference.scale / static_cast<double>(periods_a_part);
          x[part] = scale * sx;
          y[part] = scale * sy;
          m[part] = scale * sm;
        }
        if (!clipped || range_ == 0) break;
        --range_;
        time_s_ += acquisition_.dwell_s();
      }
      const double gain = gains[static_cast<std::size_t>(range_)];
      const double dwell_s = acquisition_.dwell_s();
      table.index.push_back(static_cast<std::int64_t>(table.size()));
      table.time_s.push_back(time_s_ + 0.5 * dwell_s);
      table.theta_i_deg.push_back(row.theta_i_deg);
      table.theta_r_deg.push_back(row.theta_r_deg);
      table.phi_r_deg.push_back(row.phi_r_deg);
      table.wavelength_nm.push_back(plant::laser_names[static_cast<std::size_t>(row.laser)]);
      table.polarizer_deg.push_back(row.state.polarizer_deg);
      table.analyzer_deg.push_back(row.state.analyzer_deg);
      table.direction.push_back(direction_);
      table.gain.push_back(gain);
      table.x_v.push_back(mean(x) / gain);
      table.y_v.push_back(mean(y) / gain);
      table.x_se_v.push_back(standard_error(x) / gain);
      table.y_se_v.push_back(standard_error(y) / gain);
      table.monitor_v.push_back(mean(m));
      table.saturated.push_back(clipped ? 1 : 0);
      table.shutter_open.push_back(row.shutter_open ? 1 : 0);
      time_s_ += dwell_s;
    }
    table.blocks.push_back(
        {block.name, first, static_cast<std::int64_t>(table.size()) - 1, block.settings});
  }
  return table;
}

}  // namespace umov::blind
