#include "hil/usbip/mcp2221.hpp"

#include <algorithm>

#include "firmware/core/usb/chapter9.hpp"
#include "firmware/core/usb/descriptor_builder.hpp"

namespace umov::usbip {
namespace {

namespace fu = firmware::usb;
using fu::ControlAnswer;

constexpr std::uint16_t vendor_id = 0x04d8;
constexpr std::uint16_t product_id = 0x00dd;
constexpr fu::EndpointAddress reports_in = 0x83;
constexpr fu::EndpointAddress reports_out = 0x03;

/// First byte of a command and of its answer.
constexpr std::uint8_t command_status = 0x10;
constexpr std::uint8_t command_set_gpio = 0x50;
constexpr std::uint8_t command_get_gpio = 0x51;
/// Second byte of the answer.
constexpr std::uint8_t done = 0;
constexpr std::uint8_t not_supported = 1;

constexpr fu::Bytes<18> device_descriptor = {18,
                                             1,
                                             0x00,
                                             0x02,
                                             0,
                                             0,
                                             0,
                                             packet_bytes,
                                             fu::low_byte(vendor_id),
                                             fu::high_byte(vendor_id),
                                             fu::low_byte(product_id),
                                             fu::high_byte(product_id),
                                             0x00,
                                             0x01,
                                             1,
                                             2,
                                             3,
                                             1};
constexpr auto manufacturer = fu::string_descriptor("Microchip Technology Inc. (emulated)");
constexpr auto product = fu::string_descriptor("MCP2221 USB-I2C/UART Combo");
constexpr auto serial = fu::string_descriptor("0000000001");
constexpr fu::Bytes<4> languages = {4, 3, 0x09, 0x04};
constexpr fu::Bytes<28> report_descriptor = {
    0x06, 0x00, 0xff,  // usage page (vendor-defined)
    0x09, 0x01,        // usage (1)
    0xa1, 0x01,        // collection (application)
    0x09, 0x02,        //   usage (2)
    0x15, 0x00,        //   logical minimum (0)
    0x26, 0xff, 0x00,  //   logical maximum (255)
    0x75, 0x08,        //   report size (8)
    0x95, 0x40,        //   report count (64)
    0x81, 0x02,        //   input (data, variable, absolute)
    0x09, 0x03,        //   usage (3)
    0x95, 0x40,        //   report count (64)
    0x91, 0x02,        //   output (data, variable, absolute)
    0xc0,              // end collection
};
constexpr fu::Bytes<9> hid = fu::hid_descriptor(report_descriptor.size());
constexpr auto configuration = fu::configuration_descriptor(
    fu::join(fu::interface_descriptor(0, 2, {0x03, 0, 0}, 0), hid,
             fu::endpoint_descriptor(reports_in, fu::EndpointType::interrupt, packet_bytes, 1),
             fu::endpoint_descriptor(reports_out, fu::EndpointType::interrupt, packet_bytes, 1)),
    0, 100);
static_assert(fu::well_formed_configuration(configuration, 3));

/// What the driver's probe asks for and does not want answered.
constexpr int probe_status_requests = 2;
constexpr int probe_level_requests = 4;

ControlAnswer descriptor(const fu::Request& request) {
  if (request.recipient == fu::Recipient::interface) {
    if (request.value_high() == static_cast<std::uint8_t>(fu::DescriptorType::hid_report)) {
      return ControlAnswer::reply(report_descriptor);
    }
    return request.value_high() == static_cast<std::uint8_t>(fu::DescriptorType::hid)
               ? ControlAnswer::reply(hid)
               : ControlAnswer::refuse();
  }
  switch (static_cast<fu::DescriptorType>(request.value_high())) {
    case fu::DescriptorType::device:
      return ControlAnswer::reply(device_descriptor);
    case fu::DescriptorType::configuration:
      return ControlAnswer::reply(configuration);
    case fu::DescriptorType::string:
      switch (request.value_low()) {
        case 0:
          return ControlAnswer::reply(languages);
        case 1:
          return ControlAnswer::reply(manufacturer);
        case 2:
          return ControlAnswer::reply(product);
        case 3:
          return ControlAnswer::reply(serial);
        default:
          return ControlAnswer::refuse();
      }
    default:
      return ControlAnswer::refuse();
  }
}

}  // namespace

Mcp2221::Mcp2221(GpioLines& lines) : lines_(&lines), control_(port_, *this) {
  port_.bind(*this);
  port_.connect();
}

void Mcp2221::bus_reset() {
  // Plugged in anew it has had no power: all pins are inputs.
  status_requests_ = 0;
  level_requests_ = 0;
  for (int pin = 0; pin < pin_count; ++pin) {
    pins_[static_cast<std::size_t>(pin)] = {};
    lines_->drive(pin, std::nullopt);
  }
  port_.bus_reset();
}

Handshake Mcp2221::out(std::uint8_t endpoint, std::span<const std::uint8_t> bytes) {
  if (endpoint != 0 && probing(bytes)) return Handshake::stall;
  return port_.out(endpoint, bytes);
}

bool Mcp2221::probing(std::span<const std::uint8_t> command) {
  if (command.empty()) return false;
  if (command[0] == command_status && status_requests_ < probe_status_requests) {
    ++status_requests_;
    return true;
  }
  if (command[0] == command_get_gpio && level_requests_ < probe_level_requests) {
    ++level_requests_;
    return true;
  }
  return false;
}

void Mcp2221::on_reset() {
  control_.reset();
  configuration_ = {};
}

void Mcp2221::open() {
  port_.open_endpoint(reports_in, fu::EndpointType::interrupt, packet_bytes);
  port_.open_endpoint(reports_out, fu::EndpointType::interrupt, packet_bytes);
  port_.receive(reports_out, received_);
}

void Mcp2221::on_sent(fu::EndpointAddress address) {
  if (address == fu::control_in) return control_.on_sent();
  port_.receive(reports_out, received_);
}

void Mcp2221::on_received(fu::EndpointAddress address, std::size_t size) {
  if (address == fu::control_out) return control_.on_received(size);
  carry_out(std::span<const std::uint8_t>(received_).first(size));
}

ControlAnswer Mcp2221::on_request(const fu::Request& request) {
  constexpr std::uint8_t set_idle = fu::hid::set_idle;
  if (request.kind == fu::RequestKind::class_specific) {
    return request.number == set_idle ? ControlAnswer::accept() : ControlAnswer::refuse();
  }
  if (request.kind != fu::RequestKind::standard) return ControlAnswer::refuse();
  switch (request.number) {
    case fu::standard::get_descriptor:
      return descriptor(request);
    case fu::standard::set_address:
      port_.set_address(request.value_low());
      return ControlAnswer::accept();
    case fu::standard::set_configuration:
      if (request.value > 1) break;
      configuration_[0] = request.value_low();
      if (request.value == 1) open();
      return ControlAnswer::accept();
    case fu::standard::get_configuration:
      return ControlAnswer::reply(configuration_);
    case fu::standard::clear_feature:
      if (request.recipient != fu::Recipient::endpoint || configuration_[0] == 0) break;
      open();
      return ControlAnswer::accept();
    default:
      break;
  }
  return ControlAnswer::refuse();
}

void Mcp2221::carry_out(std::span<const std::uint8_t> command) {
  // Commands come as long as they need to be; the rest is zero.
  Report whole{};
  std::copy(command.begin(), command.end(), whole.begin());
  answer_ = {};
  answer_[0] = whole[0];
  answer_[1] = done;
  switch (whole[0]) {
    case command_status:
      // Nothing is under way on I²C; a new speed is always taken.
      if (whole[3] == 0x20) answer_[3] = 0x20;
      break;
    case command_set_gpio:
      set_pins(whole);
      answer_ = whole;
      answer_[1] = done;
      break;
    case command_get_gpio:
      get_pins(answer_);
      break;
    default:
      answer_[1] = not_supported;
  }
  port_.send(reports_in, answer_);
}

void Mcp2221::set_pins(std::span<const std::uint8_t> command) {
  for (std::size_t i = 0; i < pin_count; ++i) {
    // For each pin: change the level? level, change the direction? direction (1 is input).
    const auto fields = command.subspan(2 + 4 * i, 4);
    Pin& pin = pins_[i];
    if (fields[0] != 0) pin.level = fields[1] != 0;
    if (fields[2] != 0) pin.output = fields[3] == 0;
    if (fields[0] != 0 || fields[2] != 0) {
      lines_->drive(static_cast<int>(i),
                    pin.output ? std::optional<bool>(pin.level) : std::nullopt);
    }
  }
}

void Mcp2221::get_pins(Report& answer) const {
  for (std::size_t i = 0; i < pin_count; ++i) {
    const bool level = pins_[i].output ? pins_[i].level : lines_->level(static_cast<int>(i));
    answer[2 + 2 * i] = level ? 1 : 0;
    answer[3 + 2 * i] = level ? 1 : 0;  // the direction on the chip; see the header
  }
}

}  // namespace umov::usbip
