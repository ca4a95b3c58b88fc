// The modulated signals sample by sample: square wave, noise, quantisation.
#pragma once

#include <cstdint>
#include <span>

namespace umov::plant {

/// One channel while nothing but the modulation and the noise changes. Units: ADC codes. The sum of
/// the first two is what the light makes of the modulation, turned by the electronics' phase: a lag
/// of the fundamental is exact, the shape of the edges is not modelled.
struct ChannelWave {
  double in_phase = 0.0;    ///< half the step of the square wave in phase with the reference
  double quadrature = 0.0;  ///< and of the one a quarter period ahead
  double light = 0.0;       ///< step from light off to light on
  double offset = 0.0;      ///< constant
  double noise_dark = 0.0;  ///< rms of the white noise while the light is off
  double noise_lit = 0.0;   ///< and while it is on
};

/// Keys of the noise; its counter is the sample number.
struct NoiseKeys {
  std::uint64_t electronics = 0;
  std::uint64_t light = 0;
  double light_rms = 0.0;  ///< relative power noise per sample, common to both channels
};

/// Codes of samples first … first + signal.size() - 1: the wave at phase n · phase_step (mod 2^32),
/// high below 2^31, plus noise; rounded to the nearest code and clipped to 0 … 4095. Both spans
/// have one length.
void synthesize(const ChannelWave& signal_wave, const ChannelWave& monitor_wave,
                const NoiseKeys& keys, std::uint32_t phase_step, std::uint64_t first,
                std::span<std::uint16_t> signal, std::span<std::uint16_t> monitor);

/// The same for one sample of a modulation that is driven from outside: `lit` its level at sample
/// `number`, `ahead` its level a quarter period later.
void synthesize(const ChannelWave& signal_wave, const ChannelWave& monitor_wave,
                const NoiseKeys& keys, std::uint64_t number, bool lit, bool ahead,
                std::uint16_t& signal, std::uint16_t& monitor);

/// The same for one sample of light that passes a chopper: `open` from -1 (blocked) to 1, `ahead`
/// what it will be a quarter period later.
void synthesize_chopped(const ChannelWave& signal_wave, const ChannelWave& monitor_wave,
                        const NoiseKeys& keys, std::uint64_t number, double open, double ahead,
                        std::uint16_t& signal, std::uint16_t& monitor);

}  // namespace umov::plant
