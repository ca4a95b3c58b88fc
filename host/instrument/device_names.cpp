#include "host/instrument/device_names.hpp"

#include <charconv>

#include "host/errors/error.hpp"

namespace umov::instrument {
namespace {

constexpr std::string_view available =
    "available are: emulator, usb[:SERIAL], hid[:SERIAL], serial:PATH[?baud=N], tcp:HOST:PORT";

std::string quoted(std::string_view text) {
  return "'" + std::string(text) + "'";
}

[[noreturn]] void refuse_address(std::string_view text, const std::string& why) {
  throw Error("device " + quoted(text) + ": " + why,
              "write tcp:HOST:PORT, such as tcp:localhost:5025");
}

DeviceName parse_tcp(std::string_view text) {
  std::string_view address = text.substr(4);
  const std::size_t colon = address.rfind(':');
  if (colon == std::string_view::npos) refuse_address(text, "the port is missing");
  std::string_view host = address.substr(0, colon);
  const std::string_view port = address.substr(colon + 1);
  if (host.size() >= 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string_view::npos) {
    refuse_address(text, "an IPv6 address needs brackets");
  }
  if (host.empty()) refuse_address(text, "the host is missing");
  DeviceName name{DeviceKind::tcp, std::string(host), 0, {}, std::string(text)};
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), name.port);
  if (error != std::errc{} || end != port.data() + port.size() || name.port == 0) {
    refuse_address(text, "the port " + quoted(port) + " is not a number from 1 to 65535");
  }
  return name;
}

DeviceName parse_usb(std::string_view text, DeviceKind kind) {
  DeviceName name{kind, {}, 0, {}, std::string(text)};
  if (text.size() > 3) name.serial = text.substr(4);
  if (text.size() == 4) {
    throw Error("device " + quoted(text) + ": the serial number is missing",
                "leave the colon out, or see umov device list");
  }
  return name;
}

DeviceName parse_serial(std::string_view text) {
  const auto refuse = [&](const std::string& why) {
    throw Error("device " + quoted(text) + ": " + why,
                "write serial:PATH or serial:PATH?baud=N, such as serial:/dev/ttyUSB0");
  };
  DeviceName name{DeviceKind::serial, {}, 0, {}, std::string(text)};
  std::string_view path = text.substr(std::string_view("serial").size());
  if (path.starts_with(':')) path.remove_prefix(1);
  if (const std::size_t mark = path.find('?'); mark != std::string_view::npos) {
    constexpr std::string_view key = "baud=";
    std::string_view option = path.substr(mark + 1);
    path = path.substr(0, mark);
    if (!option.starts_with(key)) refuse("it has no option " + quoted(option));
    option.remove_prefix(key.size());
    const auto [end, error] =
        std::from_chars(option.data(), option.data() + option.size(), name.baud);
    if (error != std::errc{} || end != option.data() + option.size() || name.baud == 0) {
      refuse(quoted(option) + " is no speed");
    }
  }
  if (path.empty()) refuse("the path is missing");
  name.path = path;
  return name;
}

/// `usb` and `usb:SERIAL`, but not `usbx`.
bool is_kind(std::string_view text, std::string_view kind) {
  return text.starts_with(kind) && (text.size() == kind.size() || text[kind.size()] == ':');
}

}  // namespace

DeviceName parse_device_name(std::string_view text) {
  if (text == "emulator") return {DeviceKind::emulator, {}, 0, {}, std::string(text)};
  if (is_kind(text, "tcp")) {
    if (text == "tcp") refuse_address(text, "host and port are missing");
    return parse_tcp(text);
  }
  if (is_kind(text, "usb")) return parse_usb(text, DeviceKind::usb);
  if (is_kind(text, "hid")) return parse_usb(text, DeviceKind::hid);
  if (is_kind(text, "serial")) return parse_serial(text);
  throw Error("unknown device " + quoted(text), std::string(available));
}

}  // namespace umov::instrument
