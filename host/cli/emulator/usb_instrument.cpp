#include "host/cli/emulator/usb_instrument.hpp"

#include <algorithm>
#include <array>
#include <string>

namespace umov::emulator {
namespace {

std::array<char, 24> padded(const std::string& text) {
  std::array<char, 24> out{};
  std::copy_n(text.begin(), std::min(text.size(), out.size()), out.begin());
  return out;
}

}  // namespace

UsbInstrument::UsbInstrument(const BenchOptions& options,
                             std::function<std::uint64_t()> link_time_us,
                             std::function<void(const std::string&)> on_event)
    : time_us_(link_time_us),
      on_event_(std::move(on_event)),
      instrument_(options, std::move(link_time_us)),
      device_(port_, *this, padded(bench_serial(options))) {
  port_.bind(device_);
  device_.start();
}

void UsbInstrument::run_for(std::uint64_t duration_us) {
  instrument_.board().run_for(duration_us);
  pump();
  device_.tick(time_us_());
}

void UsbInstrument::pump() {
  // What does not fit the stack's ring waits in the board's buffer, and then in the core: as on
  // hardware.
  if (output_.empty()) instrument_.board().take_output(output_);
  // Said to a host that has gone meanwhile.
  if (!device_.has_host()) written_ = output_.size();
  while (written_ < output_.size()) {
    const std::size_t size = std::min(output_.size() - written_, device_.link_room());
    if (size == 0) return;
    device_.write_link(std::span<const std::uint8_t>(output_).subspan(written_, size));
    written_ += size;
  }
  output_.clear();
  written_ = 0;
}

void UsbInstrument::on_link_bytes(std::span<const std::uint8_t> bytes) {
  instrument_.board().deliver(bytes);
  pump();
}

void UsbInstrument::on_hand_report(const firmware::usb::HandReport& report) {
  auto& board = instrument_.board();
  if (report.emergency || report.stop) return board.stop_by_hand(report.emergency);
  board.jog(report.axis, report.by_udeg);
}

firmware::usb::HandState UsbInstrument::hand_state(std::uint8_t axis) const {
  const auto view = instrument_.board().hand_view(axis);
  return {.state = static_cast<std::uint8_t>(view.state),
          .fault = static_cast<std::uint8_t>(view.fault),
          .homed_mask = view.homed_mask,
          .axis = axis,
          .position_udeg = view.position_udeg};
}

void UsbInstrument::on_detach() {
  if (on_event_) on_event_("a host wants to update the firmware; this board has no bootloader");
}

}  // namespace umov::emulator
