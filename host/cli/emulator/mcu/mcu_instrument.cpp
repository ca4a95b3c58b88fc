#include "host/cli/emulator/mcu/mcu_instrument.hpp"

#include <utility>

#include "host/cli/emulator/board_transport.hpp"

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
  double next_reference_edge(double after_s) const override {
    return plant_->next_reference_edge(after_s);
  }
  mcu::CodePair sample(double start_time_s, double sample_rate_hz, std::uint64_t number,
                       bool light) override {
    mcu::CodePair codes;
    plant_->sample_driven(start_time_s, sample_rate_hz, number, light, codes.signal, codes.monitor);
    return codes;
  }

 private:
  plant::Plant* plant_;
};

}  // namespace

McuInstrument::McuInstrument(const BenchOptions& options, mcu::McuBoardOptions board)
    : plant_(std::make_unique<plant::Plant>(plant_setup(options))),
      wiring_(std::make_unique<Wiring>(*plant_)),
      board_(std::make_unique<mcu::McuBoard>(*wiring_, std::move(board))) {}

std::unique_ptr<instrument::Transport> connect_serial(std::shared_ptr<McuInstrument> instrument) {
  return std::make_unique<BoardTransport<McuInstrument>>(std::move(instrument), "emulated board");
}

}  // namespace umov::emulator
