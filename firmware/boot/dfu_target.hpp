// The device's half of a firmware update: DFU 1.1 in DFU mode, with the downloaded image checked,
// kept apart and installed.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/boot/installer.hpp"
#include "firmware/core/usb/control_pipe.hpp"
#include "protocol/dfu.hpp"

namespace umov::firmware::boot {

namespace dfu = protocol::dfu;

/// What there is to say with a status, for iString of DFU_GETSTATUS: why an image was refused; what
/// is amiss with one that was installed; why the controller has no program.
enum class Reason : std::uint8_t {
  none,
  no_image,
  wrong_board,
  older,
  damaged,
  bad_signature,
  flash_failed,
  not_kept,
  empty,
  failed_trial,
  worn_out,
};

/// Requests come by control transfers; work() does what takes time, between them. Nothing that a
/// host sends changes what runs before the whole image has been received and found good. A request
/// out of turn ends an update, except while the device works: then it is refused and that is all.
/// An extension: DFU_DETACH in idle state ends DFU mode, like a reset on the bus. A controller that
/// has no program to start (`why` is not none) begins in the error state, status errFIRMWARE.
class DfuTarget {
 public:
  DfuTarget(Flash& flash, const Trust& trust, Reason why)
      : flash_(&flash), trust_(&trust), installer_(flash, trust) {
    if (why != Reason::none) fail(dfu::Status::no_firmware, why);
  }

  /// `older_too`: the alternate setting that takes images older than the one that runs.
  usb::ControlAnswer on_request(const usb::Request& request, bool older_too);
  bool on_data(std::span<const std::uint8_t> data);
  void on_complete(const usb::Request& request);
  /// One piece of work, if there is any: call it again and again.
  void work();
  bool working() const { return working_; }
  /// A host has asked to end DFU mode.
  bool leaving() const { return leaving_; }

  dfu::State state() const { return state_; }
  dfu::Status status() const { return status_; }
  /// String descriptor of Reason r is number first_reason_string + r − 1.
  static constexpr std::uint8_t first_reason_string = 6;

 private:
  usb::ControlAnswer download(const usb::Request& request, bool older_too);
  usb::ControlAnswer upload(const usb::Request& request);
  usb::ControlAnswer tell_status();
  usb::ControlAnswer refuse();
  bool fail(dfu::Status status, Reason reason);
  bool begins_well(std::span<const std::uint8_t> first_block);
  void store_block();
  void verify();
  std::uint32_t poll_ms() const;
  void forget();

  Flash* flash_;
  const Trust* trust_;
  Installer installer_;
  dfu::State state_ = dfu::State::idle;
  dfu::Status status_ = dfu::Status::ok;
  Reason reason_ = Reason::none;
  bool older_too_ = false;
  bool due_ = false;         ///< a block or a whole image waits for the host's DFU_GETSTATUS
  bool working_ = false;     ///< the host knows that it has to wait
  bool installing_ = false;  ///< verified and marked
  bool leaving_ = false;
  std::optional<ImageCheck> check_;
  ImageHeader header_{};
  std::uint32_t received_ = 0;
  std::uint32_t stored_ = 0;
  std::uint32_t uploaded_ = 0;
  std::array<std::uint8_t, dfu::transfer_bytes> block_{};
  std::size_t block_size_ = 0;
  std::array<std::uint8_t, 6> reply_{};
};

}  // namespace umov::firmware::boot
