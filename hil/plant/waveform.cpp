#include "hil/plant/waveform.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "hil/plant/noise.hpp"

namespace umov::plant {
namespace {

constexpr double middle = 2048.0;
constexpr std::uint32_t quarter_turn = 0x40000000u;

inline bool high(std::uint32_t phase) {
  return phase < 0x80000000u;
}

inline double level(const ChannelWave& wave, bool in_phase, bool quadrature) {
  return wave.offset + (in_phase ? wave.in_phase : -wave.in_phase) +
         (quadrature ? wave.quadrature : -wave.quadrature);
}

inline std::uint16_t to_code(double value) {
  return static_cast<std::uint16_t>(std::clamp(value + (middle + 0.5), 0.0, 4095.0));
}

/// Codes of sample n.
inline void synthesize_one(const ChannelWave& signal_wave, const ChannelWave& monitor_wave,
                           const NoiseKeys& keys, const GaussianTable& normal, std::uint64_t n,
                           bool lit, bool ahead, std::uint16_t& signal, std::uint16_t& monitor) {
  const std::uint64_t bits = random_bits(keys.electronics, n);
  double s =
      level(signal_wave, lit, ahead) + (lit ? signal_wave.noise_lit : signal_wave.noise_dark) *
                                           normal(static_cast<std::uint32_t>(bits));
  double m =
      level(monitor_wave, lit, ahead) + (lit ? monitor_wave.noise_lit : monitor_wave.noise_dark) *
                                            normal(static_cast<std::uint32_t>(bits >> 32));
  if (keys.light_rms != 0.0 && lit) {
    const double relative =
        keys.light_rms * normal(static_cast<std::uint32_t>(random_bits(keys.light, n)));
    s += signal_wave.light * relative;
    m += monitor_wave.light * relative;
  }
  signal = to_code(s);
  monitor = to_code(m);
}

}  // namespace

void synthesize(const ChannelWave& signal_wave, const ChannelWave& monitor_wave,
                const NoiseKeys& keys, std::uint32_t phase_step, std::uint64_t first,
                std::span<std::uint16_t> signal, std::span<std::uint16_t> monitor) {
  const GaussianTable& normal = GaussianTable::instance();
  for (std::size_t i = 0; i < signal.size(); ++i) {
    const std::uint64_t n = first + i;
    const auto phase = static_cast<std::uint32_t>(n * phase_step);
    synthesize_one(signal_wave, monitor_wave, keys, normal, n, high(phase),
                   high(phase + quarter_turn), signal[i], monitor[i]);
  }
}

void synthesize(const ChannelWave& signal_wave, const ChannelWave& monitor_wave,
                const NoiseKeys& keys, std::uint64_t number, bool lit, bool ahead,
                std::uint16_t& signal, std::uint16_t& monitor) {
  synthesize_one(signal_wave, monitor_wave, keys, GaussianTable::instance(), number, lit, ahead,
                 signal, monitor);
}

void synthesize_chopped(const ChannelWave& signal_wave, const ChannelWave& monitor_wave,
                        const NoiseKeys& keys, std::uint64_t number, double open, double ahead,
                        std::uint16_t& signal, std::uint16_t& monitor) {
  const GaussianTable& normal = GaussianTable::instance();
  const double share = 0.5 * (1.0 + open);
  const double relative =
      keys.light_rms == 0.0
          ? 0.0
          : share * keys.light_rms *
                normal(static_cast<std::uint32_t>(random_bits(keys.light, number)));
  const auto code = [&](const ChannelWave& wave, std::uint32_t bits) {
    const double noise = std::sqrt(wave.noise_dark * wave.noise_dark * (1.0 - share) +
                                   wave.noise_lit * wave.noise_lit * share);
    return to_code(wave.offset + wave.in_phase * open + wave.quadrature * ahead +
                   noise * normal(bits) + wave.light * relative);
  };
  const std::uint64_t bits = random_bits(keys.electronics, number);
  signal = code(signal_wave, static_cast<std::uint32_t>(bits));
  monitor = code(monitor_wave, static_cast<std::uint32_t>(bits >> 32));
}

}  // namespace umov::plant
