#include "firmware/core/usb/standard_requests.hpp"

#include <algorithm>

namespace umov::firmware::usb {

SerialString::SerialString(const std::array<char, 24>& text) {
  const auto length =
      static_cast<std::size_t>(std::find(text.begin(), text.end(), '\0') - text.begin());
  bytes_[0] = static_cast<std::uint8_t>(2 + 2 * length);
  bytes_[1] = static_cast<std::uint8_t>(DescriptorType::string);
  for (std::size_t i = 0; i < length; ++i) {
    bytes_[2 + 2 * i] = static_cast<std::uint8_t>(text[i]);
  }
}

ControlAnswer describe(const DescriptorTable& table, const SerialString& serial,
                       const Request& request) {
  if (request.recipient != Recipient::device) return ControlAnswer::refuse();
  const std::uint8_t index = request.value_low();
  std::span<const std::uint8_t> found;
  switch (static_cast<DescriptorType>(request.value_high())) {
    case DescriptorType::device:
      if (index == 0) found = table.device;
      break;
    case DescriptorType::configuration:
      if (index == 0) found = table.configuration;
      break;
    case DescriptorType::bos:
      if (index == 0) found = table.bos;
      break;
    case DescriptorType::string:
      if (index == serial_index) {
        found = serial.bytes();
      } else if (index < table.strings.size()) {
        found = table.strings[index];
      }
      break;
    default:
      break;  // device_qualifier: full speed is all there is
  }
  return found.empty() ? ControlAnswer::refuse() : ControlAnswer::reply(found);
}

}  // namespace umov::firmware::usb
