#include "host/instrument/refusals.hpp"

#include <array>
#include <utility>

#include "host/instrument/firmware_image.hpp"
#include "protocol/boot_note.hpp"
#include "protocol/codec.hpp"

namespace umov::instrument {
namespace {

using protocol::Refusal;

struct FaultText {
  std::string_view name;
  std::string_view meaning;
  std::string_view remedy;
};

// In the order of protocol::Fault.
constexpr std::array<FaultText, 17> fault_texts{{
    {"none", "no fault is latched", "nothing to do"},
    {"interlock", "the interlock opened",
     "close the enclosure and clear the fault: umov device log --clear"},
    {"emergency_stop", "the emergency stop was triggered",
     "make sure the stage is free and clear the fault: umov device log --clear"},
    {"limit", "a limit switch was reached",
     "clear the fault (umov device log --clear), home the axes (umov device home) and check the "
     "angles"},
    {"stall", "an axis stalled",
     "free the axis, clear the fault (umov device log --clear), home the axes (umov device home)"},
    {"link_lost", "the controller heard nothing from its host for too long",
     "check the cable and resume the scan"},
    {"watchdog", "the watchdog restarted the controller",
     "clear the fault (umov device log --clear), home the axes (umov device home) and resume"},
    {"brown_out", "the supply voltage dropped",
     "check the supply, clear the fault (umov device log --clear), home the axes (umov device "
     "home)"},
    {"adc_overrun", "ADC samples were lost",
     "clear the fault (umov device log --clear) and resume; restart the controller if it comes "
     "back"},
    {"missed_deadline", "the controller missed a deadline",
     "clear the fault (umov device log --clear) and resume; restart the controller if it comes "
     "back"},
    {"not_homed", "the home switch of an axis was not found",
     "check switch and cable, clear the fault (umov device log --clear), home again (umov device "
     "home)"},
    {"internal", "the firmware found an inconsistency in itself",
     "restart the controller and keep the output of umov device log for its developers"},
    {"settings_corrupt",
     "the saved settings are damaged, or of other firmware; the built-in ones are in force",
     "clear the fault (umov device log --clear), set what differs and save it (umov device config "
     "set, config save)"},
    {"over_temperature", "drivers or lasers are too hot",
     "let them cool and clear the fault (umov device log --clear); look at fans and air"},
    {"rolled_back", "the controller's image was given up and the one before it put back",
     "umov device log says why; clear the fault (umov device log --clear) and flash an image that "
     "works (umov device flash)"},
    {"no_fallback",
     "the image before the running one could not be kept: part of the flash memory is worn out",
     "clear the fault (umov device log --clear) and go on; should the running image ever fail, the "
     "boot loader waits for another (umov device flash)"},
    {"reference_lost", "the external reference went away in the middle of a scan",
     "look at chopper and cable (umov device info shows what comes in), clear the fault (umov "
     "device log --clear) and resume"},
}};
static_assert(fault_texts.size() == static_cast<std::size_t>(protocol::Fault::reference_lost) + 1);

std::string axis_or_nothing(std::int32_t detail) {
  return detail >= 0 && detail < protocol::axis_count ? " (" + axis_name(detail) + ")" : "";
}

std::string roll_back_text(std::int32_t detail) {
  const std::uint32_t version = protocol::roll_back_version(detail);
  const std::string image = "image" + (version != 0 ? " " + version_text(version) : std::string());
  switch (protocol::roll_back_reason(detail)) {
    case protocol::RollBackReason::damaged:
      return image + " failed its check at a start";
    case protocol::RollBackReason::watchdog:
      return image + " failed its trial: the watchdog had to restart it";
    case protocol::RollBackReason::crash:
      return image + " failed its trial: it crashed";
    case protocol::RollBackReason::button:
      return image + " failed its trial: it was reset by hand";
  }
  return image + ": reason " + std::to_string(detail >> 24);
}

std::string_view reference_problem(std::int32_t state) {
  switch (static_cast<protocol::ReferenceState>(state)) {
    case protocol::ReferenceState::unsteady:
      return "the edges at its reference input do not come at a steady period";
    case protocol::ReferenceState::out_of_range:
      return "the external reference is slower than 10 Hz, faster than 20 kHz, or too fast for the "
             "harmonic";
    default:
      return "no edges come in at its reference input";
  }
}

/// What came in when a fault was raised for it; `locked` where the reference was back already.
std::string lost_reference_text(std::int32_t state) {
  if (state == static_cast<std::int32_t>(protocol::ReferenceState::locked)) {
    return "it was away for a moment and came back";
  }
  return std::string(reference_problem(state));
}

struct RefusalText {
  std::string problem;
  std::string remedy;
};

RefusalText refusal_text(const protocol::ErrorReply& reply) {
  switch (static_cast<Refusal>(reply.code)) {
    case Refusal::none:
      return {"it gives no reason", "repeat the command"};
    case Refusal::unknown_message:
      return {"its firmware does not know this request", "flash the firmware of this release"};
    case Refusal::bad_length:
      return {"the request has the wrong length for its firmware",
              "flash the firmware of this release"};
    case Refusal::out_of_range: {
      const std::string field =
          reply.detail >= 0 ? "field number " + std::to_string(reply.detail) : "a field";
      return {field + " is out of range", "the ranges stand in protocol/PROTOCOL.md"};
    }
    case Refusal::wrong_state:
      return {"it is busy with something else",
              "wait until it is idle (umov device info) or stop it"};
    case Refusal::fault_active:
      return {
          "a fault is latched",
          "see umov device info for which; remove its cause and clear it: umov device log --clear"};
    case Refusal::not_homed:
      return {"an axis" + axis_or_nothing(reply.detail) + " has not been homed",
              "home the axes: umov device home"};
    case Refusal::outside_limits:
      return {"the position lies outside the limits of the axis" + axis_or_nothing(reply.detail),
              "change the plan, or the axis limits with umov device config set"};
    case Refusal::schema_mismatch:
      return {"it does not accept this program's protocol version",
              "flash the firmware of this release"};
    case Refusal::busy:
      return {"its axes are still moving", "wait, then repeat"};
    case Refusal::stale_program:
      return {"it has another program in memory", "resume the scan, which starts it anew"};
    case Refusal::not_stored:
      return {"it could not store that",
              "check its supply voltage and repeat; if it stays so, its flash memory is worn out"};
    case Refusal::no_reference:
      return {std::string(reference_problem(reply.detail)),
              "start the chopper and look at umov device info, or detect against the modulation "
              "output (reference_source internal)"};
  }
  return {"reason " + std::to_string(reply.code) + ", unknown to this program",
          "use the program release that fits the firmware"};
}

std::string compose_fault(std::uint8_t fault, const std::string& where) {
  return "controller in the safe state" + (where.empty() ? "" : " " + where) + ": " +
         fault_meaning(fault) + " [" + fault_name(fault) + "]";
}

}  // namespace

std::string fault_name(std::uint8_t fault) {
  if (fault < fault_texts.size()) return std::string(fault_texts[fault].name);
  return "fault " + std::to_string(fault);
}

std::string fault_meaning(std::uint8_t fault) {
  if (fault < fault_texts.size()) return std::string(fault_texts[fault].meaning);
  return "a fault this program does not know";
}

std::string fault_remedy(std::uint8_t fault) {
  if (fault < fault_texts.size()) return std::string(fault_texts[fault].remedy);
  return "use the program release that fits the firmware";
}

std::string fault_detail(std::uint8_t fault, std::int32_t detail) {
  switch (static_cast<protocol::Fault>(fault)) {
    case protocol::Fault::rolled_back:
      return roll_back_text(detail);
    case protocol::Fault::no_fallback:
      return detail == protocol::only_an_older_one ? "only an older image could be put back"
                                                   : "nothing could be put back";
    case protocol::Fault::internal:
      return detail == protocol::trial_not_confirmed ? "the image has proved itself, but flash "
                                                       "does not take the note: it stays on trial"
                                                     : std::to_string(detail);
    case protocol::Fault::reference_lost:
      return lost_reference_text(detail);
    default:
      return std::to_string(detail);
  }
}

std::string state_name(std::uint8_t state) {
  constexpr std::array<std::string_view, 8> names{
      "idle",   "homing",           "moving",           "scanning",
      "paused", "waiting_for_rows", "waiting_for_host", "safe"};
  static_assert(names.size() == static_cast<std::size_t>(protocol::State::safe) + 1);
  if (state < names.size()) return std::string(names[state]);
  return "state " + std::to_string(state);
}

std::string reference_state_name(std::uint8_t state) {
  constexpr std::array<std::string_view, 4> names{"absent", "unsteady", "out_of_range", "locked"};
  static_assert(names.size() == static_cast<std::size_t>(protocol::ReferenceState::locked) + 1);
  if (state < names.size()) return std::string(names[state]);
  return "state " + std::to_string(state);
}

std::string axis_name(int axis) {
  constexpr std::array<std::string_view, protocol::axis_count> names{
      "incidence", "detector", "azimuth", "polarizer", "analyzer", "filter"};
  if (axis >= 0 && axis < protocol::axis_count) {
    return std::string(names[static_cast<std::size_t>(axis)]);
  }
  return "axis " + std::to_string(axis);
}

Refused::Refused(const std::string& device, std::string_view request,
                 const protocol::ErrorReply& reply)
    : Error(Place{device},
            "the controller refuses " + std::string(request) + ": " + refusal_text(reply).problem,
            refusal_text(reply).remedy),
      refusal_(static_cast<protocol::Refusal>(reply.code)),
      detail_(reply.detail) {}

Faulted::Faulted(const std::string& device, std::uint8_t fault, const std::string& where)
    : Error(Place{device}, compose_fault(fault, where), fault_remedy(fault)),
      fault_(static_cast<protocol::Fault>(fault)) {}

}  // namespace umov::instrument
