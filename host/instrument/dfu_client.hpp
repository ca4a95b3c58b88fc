// The host's half of a firmware update: DFU 1.1, over whatever carries control transfers.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "host/errors/error.hpp"
#include "protocol/dfu.hpp"

namespace umov::instrument {

/// Class requests to the DFU interface of one device.
class DfuPipe {
 public:
  virtual ~DfuPipe() = default;
  /// Bytes that came. False in `good`: the device refuses (STALL). Throws LinkLost when it is gone.
  struct Answer {
    bool good = false;
    std::vector<std::uint8_t> bytes;
  };
  virtual Answer read(std::uint8_t request, std::uint16_t value, std::size_t length) = 0;
  /// False: the device refuses. Throws LinkLost when it is gone.
  virtual bool write(std::uint8_t request, std::uint16_t value,
                     std::span<const std::uint8_t> bytes) = 0;
  virtual void wait(std::chrono::milliseconds duration) = 0;
  /// A string descriptor of the device, empty if it has none of that number.
  virtual std::string text(std::uint8_t index) = 0;
  virtual std::string name() const = 0;
};

/// Thrown when the device refuses an image or an update fails; says why in the device's words.
class UpdateRefused : public Error {
 public:
  UpdateRefused(const std::string& device, std::uint8_t status, const std::string& reason);
  std::uint8_t status() const { return status_; }

 private:
  std::uint8_t status_;
};

enum class UpdatePhase : std::uint8_t { sending, installing };
/// `done` of `total` bytes while sending; polls so far and 0 while installing.
using UpdateProgress = std::function<void(UpdatePhase phase, std::size_t done, std::size_t total)>;

/// Sends the image and polls until the device has checked and installed it; returns what the device
/// has to say to that, mostly nothing. A download that another program left unfinished is given up
/// first. Throws UpdateRefused; LinkLost: repeat the update, the device has either image, whole.
std::string dfu_download(DfuPipe& device, std::span<const std::uint8_t> image,
                         const UpdateProgress& progress = {});

/// Why a boot loader that waits has no program to start, in its own words; empty when it was asked
/// to wait, or works on an update.
std::string dfu_trouble(DfuPipe& device);

/// The image that runs; empty when the device has none.
std::vector<std::uint8_t> dfu_upload(DfuPipe& device);

// Steps of those above, for loaders with requests of their own (rom_loader.hpp).
/// Ends whatever another program left unfinished.
void make_dfu_idle(DfuPipe& device);
/// Polls until the device is in that state. Throws UpdateRefused when it reports an error.
void wait_for_state(DfuPipe& device, protocol::dfu::State wanted);
/// Throws UpdateRefused with the reason that the device tells.
[[noreturn]] void throw_update_refused(DfuPipe& device);

/// Back to the program. The device may be gone before it has answered.
void dfu_leave(DfuPipe& device);

/// Does `work` and leaves; where that fails leaves all the same, if the device still listens, so
/// that a program that is good runs again. Throws what `work` throws.
void dfu_work_and_leave(DfuPipe& device, const std::function<void()>& work);

}  // namespace umov::instrument
