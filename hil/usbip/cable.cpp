#include "hil/usbip/cable.hpp"

#include <fcntl.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>

#include "hil/usbip/wire.hpp"
#include "host/net/listener.hpp"

namespace umov::usbip {
namespace {

/// No driver asks for more at once; whatever claims to is not USB/IP.
constexpr std::uint32_t longest_transfer = 4 * 1024 * 1024;

}  // namespace

Cable::Cable(net::Socket socket, UsbFunction& function)
    : socket_(std::move(socket)),
      bus_(function, [this](const Urb& urb, std::int32_t status, std::size_t transferred) {
        finish(urb, status, transferred);
      }) {
  const int flags = fcntl(socket_.descriptor(), F_GETFL);
  fcntl(socket_.descriptor(), F_SETFL, flags | O_NONBLOCK);
  function.bus_reset();
}

bool Cable::service() {
  const bool received = read_socket();
  const bool taken = take_commands();
  const bool moved = bus_.run();
  flush();
  return received || taken || moved;
}

bool Cable::read_socket() {
  std::array<std::uint8_t, 65536> buffer;
  bool any = false;
  while (!broken_) {
    const ssize_t count = recv(socket_.descriptor(), buffer.data(), buffer.size(), 0);
    if (count <= 0) {
      broken_ = count == 0 || !net::would_block(errno);
      break;
    }
    any = true;
    input_.insert(input_.end(), buffer.begin(), buffer.begin() + count);
    if (static_cast<std::size_t>(count) < buffer.size()) break;
  }
  return any;
}

bool Cable::take_commands() {
  bool any = false;
  while (!broken_) {
    const auto rest = std::span<const std::uint8_t>(input_).subspan(taken_);
    if (rest.size() < wire::header_bytes) break;
    const wire::Command command = wire::parse_command(rest.first<wire::header_bytes>());
    if (command.command == wire::command_unlink) {
      taken_ += wire::header_bytes;
      const bool found = bus_.unlink(command.unlink_number);
      wire::write_return_unlink(output_, command.number,
                                found ? urb_status::unlinked : urb_status::ok);
      any = true;
      continue;
    }
    const bool isochronous = command.iso_packets != 0 && command.iso_packets != 0xffffffffu;
    if (command.command != wire::command_submit || command.length > longest_transfer ||
        command.endpoint > 15 || isochronous) {
      broken_ = true;
      break;
    }
    const std::size_t data = command.to_host ? 0 : command.length;
    if (rest.size() < wire::header_bytes + data) break;
    taken_ += wire::header_bytes + data;
    Urb urb;
    urb.number = command.number;
    urb.endpoint = static_cast<std::uint8_t>(command.endpoint);
    urb.to_host = command.to_host;
    urb.add_empty_packet = (command.flags & wire::zero_packet_flag) != 0;
    urb.setup = command.setup;
    urb.length = command.length;
    const auto payload = rest.subspan(wire::header_bytes, data);
    urb.bytes.assign(payload.begin(), payload.end());
    bus_.submit(std::move(urb));
    any = true;
  }
  input_.erase(input_.begin(), input_.begin() + static_cast<std::ptrdiff_t>(taken_));
  taken_ = 0;
  return any;
}

void Cable::finish(const Urb& urb, std::int32_t status, std::size_t transferred) {
  wire::write_return_submit(output_, urb.number, status, transferred);
  if (urb.to_host) output_.insert(output_.end(), urb.bytes.begin(), urb.bytes.end());
}

void Cable::flush() {
  while (!broken_ && written_ < output_.size()) {
    const ssize_t count = send(socket_.descriptor(), output_.data() + written_,
                               output_.size() - written_, MSG_NOSIGNAL);
    if (count > 0) {
      written_ += static_cast<std::size_t>(count);
    } else {
      if (!net::would_block(errno)) broken_ = true;
      return;
    }
  }
  output_.clear();
  written_ = 0;
}

}  // namespace umov::usbip
