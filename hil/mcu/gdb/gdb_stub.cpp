#include "hil/mcu/gdb/gdb_stub.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <utility>
#include <vector>

#include "host/errors/error.hpp"

namespace umov::mcu {
namespace {

constexpr int register_count = 17;
constexpr std::uint32_t longest_read = 4096;
constexpr char interrupt_byte = 0x03;

/// Order and names of the registers; GDB takes an M-profile core from it.
constexpr std::string_view target_xml =
    "<?xml version=\"1.0\"?><!DOCTYPE target SYSTEM \"gdb-target.dtd\"><target>"
    "<architecture>arm</architecture><feature name=\"org.gnu.gdb.arm.m-profile\">"
    "<reg name=\"r0\" bitsize=\"32\"/><reg name=\"r1\" bitsize=\"32\"/>"
    "<reg name=\"r2\" bitsize=\"32\"/><reg name=\"r3\" bitsize=\"32\"/>"
    "<reg name=\"r4\" bitsize=\"32\"/><reg name=\"r5\" bitsize=\"32\"/>"
    "<reg name=\"r6\" bitsize=\"32\"/><reg name=\"r7\" bitsize=\"32\"/>"
    "<reg name=\"r8\" bitsize=\"32\"/><reg name=\"r9\" bitsize=\"32\"/>"
    "<reg name=\"r10\" bitsize=\"32\"/><reg name=\"r11\" bitsize=\"32\"/>"
    "<reg name=\"r12\" bitsize=\"32\"/><reg name=\"sp\" bitsize=\"32\" type=\"data_ptr\"/>"
    "<reg name=\"lr\" bitsize=\"32\"/><reg name=\"pc\" bitsize=\"32\" type=\"code_ptr\"/>"
    "<reg name=\"xpsr\" bitsize=\"32\"/></feature></target>";

constexpr std::string_view digits = "0123456789abcdef";

void append_byte(std::string& out, std::uint8_t byte) {
  out += digits[byte >> 4];
  out += digits[byte & 15u];
}

/// Registers travel in the target's byte order.
void append_word(std::string& out, std::uint32_t word) {
  for (unsigned i = 0; i < 4; ++i) append_byte(out, static_cast<std::uint8_t>(word >> 8 * i));
}

std::optional<std::uint32_t> number(std::string_view text) {
  std::uint32_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, 16);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<std::vector<std::uint8_t>> bytes_of(std::string_view text) {
  if (text.size() % 2 != 0) return std::nullopt;
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i < text.size(); i += 2) {
    const auto byte = number(text.substr(i, 2));
    if (!byte) return std::nullopt;
    bytes.push_back(static_cast<std::uint8_t>(*byte));
  }
  return bytes;
}

std::uint8_t checksum(std::string_view text) {
  unsigned sum = 0;
  for (const char c : text) sum += static_cast<unsigned char>(c);
  return static_cast<std::uint8_t>(sum);
}

/// "left<separator>right"; empty right where there is no separator.
std::pair<std::string_view, std::string_view> split(std::string_view text, char separator) {
  const std::size_t at = text.find(separator);
  if (at == std::string_view::npos) return {text, {}};
  return {text.substr(0, at), text.substr(at + 1)};
}

void send(std::string& output, std::string_view packet) {
  output += '$';
  output += packet;
  output += '#';
  append_byte(output, checksum(packet));
}

constexpr std::string_view stopped_trap = "S05", stopped_interrupt = "S02", bad = "E01";

}  // namespace

void GdbStub::connected() {
  input_.clear();
  chip_->halt();
  running_ = false;
}

void GdbStub::disconnected() {
  chip_->clear_breakpoints();
  go_on();
}

void GdbStub::go_on() {
  running_ = true;
  chip_->go_on();
}

void GdbStub::look_at_chip(std::string& output) {
  if (!running_ || !chip_->halted()) return;
  running_ = false;
  send(output, stopped_trap);
}

void GdbStub::take(std::string_view bytes, std::string& output) {
  input_ += bytes;
  while (!input_.empty()) {
    if (input_.front() == interrupt_byte) {
      input_.erase(0, 1);
      if (!running_) continue;
      chip_->halt();
      running_ = false;
      send(output, stopped_interrupt);
      continue;
    }
    if (input_.front() != '$') {  // acknowledgements
      input_.erase(0, 1);
      continue;
    }
    const std::size_t end = input_.find('#');
    if (end == std::string::npos || input_.size() < end + 3) return;
    const std::string packet = input_.substr(1, end - 1);
    const auto sum = number(std::string_view(input_).substr(end + 1, 2));
    input_.erase(0, end + 3);
    if (!sum || *sum != checksum(packet)) {
      output += '-';
      continue;
    }
    output += '+';
    try {
      const std::string reply = answer(packet);
      if (!running_ || !reply.empty()) send(output, reply);
    } catch (const Error&) {  // the program did something on a step that stops it for good
      send(output, "S0b");
    }
  }
}

/// An empty answer says that a packet is not known; a program that goes on answers when it stops.
std::string GdbStub::answer(std::string_view packet) {
  if (packet.empty()) return {};
  const std::string_view arguments = packet.substr(1);
  switch (packet.front()) {
    case '?':
      return std::string(stopped_trap);
    case 'g':
      return registers();
    case 'p':
      return read_register(arguments);
    case 'P':
      return write_register(arguments);
    case 'm':
      return read_memory(arguments);
    case 'M':
      return write_memory(arguments);
    case 'c':
      go_on();
      return {};
    case 's':
      chip_->step();
      return std::string(stopped_trap);
    case 'Z':
    case 'z':
      return change_breakpoint(packet);
    case 'H':
      return "OK";
    case 'D':
      disconnected();
      return "OK";
    case 'k':
      disconnected();
      return {};
    default:
      break;
  }
  if (packet.starts_with("qSupported")) return "PacketSize=2100;qXfer:features:read+";
  if (packet.starts_with("qXfer:features:read:target.xml:")) {
    return features(packet.substr(packet.rfind(':') + 1));
  }
  if (packet == "qAttached") return "1";
  if (packet == "qC") return "QC1";
  if (packet == "qfThreadInfo") return "m1";
  if (packet == "qsThreadInfo") return "l";
  return {};
}

std::string GdbStub::registers() const {
  std::string out;
  for (int i = 0; i < register_count; ++i) append_word(out, chip_->debug_register(i));
  return out;
}

std::string GdbStub::read_register(std::string_view arguments) const {
  const auto which = number(arguments);
  if (!which || *which >= register_count) return std::string(bad);
  std::string out;
  append_word(out, chip_->debug_register(static_cast<int>(*which)));
  return out;
}

std::string GdbStub::write_register(std::string_view arguments) {
  const auto [name, text] = split(arguments, '=');
  const auto which = number(name);
  const auto bytes = bytes_of(text);
  if (!which || *which >= register_count || !bytes || bytes->size() != 4) return std::string(bad);
  std::uint32_t value = 0;
  for (unsigned i = 0; i < 4; ++i) value |= std::uint32_t{(*bytes)[i]} << 8 * i;
  chip_->set_debug_register(static_cast<int>(*which), value);
  return "OK";
}

std::string GdbStub::read_memory(std::string_view arguments) const {
  const auto [place, length] = split(arguments, ',');
  const auto address = number(place), size = number(length);
  if (!address || !size || *size > longest_read) return std::string(bad);
  const auto bytes = chip_->read_memory(*address, *size);
  if (bytes.size() != *size) return std::string(bad);
  std::string out;
  for (const std::uint8_t byte : bytes) append_byte(out, byte);
  return out;
}

std::string GdbStub::write_memory(std::string_view arguments) {
  const auto [head, text] = split(arguments, ':');
  const auto [place, length] = split(head, ',');
  const auto address = number(place), size = number(length);
  const auto bytes = bytes_of(text);
  if (!address || !size || !bytes || bytes->size() != *size) return std::string(bad);
  return chip_->write_memory(*address, *bytes) ? "OK" : std::string(bad);
}

std::string GdbStub::change_breakpoint(std::string_view packet) {
  // Z0 and Z1, software or hardware: here the same. Others (watchpoints) are not known.
  if (packet.size() < 3 || (packet[1] != '0' && packet[1] != '1') || packet[2] != ',') return {};
  const auto address = number(split(packet.substr(3), ',').first);
  if (!address) return std::string(bad);
  chip_->set_breakpoint(*address, packet.front() == 'Z');
  return "OK";
}

std::string GdbStub::features(std::string_view arguments) const {
  const auto [from, length] = split(arguments, ',');
  const auto offset = number(from), size = number(length);
  if (!offset || !size) return std::string(bad);
  if (*offset >= target_xml.size()) return "l";
  const auto part = target_xml.substr(*offset, *size);
  return (*offset + part.size() < target_xml.size() ? "m" : "l") + std::string(part);
}

}  // namespace umov::mcu
