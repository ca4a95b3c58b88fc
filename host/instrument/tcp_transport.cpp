#include "host/instrument/tcp_transport.hpp"

#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>

#include "host/errors/error.hpp"
#include "host/instrument/link_lost.hpp"
#include "host/instrument/wall_clock.hpp"
#include "host/net/socket.hpp"
#include "host/net/wait.hpp"

namespace umov::instrument {
namespace {

using std::chrono::microseconds;
using Clock = std::chrono::steady_clock;

/// A controller that takes no byte for this long is gone.
constexpr std::chrono::milliseconds write_timeout{5000};

std::string error_text(int number) {
  return std::strerror(number);
}

class TcpTransport final : public Transport {
 public:
  TcpTransport(net::Socket socket, std::string name)
      : socket_(std::move(socket)), name_(std::move(name)) {}

  void write(std::span<const std::uint8_t> bytes) override {
    while (!bytes.empty()) {
      const ssize_t sent = ::send(socket_.descriptor(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (sent >= 0) {
        bytes = bytes.subspan(static_cast<std::size_t>(sent));
        continue;
      }
      if (errno == EINTR) continue;
      if (errno != EAGAIN && errno != EWOULDBLOCK) {
        throw LinkLost(name_, "connection lost: " + error_text(errno));
      }
      if (!net::wait_for(socket_, POLLOUT, write_timeout) && errno != EINTR) {
        throw LinkLost(name_, "connection lost: the controller takes no data");
      }
    }
  }

  std::size_t read(std::span<std::uint8_t> buffer, microseconds timeout) override {
    if (!net::wait_for(socket_, POLLIN, timeout)) return 0;
    const ssize_t count = ::recv(socket_.descriptor(), buffer.data(), buffer.size(), 0);
    if (count > 0) return static_cast<std::size_t>(count);
    if (count == 0) throw LinkLost(name_, "the controller closed the connection");
    if (errno == EINTR || errno == EAGAIN || errno == EWOULDBLOCK) return 0;
    throw LinkLost(name_, "connection lost: " + error_text(errno));
  }

  std::uint64_t clock_us() override { return clock_.now_us(); }

  std::string name() const override { return name_; }

 private:
  net::Socket socket_;
  std::string name_;
  WallClock clock_;
};

/// 0 when connected, else errno.
int connect_within(const net::Socket& socket, const addrinfo& address, Clock::time_point deadline) {
  if (::connect(socket.descriptor(), address.ai_addr, address.ai_addrlen) == 0) return 0;
  if (errno != EINPROGRESS) return errno;
  for (;;) {
    const auto left = std::chrono::duration_cast<microseconds>(deadline - Clock::now());
    if (net::wait_for(socket, POLLOUT, left)) break;
    if (left.count() <= 0) return ETIMEDOUT;
  }
  int failure = 0;
  socklen_t size = sizeof failure;
  if (getsockopt(socket.descriptor(), SOL_SOCKET, SO_ERROR, &failure, &size) != 0) return errno;
  return failure;
}

}  // namespace

std::unique_ptr<Transport> connect_tcp(const std::string& host, std::uint16_t port,
                                       std::chrono::milliseconds timeout) {
  const std::string port_text = std::to_string(port);
  const std::string remedy =
      "is the emulator running? start it with: umov emulator --port " + port_text;
  const std::string problem = "cannot reach " + host + ":" + port_text + ": ";

  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int code = getaddrinfo(host.c_str(), port_text.c_str(), &hints, &found); code != 0) {
    throw Error(problem + gai_strerror(code), "check the name of the host");
  }
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> addresses(found, freeaddrinfo);

  const Clock::time_point deadline = Clock::now() + timeout;
  int failure = EHOSTUNREACH;
  for (const addrinfo* address = found; address != nullptr; address = address->ai_next) {
    net::Socket socket(::socket(address->ai_family,
                                address->ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC,
                                address->ai_protocol));
    if (!socket) {
      failure = errno;
      continue;
    }
    failure = connect_within(socket, *address, deadline);
    if (failure != 0) continue;
    const int on = 1;
    setsockopt(socket.descriptor(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    return std::make_unique<TcpTransport>(std::move(socket), "tcp:" + host + ":" + port_text);
  }
  throw Error(problem + error_text(failure), remedy);
}

}  // namespace umov::instrument
