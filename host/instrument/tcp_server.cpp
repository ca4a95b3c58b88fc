#include "host/instrument/tcp_server.hpp"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <vector>

#include "host/errors/error.hpp"
#include "host/instrument/socket.hpp"
#include "protocol/frame.hpp"
#include "protocol/messages.hpp"

namespace umov::instrument {
namespace {

using Clock = std::chrono::steady_clock;

/// How long a refused client may take to read why. Closing at once would reset the connection and
/// could take the explanation with it.
constexpr std::chrono::seconds farewell{1};
constexpr std::size_t most_refused = 16;

struct RefusedClient {
  Socket socket;
  Clock::time_point until;
};

Socket accept_from(const Socket& listener) {
  return Socket(accept4(listener.descriptor(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
}

void set_option(const Socket& socket, int level, int option, int value) {
  setsockopt(socket.descriptor(), level, option, &value, sizeof value);
}

bool would_block(int number) {
  return number == EAGAIN || number == EWOULDBLOCK || number == EINTR;
}

/// Reads and drops; false once the other side has closed.
bool drain(const Socket& socket) {
  std::array<std::uint8_t, 512> dropped;
  for (;;) {
    const ssize_t count = recv(socket.descriptor(), dropped.data(), dropped.size(), 0);
    if (count > 0) continue;
    return count < 0 && would_block(errno);
  }
}

}  // namespace

struct TcpServer::Sockets {
  Socket listener;
  std::uint16_t port = 0;
  Socket client;
  std::uint64_t client_number = 0;
  protocol::FrameReader client_reader;  ///< looks for the hello
  protocol::Name owner{};
  std::vector<RefusedClient> refused;

  void admit(Socket socket) {
    set_option(socket, IPPROTO_TCP, TCP_NODELAY, 1);
    // A client that lost its power sends no farewell: notice within about ten seconds.
    set_option(socket, SOL_SOCKET, SO_KEEPALIVE, 1);
    set_option(socket, IPPROTO_TCP, TCP_KEEPIDLE, 4);
    set_option(socket, IPPROTO_TCP, TCP_KEEPINTVL, 2);
    set_option(socket, IPPROTO_TCP, TCP_KEEPCNT, 3);
    client = std::move(socket);
    client_reader = {};
    owner = {};
    ++client_number;
  }

  void refuse(Socket socket) {
    std::array<std::uint8_t, protocol::wire_frame_size<protocol::Busy>> frame{};
    const std::size_t size =
        protocol::FrameWriter::write(std::uint16_t{0}, protocol::Busy{owner}, frame);
    // A fresh connection has room for one frame; if not, it is refused without words.
    (void)!send(socket.descriptor(), frame.data(), size, MSG_NOSIGNAL);
    shutdown(socket.descriptor(), SHUT_WR);
    if (refused.size() < most_refused) {
      refused.push_back({std::move(socket), Clock::now() + farewell});
    }
  }

  void drop_client() {
    client.close();
    client_reader = {};
    owner = {};
  }

  /// True when the client has gone and left nothing to read.
  bool client_has_gone() const {
    std::uint8_t byte = 0;
    const ssize_t count = recv(client.descriptor(), &byte, 1, MSG_PEEK);
    return count == 0 || (count < 0 && !would_block(errno));
  }

  void note_owner(std::span<const std::uint8_t> bytes) {
    client_reader.feed(bytes, [&](const protocol::FrameView& frame) {
      protocol::Hello hello{};
      if (frame.type == protocol::Hello::info.id && protocol::decode(frame.payload, hello).ok()) {
        owner = hello.host_name;
      }
    });
  }

  void let_refused_go() {
    const auto now = Clock::now();
    std::erase_if(refused,
                  [&](RefusedClient& other) { return now >= other.until || !drain(other.socket); });
  }
};

TcpServer::TcpServer(std::uint16_t port, const std::string& address)
    : sockets_(std::make_unique<Sockets>()) {
  const std::string port_text = std::to_string(port);
  const auto fail = [&](const std::string& why, const std::string& remedy) {
    throw Error("cannot listen on " + address + ":" + port_text + ": " + why, remedy);
  };
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE;
  addrinfo* found = nullptr;
  if (const int code = getaddrinfo(address.c_str(), port_text.c_str(), &hints, &found); code != 0) {
    fail(gai_strerror(code), "give an address of this machine, such as 127.0.0.1");
  }
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> addresses(found, freeaddrinfo);

  Socket listener(socket(found->ai_family, found->ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!listener) fail(std::strerror(errno), "check the limits of this machine");
  set_option(listener, SOL_SOCKET, SO_REUSEADDR, 1);
  if (bind(listener.descriptor(), found->ai_addr, found->ai_addrlen) != 0 ||
      listen(listener.descriptor(), 8) != 0) {
    fail(std::strerror(errno), "choose another port with --port");
  }
  sockaddr_storage bound{};
  socklen_t size = sizeof bound;
  getsockname(listener.descriptor(), reinterpret_cast<sockaddr*>(&bound), &size);
  const auto network_port = bound.ss_family == AF_INET6
                                ? reinterpret_cast<const sockaddr_in6&>(bound).sin6_port
                                : reinterpret_cast<const sockaddr_in&>(bound).sin_port;
  sockets_->listener = std::move(listener);
  sockets_->port = ntohs(network_port);
}

TcpServer::~TcpServer() = default;
TcpServer::TcpServer(TcpServer&&) noexcept = default;
TcpServer& TcpServer::operator=(TcpServer&&) noexcept = default;

std::uint16_t TcpServer::port() const {
  return sockets_->port;
}
bool TcpServer::has_client() const {
  return static_cast<bool>(sockets_->client);
}
std::uint64_t TcpServer::client_number() const {
  return sockets_->client_number;
}

bool TcpServer::wait(std::chrono::microseconds timeout) {
  Sockets& s = *sockets_;
  s.let_refused_go();
  const auto us = std::max<std::chrono::microseconds::rep>(timeout.count(), 0);
  const timespec limit{us / 1'000'000, (us % 1'000'000) * 1000};
  std::array<pollfd, 2> requests{
      {{s.listener.descriptor(), POLLIN, 0}, {s.client.descriptor(), POLLIN, 0}}};
  if (ppoll(requests.data(), requests.size(), &limit, nullptr) <= 0) return false;

  bool news = requests[1].revents != 0;
  if (news && s.client && s.client_has_gone()) s.drop_client();
  if (requests[0].revents != 0) {
    while (Socket socket = accept_from(s.listener)) {
      if (s.client) {
        s.refuse(std::move(socket));
      } else {
        s.admit(std::move(socket));
        news = true;
      }
    }
  }
  return news;
}

std::size_t TcpServer::read(std::span<std::uint8_t> buffer) {
  Sockets& s = *sockets_;
  if (!s.client || buffer.empty()) return 0;
  const ssize_t count = recv(s.client.descriptor(), buffer.data(), buffer.size(), 0);
  if (count > 0) {
    const auto size = static_cast<std::size_t>(count);
    s.note_owner(buffer.first(size));
    return size;
  }
  if (count == 0 || !would_block(errno)) s.drop_client();
  return 0;
}

std::size_t TcpServer::write(std::span<const std::uint8_t> bytes) {
  Sockets& s = *sockets_;
  if (!s.client) return bytes.size();
  const ssize_t count = send(s.client.descriptor(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
  if (count >= 0) return static_cast<std::size_t>(count);
  if (would_block(errno)) return 0;
  s.drop_client();
  return bytes.size();
}

}  // namespace umov::instrument
