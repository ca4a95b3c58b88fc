#include "host/instrument/tcp_server.hpp"

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
#include "host/net/listener.hpp"
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
  net::Socket socket;
  Clock::time_point until;
};

void set_option(const net::Socket& socket, int level, int option, int value) {
  setsockopt(socket.descriptor(), level, option, &value, sizeof value);
}

/// Reads and drops; false once the other side has closed.
bool drain(const net::Socket& socket) {
  std::array<std::uint8_t, 512> dropped;
  for (;;) {
    const ssize_t count = recv(socket.descriptor(), dropped.data(), dropped.size(), 0);
    if (count > 0) continue;
    return count < 0 && net::would_block(errno);
  }
}

}  // namespace

struct TcpServer::Sockets {
  net::Listener listener;
  net::Socket client;
  std::uint64_t client_number = 0;
  protocol::FrameReader client_reader;  ///< looks for the hello
  protocol::Name owner{};
  std::vector<RefusedClient> refused;

  void admit(net::Socket socket) {
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

  void refuse(net::Socket socket) {
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
    return count == 0 || (count < 0 && !net::would_block(errno));
  }

  /// True when the client has gone, whether or not it left something to read.
  bool client_is_leaving() const {
    pollfd request{client.descriptor(), POLLRDHUP, 0};
    return poll(&request, 1, 0) > 0;
  }

  bool somebody_waits() const {
    pollfd request{listener.descriptor(), POLLIN, 0};
    return poll(&request, 1, 0) > 0;
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
  sockets_->listener = net::Listener(port, address);
}

TcpServer::~TcpServer() = default;
TcpServer::TcpServer(TcpServer&&) noexcept = default;
TcpServer& TcpServer::operator=(TcpServer&&) noexcept = default;

std::uint16_t TcpServer::port() const {
  return sockets_->listener.port();
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
  while (s.somebody_waits()) {
    // Both may have happened since the last look: the client went, another came. What the first
    // one said last is read before the other is let in.
    if (s.client && s.client_has_gone()) s.drop_client();
    if (s.client && s.client_is_leaving()) break;
    net::Socket socket = s.listener.accept();
    if (!socket) break;
    if (s.client) {
      s.refuse(std::move(socket));
    } else {
      s.admit(std::move(socket));
      news = true;
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
  if (count == 0 || !net::would_block(errno)) s.drop_client();
  return 0;
}

std::size_t TcpServer::write(std::span<const std::uint8_t> bytes) {
  Sockets& s = *sockets_;
  if (!s.client) return bytes.size();
  const ssize_t count = send(s.client.descriptor(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
  if (count >= 0) return static_cast<std::size_t>(count);
  if (net::would_block(errno)) return 0;
  s.drop_client();
  return bytes.size();
}

}  // namespace umov::instrument
