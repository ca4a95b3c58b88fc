#include "protocol/tools/description.hpp"

#include <cstdio>
#include <string>
#include <type_traits>

#include "protocol/frame.hpp"
#include "protocol/requests.hpp"
#include "protocol/schema.hpp"

namespace umov::protocol {
namespace {

std::string hex(std::uint64_t value, int digits) {
  char text[24];
  std::snprintf(text, sizeof text, "0x%0*llX", digits, static_cast<unsigned long long>(value));
  return text;
}

template <class Member>
std::string type_name() {
  using Shape = FieldShape<Member>;
  using Element = typename Shape::Element;
  std::string name;
  if constexpr (std::is_same_v<Element, char>) {
    name = "char";
  } else {
    name = std::string(std::is_signed_v<Element> ? "i" : "u") + std::to_string(8 * sizeof(Element));
  }
  if (Shape::is_array) name += "[" + std::to_string(Shape::count) + "]";
  return name;
}

std::string range_text(std::int64_t min, std::int64_t max) {
  return min < max ? std::to_string(min) + " … " + std::to_string(max) : "any";
}

template <class M>
std::string answer_text() {
  if constexpr (Request<M>) {
    return " Answered by `" + std::string(ReplyTo<M>::info.name) + "` or `error_reply`" +
           (AnswerTo<M>::repeatable ? "; may be repeated." : "; not repeated blindly.");
  } else {
    return {};
  }
}

template <class M>
std::string message_section() {
  std::string text = "### " + hex(M::info.id, 2) + " `" + std::string(M::info.name) + "` (" +
                     (M::info.sender == Sender::host ? "host → device" : "device → host") + ", " +
                     std::to_string(wire_size<M>) + " bytes)\n\n" + std::string(M::info.doc) +
                     answer_text<M>() + "\n\n";
  text += "| offset | type | field | unit | range | meaning |\n|---|---|---|---|---|---|\n";
  std::size_t offset = 0;
  for_each_field<M>([&]<class Member>(const Field<M, Member>& declared) {
    text += "| " + std::to_string(offset) + " | " + type_name<Member>() + " | `" +
            std::string(declared.name) + "` | " + std::string(declared.unit) + " | " +
            range_text(declared.min, declared.max) + " | " + std::string(declared.doc) + " |\n";
    offset += field_size<Member>;
  });
  return text + "\n";
}

/// "0 none, 1 interlock, …" from names in the order of an enumeration.
template <std::size_t N>
std::string enumerated(const char* const (&names)[N]) {
  std::string text;
  for (std::size_t i = 0; i < N; ++i) {
    text += (i == 0 ? "" : ", ") + std::to_string(i) + " " + names[i];
  }
  return text;
}

std::string enumeration_section() {
  static constexpr const char* axes[] = {"incidence", "detector", "azimuth",
                                         "polarizer", "analyzer", "filter"};
  static_assert(std::size(axes) == axis_count);
  static constexpr const char* faults[] = {"none",
                                           "interlock",
                                           "emergency_stop",
                                           "limit",
                                           "stall",
                                           "link_lost",
                                           "watchdog",
                                           "brown_out",
                                           "adc_overrun",
                                           "missed_deadline",
                                           "not_homed",
                                           "internal",
                                           "settings_corrupt",
                                           "over_temperature",
                                           "rolled_back",
                                           "no_fallback",
                                           "reference_lost"};
  static_assert(std::size(faults) == static_cast<std::size_t>(Fault::reference_lost) + 1);
  static constexpr const char* states[] = {
      "idle",   "homing",           "moving",           "scanning",
      "paused", "waiting_for_rows", "waiting_for_host", "safe"};
  static_assert(std::size(states) == static_cast<std::size_t>(State::safe) + 1);
  static constexpr const char* refusals[] = {
      "none",          "unknown_message", "bad_length",     "out_of_range",    "wrong_state",
      "fault_active",  "not_homed",       "outside_limits", "schema_mismatch", "busy",
      "stale_program", "not_stored",      "no_reference"};
  static_assert(std::size(refusals) == static_cast<std::size_t>(Refusal::no_reference) + 1);
  static constexpr const char* sources[] = {"internal", "external"};
  static_assert(std::size(sources) == static_cast<std::size_t>(ReferenceSource::external) + 1);
  static constexpr const char* references[] = {"absent", "unsteady", "out_of_range", "locked"};
  static_assert(std::size(references) == static_cast<std::size_t>(ReferenceState::locked) + 1);
  return "## Enumerations\n\n- Axis: " + enumerated(axes) + "\n- Fault: " + enumerated(faults) +
         "\n- State: " + enumerated(states) + "\n- Refusal: " + enumerated(refusals) +
         "\n- ReferenceSource: " + enumerated(sources) +
         "\n- ReferenceState: " + enumerated(references) +
         "\n- Gain request: 0 … 3 = range 1, 10, 100, 1000; 255 = automatic\n"
         "- Polariser or analyser position −2147483648: element moved out of the beam (open)\n\n";
}

}  // namespace

std::string describe_protocol() {
  std::string text =
      "# The Umov protocol\n\n"
      "Written by `umov_protocol_doc` from the declarations in `messages.hpp`; do not edit by "
      "hand.\n\n"
      "Version " +
      std::to_string(protocol_version) + ", schema hash `" + hex(schema_hash, 16) +
      "`. The same bytes travel over every pipe (TCP, USB, HID reports, UART).\n\n"
      "## Frames\n\n"
      "```\n"
      "raw frame   = type u8 | sequence u16 | payload, 0 to " +
      std::to_string(max_payload_size) +
      " bytes | CRC-32C u32 of all before it\n"
      "on the wire = COBS(raw frame) | 0x00\n"
      "```\n"
      "- Integers are little-endian, two's complement, without padding. Texts are UTF-8 padded "
      "with zeros.\n"
      "- CRC-32C: polynomial 0x1EDC6F41 reflected (0x82F63B78), initial value and final "
      "exclusive-or "
      "0xFFFFFFFF; \"123456789\" gives 0xE3069283.\n"
      "- COBS: a code byte c, then c − 1 bytes other than 0; they stand for themselves and, unless "
      "c = 255 or "
      "the frame ends, a following 0.\n"
      "- No frame says how long it is: after any damage the next 0x00 starts afresh. A lone 0x00 "
      "is an empty "
      "frame and means nothing; it pads HID reports.\n"
      "- The largest frame has " +
      std::to_string(max_raw_frame_size) + " bytes raw, " + std::to_string(max_wire_frame_size) +
      " on the wire. Longer ones, bad CRCs and broken stuffing are dropped and counted.\n"
      "- A receiver refuses a payload whose length is not the message's, and a field outside its "
      "range.\n"
      "- The schema hash is FNV-1a (64 bit) over version and over every message's type, name, "
      "sender and "
      "fields (name, element size, kind, count, unit, range), strings ended by 0, numbers as eight "
      "bytes.\n\n";
  text += describe_session_and_streams() + "\n" + enumeration_section() + "## Messages\n\n";
  for_each_message([&]<class M>() { text += message_section<M>(); });
  while (text.ends_with("\n\n")) text.pop_back();
  return text;
}

}  // namespace umov::protocol
