#include "hil/usbip/server.hpp"

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
#include "host/net/listener.hpp"

namespace umov::usbip {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t most_clients = 16;
/// A client that has not said what it wants by then has gone.
constexpr std::chrono::seconds patience{10};
/// Status in replies: all is well; the device is not there or somebody else has it.
constexpr std::uint32_t good = 0;
constexpr std::uint32_t refused = 1;

/// A connection that has not imported a device yet.
struct Client {
  net::Socket socket;
  std::vector<std::uint8_t> input;
  Clock::time_point since;
};

void reply_header(std::vector<std::uint8_t>& out, std::uint16_t code, std::uint32_t status) {
  wire::Writer(out).u16(wire::version).u16(code).u32(status);
}

/// Replies are short and the connection is fresh: what does not go out at once never will.
bool send_all(const net::Socket& socket, const std::vector<std::uint8_t>& bytes) {
  return ::send(socket.descriptor(), bytes.data(), bytes.size(), MSG_NOSIGNAL) ==
         static_cast<ssize_t>(bytes.size());
}

}  // namespace

struct Server::Impl {
  std::vector<ExportedDevice> devices;
  OnPlug on_plug;
  net::Listener listener;
  std::list<Client> clients;
  std::map<std::string, std::unique_ptr<Cable>> cables;

  const ExportedDevice* find(const std::string& bus_id) const {
    const auto found = std::find_if(devices.begin(), devices.end(),
                                    [&](const auto& device) { return device.bus_id == bus_id; });
    return found == devices.end() ? nullptr : &*found;
  }

  void plug(const ExportedDevice& device, net::Socket socket) {
    cables[device.bus_id] = std::make_unique<Cable>(std::move(socket), *device.function);
    if (on_plug) on_plug(device.bus_id, true);
  }

  void accept_clients() {
    if (listener.descriptor() < 0) return;
    while (net::Socket socket = listener.accept()) take(std::move(socket));
  }

  /// Clients ask at once. One that has been silent longest makes room for the next, so that a few
  /// that never ask keep nobody out.
  void take(net::Socket socket) {
    if (clients.size() >= most_clients) clients.pop_front();
    clients.push_back({std::move(socket), {}, Clock::now()});
  }

  /// False when the client is done with: gone, refused, or its socket has become a cable.
  bool serve(Client& client) {
    std::array<std::uint8_t, 256> buffer;
    const ssize_t count = recv(client.socket.descriptor(), buffer.data(), buffer.size(), 0);
    if (count == 0) return false;
    if (count < 0) return net::would_block(errno) && Clock::now() - client.since < patience;
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
  impl_->listener = net::Listener(port, address);
  return impl_->listener.port();
}

void Server::take_connection(net::Socket client) {
  impl_->take(std::move(client));
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
  if (impl_->listener.descriptor() >= 0)
    requests.push_back({impl_->listener.descriptor(), POLLIN, 0});
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
