#include "hil/usbip/server.hpp"

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
#include <list>
#include <map>
#include <utility>

#include "hil/usbip/cable.hpp"
#include "hil/usbip/vhci.hpp"
#include "hil/usbip/wire.hpp"
#include "host/errors/error.hpp"

namespace umov::usbip {
namespace {

constexpr std::size_t most_clients = 16;
/// Status in replies: all is well; the device is not there or somebody else has it.
constexpr std::uint32_t good = 0;
constexpr std::uint32_t refused = 1;

/// A connection that has not imported a device yet.
struct Client {
  Socket socket;
  std::vector<std::uint8_t> input;
};

void reply_header(std::vector<std::uint8_t>& out, std::uint16_t code, std::uint32_t status) {
  wire::Writer(out).u16(wire::version).u16(code).u32(status);
}

/// Replies are short and the connection is fresh: what does not go out at once never will.
bool send_all(const Socket& socket, const std::vector<std::uint8_t>& bytes) {
  return ::send(socket.descriptor(), bytes.data(), bytes.size(), MSG_NOSIGNAL) ==
         static_cast<ssize_t>(bytes.size());
}

}  // namespace

struct Server::Impl {
  std::vector<ExportedDevice> devices;
  OnPlug on_plug;
  Socket listener;
  std::list<Client> clients;
  std::map<std::string, std::unique_ptr<Cable>> cables;

  const ExportedDevice* find(const std::string& bus_id) const {
    const auto found = std::find_if(devices.begin(), devices.end(),
                                    [&](const auto& device) { return device.bus_id == bus_id; });
    return found == devices.end() ? nullptr : &*found;
  }

  void plug(const ExportedDevice& device, Socket socket) {
    cables[device.bus_id] = std::make_unique<Cable>(std::move(socket), *device.function);
    if (on_plug) on_plug(device.bus_id, true);
  }

  void accept_clients() {
    while (listener) {
      Socket socket(accept4(listener.descriptor(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
      if (!socket) return;
      const int on = 1;
      setsockopt(socket.descriptor(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
      if (clients.size() < most_clients) clients.push_back({std::move(socket), {}});
    }
  }

  /// False when the client is done with: gone, refused, or its socket has become a cable.
  bool serve(Client& client) {
    std::array<std::uint8_t, 256> buffer;
    const ssize_t count = recv(client.socket.descriptor(), buffer.data(), buffer.size(), 0);
    if (count == 0) return false;
    if (count < 0) return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
    client.input.insert(client.input.end(), buffer.begin(), buffer.begin() + count);
    if (client.input.size() < wire::operation_header_bytes) return true;
    std::vector<std::uint8_t> reply;
    switch (wire::u16_at(client.input, 2)) {
      case wire::request_list:
        reply_header(reply, wire::reply_list, good);
        wire::Writer(reply).u32(static_cast<std::uint32_t>(devices.size()));
        for (const auto& device : devices) {
          write_description(reply, device);
          write_interfaces(reply, device);
        }
        (void)send_all(client.socket, reply);
        return false;
      case wire::request_import:
        return import(client);
      default:
        return false;
    }
  }

  bool import(Client& client) {
    if (client.input.size() < wire::operation_header_bytes + wire::bus_id_bytes) return true;
    const auto* text =
        reinterpret_cast<const char*>(client.input.data()) + wire::operation_header_bytes;
    const std::string bus_id(text, strnlen(text, wire::bus_id_bytes));
    const ExportedDevice* device = find(bus_id);
    std::vector<std::uint8_t> reply;
    if (device == nullptr || cables.contains(bus_id)) {
      reply_header(reply, wire::reply_import, refused);
      (void)send_all(client.socket, reply);
      return false;
    }
    reply_header(reply, wire::reply_import, good);
    write_description(reply, *device);
    if (send_all(client.socket, reply)) plug(*device, std::move(client.socket));
    return false;
  }

  bool serve_clients() {
    const std::size_t before = clients.size();
    const bool plugged_before = !cables.empty();
    for (auto client = clients.begin(); client != clients.end();) {
      client = serve(*client) ? std::next(client) : clients.erase(client);
    }
    return clients.size() != before || plugged_before == cables.empty();
  }

  bool serve_cables() {
    bool any = false;
    std::vector<std::string> broken;
    for (auto& [bus_id, cable] : cables) {
      any = cable->service() || any;
      if (cable->broken()) broken.push_back(bus_id);
    }
    for (const auto& bus_id : broken) remove(bus_id);
    return any || !broken.empty();
  }

  void remove(const std::string& bus_id) {
    cables.erase(bus_id);
    find(bus_id)->function->bus_reset();
    if (on_plug) on_plug(bus_id, false);
  }
};

Server::Server(std::vector<ExportedDevice> devices, OnPlug on_plug)
    : impl_(std::make_unique<Impl>()) {
  impl_->devices = std::move(devices);
  impl_->on_plug = std::move(on_plug);
}
Server::~Server() = default;

std::uint16_t Server::listen(std::uint16_t port, const std::string& address) {
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
      ::listen(listener.descriptor(), 8) != 0) {
    fail(std::strerror(errno), "choose another port with --port");
  }
  sockaddr_storage bound{};
  socklen_t size = sizeof bound;
  getsockname(listener.descriptor(), reinterpret_cast<sockaddr*>(&bound), &size);
  impl_->listener = std::move(listener);
  return ntohs(bound.ss_family == AF_INET6 ? reinterpret_cast<const sockaddr_in6&>(bound).sin6_port
                                           : reinterpret_cast<const sockaddr_in&>(bound).sin_port);
}

void Server::replace(ExportedDevice device) {
  for (auto& present : impl_->devices) {
    if (present.bus_id == device.bus_id) present = std::move(device);
  }
}

void Server::plug_into_kernel(const std::string& bus_id) {
  const ExportedDevice* device = impl_->find(bus_id);
  if (device == nullptr) throw Error("no device " + bus_id, "devices are numbered from 1-1");
  impl_->plug(*device, attach_to_kernel(device->device_id()));
}

bool Server::plugged(const std::string& bus_id) const {
  return impl_->cables.contains(bus_id);
}

void Server::unplug(const std::string& bus_id) {
  if (plugged(bus_id)) impl_->remove(bus_id);
}

void Server::wait(std::chrono::microseconds timeout) {
  std::vector<pollfd> requests;
  if (impl_->listener) requests.push_back({impl_->listener.descriptor(), POLLIN, 0});
  for (const auto& client : impl_->clients) {
    requests.push_back({client.socket.descriptor(), POLLIN, 0});
  }
  for (const auto& [bus_id, cable] : impl_->cables) {
    const auto events = static_cast<short>(cable->wants_to_write() ? POLLIN | POLLOUT : POLLIN);
    requests.push_back({cable->descriptor(), events, 0});
  }
  const auto us = std::max<std::chrono::microseconds::rep>(timeout.count(), 0);
  const timespec limit{us / 1'000'000, (us % 1'000'000) * 1000};
  ppoll(requests.data(), requests.size(), &limit, nullptr);
}

bool Server::service() {
  impl_->accept_clients();
  const bool clients = impl_->serve_clients();
  const bool cables = impl_->serve_cables();
  return clients || cables;
}

}  // namespace umov::usbip
