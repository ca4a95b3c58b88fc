#include "host/instrument/serial_transport.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/file.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "host/errors/error.hpp"
#include "host/instrument/link_lost.hpp"
#include "host/instrument/usb_devices.hpp"
#include "host/instrument/wall_clock.hpp"
#include "host/net/socket.hpp"
#include "host/net/wait.hpp"

namespace umov::instrument {
namespace {

using std::chrono::microseconds;

/// A line that takes no byte for this long is dead.
constexpr microseconds write_timeout{5'000'000};

constexpr std::array<std::pair<std::uint32_t, speed_t>, 15> speeds = {{{9600, B9600},
                                                                       {19200, B19200},
                                                                       {38400, B38400},
                                                                       {57600, B57600},
                                                                       {115200, B115200},
                                                                       {230400, B230400},
                                                                       {460800, B460800},
                                                                       {500000, B500000},
                                                                       {576000, B576000},
                                                                       {921600, B921600},
                                                                       {1000000, B1000000},
                                                                       {1152000, B1152000},
                                                                       {1500000, B1500000},
                                                                       {2000000, B2000000},
                                                                       {3000000, B3000000}}};

class SerialTransport final : public Transport {
 public:
  SerialTransport(net::Socket line, std::string name)
      : line_(std::move(line)), name_(std::move(name)) {}

  void write(std::span<const std::uint8_t> bytes) override {
    while (!bytes.empty()) {
      const ssize_t sent = ::write(line_.descriptor(), bytes.data(), bytes.size());
      if (sent > 0) {
        bytes = bytes.subspan(static_cast<std::size_t>(sent));
        continue;
      }
      if (sent < 0 && errno == EINTR) continue;
      if (sent < 0 && errno != EAGAIN) lose(std::strerror(errno));
      if (!net::wait_for(line_, POLLOUT, write_timeout) && errno != EINTR) lose("it takes no data");
    }
  }

  std::size_t read(std::span<std::uint8_t> buffer, microseconds timeout) override {
    if (!net::wait_for(line_, POLLIN, timeout)) return 0;
    const ssize_t count = ::read(line_.descriptor(), buffer.data(), buffer.size());
    if (count > 0) return static_cast<std::size_t>(count);
    if (count == 0) lose("the adapter was unplugged");
    if (errno == EINTR || errno == EAGAIN) return 0;
    lose(errno == EIO ? "the adapter was unplugged" : std::strerror(errno));
  }

  std::uint64_t clock_us() override { return clock_.now_us(); }
  std::string name() const override { return name_; }

 private:
  [[noreturn]] void lose(const std::string& why) const {
    throw LinkLost(name_, "connection lost: " + why);
  }

  net::Socket line_;
  std::string name_;
  WallClock clock_;
};

}  // namespace

std::unique_ptr<Transport> connect_serial_line(const std::string& path, std::uint32_t baud) {
  const std::string name = "serial:" + path;
  const auto speed = std::find_if(speeds.begin(), speeds.end(),
                                  [&](const auto& known) { return known.first == baud; });
  if (speed == speeds.end()) {
    throw Error({name}, std::to_string(baud) + " baud is no speed of serial lines",
                "the controller speaks 1000000 baud; leave ?baud= out");
  }
  net::Socket line(::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!line) {
    const int error = errno;
    throw Error({name}, "can't be opened: " + std::string(std::strerror(error)),
                error == EACCES
                    ? "add yourself to the group dialout: sudo usermod -aG dialout $USER, "
                      "then log in again"
                    : "see ls /dev/ttyUSB* /dev/ttyACM* for what is plugged in");
  }
  if (::flock(line.descriptor(), LOCK_EX | LOCK_NB) != 0) throw_busy(name, path);
  termios settings{};
  if (tcgetattr(line.descriptor(), &settings) != 0) {
    throw Error({name}, "is no serial line",
                "see ls /dev/ttyUSB* /dev/ttyACM* for what is plugged in");
  }
  cfmakeraw(&settings);
  // No modem lines; DTR stays as it is when the program ends: on some adapters it resets a board.
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | CRTSCTS | HUPCL);
  settings.c_cc[VMIN] = 0;
  settings.c_cc[VTIME] = 0;
  if (cfsetspeed(&settings, speed->second) != 0 ||
      tcsetattr(line.descriptor(), TCSANOW, &settings) != 0) {
    throw Error({name},
                "can't be set to " + std::to_string(baud) + " baud: " + std::strerror(errno),
                "use an adapter that knows this speed, or USB");
  }
  tcflush(line.descriptor(), TCIOFLUSH);
  return std::make_unique<SerialTransport>(std::move(line), name);
}

}  // namespace umov::instrument
