#include "firmware/boot/boot_device.hpp"

namespace umov::firmware::boot {

using usb::ControlAnswer;
using usb::Recipient;
using usb::RequestKind;

BootDevice::BootDevice(usb::Port& port, Flash& flash, const Trust& trust,
                       const std::array<char, 24>& serial, bool development_key, Reason why)
    : port_(&port),
      control_(port, *this),
      target_(flash, trust, why),
      serial_(serial),
      descriptors_(development_key ? &development_table : &descriptor_table) {}

void BootDevice::on_reset() {
  // A host resets a device that it meets; one that was in use it sends back to its program
  // (DFU 1.1, 7). An image half received is dropped: what runs is untouched.
  if (configuration_ != 0) reset_ = true;
  control_.reset();
  configuration_ = setting_ = 0;
}

void BootDevice::on_sent(usb::EndpointAddress address) {
  if (address == usb::control_in) control_.on_sent();
}

void BootDevice::on_received(usb::EndpointAddress address, std::size_t size) {
  if (address == usb::control_out) control_.on_received(size);
}

ControlAnswer BootDevice::on_request(const usb::Request& request) {
  switch (request.kind) {
    case RequestKind::standard:
      return on_standard(request);
    case RequestKind::class_specific:
      if (request.recipient != Recipient::interface || request.index != 0 || configuration_ == 0) {
        return ControlAnswer::refuse();
      }
      return target_.on_request(request, setting_ == dfu::setting_older_too);
    case RequestKind::vendor:
      if (request.recipient == Recipient::device && request.to_host &&
          request.number == usb::ms_os_20::vendor_code &&
          request.index == usb::ms_os_20::descriptor_index) {
        return ControlAnswer::reply(windows_descriptors);
      }
      break;
    case RequestKind::reserved:
      break;
  }
  return ControlAnswer::refuse();
}

ControlAnswer BootDevice::on_standard(const usb::Request& request) {
  namespace standard = usb::standard;
  if (!usb::proper(request, usb::asks_standard(request.number))) return ControlAnswer::refuse();
  const bool to_device = request.recipient == Recipient::device;
  const bool to_interface =
      request.recipient == Recipient::interface && request.index == 0 && configuration_ != 0;
  const std::span<const std::uint8_t> small(small_);
  switch (request.number) {
    case standard::get_status: {
      constexpr std::uint8_t self_powered = 1;
      const bool endpoint = request.recipient == Recipient::endpoint && request.value == 0 &&
                            (request.index & 0x7Fu) == 0;
      if (!to_device && !to_interface && !endpoint) break;
      small_ = {to_device ? self_powered : std::uint8_t{0}, 0};
      return ControlAnswer::reply(small);
    }
    case standard::set_address:
      if (!to_device || request.value > 127 || configuration_ != 0) break;
      port_->set_address(request.value_low());
      return ControlAnswer::accept();
    case standard::get_descriptor:
      return get_descriptor(request);
    case standard::get_configuration:
      if (!to_device) break;
      small_[0] = configuration_;
      return ControlAnswer::reply(small.first(1));
    case standard::set_configuration:
      if (!to_device || request.value > 1) break;
      configuration_ = request.value_low();
      setting_ = 0;
      return ControlAnswer::accept();
    case standard::get_interface:
      if (!to_interface) break;
      small_[0] = setting_;
      return ControlAnswer::reply(small.first(1));
    case standard::set_interface:
      if (!to_interface || request.value > 1) break;
      setting_ = request.value_low();
      return ControlAnswer::accept();
    default:
      break;
  }
  return ControlAnswer::refuse();
}

ControlAnswer BootDevice::get_descriptor(const usb::Request& request) const {
  if (request.recipient == Recipient::interface &&
      request.value_high() == usb::dfu_functional_descriptor) {
    return ControlAnswer::reply(dfu_descriptor);
  }
  return usb::describe(*descriptors_, serial_, request);
}

bool BootDevice::on_data(const usb::Request&, std::span<const std::uint8_t> data) {
  return target_.on_data(data);  // DFU_DNLOAD is the one request with data
}

void BootDevice::on_complete(const usb::Request& request) {
  if (request.kind == RequestKind::class_specific) target_.on_complete(request);
}

}  // namespace umov::firmware::boot
