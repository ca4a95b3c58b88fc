// What the USB stack asks of this board: the controller behind it.
#pragma once

#include "boards/stm32f407/boot_request.hpp"
#include "firmware/core/controller.hpp"
#include "firmware/core/usb/application.hpp"

namespace umov::boards::stm32f407 {

class UsbApplication final : public firmware::usb::Application {
 public:
  void bind(firmware::Controller& controller) { controller_ = &controller; }

  void on_link_bytes(std::span<const std::uint8_t> bytes) override {
    controller_->on_link_bytes(bytes);
  }
  void on_hand_report(const firmware::usb::HandReport& report) override {
    if (report.emergency || report.stop) {
      controller_->stop_by_hand(report.emergency);
    } else {
      controller_->jog(report.axis, report.by_udeg);
    }
  }
  firmware::usb::HandState hand_state(std::uint8_t axis) const override {
    const firmware::HandView view = controller_->hand_view(axis);
    return {.state = static_cast<std::uint8_t>(view.state),
            .fault = static_cast<std::uint8_t>(view.fault),
            .homed_mask = view.homed_mask,
            .axis = axis,
            .position_udeg = view.position_udeg};
  }
  bool detach_allowed() const override {
    return has_boot_loader() && !controller_->sequencer().active() && !controller_->motion().busy();
  }
  void on_detach() override { detached_ = true; }
  /// The host has been told that the program ends.
  bool detached() const { return detached_; }

 private:
  bool detached_ = false;
  firmware::Controller* controller_ = nullptr;
};

}  // namespace umov::boards::stm32f407
