// What records must hold for a diagnosis to be made of them.
#pragma once

#include "host/gap/scan/record.hpp"

namespace umov::gap::scan {

/// Refuses records that no diagnosis can be made of, before fits make something of them: too many
/// wavelengths, shutter closed throughout, saturated, no light, the same signal everywhere, too few
/// angles, θr with the wrong sign. What they cannot tell although a diagnosis can be made goes to
/// their notes. Throws umov::Error.
void require_substance(ScanRecords& all);

}  // namespace umov::gap::scan
