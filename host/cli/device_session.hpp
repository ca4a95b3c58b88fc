// What the subcommands of `umov device` share: opening a session, names of axes, numbers as the
// user writes them.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <type_traits>

#include <fmt/format.h>

#include "host/cli/command.hpp"
#include "host/cli/device_choice.hpp"
#include "host/errors/error.hpp"
#include "host/instrument/session.hpp"

namespace umov::cli {

/// Says on stderr when it is the embedded emulator only because no device was named.
instrument::Session open_session(const DeviceChoice& device, const Common& common);

/// Lets the controller work for a moment; events are forgotten.
void let_work(instrument::Session& session);

/// Until the axes stand: idle, or paused where a program waits. Ctrl-C brakes them (Interrupted).
/// `axes`: how many may move one after the other. Throws Faulted, umov::Error when it takes too
/// long.
void wait_until_arrived(instrument::Session& session, int axes);

/// Number of the axis of that name. Throws umov::Error that lists the axes.
std::uint8_t axis_by_name(const std::string& name);

/// The whole of `text` as a finite number; `what` names it in the message of umov::Error.
double finite_number(const std::string& text, const std::string& what, const char* remedy);

/// `value` in units of 1/scale, for a field of the controller. INT32_MIN is no number there.
/// Throws umov::Error with the range where the field cannot hold it.
template <class Integer>
Integer scaled_integer(double value, double scale, const std::string& name) {
  constexpr auto most = std::numeric_limits<Integer>::max();
  const double least = std::is_signed_v<Integer> ? -static_cast<double>(most) : 0.0;
  const double scaled = std::round(scale * value);
  if (!(scaled >= least && scaled <= static_cast<double>(most))) {
    throw Error(fmt::format("{} = {:g} is out of range", name, value),
                fmt::format("give {:g} to {:g}", least / scale, static_cast<double>(most) / scale));
  }
  return static_cast<Integer>(scaled);
}

}  // namespace umov::cli
