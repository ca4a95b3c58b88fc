#include "hil/usbip/exported_device.hpp"

#include <utility>

#include "hil/usbip/bus.hpp"
#include "hil/usbip/wire.hpp"
#include "host/errors/error.hpp"

namespace umov::usbip {
namespace {

constexpr std::uint8_t get_descriptor = 6;
constexpr std::uint8_t device_type = 1;
constexpr std::uint8_t configuration_type = 2;
constexpr std::uint8_t interface_type = 4;

std::vector<std::uint8_t> descriptor(UsbFunction& function, std::uint8_t type, std::size_t size) {
  std::vector<std::uint8_t> answer;
  Bus bus(function, [&](const Urb& urb, std::int32_t status, std::size_t) {
    if (status == urb_status::ok) answer = urb.bytes;
  });
  Urb urb;
  urb.to_host = true;
  urb.length = size;
  urb.setup = {0x80,
               get_descriptor,
               0,
               type,
               0,
               0,
               static_cast<std::uint8_t>(size & 0xffu),
               static_cast<std::uint8_t>(size >> 8)};
  bus.submit(std::move(urb));
  bus.run();
  return answer;
}

/// Calls `f` with class, subclass and protocol of each interface.
template <class F>
void for_each_interface(const ExportedDevice& device, F&& f) {
  const auto& bytes = device.configuration;
  for (std::size_t at = 0; at + 1 < bytes.size() && bytes[at] != 0; at += bytes[at]) {
    if (bytes[at + 1] == interface_type && at + 7 < bytes.size()) {
      f(bytes[at + 5], bytes[at + 6], bytes[at + 7]);
    }
  }
}

}  // namespace

ExportedDevice export_device(std::string bus_id, std::uint32_t number, UsbFunction& function) {
  function.bus_reset();
  ExportedDevice device{std::move(bus_id), &function, {}, {}, number};
  device.device_descriptor = descriptor(function, device_type, 18);
  device.configuration = descriptor(function, configuration_type, 1024);
  if (device.device_descriptor.size() != 18 || device.configuration.size() < 9) {
    throw Error("the emulated USB device " + device.bus_id + " does not answer",
                "this is a fault of the program; please report it");
  }
  return device;
}

void write_description(std::vector<std::uint8_t>& out, const ExportedDevice& device) {
  const auto& d = device.device_descriptor;
  const auto u16 = [&](std::size_t at) {
    return static_cast<std::uint16_t>(d[at] | (d[at + 1] << 8));
  };
  wire::Writer(out)
      .text("/sys/devices/umov/" + device.bus_id, 256)
      .text(device.bus_id, wire::bus_id_bytes)
      .u32(1)
      .u32(device.number)
      .u32(wire::full_speed)
      .u16(u16(8))
      .u16(u16(10))
      .u16(u16(12))
      .u8(d[4])
      .u8(d[5])
      .u8(d[6])
      .u8(device.configuration[5])
      .u8(d[17])
      .u8(device.configuration[4]);
}

void write_interfaces(std::vector<std::uint8_t>& out, const ExportedDevice& device) {
  for_each_interface(device, [&](std::uint8_t code, std::uint8_t subclass, std::uint8_t protocol) {
    wire::Writer(out).u8(code).u8(subclass).u8(protocol).u8(0);
  });
}

}  // namespace umov::usbip
