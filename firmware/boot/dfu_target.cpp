#include "firmware/boot/dfu_target.hpp"

#include <algorithm>

namespace umov::firmware::boot {

using dfu::State;
using dfu::Status;
using usb::ControlAnswer;

namespace {

// How long a host should wait before it asks again: typical times (DS8626, table 47). A device that
// still works then lets the host's request wait: erasing 128 KB takes 1 to 2 s, a block of 256
// words 4 to 26 ms.
constexpr std::uint32_t erase_ms = 1000, block_ms = 5, verify_ms = 100;

}  // namespace

ControlAnswer DfuTarget::refuse() {
  // What is being written or installed is not to be stopped half-way, whatever a host asks for; and
  // an error stays what it is until it is cleared (DFU 1.1, A.2.11): its reason is yet to be read.
  if (working_ || state_ == State::error) return ControlAnswer::refuse();
  fail(Status::stalled_packet, Reason::none);
  return ControlAnswer::refuse();
}

bool DfuTarget::fail(Status status, Reason reason) {
  state_ = State::error;
  status_ = status;
  reason_ = reason;
  due_ = working_ = installing_ = false;
  return false;
}

void DfuTarget::forget() {
  state_ = State::idle;
  status_ = Status::ok;
  reason_ = Reason::none;
  due_ = working_ = installing_ = false;
  received_ = stored_ = uploaded_ = 0;
}

ControlAnswer DfuTarget::on_request(const usb::Request& request, bool older_too) {
  const bool asks_nothing = !request.to_host && request.length == 0;
  switch (request.number) {
    case dfu::download:
      if (request.to_host) break;
      return download(request, older_too);
    case dfu::upload:
      if (!request.to_host) break;
      return upload(request);
    case dfu::get_status:
      if (!request.to_host) break;
      return tell_status();
    case dfu::get_state:
      if (!request.to_host) break;
      reply_[0] = static_cast<std::uint8_t>(state_);
      return ControlAnswer::reply(std::span<const std::uint8_t>(reply_).first(1));
    case dfu::clear_status:
      if (!asks_nothing || state_ != State::error) break;
      forget();
      return ControlAnswer::accept();
    case dfu::abort:
      if (!asks_nothing || working_ || state_ == State::error) break;
      forget();
      return ControlAnswer::accept();
    case dfu::detach:
      if (!asks_nothing || state_ != State::idle) break;
      return ControlAnswer::accept();
    default:
      break;
  }
  return refuse();
}

ControlAnswer DfuTarget::download(const usb::Request& request, bool older_too) {
  if (state_ == State::idle && request.length > 0) {
    forget();
    older_too_ = older_too;
  } else if (state_ != State::download_idle) {
    return refuse();
  }
  if (request.length > block_.size()) return refuse();
  if (request.length > 0) return ControlAnswer::take(block_);
  if (received_ != header_.image_bytes()) {
    fail(Status::not_done, Reason::no_image);
    return ControlAnswer::refuse();
  }
  state_ = State::manifest_sync;
  due_ = true;
  check_.reset();
  return ControlAnswer::accept();
}

/// What the header tells is looked at before anything is erased.
bool DfuTarget::begins_well(std::span<const std::uint8_t> first_block) {
  const std::size_t room = flash_->contents(Place::staged).size() - reserved_bytes;
  switch (check_header(first_block, room, *trust_, header_)) {
    case Verdict::good:
      break;
    case Verdict::wrong_board:
      return fail(Status::wrong_target, Reason::wrong_board);
    default:
      return fail(Status::bad_file, Reason::no_image);
  }
  ImageHeader running;
  const auto place = flash_->contents(Place::running);
  const bool known = check_header(place, place.size(), *trust_, running) == Verdict::good;
  // One that has failed is no measure for another.
  const bool proven = known && !Trial(*flash_).failed();
  if (proven && header_.version < running.version && !older_too_) {
    return fail(Status::vendor, Reason::older);
  }
  return true;
}

bool DfuTarget::on_data(std::span<const std::uint8_t> data) {
  if (received_ == 0 && !begins_well(data)) return false;
  // Only the last block may be no multiple of four, and then it is none of ours.
  if (data.size() % 4 != 0 || received_ + data.size() > header_.image_bytes()) {
    return fail(Status::bad_file, Reason::no_image);
  }
  block_size_ = data.size();  // they lie in block_ already
  received_ += static_cast<std::uint32_t>(data.size());
  state_ = State::download_sync;
  due_ = true;
  return true;
}

ControlAnswer DfuTarget::upload(const usb::Request& request) {
  if (state_ == State::idle) {
    uploaded_ = 0;
  } else if (state_ != State::upload_idle) {
    return refuse();
  }
  ImageHeader header;
  const auto place = flash_->contents(Place::running);
  const bool there = check_header(place, place.size(), *trust_, header) == Verdict::good;
  const std::uint32_t whole = there ? header.image_bytes() : 0;
  const std::uint32_t rest = whole - std::min(uploaded_, whole);
  const std::uint32_t size = std::min<std::uint32_t>(rest, request.length);
  const auto piece = place.subspan(whole - rest, size);
  uploaded_ += size;
  state_ = size < request.length ? State::idle : State::upload_idle;
  return ControlAnswer::reply(piece);
}

std::uint32_t DfuTarget::poll_ms() const {
  switch (state_) {
    case State::download_busy:
      return stored_ == 0 ? erase_ms : block_ms;
    case State::manifest:
      if (!installing_) return verify_ms;
      return installer_.erases_next() ? erase_ms : block_ms;
    default:
      return 0;
  }
}

ControlAnswer DfuTarget::tell_status() {
  if (state_ == State::download_sync) state_ = due_ ? State::download_busy : State::download_idle;
  if (state_ == State::manifest_sync) {
    if (due_) {
      state_ = State::manifest;
    } else {
      forget();
      if (!installer_.kept()) reason_ = Reason::not_kept;
    }
  }
  const std::uint32_t wait_ms = poll_ms();
  reply_ = {static_cast<std::uint8_t>(status_),      static_cast<std::uint8_t>(wait_ms),
            static_cast<std::uint8_t>(wait_ms >> 8), static_cast<std::uint8_t>(wait_ms >> 16),
            static_cast<std::uint8_t>(state_),       0};
  if (reason_ != Reason::none) {
    reply_[5] = static_cast<std::uint8_t>(first_reason_string + static_cast<int>(reason_) - 1);
  }
  return ControlAnswer::reply(reply_);
}

void DfuTarget::on_complete(const usb::Request& request) {
  if (request.number == dfu::get_status && due_ &&
      (state_ == State::download_busy || state_ == State::manifest)) {
    working_ = true;
  }
  if (request.number == dfu::detach && state_ == State::idle) leaving_ = true;
}

void DfuTarget::work() {
  if (!working_) return;
  if (state_ == State::download_busy) return store_block();
  if (!installing_) return verify();
  if (installer_.step()) return;
  if (installer_.failed()) {
    fail(Status::program_failed, Reason::flash_failed);
    return;
  }
  state_ = State::manifest_sync;
  due_ = working_ = installing_ = false;
}

void DfuTarget::store_block() {
  if (stored_ == 0 && !flash_->erase(Place::staged)) {
    fail(Status::erase_failed, Reason::flash_failed);
    return;
  }
  if (!flash_->program(Place::staged, stored_,
                       std::span<const std::uint8_t>(block_).first(block_size_))) {
    fail(Status::program_failed, Reason::flash_failed);
    return;
  }
  stored_ += static_cast<std::uint32_t>(block_size_);
  state_ = State::download_sync;
  due_ = working_ = false;
}

void DfuTarget::verify() {
  if (!check_) check_.emplace(flash_->contents(Place::staged), *trust_);
  if (check_->step()) return;
  const Verdict verdict = check_->verdict();
  check_.reset();
  switch (verdict) {
    case Verdict::good:
      break;
    case Verdict::bad_signature:
      fail(Status::vendor, Reason::bad_signature);
      return;
    default:
      fail(Status::verify_failed, Reason::damaged);
      return;
  }
  if (!installer_.order()) {
    fail(Status::program_failed, Reason::flash_failed);
    return;
  }
  installing_ = true;
  if (!installer_.begin(true)) fail(Status::program_failed, Reason::flash_failed);
}

}  // namespace umov::firmware::boot
