// A plan's rows in the units of the controller.
#pragma once

#include <cstdint>

#include "host/instrument/session.hpp"
#include "host/scan/plan.hpp"
#include "protocol/messages.hpp"

namespace umov::scan {

/// One row as the controller wants it. Throws umov::Error for a wavelength, amplifier range or
/// optical density that the device does not have, naming those it has.
protocol::ProgramRow program_row(const PlanRow& row, std::uint32_t index,
                                 const protocol::HelloReply& device);

/// Refuses a plan that this instrument can't do, before anything moves or is written: every row is
/// held against the device's lasers, ranges, filters and axis limits. Throws umov::Error.
void check_against_device(const Plan& plan, const Program& program, instrument::Session& session);

}  // namespace umov::scan
