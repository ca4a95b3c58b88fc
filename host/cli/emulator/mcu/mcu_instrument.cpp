#include "host/cli/emulator/mcu/mcu_instrument.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace umov::emulator {
namespace {

/// The wires between the board's connectors and the plant.
class Wiring : public mcu::Bench {
 public:
  explicit Wiring(plant::Plant& plant) : plant_(&plant) {}

  void step(int axis, int direction, double time_s) override {
    plant_->step(axis, direction, time_s);
  }
  mcu::AxisSwitches switches(int axis) const override {
    const auto state = plant_->switches(axis);
    return {.home = state.home, .lower_limit = state.lower_limit, .upper_limit = state.upper_limit};
  }
  void set_laser(int laser, bool on, double time_s) override {
    plant_->set_laser(laser, on, time_s);
  }
  void set_shutter(bool open, double time_s) override { plant_->set_shutter(open, time_s); }
  void set_gain(int range, double time_s) override { plant_->set_gain(range, time_s); }
  bool interlock_closed() const override { return plant_->interlock_closed(); }
  mcu::CodePair sample(double start_time_s, double sample_rate_hz, std::uint64_t number,
                       bool light) override {
    mcu::CodePair codes;
    plant_->sample_driven(start_time_s, sample_rate_hz, number, light, codes.signal, codes.monitor);
    return codes;
  }

 private:
  plant::Plant* plant_;
};

class SerialTransport : public instrument::Transport {
 public:
  explicit SerialTransport(std::shared_ptr<McuInstrument> instrument)
      : instrument_(std::move(instrument)) {}

  void write(std::span<const std::uint8_t> bytes) override { instrument_->board().deliver(bytes); }

  std::size_t read(std::span<std::uint8_t> buffer, std::chrono::microseconds timeout) override {
    auto& board = instrument_->board();
    if (used_ == output_.size()) {
      output_.clear();
      used_ = 0;
      board.run_until_output(
          static_cast<std::uint64_t>(std::max<std::int64_t>(timeout.count(), 1)));
      board.take_output(output_);
    }
    const std::size_t n = std::min(buffer.size(), output_.size() - used_);
    std::copy_n(output_.begin() + static_cast<std::ptrdiff_t>(used_), n, buffer.begin());
    used_ += n;
    return n;
  }

  std::uint64_t clock_us() override { return instrument_->board().now_us(); }
  std::string name() const override { return "emulated board"; }

 private:
  std::shared_ptr<McuInstrument> instrument_;
  std::vector<std::uint8_t> output_;
  std::size_t used_ = 0;
};

}  // namespace

McuInstrument::McuInstrument(const BenchOptions& options, mcu::McuBoardOptions board)
    : plant_(std::make_unique<plant::Plant>(plant_setup(options))),
      wiring_(std::make_unique<Wiring>(*plant_)),
      board_(std::make_unique<mcu::McuBoard>(*wiring_, std::move(board))) {}

std::unique_ptr<instrument::Transport> connect_serial(std::shared_ptr<McuInstrument> instrument) {
  return std::make_unique<SerialTransport>(std::move(instrument));
}

}  // namespace umov::emulator
