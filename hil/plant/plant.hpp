// The emulated instrument in virtual time: what the controller's pins are wired to.
//
// Chain: laser (square-wave modulated by the reference output) → polariser → neutral-density wheel
// → monitor pick-off → shutter → sample → detector arm with analyser → photodiode → switchable
// amplifier → ADC. The amplifier passes the modulation only (its mean is removed), so that light
// swings the ADC's code evenly about mid-scale 2048.
//
// Nominal signal (ideal preset): the fundamental of the modulated signal, referred to range 1, is
//     X = C_λ · f · cos θr · ΔΩ · M,    Y = 0,
// M the fundamental of the monitor signal; a mirror in the mirror direction gives X = C_λ · R · M
// (P7).
//
// Speckle: coherent light on a rough sample, of which the aperture collects many grains; their sum
// follows a gamma distribution whose contrast is one over the root of their number (J. W. Goodman,
// Speckle Phenomena in Optics, 2007, ch. 4). A pattern belongs to a sample's place, wavelength,
// geometry and polarisation state: it comes back with them, and changes when the sample is shifted.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "hil/plant/chopper.hpp"
#include "hil/plant/collection.hpp"
#include "hil/plant/collection_memory.hpp"
#include "hil/plant/driven_modulation.hpp"
#include "hil/plant/laser_power.hpp"
#include "hil/plant/plant_config.hpp"
#include "hil/plant/polarization.hpp"
#include "hil/plant/sample.hpp"
#include "hil/plant/stage.hpp"
#include "hil/plant/waveform.hpp"

namespace umov::plant {

/// Everything a Plant is made of.
struct PlantSetup {
  PlantConfig config = ideal_config();
  std::array<AxisTravel, axis_count> travel = reference_travel();
  std::shared_ptr<const Sample> sample;
  std::uint64_t seed = 1;
  /// Which time the instrument was switched on: noise and the sources' wanderings differ from one
  /// to the next, stages and speckle do not.
  std::uint64_t session = 0;
};

/// Signal and monitor as the lock-in would see them without noise, volts referred to range 1.
struct ExpectedSignal {
  double x_v = 0.0, y_v = 0.0, monitor_v = 0.0;
};

/// Single-threaded. All randomness comes from the seed: the same calls give the same codes, and
/// samples do not depend on how a stream is cut into blocks.
class Plant {
 public:
  /// Throws umov::Error where no sample is given.
  explicit Plant(PlantSetup setup);

  // --- what the board drives; see boards/native/world.hpp for the same verbs ---

  /// One step pulse; direction +1 or -1.
  void step(int axis, int direction, double time_s);
  /// Many step pulses of one sense: the motor turns until it has made `target` steps from the home
  /// edge.
  void turn_to(int axis, std::int64_t target_steps, double time_s);
  AxisSwitches switches(int axis) const;
  /// Laser enables 0..2. The open interlock cuts the light whatever is commanded.
  void set_laser(int laser, bool on, double time_s);
  void set_shutter(bool open, double time_s);
  /// Amplifier range 0..3 = gain 1, 10, 100, 1000.
  void set_gain(int range, double time_s);
  bool interlock_closed() const { return interlock_closed_; }
  /// Modulation: light is on while phase(n) = n · phase_step (mod 2^32) is below 2^31.
  void set_reference(std::uint32_t phase_step);
  /// The photo-interrupter of the chopper: its first rising edge after `after_s`; infinite: none
  /// comes. With a chopper in the beam the light of samples is what it lets pass of the modulated
  /// light, so that a controller which detects against it leaves the modulation on.
  double next_reference_edge(double after_s) const { return chopper_.next_edge_s(after_s); }
  /// Codes 0..4095 of samples first … first + n - 1 of the stream that began at `start_time_s`;
  /// sample n is taken n / sample_rate_hz later, at modulation phase n · phase_step.
  void sample(double start_time_s, double sample_rate_hz, std::uint64_t first,
              std::span<std::uint16_t> signal, std::span<std::uint16_t> monitor);
  /// One sample of the stream where the modulation output is wired to the lasers instead of told by
  /// set_reference(): `light` is its level at that sample. Samples come in order, from number 0.
  /// What lags in phase (amplifier, pick-up) needs the period: it is known from the second rising
  /// edge on, until then there is no lag.
  void sample_driven(double start_time_s, double sample_rate_hz, std::uint64_t number, bool light,
                     std::uint16_t& signal, std::uint16_t& monitor);

  // --- what a person at the instrument does ---

  void set_interlock(bool closed) {
    interlock_closed_ = closed;
    waves_of_.reset();
  }
  /// What dust, water and marks the configuration names lie on the sample that the instrument was
  /// set up with; another one (a white tile) is clean.
  void place_sample(std::shared_ptr<const Sample> sample);
  void arrange(const Setup& setup);

  // --- the truth, for tests and for sealed answers ---

  const PlantConfig& config() const { return config_; }
  /// With all that lies on it.
  const Sample& sample_on_stage() const { return *sample_; }
  /// Angle of an axis at which the optics really stand, degrees.
  double true_angle_deg(int axis) const;
  /// Noise-free lock-in result of the present state at a moment, before the ADC (range errors
  /// included, divided by the nominal gain).
  ExpectedSignal expected(double time_s) const;

 private:
  struct Beams;
  /// Both channels while nothing changes.
  struct Waves {
    ChannelWave signal, monitor;
    NoiseKeys keys;
  };
  /// Where in a stream the present waves were taken; they hold until something is driven.
  struct WavesOf {
    double start_time_s, sample_rate_hz;
    std::uint64_t interval;
    bool operator==(const WavesOf&) const = default;
  };

  void stage_moved(int axis);
  void set_sample(std::shared_ptr<const Sample> clean);
  Geometry geometry() const;
  Throughput throughput(int laser, double time_s) const;
  double speckle(int laser) const;
  double humidity(double time_s) const;
  double phase_wander_deg(double time_s) const;
  double motor_pickup_v() const;
  Stokes beam_behind_filter(int laser, double time_s) const;
  Beams beams_at(double time_s) const;
  Waves waves_of(const WavesOf& where) const;
  double filter_transmittance() const;
  double long_pass_transmittance(int laser) const;
  Stokes detection_row(int laser) const;
  double shutter_opening(double time_s) const;
  double gain_at_adc() const;
  void sample_chopped(const Waves& waves, const WavesOf& where, std::uint64_t number, bool light,
                      std::uint16_t& signal, std::uint16_t& monitor) const;

  PlantConfig config_;
  std::vector<Stage> stages_;
  std::shared_ptr<const Sample> own_sample_;  ///< as given, clean
  std::shared_ptr<const Sample> sample_;      ///< on the stage, coated
  std::shared_ptr<const Sample> humid_;  ///< the same, swollen; null where that changes nothing
  std::vector<LaserPower> power_;
  std::uint64_t noise_seed_;
  std::uint64_t speckle_seed_;
  Setup setup_;

  std::array<bool, laser_count> laser_on_{};
  bool interlock_closed_ = true;
  bool shutter_open_ = false;
  double shutter_changed_s_ = -1e9;
  int range_ = 0;
  double range_changed_s_ = -1e9;
  std::uint32_t phase_step_ = 0;
  DrivenModulation driven_;
  Chopper chopper_;
  std::optional<WavesOf> waves_of_;
  Waves waves_;

  /// Filled on demand; the present entries are looked up again when the geometry changes.
  mutable CollectionMemory memory_;
  mutable std::array<const CollectionMemory::Entry*, laser_count> present_{};
};

}  // namespace umov::plant
