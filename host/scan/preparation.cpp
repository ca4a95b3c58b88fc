#include "host/scan/preparation.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <optional>

#include "host/errors/error.hpp"
#include "host/instrument/program_control.hpp"
#include "host/instrument/refusals.hpp"

namespace umov::scan {
namespace {

using instrument::Session;

constexpr std::uint8_t all_axes = 0x3f;
/// How long a controller may take to come to rest, microseconds of the link's clock.
constexpr std::uint64_t rest_limit_us = 20'000'000;
/// And an external reference to be steady.
constexpr std::uint64_t reference_limit_us = 10'000'000;

class Preparation {
 public:
  Preparation(const Plan& plan, const PreparationOptions& options)
      : plan_(plan), options_(options), id_(options.program_id) {}

  bool run(Session& session) {
    const auto status = session.request(protocol::GetStatus{});
    if (status.program_id == id_ &&
        status.state != static_cast<std::uint8_t>(protocol::State::idle))
      return true;
    if (status.fault == static_cast<std::uint8_t>(protocol::Fault::link_lost)) {
      clear_link_lost(session);
      if (options_.link_lost_cleared) options_.link_lost_cleared();
    } else if (status.fault != 0) {
      throw instrument::Faulted(session.name(), status.fault, "before the scan began");
    }
    if (status.program_id != id_) refuse_to_lose_records(session, status);
    const auto idle = come_to_rest(session);
    if (!idle) return false;
    if (idle->homed_mask != all_axes &&
        !home(session, static_cast<std::uint8_t>(all_axes & ~idle->homed_mask))) {
      return false;
    }
    protocol::SetLockin lockin;
    lockin.reference_mhz = static_cast<std::uint32_t>(std::lround(1000 * plan_.reference_hz));
    lockin.harmonic = 1;
    lockin.settle_ms = static_cast<std::uint16_t>(plan_.settle_ms);
    lockin.blocks = 10;
    lockin.source =
        static_cast<std::uint8_t>(plan_.external_reference ? protocol::ReferenceSource::external
                                                           : protocol::ReferenceSource::internal);
    session.request(lockin);
    return !plan_.external_reference || wait_for_reference(session);
  }

 private:
  void refuse_to_lose_records(const Session& session, const protocol::Status& status) const {
    if (status.first_unacknowledged < status.next_record && !options_.discard_records) {
      throw Error({session.name()},
                  fmt::format("the controller still holds {} records of another scan",
                              status.next_record - status.first_unacknowledged),
                  "finish that scan with --resume, or discard them with --force");
    }
  }

  /// Ends what another host left going and waits until the axes stand; set_lockin and home are
  /// refused before. The status then, or nothing when the scan was called off meanwhile.
  std::optional<protocol::Status> come_to_rest(Session& session) {
    const auto deadline = session.clock_us() + rest_limit_us;
    while (options_.wanted()) {
      const auto status = session.request(protocol::GetStatus{});
      if (status.fault != 0)
        throw instrument::Faulted(session.name(), status.fault, "before the scan began");
      if (instrument::is_idle(status)) return status;
      if (session.clock_us() >= deadline) {
        throw Error({session.name()},
                    fmt::format("the controller is {} and does not come to rest",
                                instrument::state_name(status.state)),
                    "wait until it is idle (umov device info) or stop it");
      }
      if (instrument::is_running(status)) {
        instrument::control_program(session, instrument::ProgramAction::abort);
      }
      let_work(session);
    }
    return std::nullopt;
  }

  /// Lets the controller work a little; what it says belongs to nobody yet.
  static void let_work(Session& session) {
    session.poll(std::chrono::milliseconds(50));
    while (session.next_event()) {
    }
  }

  /// The fault that an earlier host's silence left; refused while the axes still come to rest.
  void clear_link_lost(Session& session) {
    for (int tries_left = 100;; --tries_left) {
      try {
        session.request(
            protocol::ClearFault{static_cast<std::uint8_t>(protocol::Fault::link_lost)});
        return;
      } catch (const instrument::Refused& refused) {
        // Cleared already, by a frame that was sent twice.
        if (refused.refusal() == protocol::Refusal::wrong_state) return;
        if (refused.refusal() != protocol::Refusal::busy || tries_left == 0) throw;
      }
      let_work(session);
    }
  }

  /// A chopper may still be getting up to speed. Without it in time the controller refuses the
  /// program and says what is wrong. False when the scan was called off meanwhile.
  bool wait_for_reference(Session& session) {
    constexpr auto locked = static_cast<std::uint8_t>(protocol::ReferenceState::locked);
    const auto deadline = session.clock_us() + reference_limit_us;
    while (session.request(protocol::GetStatus{}).reference_state != locked) {
      if (session.clock_us() >= deadline) return true;
      if (options_.note) options_.note("waiting for the external reference");
      if (!options_.wanted()) return false;
      let_work(session);
    }
    return true;
  }

  /// False when the scan was called off meanwhile.
  bool home(Session& session, std::uint8_t mask) {
    session.request(protocol::Home{mask});
    for (;;) {
      let_work(session);
      const auto status = session.request(protocol::GetStatus{});
      if (status.fault != 0)
        throw instrument::Faulted(session.name(), status.fault, "while homing");
      if (status.homed_mask == all_axes &&
          status.state == static_cast<std::uint8_t>(protocol::State::idle))
        return true;
      if (options_.note) options_.note("homing");
      if (!options_.wanted()) {
        session.request(protocol::Stop{});
        return false;
      }
    }
  }

  const Plan& plan_;
  const PreparationOptions& options_;
  std::uint32_t id_;
};

}  // namespace

bool prepare_controller(Session& session, const Plan& plan, const PreparationOptions& options) {
  return Preparation(plan, options).run(session);
}

}  // namespace umov::scan
