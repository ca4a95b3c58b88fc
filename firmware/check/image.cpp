// A board of nothing but registers, so that the core and its USB stack can be linked and measured
// as a whole.
#include <cstddef>
#include <cstdint>
#include <new>

#include "firmware/core/config/settings_pages.hpp"
#include "firmware/core/controller.hpp"
#include "firmware/core/usb/device.hpp"

namespace {

volatile std::uint32_t reg[80];  // stands for the chip's registers

class RegisterBoard final : public umov::firmware::Board {
 public:
  std::uint64_t time_us() const override { return reg[0]; }
  std::uint64_t link_time_us() const override { return reg[0]; }
  std::size_t link_room() const override { return reg[32]; }
  bool write_link(std::span<const std::uint8_t> frame) override {
    for (const std::uint8_t byte : frame) reg[1] = byte;
    return true;
  }
  void set_direction(int axis, int direction) override {
    reg[2 + axis] = static_cast<std::uint32_t>(direction);
  }
  void start_step_timer(int axis, std::uint32_t ticks) override { reg[8 + axis] = ticks; }
  void stop_step_timer(int axis) override { reg[8 + axis] = 0; }
  void step(int axis) override { reg[14] = 1u << axis; }
  umov::firmware::AxisInputs switches(int axis) const override {
    const std::uint32_t bits = reg[15] >> (3 * axis);
    return {(bits & 1u) != 0, (bits & 2u) != 0, (bits & 4u) != 0};
  }
  void set_laser(int laser, bool on) override { reg[16 + laser] = on; }
  void set_shutter(bool open) override { reg[19] = open; }
  void set_gain(int range) override { reg[20] = static_cast<std::uint32_t>(range); }
  bool emergency_released() const override { return reg[60] != 0; }
  bool overheated() const override { return reg[61] != 0; }
  bool supply_low() const override { return reg[62] != 0; }
  bool stalled(int axis) const override { return (reg[63] >> axis & 1u) != 0; }
  bool interlock_closed() const override { return reg[21] != 0; }
  std::uint32_t start_sampling(std::uint32_t phase_step) override {
    reg[22] = phase_step;
    return reg[70];
  }
  std::uint32_t reference_clock() const override { return reg[70]; }
  void stop_sampling() override { reg[22] = 0; }
  void mask_interrupts() override { reg[23] = 1; }
  void unmask_interrupts() override { reg[23] = 0; }
};

class NoLog final : public umov::firmware::PersistentLog {
 public:
  void append(const umov::firmware::LoggedFault& entry) override { reg[24] = entry.fault; }
  std::uint16_t count() const override { return 0; }
  bool read(std::uint16_t, umov::firmware::LoggedFault&) const override { return false; }
};

class RegisterPages final : public umov::firmware::FlashPages {
 public:
  std::uint32_t words_per_page() const override { return 4096; }
  std::uint32_t read(int, std::uint32_t word) const override { return reg[58] + word; }
  bool program(int page, std::uint32_t word, std::span<const std::uint32_t> words) override {
    reg[59] = static_cast<std::uint32_t>(page) + word;
    for (const std::uint32_t w : words) reg[60] = w;
    return reg[61] == 0;
  }
  bool erase(int page) override {
    reg[62] = static_cast<std::uint32_t>(page);
    return true;
  }
};

class RegisterPort final : public umov::firmware::usb::Port {
 public:
  using Address = umov::firmware::usb::EndpointAddress;
  void connect() override { reg[40] = 1; }
  void disconnect() override { reg[40] = 0; }
  void set_address(std::uint8_t address) override { reg[41] = address; }
  void open_endpoint(Address address, umov::firmware::usb::EndpointType type,
                     std::uint16_t max_packet) override {
    reg[42] = address + max_packet + static_cast<std::uint32_t>(type);
  }
  void close_endpoint(Address address) override { reg[43] = address; }
  void send(Address address, std::span<const std::uint8_t> bytes) override {
    reg[44] = address;
    for (const std::uint8_t byte : bytes) reg[45] = byte;
  }
  void receive(Address address, std::span<std::uint8_t> buffer) override {
    reg[46] = address;
    if (!buffer.empty()) buffer[0] = static_cast<std::uint8_t>(reg[47]);
  }
  void stall(Address address) override { reg[48] = address; }
  void clear_stall(Address address) override { reg[49] = address; }
};

/// As a board wires the USB stack to the controller.
class Wires final : public umov::firmware::usb::Application {
 public:
  explicit Wires(umov::firmware::Controller& controller) : controller_(&controller) {}
  void on_link_bytes(std::span<const std::uint8_t> bytes) override {
    controller_->on_link_bytes(bytes);
  }
  void on_hand_report(const umov::firmware::usb::HandReport& report) override {
    if (report.stop || report.emergency) return controller_->stop_by_hand(report.emergency);
    controller_->jog(report.axis, report.by_udeg);
  }
  umov::firmware::usb::HandState hand_state(std::uint8_t axis) const override {
    const auto view = controller_->hand_view(axis);
    return {static_cast<std::uint8_t>(view.state), static_cast<std::uint8_t>(view.fault),
            view.homed_mask, axis, view.position_udeg};
  }
  bool detach_allowed() const override { return reg[63] != 0; }
  void on_detach() override { reg[50] = 1; }

 private:
  umov::firmware::Controller* controller_;
};

alignas(umov::firmware::usb::Device) unsigned char usb_storage[sizeof(umov::firmware::usb::Device)];
alignas(Wires) unsigned char application_storage[sizeof(Wires)];
RegisterPort usb_port;
alignas(umov::firmware::Controller) unsigned char storage[sizeof(umov::firmware::Controller)];
RegisterBoard board;
NoLog fault_log;
RegisterPages settings_flash;
umov::firmware::SettingsPages settings(settings_flash);

}  // namespace

extern "C" {

void umov_check_entry() {
  settings.begin();
  auto* controller = new (storage)
      umov::firmware::Controller(board, fault_log, {}, umov::firmware::default_axes, &settings);
  controller->start();
  auto* application = new (application_storage) Wires(*controller);
  auto* usb = new (usb_storage) umov::firmware::usb::Device(usb_port, *application, {});
  usb->start();
  for (;;) {
    usb->tick(reg[0]);
    if (reg[51] != 0) usb->on_reset();
    if (reg[52] != 0) usb->on_setup({static_cast<std::uint8_t>(reg[53])});
    if (reg[54] != 0) usb->on_sent(static_cast<std::uint8_t>(reg[54]));
    if (reg[55] != 0) usb->on_received(static_cast<std::uint8_t>(reg[55]), reg[56]);
    const std::uint8_t waiting[1] = {static_cast<std::uint8_t>(reg[57])};
    if (usb->link_room() > 0) usb->write_link(waiting);
    const std::uint8_t byte = static_cast<std::uint8_t>(reg[25]);
    const std::uint16_t codes[2] = {static_cast<std::uint16_t>(reg[26]),
                                    static_cast<std::uint16_t>(reg[27])};
    controller->on_link_bytes({&byte, 1});
    controller->on_samples({codes, 1}, {codes + 1, 1});
    reg[8] = controller->on_step_timer(static_cast<int>(reg[28] % 6));
    if (reg[29] != 0) controller->on_stall(0);
    if (reg[30] != 0) controller->on_adc_overrun();
    if (reg[64] != 0) controller->on_late_step(0);
    if (reg[65] != 0) controller->on_interlock_open();
    if (reg[66] != 0) controller->on_emergency_stop();
    if (reg[67] != 0) controller->on_overheat();
    if (reg[68] != 0) controller->on_low_supply();
    if (reg[71] != 0) controller->on_reference_edge(reg[71]);
    controller->tick();
    reg[69] = controller->send_more();
  }
}

// What a freestanding compiler may call.
void* memcpy(void* to, const void* from, std::size_t size) {
  auto* t = static_cast<unsigned char*>(to);
  const auto* f = static_cast<const unsigned char*>(from);
  for (std::size_t i = 0; i < size; ++i) static_cast<volatile unsigned char*>(t)[i] = f[i];
  return to;
}
void* memset(void* to, int value, std::size_t size) {
  auto* t = static_cast<volatile unsigned char*>(to);
  for (std::size_t i = 0; i < size; ++i) t[i] = static_cast<unsigned char>(value);
  return to;
}
void* memmove(void* to, const void* from, std::size_t size) {
  auto* t = static_cast<volatile unsigned char*>(to);
  const auto* f = static_cast<const volatile unsigned char*>(from);
  if (t < f) {
    for (std::size_t i = 0; i < size; ++i) t[i] = f[i];
  } else {
    for (std::size_t i = size; i > 0; --i) t[i - 1] = f[i - 1];
  }
  return to;
}
[[noreturn]] void __cxa_pure_virtual() {
  for (;;) reg[31] = 1;
}
[[noreturn]] void abort() {
  for (;;) reg[31] = 2;
}
int __aeabi_atexit(void*, void (*)(void*), void*) {
  return 0;
}
void* __dso_handle = nullptr;
int __cxa_atexit(void (*)(void*), void*, void*) {
  return 0;
}
void __aeabi_unwind_cpp_pr0() {}
void __aeabi_unwind_cpp_pr1() {}
}
