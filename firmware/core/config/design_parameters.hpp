// Timing and size constants of the controller, each with its reason.
#pragma once

#include <array>
#include <cstdint>

#include "protocol/messages.hpp"

namespace umov::firmware {

/// Step timers: 84 MHz / 21. At 200,000 steps/s an interval is 20 ticks.
inline constexpr std::uint32_t step_timer_hz = 4'000'000;
/// Shortest interval between two steps of an axis: 500,000 steps/s, the drivers' limit.
inline constexpr std::uint32_t shortest_step_ticks = 8;
/// Slower than 50 steps/s a motor stops within a step: no ramp needed.
inline constexpr std::uint32_t crawl_ticks = step_timer_hz / 50;
/// Time the core takes to plan a stop while steps go on.
inline constexpr std::uint32_t stop_planning_ticks = step_timer_hz / 2000;

/// From a step that meets a limit switch until the axis slows down: a tick in which that is
/// noticed, half a millisecond to plan, and as much for a tick that comes late.
inline constexpr std::uint64_t stop_delay_us = 2'000;

inline constexpr std::uint32_t sample_rate_hz = 100'000;
/// Clock of the edges of an external reference: a tick is 7e-4 rad at 20 kHz; 32 bits of it last
/// 25 s.
inline constexpr std::uint32_t reference_clock_hz = 168'000'000;
inline constexpr std::uint32_t reference_ticks_per_sample = reference_clock_hz / sample_rate_hz;
static_assert(reference_ticks_per_sample * sample_rate_hz == reference_clock_hz);
/// Frequencies of an external reference: those of the modulation and a hundredth more, so that one
/// at the end of the range is not lost for its jitter.
inline constexpr std::uint32_t lowest_reference_mhz = 9'900;
inline constexpr std::uint32_t highest_reference_mhz = 20'200'000;
inline constexpr std::uint16_t adc_codes = 4096;
inline constexpr int adc_middle = 2048;
/// 3.3 V over 4096 codes.
inline constexpr std::uint32_t adc_step_nv = 805'664;
inline constexpr std::array<std::uint16_t, 4> gains = {1, 10, 100, 1000};
inline constexpr std::array<std::uint16_t, 3> wavelengths_nm = {532, 633, 814};
inline constexpr std::array<std::uint16_t, 6> filter_od_milli = {0, 1000, 2000, 3000, 4000, 5000};

/// Rows and records held. With 32 ms a row, 128 rows bridge a host that is busy for 4 s.
inline constexpr std::uint32_t row_capacity = 128;
inline constexpr std::uint32_t record_capacity = 192;

/// A program that waits for rows or for room waits in the light for so long, then in the dark: long
/// enough for every hitch of a host, which would cost a laser's settling.
inline constexpr std::uint64_t lit_wait_us = 1'000'000;

/// Room in the transmit buffer that is left to replies: eight of the longest.
inline constexpr std::uint32_t reply_reserve_bytes = 1100;
/// A frame must come within this time of the link's clock while a program runs or a laser is on.
inline constexpr std::uint64_t link_timeout_us = 3'000'000;
/// Records sent and not acknowledged are sent again after this time of the link's clock.
inline constexpr std::uint64_t record_resend_us = 2'000'000;
/// Records put into frames at a time: 0.2 ms of work, after which a board can look at its link
/// again.
inline constexpr int records_per_turn = 4;
/// Unanswered row credit is repeated after this time of the link's clock.
inline constexpr std::uint64_t credit_resend_us = 100'000;
/// New credit is told when this many rows have been taken or freed.
inline constexpr std::uint32_t credit_batch = row_capacity / 4;
/// A limit switch that has been released for so many ticks is pressed anew when it closes; before,
/// it bounces.
inline constexpr std::uint8_t limit_release_ticks = 20;
/// A step later than this may not have been followed by its motor: 20 us, four intervals at
/// 200,000 steps/s.
inline constexpr std::uint32_t late_step_ticks = step_timer_hz / 50'000;
/// The tick comes each millisecond; later than this and a deadline was missed.
inline constexpr std::uint64_t tick_limit_us = 20'000;

/// Defaults of the lock-in (set_lockin changes them). 1 kHz is 100 samples a period.
inline constexpr protocol::SetLockin default_lockin{.reference_mhz = 1'000'000,
                                                    .harmonic = 1,
                                                    .phase_udeg = 0,
                                                    .settle_ms = 20,
                                                    .blocks = 10,
                                                    .source = 0};

/// Static RAM the core may take; the board's own buffers and stacks share the 64 KB with it.
inline constexpr std::uint32_t ram_budget_bytes = 40 * 1024;

}  // namespace umov::firmware
