#include "host/cli/device_session.hpp"

#include <charconv>
#include <system_error>

#include "host/instrument/refusals.hpp"

namespace umov::cli {

instrument::Session open_session(const DeviceChoice& device, const Common& common) {
  return instrument::Session(connector(device, "white-99", common.seed)());
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
