#include "host/cli/device_session.hpp"

#include <charconv>
#include <chrono>
#include <system_error>

#include "host/cli/interrupt.hpp"
#include "host/instrument/program_control.hpp"
#include "host/instrument/refusals.hpp"

namespace umov::cli {
namespace {

/// Longest move of one axis, and longest search for its home switch.
constexpr std::chrono::seconds axis_limit{120};

}  // namespace

instrument::Session open_session(const DeviceChoice& device, const Common& common) {
  if (!device.named && !common.quiet) {
    fmt::print(stderr,
               "no --device given: this is an emulated controller, which ends with this command "
               "(umov device list shows what is plugged in)\n");
  }
  return instrument::Session(connector(device, "white-99", common.seed)());
}

void let_work(instrument::Session& session) {
  session.poll(std::chrono::milliseconds(50));
  while (session.next_event()) {
  }
}

void wait_until_arrived(instrument::Session& session, int axes) {
  const auto limit = axes * axis_limit;
  const auto deadline = session.clock_us() + instrument::to_us(limit);
  for (;;) {
    let_work(session);
    const auto status = session.request(protocol::GetStatus{});
    if (status.fault != 0) throw instrument::Faulted(session.name(), status.fault, "while moving");
    const auto state = static_cast<protocol::State>(status.state);
    if (state == protocol::State::idle || state == protocol::State::paused) return;
    if (interrupt_flag().load()) {
      session.request(protocol::Stop{});
      throw Interrupted("stopped; the axes brake where they are");
    }
    if (session.clock_us() >= deadline) {
      session.request(protocol::Stop{});
      throw Error({session.name()},
                  fmt::format("the controller is still {} after {} s",
                              instrument::state_name(status.state), limit.count()),
                  "it was told to stop; look at its axes and repeat the command");
    }
  }
}

std::uint8_t axis_by_name(const std::string& name) {
  for (int axis = 0; axis < protocol::axis_count; ++axis) {
    if (instrument::axis_name(axis) == name) return static_cast<std::uint8_t>(axis);
  }
  throw Error(fmt::format("there is no axis '{}'", name),
              "axes are incidence, detector, azimuth, polarizer, analyzer, filter");
}

double finite_number(const std::string& text, const std::string& what, const char* remedy) {
  const char* first = text.data();
  const char* end = first + text.size();
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') ++first;
  double value = 0;
  const auto [last, error] = std::from_chars(first, end, value);
  if (error != std::errc() || last != end || !std::isfinite(value)) {
    throw Error(fmt::format("'{}' is not {}", text, what), remedy);
  }
  return value;
}

}  // namespace umov::cli
