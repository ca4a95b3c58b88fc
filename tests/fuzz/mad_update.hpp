// A host gone mad at the boot loader: pieces of proper updates in any order, between any other
// transactions. Its image has a good header and CRC and a signature that nobody made: whatever
// happens, the program that runs stays as it is.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "firmware/boot/boot_device.hpp"
#include "hil/usbip/stack_port.hpp"
#include "protocol/dfu.hpp"
#include "tests/fuzz/foreign_bytes.hpp"

namespace umov::fuzz {

class SmallFlash final : public firmware::boot::Flash {
 public:
  static constexpr std::size_t place_bytes = 8192;
  SmallFlash() {
    for (auto& place : places) place.assign(place_bytes, 0xFF);
    std::fill_n(places[0].begin(), 100, std::uint8_t{0x11});
  }
  std::span<const std::uint8_t> contents(firmware::boot::Place place) const override {
    return places[static_cast<std::size_t>(place)];
  }
  bool erase(firmware::boot::Place place) override {
    auto& bytes = places[static_cast<std::size_t>(place)];
    std::fill(bytes.begin(), bytes.end(), std::uint8_t{0xFF});
    return true;
  }
  bool program(firmware::boot::Place place, std::uint32_t offset,
               std::span<const std::uint8_t> bytes) override {
    require(offset % 4 == 0 && bytes.size() % 4 == 0 && offset + bytes.size() <= place_bytes);
    for (const std::uint8_t byte : bytes) {
      auto& cell = places[static_cast<std::size_t>(place)][offset++];
      cell = static_cast<std::uint8_t>(cell & byte);
    }
    return true;
  }
  std::array<std::vector<std::uint8_t>, 3> places;
};

inline std::vector<std::uint8_t> unsigned_image() {
  std::vector<std::uint8_t> image(protocol::ImageHeader::bytes + 2048, 0x42);
  protocol::ImageHeader header;
  header.program_bytes = 2048;
  header.board = {'b', 'o', 'a', 'r', 'd'};
  header.program_crc =
      protocol::crc32c(std::span<const std::uint8_t>(image).subspan(protocol::ImageHeader::bytes));
  protocol::write_image_header(header, image);
  return image;
}

/// `Input` gives bytes by take() and take(size).
template <class Input>
void update_madly(Input& input) {
  namespace dfu = protocol::dfu;
  using usbip::Handshake;
  static const auto image = unsigned_image();
  SmallFlash flash;
  const auto before = flash.places[0];
  const firmware::boot::Trust trust{"board", {1, 2, 3}};
  usbip::StackPort port;
  const bool no_program = !input.empty() && (input.take() & 1) != 0;
  const auto why = no_program ? firmware::boot::Reason::empty : firmware::boot::Reason::none;
  firmware::boot::BootDevice device(port, flash, trust, {'F'}, false, why);
  port.bind(device);
  device.start();
  port.bus_reset();
  usbip::Packet packet;
  const auto setup = [&](std::uint8_t type, std::uint8_t request, std::uint16_t value,
                         std::uint16_t length) {
    require(
        port.setup({type, request, static_cast<std::uint8_t>(value),
                    static_cast<std::uint8_t>(value >> 8), 0, 0, static_cast<std::uint8_t>(length),
                    static_cast<std::uint8_t>(length >> 8)}) == Handshake::ack);
  };
  const auto tell = [&](std::uint8_t type, std::uint8_t request, std::uint16_t value) {
    setup(type, request, value, 0);
    port.in(0, packet);
  };
  tell(0x00, 9, 1);  // SET_CONFIGURATION
  while (!input.empty()) {
    switch (const std::uint8_t what = input.take(); what & 15) {
      case 0: {
        const auto raw = input.take(8);
        std::array<std::uint8_t, 8> bytes{};
        std::copy(raw.begin(), raw.end(), bytes.begin());
        require(port.setup(bytes) == Handshake::ack);
        break;
      }
      case 1:
      case 2:
      case 3: {  // the block that comes next, or another one
        const std::size_t at = what / 16u % 4 * 1024;
        const std::size_t size =
            std::min<std::size_t>(1024, image.size() - std::min(at, image.size()));
        setup(0x21, dfu::download, 0, static_cast<std::uint16_t>(size));
        for (std::size_t sent = 0; sent < size; sent += 64) {
          port.out(0, std::span(image).subspan(at + sent, std::min<std::size_t>(64, size - sent)));
        }
        port.in(0, packet);
        break;
      }
      case 4:
      case 5:
      case 6:
        setup(0xA1, dfu::get_status, 0, 6);
        if (port.in(0, packet) == Handshake::ack) require(packet.size <= 6);
        port.out(0, {});
        break;
      case 7:
      case 8:
        for (int i = 0; i < 8; ++i) device.work();
        break;
      case 9:
        tell(0x21, static_cast<std::uint8_t>(what / 16 % 8), 0);
        break;
      case 10:
        setup(0xA1, dfu::upload, 0, static_cast<std::uint16_t>(input.take() * 8));
        while (port.in(0, packet) == Handshake::ack && packet.size == 64) {
        }
        port.out(0, {});
        break;
      case 11:
        tell(0x01, 11, what / 16 % 2);  // SET_INTERFACE
        break;
      case 12:
        port.bus_reset();
        tell(0x00, 9, 1);
        break;
      case 13: {
        const auto bytes = input.take(input.take() % 65);
        port.out(0, bytes);
        break;
      }
      default:
        port.in(0, packet);
    }
  }
  require(flash.places[0] == before);
  setup(0x80, 6, 0x0100, 18);
  require(port.in(0, packet) == Handshake::ack && packet.size == 18);
}

}  // namespace umov::fuzz
