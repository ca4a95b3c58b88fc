#include "host/instrument/hid_transport.hpp"

#include <fcntl.h>
#include <hidapi.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <cstdint>
#include <cstring>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>

#include "host/instrument/link_lost.hpp"
#include "host/instrument/usb_devices.hpp"
#include "host/instrument/wall_clock.hpp"
#include "host/net/socket.hpp"
#include "protocol/usb.hpp"

namespace umov::instrument {
namespace {

using protocol::usb::report_bytes;
using std::chrono::microseconds;

struct CloseHid {
  void operator()(hid_device* device) const { hid_close(device); }
};
using HidHandle = std::unique_ptr<hid_device, CloseHid>;

/// The kernel keeps 64 reports for a program and drops what comes then: 64 ms of a controller that
/// talks without pause. So a thread of its own takes them whatever the program does meanwhile, on a
/// handle of its own, since hidapi's handles are not for two threads.
class ReportReader {
 public:
  explicit ReportReader(HidHandle handle)
      : handle_(std::move(handle)), thread_([this] { work(); }) {}
  ReportReader(const ReportReader&) = delete;
  ReportReader& operator=(const ReportReader&) = delete;
  ~ReportReader() {
    ended_ = true;
    thread_.join();
  }

  /// Takes what has come, waiting for the first byte; 0 on timeout. `lost` when nothing will come
  /// any more.
  std::size_t take(std::span<std::uint8_t> buffer, microseconds timeout, bool& lost) {
    std::unique_lock lock(mutex_);
    news_.wait_for(lock, timeout, [this] { return !bytes_.empty() || lost_; });
    const std::size_t count = std::min(buffer.size(), bytes_.size());
    const auto end = bytes_.begin() + static_cast<std::ptrdiff_t>(count);
    std::copy(bytes_.begin(), end, buffer.begin());
    bytes_.erase(bytes_.begin(), end);
    lost = lost_ && count == 0;
    return count;
  }

 private:
  void work() {
    constexpr int look_up_ms = 50;
    std::array<unsigned char, report_bytes> report{};
    while (!ended_) {
      const int count = hid_read_timeout(handle_.get(), report.data(), report.size(), look_up_ms);
      if (count == 0) continue;
      const std::lock_guard lock(mutex_);
      if (count < 0) {
        lost_ = true;
      } else {
        bytes_.insert(bytes_.end(), report.begin(), report.begin() + count);
      }
      news_.notify_one();
      if (lost_) return;
    }
  }

  HidHandle handle_;
  std::mutex mutex_;
  std::condition_variable news_;
  std::deque<std::uint8_t> bytes_;
  bool lost_ = false;
  std::atomic<bool> ended_ = false;
  std::thread thread_;
};

class HidTransport final : public Transport {
 public:
  HidTransport(net::Socket lock, HidHandle reading, HidHandle writing, std::string name,
               std::string node)
      : lock_(std::move(lock)),
        handle_(std::move(writing)),
        name_(std::move(name)),
        node_(std::move(node)),
        reader_(std::move(reading)) {
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
      if (hid_write(handle_.get(), report.data(), report.size()) < 0) lose(std::strerror(errno));
      bytes = bytes.subspan(part.size());
    }
  }

  std::size_t read(std::span<std::uint8_t> buffer, microseconds timeout) override {
    bool lost = false;
    const std::size_t count = reader_.take(buffer, std::max(timeout, microseconds(0)), lost);
    if (lost) lose("its reports can't be read any more");
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
  /// An unplugged device's node has gone; else it is the device or the system that refuses.
  [[noreturn]] void lose(const std::string& why) const {
    const bool gone = ::access(node_.c_str(), F_OK) != 0;
    throw LinkLost(name_, "connection lost: " + (gone ? "the controller was unplugged" : why));
  }

  net::Socket lock_;
  HidHandle handle_;
  std::string name_;
  std::string node_;
  WallClock clock_;
  ReportReader reader_;
};

}  // namespace

std::unique_ptr<Transport> connect_hid(const std::string& serial) {
  const UsbDeviceInfo device = choose_device(list_hid_devices(), "hid", serial);
  const std::string name = "hid:" + device.serial;
  // Any number of programs may open a hidraw node, and all would get every report: a lock keeps
  // the second one out.
  net::Socket lock(::open(device.node.c_str(), O_RDWR | O_CLOEXEC));
  if (!lock) throw LinkLost(name, "can't open " + device.node + ": " + std::strerror(errno));
  if (::flock(lock.descriptor(), LOCK_EX | LOCK_NB) != 0) throw_busy(name, device.node);
  HidHandle reading(hid_open_path(device.node.c_str()));
  HidHandle writing(hid_open_path(device.node.c_str()));
  if (!reading || !writing) throw LinkLost(name, "can't open " + device.node + " for reports");
  return std::make_unique<HidTransport>(std::move(lock), std::move(reading), std::move(writing),
                                        name, device.node);
}

}  // namespace umov::instrument
