// How soon a controller locks on an external reference, and how well it holds it: measured through
// its protocol, on any rig of trouble_rigs.hpp.
#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>

#include "host/instrument/refusals.hpp"
#include "tests/unit/mcu_board/scan_run.hpp"
#include "tests/unit/mcu_board/trouble_rigs.hpp"
#include "tests/unit/outside_reference.hpp"

namespace umov::test {

inline protocol::SetLockin external_lockin() {
  return {.reference_mhz = 1'000'000,
          .harmonic = 1,
          .phase_udeg = 0,
          .settle_ms = 0,
          .blocks = 10,
          .source = static_cast<std::uint8_t>(protocol::ReferenceSource::external)};
}

/// Measures where the axes stand.
inline protocol::ProgramRow still_row(std::uint32_t index, std::uint16_t dwell_ms) {
  return {.index = index,
          .target_udeg = {},
          .laser = 1,
          .shutter_open = 1,
          .gain = 0,
          .dwell_ms = dwell_ms};
}

/// Periods from the first edge at the input to the lock, by asking for the status.
template <class Rig>
double periods_to_lock(OutsideReference reference) {
  Rig rig;
  instrument::Session session(rig.connect());
  // The boards look each millisecond whether a reference has been switched on: it turns later.
  reference.starts_s = rig.now_s() + 0.005;
  rig.stages().reference = reference;
  const double first_s = reference.next_edge_s(0);
  constexpr auto locked = static_cast<std::uint8_t>(protocol::ReferenceState::locked);
  while (rig.now_s() < first_s + 100 / reference.frequency_hz) {
    const auto status = session.request(protocol::GetStatus{});
    const double at_s = static_cast<double>(status.time_us) * 1e-6;
    if (status.reference_state == locked) return (at_s - first_s) * reference.frequency_hz;
    rig.run_for(20);
  }
  return 1e9;
}

/// Phase of records against light whose phase is known.
struct Hold {
  double mean_rad = 0;
  double rms_rad = 0;  ///< about the mean
  int records = 0;
};

/// Records of eight periods, shorter than the loop remembers, so that they do not average its
/// errors away; at least 5 ms, which keeps the ADC's noise below 1e-5 rad.
template <class Rig>
Hold hold(const OutsideReference& reference, int records_wanted) {
  Rig rig;
  rig.stages().reference = reference;
  instrument::Session session(rig.connect());
  home_all(session);
  session.request(external_lockin());
  const auto dwell_ms =
      static_cast<std::uint16_t>(std::max(5.0, std::ceil(8000 / reference.frequency_hz)));
  Records records;
  instrument::ProgramStream stream(
      {.program_id = 5, .row_count = static_cast<std::uint32_t>(records_wanted)},
      [&](std::uint32_t index) { return still_row(index, dwell_ms); }, records);
  stream.run(session);
  Hold result{.records = static_cast<int>(records.all.size())};
  double squares = 0;
  for (const auto& r : records.all) {
    const double phase =
        std::atan2(static_cast<double>(r.signal_y), static_cast<double>(r.signal_x));
    result.mean_rad += phase / result.records;
    squares += phase * phase / result.records;
  }
  result.rms_rad = std::sqrt(std::max(0.0, squares - result.mean_rad * result.mean_rad));
  return result;
}

}  // namespace umov::test
