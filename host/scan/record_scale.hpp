// From lock-in sums of the controller to volts.
#pragma once

#include "host/formats/journal.hpp"
#include "host/scan/plan.hpp"
#include "protocol/messages.hpp"

namespace umov::scan {

/// One scan record in volts referred to range 1, from the controller's sums and the row that was
/// commanded: amplitude = 2 · sum / (samples · sine amplitude) · ADC step / gain. The
/// monitor is its signed in-phase component; it has no ranges. `start_us` is the device time that
/// counts as 0 s.
formats::ScanRecord scaled(const protocol::Record& record, const PlanRow& row,
                           const protocol::HelloReply& device, double start_us);

}  // namespace umov::scan
