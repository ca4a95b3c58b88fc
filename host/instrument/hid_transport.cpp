#include "host/instrument/hid_transport.hpp"

#include <fcntl.h>
#include <hidapi.h>
#include <sys/file.h>

#include <algorithm>
#include <array>
#include <utility>

#include "host/instrument/link_lost.hpp"
#include "host/instrument/socket.hpp"
#include "host/instrument/usb_devices.hpp"
#include "host/instrument/wall_clock.hpp"
#include "protocol/usb.hpp"

namespace umov::instrument {
namespace {

using protocol::usb::report_bytes;
using std::chrono::microseconds;

struct CloseHid {
  void operator()(hid_device* device) const { hid_close(device); }
};
using HidHandle = std::unique_ptr<hid_device, CloseHid>;

class HidTransport final : public Transport {
 public:
  HidTransport(Socket lock, HidHandle handle, std::string name)
      : lock_(std::move(lock)), handle_(std::move(handle)), name_(std::move(name)) {
    tell_presence(1);
  }
  ~HidTransport() override { tell_presence(0); }
  HidTransport(const HidTransport&) = delete;
  HidTransport& operator=(const HidTransport&) = delete;

  void write(std::span<const std::uint8_t> bytes) override {
    while (!bytes.empty()) {
      // Report number 0 (there are no numbers), then the report, padded with empty frames.
      std::array<unsigned char, 1 + report_bytes> report{};
      const auto part = bytes.first(std::min(bytes.size(), report_bytes));
      std::copy(part.begin(), part.end(), report.begin() + 1);
      if (hid_write(handle_.get(), report.data(), report.size()) < 0) lose();
      bytes = bytes.subspan(part.size());
    }
  }

  std::size_t read(std::span<std::uint8_t> buffer, microseconds timeout) override {
    if (used_ == size_) {
      const auto ms = std::chrono::ceil<std::chrono::milliseconds>(timeout).count();
      const int count = hid_read_timeout(handle_.get(), report_.data(), report_.size(),
                                         static_cast<int>(std::max<decltype(ms)>(ms, 0)));
      if (count < 0) lose();
      used_ = 0;
      size_ = static_cast<std::size_t>(count);
    }
    const std::size_t count = std::min(buffer.size(), size_ - used_);
    std::copy_n(report_.begin() + static_cast<std::ptrdiff_t>(used_), count, buffer.begin());
    used_ += count;
    return count;
  }

  std::uint64_t clock_us() override { return clock_.now_us(); }
  std::string name() const override { return name_; }

 private:
  void tell_presence(unsigned char present) {
    // Report number 0, then the report. A controller that has gone needs not be told.
    const std::array<unsigned char, 1 + protocol::usb::presence_report_bytes> report{0, present};
    (void)hid_send_feature_report(handle_.get(), report.data(), report.size());
  }
  [[noreturn]] void lose() const {
    throw LinkLost(name_, "connection lost: the controller was unplugged");
  }

  Socket lock_;
  HidHandle handle_;
  std::string name_;
  WallClock clock_;
  std::array<unsigned char, report_bytes> report_{};
  std::size_t used_ = 0;
  std::size_t size_ = 0;
};

}  // namespace

std::unique_ptr<Transport> connect_hid(const std::string& serial) {
  const UsbDeviceInfo device = choose_device(list_hid_devices(), "hid", serial);
  const std::string name = "hid:" + device.serial;
  // Any number of programs may open a hidraw node, and all would get every report: a lock keeps
  // the second one out.
  Socket lock(::open(device.node.c_str(), O_RDWR | O_CLOEXEC));
  if (!lock) throw LinkLost(name, "the controller has gone");
  if (::flock(lock.descriptor(), LOCK_EX | LOCK_NB) != 0) throw_busy(name, device.node);
  HidHandle handle(hid_open_path(device.node.c_str()));
  if (!handle) throw LinkLost(name, "the controller has gone");
  return std::make_unique<HidTransport>(std::move(lock), std::move(handle), name);
}

}  // namespace umov::instrument
