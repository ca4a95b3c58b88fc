#include "hil/mcu/board/mcu_board.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "boards/stm32f407/board_description.hpp"
#include "hil/mcu/otg_fs.hpp"

namespace umov::mcu {
namespace {

namespace wiring = boards::stm32f407;
using wiring::Pin;

constexpr int axis_count = static_cast<int>(wiring::axis_pins.size());
/// The reference input is high for so long after an edge.
constexpr Time pulse_length = 5 * time_per_us;
/// Inputs that the bench does not announce are looked at this often.
constexpr Time look_interval = 1000 * time_per_us;
/// A sample this long after another belongs to the same stream.
constexpr double sample_rate_hz = 100'000;
constexpr Time sample_interval = time_per_second / 100'000;

constexpr int number(Pin pin) {
  return pin.number;
}
constexpr int port(Pin pin) {
  return static_cast<int>(pin.port);
}
const wiring::AxisPins& pins_of(int axis) {
  return wiring::axis_pins[static_cast<std::size_t>(axis)];
}

/// What a pin that the chip drives does.
enum class Role : std::uint8_t { none, step, laser, shutter, gain };
struct Use {
  Role role = Role::none;
  int index = 0;
};

/// The transactions of a cable, carried to whatever controller the chip has after its last reset.
class UsbConnector final : public usbip::UsbFunction {
 public:
  UsbConnector(Stm32f407& chip, std::function<void(Time)> let_pass)
      : chip_(&chip), let_pass_(std::move(let_pass)) {}

  void bus_reset() override {
    if (OtgFs* usb = chip_->usb()) usb->bus_reset();
    // Hosts give a device this long to recover (USB 2.0 7.1.7.5); a cable of software may not.
    let_pass_(10'000 * time_per_us);
  }
  usbip::Handshake setup(const std::array<std::uint8_t, 8>& packet) override {
    OtgFs* usb = chip_->usb();
    return usb == nullptr ? usbip::Handshake::none : handshake(usb->setup(packet));
  }
  usbip::Handshake out(std::uint8_t endpoint, std::span<const std::uint8_t> bytes) override {
    OtgFs* usb = chip_->usb();
    return usb == nullptr ? usbip::Handshake::none : handshake(usb->out(endpoint, bytes));
  }
  usbip::Handshake in(std::uint8_t endpoint, usbip::Packet& packet) override {
    OtgFs* usb = chip_->usb();
    if (usb == nullptr) return usbip::Handshake::none;
    const usbip::Handshake answer = handshake(usb->in(endpoint, bytes_));
    if (answer == usbip::Handshake::ack) {
      std::copy(bytes_.begin(), bytes_.end(), packet.bytes.begin());
      packet.size = bytes_.size();
    }
    return answer;
  }

 private:
  static usbip::Handshake handshake(UsbAnswer answer) {
    switch (answer) {
      case UsbAnswer::ack:
        return usbip::Handshake::ack;
      case UsbAnswer::nak:
        return usbip::Handshake::nak;
      case UsbAnswer::stall:
        return usbip::Handshake::stall;
      case UsbAnswer::none:
        break;
    }
    return usbip::Handshake::none;
  }

  Stm32f407* chip_;
  std::function<void(Time)> let_pass_;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace

struct McuBoard::Impl final : Surroundings {
  Impl(Bench& the_bench, McuBoardOptions the_options)
      : bench(&the_bench), options(std::move(the_options)), chip(*this, options.chip) {
    for (int axis = 0; axis < axis_count; ++axis) use(pins_of(axis).step) = {Role::step, axis};
    for (std::size_t i = 0; i < wiring::laser_pins.size(); ++i)
      use(wiring::laser_pins[i]) = {Role::laser, static_cast<int>(i)};
    for (std::size_t i = 0; i < wiring::gain_pins.size(); ++i)
      use(wiring::gain_pins[i]) = {Role::gain, static_cast<int>(i)};
    use(wiring::shutter_pin) = {Role::shutter, 0};
    if (!options.image.empty()) chip.flash(read_elf(options.image));
    if (!options.boot_loader.empty()) chip.flash(read_elf(options.boot_loader));
    look_at_inputs();
    chip.reset(ResetSource::power_on);
  }

  Use& use(Pin pin) {
    return uses[static_cast<std::size_t>(port(pin))][static_cast<std::size_t>(number(pin))];
  }

  // Surroundings
  void on_pin(int port_number, int pin, bool level, Time now) override {
    const Use u = uses[static_cast<std::size_t>(port_number)][static_cast<std::size_t>(pin)];
    switch (u.role) {
      case Role::none:
        return;
      case Role::step:
        if (level) {
          step(u.index, now);
        } else if (options.on_step_end) {
          options.on_step_end(u.index, now);
        }
        return;
      case Role::laser:
        return bench->set_laser(u.index, level, seconds(now));
      case Role::shutter:
        return bench->set_shutter(level, seconds(now));
      case Role::gain:
        return bench->set_gain(range(), seconds(now));
    }
  }
  std::uint16_t analog(unsigned channel, Time now) override {
    if (!sampled || now != sampled_at) {
      if (sampled && now == sampled_at + sample_interval) {
        ++sample_number;
      } else {
        sample_number = 0;
        stream_start = now;
      }
      sampled = true;
      sampled_at = now;
      const bool light =
          chip.pin_level(port(wiring::modulation_pin), number(wiring::modulation_pin));
      codes = bench->sample(seconds(stream_start), sample_rate_hz, sample_number, light);
    }
    if (channel == wiring::signal_input.channel) return codes.signal;
    if (channel == wiring::monitor_input.channel) return codes.monitor;
    return 0;
  }
  void on_serial(std::uint8_t byte, Time) override {
    output.push_back(byte);
    if (until_output) chip.pause();
  }

  Time next_change(Time now) override {
    if (reference_high) return edge + pulse_length;
    const double next_s = bench->next_reference_edge(std::max(edge_s, seconds(now)));
    if (!std::isfinite(next_s)) return now + look_interval;  // somebody may switch it on
    edge_due = true;
    edge_s = next_s;
    edge = static_cast<Time>(next_s * static_cast<double>(time_per_second));
    return std::max(edge, now);
  }
  void change(Time) override {
    if (!reference_high && !std::exchange(edge_due, false)) return;
    reference_high = !reference_high;
    drive(wiring::reference_input.pin, reference_high);
  }

  int range() const {
    int value = 0;
    for (std::size_t i = 0; i < wiring::gain_pins.size(); ++i) {
      const Pin pin = wiring::gain_pins[i];
      value |= (chip.pin_level(port(pin), number(pin)) ? 1 : 0) << i;
    }
    return value;
  }

  void step(int axis, Time now) {
    const Pin direction = pins_of(axis).direction;
    const bool positive = chip.pin_level(port(direction), number(direction));
    bench->step(axis, positive ? 1 : -1, seconds(now));
    if (options.on_step) options.on_step(axis, now);
    show_switches(axis);
  }

  /// Normally closed to ground: a pressed switch leaves its pin to the pull-up.
  void show_switches(int axis) {
    const AxisSwitches s = bench->switches(axis);
    const wiring::AxisPins& pins = pins_of(axis);
    const auto show = [this](Pin pin, bool pressed) {
      drive(pin, pressed ? std::nullopt : std::optional(false));
    };
    show(pins.home, s.home);
    show(pins.lower_limit, s.lower_limit);
    show(pins.upper_limit, s.upper_limit);
  }
  void look_at_inputs() {
    for (int axis = 0; axis < axis_count; ++axis) show_switches(axis);
    const auto loop = [this](Pin pin, bool closed) {
      drive(pin, closed ? std::optional(true) : std::nullopt);
    };
    loop(wiring::interlock_pin, bench->interlock_closed());
    loop(wiring::emergency_pin, bench->emergency_released());
    loop(wiring::cool_pin, !bench->overheated());
  }
  void drive(Pin pin, std::optional<bool> level) { chip.drive_pin(port(pin), number(pin), level); }

  void run_until(Time limit) {
    while (chip.now() < limit && !chip.halted()) {
      look_at_inputs();
      chip.run_until(std::min(limit, chip.now() + look_interval));
      if (until_output && !output.empty()) return;
    }
  }

  Bench* bench;
  McuBoardOptions options;
  std::array<std::array<Use, 16>, 5> uses{};
  Stm32f407 chip;
  UsbConnector usb{chip, [this](Time duration) { run_until(chip.now() + duration); }};
  std::vector<std::uint8_t> output;
  bool until_output = false;
  bool sampled = false;
  Time sampled_at = 0, stream_start = 0;
  bool reference_high = false, edge_due = false;
  double edge_s = 0;
  Time edge = 0;  ///< the same
  std::uint64_t sample_number = 0;
  CodePair codes{};
};

McuBoard::McuBoard(Bench& bench, McuBoardOptions options)
    : impl_(std::make_unique<Impl>(bench, std::move(options))) {}
McuBoard::~McuBoard() = default;

void McuBoard::deliver(std::span<const std::uint8_t> bytes) {
  impl_->chip.serial(bytes);
}

std::size_t McuBoard::take_output(std::vector<std::uint8_t>& buffer) {
  const std::size_t size = impl_->output.size();
  buffer.insert(buffer.end(), impl_->output.begin(), impl_->output.end());
  impl_->output.clear();
  return size;
}

bool McuBoard::has_output() const {
  return !impl_->output.empty();
}

void McuBoard::run_for(std::uint64_t duration_us) {
  impl_->run_until(impl_->chip.now() + duration_us * time_per_us);
}

bool McuBoard::run_until_output(std::uint64_t max_duration_us) {
  impl_->until_output = true;
  if (impl_->output.empty()) impl_->run_until(impl_->chip.now() + max_duration_us * time_per_us);
  impl_->until_output = false;
  return has_output();
}

std::uint64_t McuBoard::now_us() const {
  return impl_->chip.now() / time_per_us;
}

void McuBoard::look_at_inputs() {
  impl_->look_at_inputs();
}

void McuBoard::set_stall(int axis, bool high) {
  impl_->drive(pins_of(axis).stall, high ? std::optional(true) : std::nullopt);
}

void McuBoard::signal_stall(int axis) {
  set_stall(axis, true);
  run_for(10);
  set_stall(axis, false);
}

void McuBoard::reset(ResetSource source) {
  impl_->chip.reset(source);
}

usbip::UsbFunction& McuBoard::usb() {
  return impl_->usb;
}

bool McuBoard::usb_connected() {
  const OtgFs* usb = impl_->chip.usb();
  return usb != nullptr && usb->connected();
}

Stm32f407& McuBoard::chip() {
  return impl_->chip;
}
const Stm32f407& McuBoard::chip() const {
  return impl_->chip;
}

}  // namespace umov::mcu
