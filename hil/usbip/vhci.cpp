#include "hil/usbip/vhci.hpp"

#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>

#include "hil/usbip/wire.hpp"
#include "host/errors/error.hpp"

namespace umov::usbip {
namespace {

const std::string controller = "/sys/devices/platform/vhci_hcd.0/";
/// VDEV_ST_NULL: nothing plugged in.
constexpr int port_is_free = 4;

/// Number of a free full-speed port, -1 if there is none. Lines of `status`:
/// hub port state speed device socket local-bus-id.
int free_port(std::istream& status) {
  std::string line;
  while (std::getline(status, line)) {
    std::istringstream fields(line);
    std::string hub;
    int port = 0;
    int state = 0;
    if (fields >> hub >> port >> state && hub == "hs" && state == port_is_free) return port;
  }
  return -1;
}

}  // namespace

net::Socket attach_to_kernel(std::uint32_t device_id) {
  std::ifstream status(controller + "status");
  if (!status) {
    throw Error("this kernel has no virtual USB host controller",
                "load it as root with: modprobe vhci-hcd");
  }
  const int port = free_port(status);
  if (port < 0) {
    throw Error("all ports of the virtual USB host controller are taken",
                "detach one with: usbip detach -p 0");
  }
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    throw Error(std::string("no socket for the virtual cable: ") + std::strerror(errno),
                "check the limits of this machine");
  }
  net::Socket ours(ends[0]);
  const net::Socket kernels(ends[1]);
  // One write with all of it: what the attribute expects.
  const std::string line = std::to_string(port) + " " + std::to_string(kernels.descriptor()) + " " +
                           std::to_string(device_id) + " " + std::to_string(wire::full_speed);
  const net::Socket attribute(::open((controller + "attach").c_str(), O_WRONLY | O_CLOEXEC));
  if (!attribute || ::write(attribute.descriptor(), line.data(), line.size()) !=
                        static_cast<ssize_t>(line.size())) {
    throw Error(std::string("the kernel does not take the virtual cable: ") + std::strerror(errno),
                "run this as root");
  }
  return ours;
}

}  // namespace umov::usbip
