#include "firmware/core/usb/device.hpp"

namespace umov::firmware::usb {

Device::Device(Port& port, Application& application, const std::array<char, 24>& serial,
               SerialLine* line)
    : port_(&port),
      application_(&application),
      control_(port, *this),
      links_(port, application, line),
      serial_(serial) {}

void Device::on_reset() {
  control_.reset();
  links_.forget();
  configuration_ = 0;
  halted_ = 0;
  detaching_ = false;
  hand_sending_ = false;
}

void Device::set_configuration(std::uint8_t value) {
  if (configuration_ != 0) {
    links_.stop();
    port_->close_endpoint(hand_in);
  }
  configuration_ = value;
  halted_ = 0;
  hand_sending_ = false;
  hand_told_ = false;
  if (value == 0) return;
  links_.start();
  port_->open_endpoint(hand_in, EndpointType::interrupt, hand_report_bytes);
}

void Device::tick(std::uint64_t now_us) {
  links_.tick(now_us);
  send_hand_state();
}

void Device::send_hand_state() {
  if (configuration_ == 0 || hand_sending_ || (halted_ & (1u << (8 + endpoint_number(hand_in))))) {
    return;
  }
  const HandState state = application_->hand_state(hand_axis_);
  if (hand_told_ && state == hand_state_) return;
  hand_state_ = state;
  hand_told_ = true;
  hand_sending_ = true;
  hand_bytes_ = hand_state_bytes(state);
  port_->send(hand_in, hand_bytes_);
}

void Device::on_sent(EndpointAddress address) {
  if (address == control_in) {
    control_.on_sent();
  } else if (address == hand_in) {
    hand_sending_ = false;
  } else {
    links_.on_sent(address);
  }
}

void Device::on_received(EndpointAddress address, std::size_t size) {
  if (address == control_out) {
    control_.on_received(size);
  } else {
    links_.on_received(address, size);
  }
}

}  // namespace umov::firmware::usb
