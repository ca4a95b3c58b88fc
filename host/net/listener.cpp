#include "host/net/listener.hpp"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <memory>

#include "host/errors/error.hpp"

namespace umov::net {

Listener::Listener(std::uint16_t port, const std::string& address) {
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
  const int on = 1;
  setsockopt(listener.descriptor(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (bind(listener.descriptor(), found->ai_addr, found->ai_addrlen) != 0 ||
      listen(listener.descriptor(), 8) != 0) {
    fail(std::strerror(errno), "choose another port with --port");
  }
  sockaddr_storage bound{};
  socklen_t size = sizeof bound;
  getsockname(listener.descriptor(), reinterpret_cast<sockaddr*>(&bound), &size);
  port_ = ntohs(bound.ss_family == AF_INET6 ? reinterpret_cast<const sockaddr_in6&>(bound).sin6_port
                                            : reinterpret_cast<const sockaddr_in&>(bound).sin_port);
  socket_ = std::move(listener);
}

Socket Listener::accept() const {
  Socket client(accept4(socket_.descriptor(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
  const int on = 1;
  if (client) setsockopt(client.descriptor(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  return client;
}

bool would_block(int error_number) {
  return error_number == EAGAIN || error_number == EWOULDBLOCK || error_number == EINTR;
}

}  // namespace umov::net
