#include "hil/mcu/gdb/gdb_server.hpp"

#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <utility>

namespace umov::mcu {

GdbServer::GdbServer(Stm32f407& chip, std::uint16_t port, const std::string& address)
    : listener_(port, address), stub_(chip) {}

void GdbServer::drop() {
  client_.close();
  output_.clear();
  stub_.disconnected();
}

void GdbServer::receive() {
  std::array<char, 4096> buffer;
  const ssize_t count = recv(client_.descriptor(), buffer.data(), buffer.size(), 0);
  if (count > 0) {
    stub_.take({buffer.data(), static_cast<std::size_t>(count)}, output_);
  } else if (count == 0 || !net::would_block(errno)) {
    drop();
  }
}

void GdbServer::service() {
  if (!client_) {
    client_ = listener_.accept();
    if (!client_) return;
    stub_.connected();
  }
  receive();
  if (!client_) return;
  stub_.look_at_chip(output_);
  if (output_.empty()) return;
  const ssize_t sent = send(client_.descriptor(), output_.data(), output_.size(), MSG_NOSIGNAL);
  if (sent > 0) {
    output_.erase(0, static_cast<std::size_t>(sent));
  } else if (!net::would_block(errno)) {
    drop();
  }
}

}  // namespace umov::mcu
