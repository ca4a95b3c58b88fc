#include "firmware/boot/boot_device.hpp"

#include <algorithm>

namespace umov::firmware::boot {

using usb::ControlAnswer;
using usb::DescriptorType;
using usb::Recipient;
using usb::RequestKind;

BootDevice::BootDevice(usb::Port& port, Flash& flash, const Trust& trust,
                       const std::array<char, 24>& serial, bool development_key)
    : port_(&port),
      control_(port, *this),
      target_(flash, trust),
      development_key_(development_key) {
  const auto length =
      static_cast<std::size_t>(std::find(serial.begin(), serial.end(), '\0') - serial.begin());
  serial_string_[0] = usb::low_byte(2 + 2 * length);
  serial_string_[1] = static_cast<std::uint8_t>(DescriptorType::string);
  for (std::size_t i = 0; i < length; ++i) {
    serial_string_[2 + 2 * i] = static_cast<std::uint8_t>(serial[i]);
  }
}

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
  const bool to_device = request.recipient == Recipient::device;
  const bool to_interface =
      request.recipient == Recipient::interface && request.index == 0 && configuration_ != 0;
  const bool tells = !request.to_host && request.length == 0;
  const std::span<const std::uint8_t> small(small_);
  switch (request.number) {
    case standard::get_status: {
      constexpr std::uint8_t self_powered = 1;
      const bool endpoint = request.recipient == Recipient::endpoint && request.value == 0 &&
                            (request.index & 0x7Fu) == 0;
      if (!request.to_host || (!to_device && !to_interface && !endpoint)) break;
      small_ = {to_device ? self_powered : std::uint8_t{0}, 0};
      return ControlAnswer::reply(small);
    }
    case standard::set_address:
      if (!tells || !to_device || request.value > 127 || configuration_ != 0) break;
      port_->set_address(request.value_low());
      return ControlAnswer::accept();
    case standard::get_descriptor:
      if (!request.to_host) break;
      return get_descriptor(request);
    case standard::get_configuration:
      if (!request.to_host || !to_device) break;
      small_[0] = configuration_;
      return ControlAnswer::reply(small.first(1));
    case standard::set_configuration:
      if (!tells || !to_device || request.value > 1) break;
      configuration_ = request.value_low();
      setting_ = 0;
      return ControlAnswer::accept();
    case standard::get_interface:
      if (!request.to_host || !to_interface) break;
      small_[0] = setting_;
      return ControlAnswer::reply(small.first(1));
    case standard::set_interface:
      if (!tells || !to_interface || request.value > 1) break;
      setting_ = request.value_low();
      return ControlAnswer::accept();
    default:
      break;
  }
  return ControlAnswer::refuse();
}

ControlAnswer BootDevice::get_descriptor(const usb::Request& request) const {
  const std::uint8_t type = request.value_high();
  if (request.recipient == Recipient::interface && type == usb::dfu_functional_descriptor) {
    return ControlAnswer::reply(dfu_descriptor);
  }
  if (request.recipient != Recipient::device) return ControlAnswer::refuse();
  if (type == static_cast<std::uint8_t>(DescriptorType::string)) {
    return get_string(request.value_low());
  }
  if (request.value_low() != 0) return ControlAnswer::refuse();
  switch (static_cast<DescriptorType>(type)) {
    case DescriptorType::device:
      return ControlAnswer::reply(device_descriptor);
    case DescriptorType::configuration:
      return ControlAnswer::reply(configuration);
    case DescriptorType::bos:
      return ControlAnswer::reply(bos_descriptor);
    default:
      return ControlAnswer::refuse();
  }
}

ControlAnswer BootDevice::get_string(std::uint8_t index) const {
  switch (index) {
    case 0:
      return ControlAnswer::reply(language_ids);
    case string_index::manufacturer:
      return ControlAnswer::reply(manufacturer_text);
    case string_index::product:
      return development_key_ ? ControlAnswer::reply(development_text)
                              : ControlAnswer::reply(product_text);
    case string_index::serial:
      return ControlAnswer::reply(
          std::span<const std::uint8_t>(serial_string_).first(serial_string_[0]));
    case string_index::newer:
      return ControlAnswer::reply(newer_text);
    case string_index::older_too:
      return ControlAnswer::reply(older_too_text);
    case string_index::no_image:
      return ControlAnswer::reply(no_image_text);
    case string_index::wrong_board:
      return ControlAnswer::reply(wrong_board_text);
    case string_index::older:
      return ControlAnswer::reply(older_text);
    case string_index::damaged:
      return ControlAnswer::reply(damaged_text);
    case string_index::bad_signature:
      return ControlAnswer::reply(bad_signature_text);
    case string_index::flash_failed:
      return ControlAnswer::reply(flash_failed_text);
    default:
      return ControlAnswer::refuse();
  }
}

bool BootDevice::on_data(const usb::Request&, std::span<const std::uint8_t> data) {
  return target_.on_data(data);  // DFU_DNLOAD is the one request with data
}

void BootDevice::on_complete(const usb::Request& request) {
  if (request.kind == RequestKind::class_specific) target_.on_complete(request);
}

}  // namespace umov::firmware::boot
