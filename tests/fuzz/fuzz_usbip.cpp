// Whatever may come over the network to a USB/IP server: the input decides what a client says, in
// which pieces, before and after it has imported the firmware's USB device. The server neither
// crashes nor keeps what was closed, and a proper client is served afterwards.
//
// fuzz-link: umov_firmware umov_usbip
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "firmware/core/usb/device.hpp"
#include "hil/usbip/server.hpp"
#include "hil/usbip/stack_port.hpp"
#include "hil/usbip/wire.hpp"
#include "tests/fuzz/foreign_bytes.hpp"

namespace {

using namespace umov;
using Bytes = std::vector<std::uint8_t>;

class Deaf final : public firmware::usb::Application {
 public:
  void on_link_bytes(std::span<const std::uint8_t>) override {}
  void on_hand_report(const firmware::usb::HandReport&) override {}
  firmware::usb::HandState hand_state(std::uint8_t axis) const override { return {.axis = axis}; }
  bool detach_allowed() const override { return true; }
  void on_detach() override {}
};

Bytes request(std::uint16_t code) {
  Bytes out;
  usbip::wire::Writer(out).u16(usbip::wire::version).u16(code).u32(0);
  if (code == usbip::wire::request_import) {
    usbip::wire::Writer(out).text("1-1", usbip::wire::bus_id_bytes);
  }
  return out;
}

/// One end of a connection whose other one the server has.
class Client {
 public:
  explicit Client(usbip::Server& server) {
    std::array<int, 2> ends{};
    fuzz::require(socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, ends.data()) == 0);
    end_ = net::Socket(ends[0]);
    server.take_connection(net::Socket(ends[1]));
  }
  void say(std::span<const std::uint8_t> bytes) {
    (void)!::send(end_.descriptor(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
  }
  std::size_t hear() {
    std::size_t all = 0;
    std::array<std::uint8_t, 4096> buffer;
    for (;;) {
      const ssize_t count = ::recv(end_.descriptor(), buffer.data(), buffer.size(), 0);
      if (count <= 0) return all;
      all += static_cast<std::size_t>(count);
    }
  }

 private:
  net::Socket end_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::span<const std::uint8_t> input(data, size);
  const auto take = [&](std::size_t count) {
    const auto part = input.first(std::min(count, input.size()));
    input = input.subspan(part.size());
    return part;
  };
  Deaf application;
  usbip::StackPort port;
  firmware::usb::Device device(port, application, {'F'});
  port.bind(device);
  device.start();
  usbip::Server server({usbip::export_device("1-1", 2, port)});
  {
    Client client(server);
    if (!input.empty() && (take(1)[0] & 1) != 0) {
      client.say(request(usbip::wire::request_import));
      server.service();
      fuzz::require(server.plugged("1-1") && client.hear() == 8 + 312);
    }
    while (!input.empty()) {
      // A command that is right but for some bytes, or any bytes.
      const auto head = take(2);
      if (head.size() < 2) break;
      if ((head[0] & 1) != 0) {
        Bytes command;
        usbip::wire::Writer(command)
            .u32(usbip::wire::command_submit)
            .u32(head[1])
            .u32(0)
            .u32(head[0] >> 1 & 1u)
            .u32(head[0] >> 2 & 3u)
            .u32(0)
            .u32(head[0] >> 4)
            .u32(0)
            .u32(0xffffffffu);
        command.resize(usbip::wire::header_bytes);
        const auto setup = take(8);
        std::copy(setup.begin(), setup.end(), command.end() - 8);
        if ((head[0] >> 1 & 1u) == 0) command.resize(command.size() + (head[0] >> 4));
        client.say(command);
      } else {
        client.say(take(head[1]));
      }
      server.service();
      client.hear();
    }
  }
  for (int i = 0; i < 3; ++i) server.service();
  fuzz::require(!server.plugged("1-1"));
  Client proper(server);
  proper.say(request(usbip::wire::request_import));
  server.service();
  fuzz::require(server.plugged("1-1") && proper.hear() == 8 + 312);
  return 0;
}
