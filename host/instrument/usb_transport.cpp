#include "host/instrument/usb_transport.hpp"

#include <sys/time.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <vector>

#include "host/instrument/libusb_handles.hpp"
#include "host/instrument/link_lost.hpp"
#include "host/instrument/wall_clock.hpp"
#include "protocol/usb.hpp"

namespace umov::instrument {
namespace {

namespace usb = protocol::usb;
using std::chrono::microseconds;

/// Reads in flight, and the size of each: a multiple of the packet size, so that no packet is too
/// long for what is left of a transfer.
constexpr std::size_t reads_in_flight = 4;
constexpr std::size_t read_bytes = 16384;
/// A controller that takes no byte for this long is gone.
constexpr unsigned write_timeout_ms = 5000;
constexpr unsigned request_timeout_ms = 1000;

class UsbTransport final : public Transport {
 public:
  UsbTransport(UsbContext context, UsbHandle handle, std::string name)
      : context_(std::move(context)), handle_(std::move(handle)), name_(std::move(name)) {
    tell_presence(1);
    for (auto& slot : reads_) {
      slot = std::make_unique<Read>();
      Read& read = *slot;
      read.transfer = libusb_alloc_transfer(0);
      read.owner = this;
      libusb_fill_bulk_transfer(read.transfer, handle_.get(), usb::bulk_in, read.bytes.data(),
                                static_cast<int>(read.bytes.size()), on_read, &read, 0);
      submit(read);
    }
  }
  UsbTransport(const UsbTransport&) = delete;
  UsbTransport& operator=(const UsbTransport&) = delete;

  ~UsbTransport() override {
    closing_ = true;  // a read that has ended already must not begin anew
    for (const auto& read : reads_) {
      if (read->in_flight) libusb_cancel_transfer(read->transfer);
    }
    const auto flying = [](const auto& read) { return read->in_flight; };
    while (std::any_of(reads_.begin(), reads_.end(), flying)) {
      const int code = libusb_handle_events(context_.get());
      if (code != 0 && code != LIBUSB_ERROR_INTERRUPTED) break;
    }
    for (auto& read : reads_) {
      if (!read->in_flight) {
        libusb_free_transfer(read->transfer);
      } else {
        // It never came back and is still the library's: better lost than freed under it.
        (void)read.release();
      }
    }
    if (lost_.empty()) tell_presence(0);
    libusb_release_interface(handle_.get(), usb::interface::bulk);
  }

  void write(std::span<const std::uint8_t> bytes) override {
    require_link();
    Write write{std::vector<std::uint8_t>(bytes.begin(), bytes.end())};
    libusb_transfer* transfer = libusb_alloc_transfer(0);
    libusb_fill_bulk_transfer(transfer, handle_.get(), usb::bulk_out, write.bytes.data(),
                              static_cast<int>(write.bytes.size()), on_written, &write,
                              write_timeout_ms);
    int code = libusb_submit_transfer(transfer);
    write.done = code != 0 ? 1 : 0;
    while (write.done == 0) libusb_handle_events_completed(context_.get(), &write.done);
    const bool complete = code == 0 && transfer->status == LIBUSB_TRANSFER_COMPLETED &&
                          transfer->actual_length == transfer->length;
    const std::string why = code != 0 ? libusb_strerror(code) : reason(transfer->status);
    libusb_free_transfer(transfer);
    if (!complete) lose("connection lost: " + why);
    require_link();
  }

  std::size_t read(std::span<std::uint8_t> buffer, microseconds timeout) override {
    if (received_.empty()) {
      require_link();
      wait(std::max(timeout, microseconds(0)));
    }
    if (received_.empty()) {
      require_link();
      return 0;
    }
    const std::size_t count = std::min(buffer.size(), received_.size() - taken_);
    std::copy_n(received_.begin() + static_cast<std::ptrdiff_t>(taken_), count, buffer.begin());
    taken_ += count;
    if (taken_ == received_.size()) {
      received_.clear();
      taken_ = 0;
    }
    return count;
  }

  std::uint64_t clock_us() override { return clock_.now_us(); }
  std::string name() const override { return name_; }

 private:
  struct Read {
    UsbTransport* owner = nullptr;
    libusb_transfer* transfer = nullptr;
    bool in_flight = false;
    std::array<std::uint8_t, read_bytes> bytes{};
  };
  struct Write {
    std::vector<std::uint8_t> bytes;
    int done = 0;
  };

  static void LIBUSB_CALL on_read(libusb_transfer* transfer) {
    auto& read = *static_cast<Read*>(transfer->user_data);
    read.in_flight = false;
    UsbTransport& self = *read.owner;
    // What came before a failure is good, too.
    self.received_.insert(self.received_.end(), read.bytes.begin(),
                          read.bytes.begin() + transfer->actual_length);
    self.news_ = 1;
    if (transfer->status == LIBUSB_TRANSFER_COMPLETED) {
      self.submit(read);
    } else if (transfer->status != LIBUSB_TRANSFER_CANCELLED) {
      self.lose("connection lost: " + reason(transfer->status));
    }
  }

  static void LIBUSB_CALL on_written(libusb_transfer* transfer) {
    static_cast<Write*>(transfer->user_data)->done = 1;
  }

  static std::string reason(libusb_transfer_status status) {
    switch (status) {
      case LIBUSB_TRANSFER_NO_DEVICE:
        return "the controller was unplugged";
      case LIBUSB_TRANSFER_TIMED_OUT:
        return "the controller takes no data";
      case LIBUSB_TRANSFER_STALL:
        return "the controller refuses the transfer";
      case LIBUSB_TRANSFER_OVERFLOW:
        return "the controller sends more than was asked for";
      default:
        return "the transfer failed";
    }
  }

  void submit(Read& read) {
    if (closing_ || !lost_.empty()) return;
    const int code = libusb_submit_transfer(read.transfer);
    read.in_flight = code == 0;
    if (code != 0) lose(std::string("connection lost: ") + libusb_strerror(code));
  }

  /// Until something has arrived or was lost.
  void wait(microseconds timeout) {
    const auto deadline = std::chrono::steady_clock::now() + timeout;
    do {
      news_ = 0;  // an empty packet is news, too, but nothing to read
      const auto left = std::max(
          std::chrono::duration_cast<microseconds>(deadline - std::chrono::steady_clock::now()),
          microseconds(0));
      timeval limit{};
      limit.tv_sec = static_cast<time_t>(left.count() / 1'000'000);
      limit.tv_usec = static_cast<suseconds_t>(left.count() % 1'000'000);
      libusb_handle_events_timeout_completed(context_.get(), &limit, &news_);
    } while (received_.empty() && lost_.empty() && std::chrono::steady_clock::now() < deadline);
  }

  void tell_presence(std::uint16_t present) {
    // Older firmware may not know it; nothing depends on its answer.
    (void)libusb_control_transfer(
        handle_.get(),
        static_cast<std::uint8_t>(LIBUSB_REQUEST_TYPE_VENDOR) | LIBUSB_RECIPIENT_INTERFACE,
        usb::request_user_present, present, usb::interface::bulk, nullptr, 0, request_timeout_ms);
  }

  void lose(const std::string& why) {
    if (lost_.empty()) lost_ = why;
  }
  void require_link() const {
    if (!lost_.empty()) throw LinkLost(name_, lost_);
  }

  UsbContext context_;
  UsbHandle handle_;
  std::string name_;
  WallClock clock_;
  std::array<std::unique_ptr<Read>, reads_in_flight> reads_;
  std::vector<std::uint8_t> received_;  ///< emptied when all of it is taken
  std::size_t taken_ = 0;
  int news_ = 0;
  bool closing_ = false;
  std::string lost_;
};

}  // namespace

std::unique_ptr<Transport> connect_usb(const std::string& serial) {
  UsbContext context = open_usb_context();
  std::vector<OpenUsbDevice> found = find_usb_devices(context.get());
  std::vector<UsbDeviceInfo> infos;
  for (const auto& one : found) infos.push_back(one.info);
  const UsbDeviceInfo device = choose_device(infos, "usb", serial);
  const std::string name = "usb:" + device.serial;
  UsbHandle handle = std::move(std::find_if(found.begin(), found.end(), [&](const auto& one) {
                                 return one.info.node == device.node;
                               })->handle);
  found.clear();
  const int code = libusb_claim_interface(handle.get(), usb::interface::bulk);
  if (code == LIBUSB_ERROR_BUSY) throw_busy(name, device.node);
  if (code != 0) throw LinkLost(name, std::string("cannot use it: ") + libusb_strerror(code));
  return std::make_unique<UsbTransport>(std::move(context), std::move(handle), name);
}

}  // namespace umov::instrument
