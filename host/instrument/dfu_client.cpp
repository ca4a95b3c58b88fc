#include "host/instrument/dfu_client.hpp"

#include <algorithm>

#include "host/instrument/link_lost.hpp"
#include "protocol/dfu.hpp"

namespace umov::instrument {
namespace {

namespace dfu = protocol::dfu;
using dfu::State;
using std::chrono::milliseconds;

/// A device that says it needs no time is asked again after this.
constexpr milliseconds shortest_wait{1};
/// Far more polls than the longest update needs.
constexpr int most_polls = 4000;

struct Report {
  std::uint8_t status = 0;
  milliseconds poll{0};
  State state = State::error;
  std::uint8_t text = 0;
};

std::string meaning(std::uint8_t status) {
  switch (static_cast<dfu::Status>(status)) {
    case dfu::Status::wrong_target:
      return "the image is for another device";
    case dfu::Status::bad_file:
      return "the file is no image for it";
    case dfu::Status::write_failed:
    case dfu::Status::erase_failed:
    case dfu::Status::program_failed:
      return "its flash memory fails";
    case dfu::Status::verify_failed:
      return "what it has stored fails its check";
    case dfu::Status::no_firmware:
      return "it has no program that it could start";
    case dfu::Status::not_done:
      return "the file is not all of the image";
    case dfu::Status::stalled_packet:
      return "it did not expect this request";
    default:
      return "DFU status " + std::to_string(status);
  }
}

Report report_of(DfuPipe& device) {
  const auto answer = device.read(dfu::get_status, 0, 6);
  if (!answer.good || answer.bytes.size() != 6) {
    throw LinkLost(device.name(), "it does not tell its DFU status");
  }
  const auto& b = answer.bytes;
  return {b[0], milliseconds(b[1] | b[2] << 8 | b[3] << 16), static_cast<State>(b[4]), b[5]};
}

std::string words_of(DfuPipe& device, const Report& report) {
  return report.text != 0 ? device.text(report.text) : std::string();
}

std::string reason_of(DfuPipe& device, const Report& report) {
  const std::string words = words_of(device, report);
  return words.empty() ? meaning(report.status) : words;
}

[[noreturn]] void throw_refused(DfuPipe& device, const Report& report) {
  throw UpdateRefused(device.name(), report.status, reason_of(device, report));
}

/// Polls until the device is in that state, and returns what it said then; `each` is called for
/// each poll.
template <class Each>
Report wait_for(DfuPipe& device, State wanted, Each&& each) {
  for (int polls = 0; polls < most_polls; ++polls) {
    const Report report = report_of(device);
    if (report.status != 0 || report.state == State::error) throw_refused(device, report);
    if (report.state == wanted) return report;
    each(polls);
    device.wait(std::max(report.poll, shortest_wait));
  }
  throw Error({device.name()}, "the update does not come to an end",
              "restart the controller and repeat the update");
}

}  // namespace

UpdateRefused::UpdateRefused(const std::string& device, std::uint8_t status,
                             const std::string& reason)
    : Error({device}, "the controller refuses the update: " + reason,
            "give an image of this board, signed with its key; an older one needs --allow-older"),
      status_(status) {}

void make_dfu_idle(DfuPipe& device) {
  for (int tries = 0; tries < most_polls; ++tries) {
    const Report report = report_of(device);
    switch (report.state) {
      case State::idle:
        return;
      case State::error:
        device.write(dfu::clear_status, 0, {});
        break;
      case State::download_idle:
      case State::upload_idle:
        device.write(dfu::abort, 0, {});
        break;
      default:
        device.wait(std::max(report.poll, shortest_wait));
    }
  }
  throw Error({device.name()}, "the boot loader does not become idle",
              "restart the controller and repeat the update");
}

void wait_for_state(DfuPipe& device, dfu::State wanted) {
  wait_for(device, wanted, [](int) {});
}

void throw_update_refused(DfuPipe& device) {
  throw_refused(device, report_of(device));
}

std::string dfu_download(DfuPipe& device, std::span<const std::uint8_t> image,
                         const UpdateProgress& progress) {
  make_dfu_idle(device);
  const auto tell = [&](UpdatePhase phase, std::size_t done, std::size_t total) {
    if (progress) progress(phase, done, total);
  };
  const auto send = [&](std::uint16_t block, std::span<const std::uint8_t> bytes) {
    if (!device.write(dfu::download, block, bytes)) throw_update_refused(device);
  };
  std::uint16_t block = 0;
  for (std::size_t at = 0; at < image.size(); ++block) {
    const std::size_t size = std::min<std::size_t>(dfu::transfer_bytes, image.size() - at);
    send(block, image.subspan(at, size));
    wait_for_state(device, State::download_idle);
    at += size;
    tell(UpdatePhase::sending, at, image.size());
  }
  send(block, {});
  const Report end = wait_for(device, State::idle, [&](int polls) {
    tell(UpdatePhase::installing, static_cast<std::size_t>(polls), 0);
  });
  return words_of(device, end);
}

std::string dfu_trouble(DfuPipe& device) {
  const Report report = report_of(device);
  const bool no_program = report.state == State::error &&
                          report.status == static_cast<std::uint8_t>(dfu::Status::no_firmware);
  return no_program ? reason_of(device, report) : std::string();
}

std::vector<std::uint8_t> dfu_upload(DfuPipe& device) {
  make_dfu_idle(device);
  std::vector<std::uint8_t> image;
  for (std::uint16_t block = 0;; ++block) {
    const auto answer = device.read(dfu::upload, block, dfu::transfer_bytes);
    if (!answer.good) throw_update_refused(device);
    image.insert(image.end(), answer.bytes.begin(), answer.bytes.end());
    if (answer.bytes.size() < dfu::transfer_bytes) return image;
  }
}

void dfu_leave(DfuPipe& device) {
  make_dfu_idle(device);
  try {
    device.write(dfu::detach, 0, {});
  } catch (const LinkLost&) {
    // Gone, as it should.
  }
}

void dfu_work_and_leave(DfuPipe& device, const std::function<void()>& work) {
  try {
    work();
  } catch (...) {
    try {
      dfu_leave(device);
    } catch (const Error&) {
      // What went wrong first is what the user must know.
    }
    throw;
  }
  dfu_leave(device);
}

}  // namespace umov::instrument
