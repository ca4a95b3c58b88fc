#include "host/cli/emulator/emulated_instrument.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

#include "hil/plant/parameter_list.hpp"
#include "hil/plant/sample_catalog.hpp"
#include "host/cli/emulator/board_transport.hpp"

namespace umov::emulator {
namespace {

/// The wires between the board's pins and the plant.
class Wiring : public boards::native::World {
 public:
  explicit Wiring(plant::Plant& plant) : plant_(&plant) {}

  void step(int axis, int direction, double time_s) override {
    plant_->step(axis, direction, time_s);
  }
  boards::native::AxisSwitches switches(int axis) const override {
    const auto state = plant_->switches(axis);
    return {.home = state.home, .lower_limit = state.lower_limit, .upper_limit = state.upper_limit};
  }
  void set_laser(int laser, bool on, double time_s) override {
    plant_->set_laser(laser, on, time_s);
  }
  void set_shutter(bool open, double time_s) override { plant_->set_shutter(open, time_s); }
  void set_gain(int range, double time_s) override { plant_->set_gain(range, time_s); }
  bool interlock_closed() const override { return plant_->interlock_closed(); }
  void set_reference(std::uint32_t phase_step) override { plant_->set_reference(phase_step); }
  double next_reference_edge(double after_s) const override {
    return plant_->next_reference_edge(after_s);
  }
  void sample(double start_time_s, double sample_rate_hz, std::uint64_t first,
              std::span<std::uint16_t> signal, std::span<std::uint16_t> monitor) override {
    plant_->sample(start_time_s, sample_rate_hz, first, signal, monitor);
  }

 private:
  plant::Plant* plant_;
};

/// Differs from start to start, so that hosts notice a restart.
std::uint32_t fresh_boot_id() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const auto us = std::chrono::duration_cast<std::chrono::microseconds>(now).count();
  return static_cast<std::uint32_t>(us) ^ (static_cast<std::uint32_t>(getpid()) << 16U);
}

void mix(std::uint32_t& hash, const std::string& text) {
  // FNV-1a; the length before the text keeps "ab" + "c" apart from "a" + "bc".
  for (const char c : std::to_string(text.size()) + ':' + text) {
    hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
  }
}

/// Contents of a file, empty when there is none of that name.
std::string text_of_file(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return {};
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

}  // namespace

std::string bench_serial(const BenchOptions& options) {
  std::uint32_t hash = 2166136261u;
  mix(hash, options.sample);
  mix(hash, text_of_file(options.sample));
  mix(hash, options.plant_file.empty() ? options.preset : text_of_file(options.plant_file));
  for (const auto& setting : options.settings) mix(hash, setting);
  mix(hash, std::to_string(options.seed));
  std::array<char, 16> serial{};
  std::snprintf(serial.data(), serial.size(), "EMU-%08x", static_cast<unsigned>(hash));
  return serial.data();
}

plant::PlantSetup plant_setup(const BenchOptions& options) {
  plant::PlantSetup setup;
  setup.config = options.plant_file.empty() ? plant::preset_config(options.preset)
                                            : plant::config_from_file(options.plant_file);
  for (const auto& setting : options.settings) plant::apply_override(setup.config, setting);
  setup.sample = plant::make_sample(options.sample);
  setup.seed = options.seed;
  setup.session = options.session;
  return setup;
}

EmulatedInstrument::EmulatedInstrument(const BenchOptions& options,
                                       std::function<std::uint64_t()> link_time_us) {
  plant::PlantSetup setup = plant_setup(options);
  own_sample_ = setup.sample;
  plant_ = std::make_unique<plant::Plant>(std::move(setup));
  wiring_ = std::make_unique<Wiring>(*plant_);
  boards::native::NativeBoardOptions board;
  board.serial = bench_serial(options);
  board.boot_id = fresh_boot_id();
  board.link_time_us = std::move(link_time_us);
  board_ = std::make_unique<boards::native::NativeBoard>(*wiring_, std::move(board));
}

std::unique_ptr<instrument::Transport> make_embedded(const BenchOptions& options) {
  return connect_embedded(std::make_shared<EmulatedInstrument>(options));
}

std::unique_ptr<instrument::Transport> connect_embedded(
    std::shared_ptr<EmulatedInstrument> instrument) {
  return std::make_unique<BoardTransport<EmulatedInstrument>>(std::move(instrument), "emulator");
}

}  // namespace umov::emulator
