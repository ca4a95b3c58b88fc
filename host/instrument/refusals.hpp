// Faults and refusals of the controller in words, each with what to do about it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "host/errors/error.hpp"
#include "protocol/messages.hpp"

namespace umov::instrument {

/// Name of a fault as in PROTOCOL.md, such as "emergency_stop"; "fault 77" for an unknown one.
std::string fault_name(std::uint8_t fault);
/// What happened, for a sentence: "the interlock opened".
std::string fault_meaning(std::uint8_t fault);
/// What the user should do about it.
std::string fault_remedy(std::uint8_t fault);

/// What a fault's detail says: in words where there are any, else the number.
std::string fault_detail(std::uint8_t fault, std::int32_t detail);

/// Name of a state, such as "waiting_for_rows".
std::string state_name(std::uint8_t state);
/// Of protocol::ReferenceState: what comes in at the reference input.
std::string reference_state_name(std::uint8_t state);
/// Name of an axis, 0 … 5, such as "detector".
std::string axis_name(int axis);

/// Thrown when the controller answers a request by error_reply.
class Refused : public Error {
 public:
  /// `device` is Transport::name(), `request` the name of the refused message.
  Refused(const std::string& device, std::string_view request, const protocol::ErrorReply& reply);
  protocol::Refusal refusal() const { return refusal_; }
  std::int32_t detail() const { return detail_; }

 private:
  protocol::Refusal refusal_;
  std::int32_t detail_;
};

/// Thrown when the controller is, or falls, into the safe state.
class Faulted : public Error {
 public:
  /// `where` completes the message, such as "at row 17" (may be empty).
  Faulted(const std::string& device, std::uint8_t fault, const std::string& where);
  protocol::Fault fault() const { return fault_; }

 private:
  protocol::Fault fault_;
};

}  // namespace umov::instrument
