// Bringing a controller into the state that a scan program starts from.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "host/instrument/session.hpp"
#include "host/scan/plan.hpp"

namespace umov::scan {

struct PreparationOptions {
  std::uint32_t program_id = 0;
  bool discard_records = false;  ///< of another scan, that the controller still holds
  std::function<bool()> wanted;  ///< false: the scan was called off
  std::function<void(const std::string& what)> note;  ///< what takes time ("homing"); may be empty
  std::function<void()> link_lost_cleared;  ///< told when that fault was cleared; may be empty
};

/// Brings an idle controller into the state that the plan needs (faults of a lost link cleared,
/// another host's program ended, axes homed, lock-in set); leaves one alone that runs this program.
/// False when the scan was called off meanwhile. Throws umov::Error: a latched fault, records of
/// another scan, a controller that does not come to rest.
bool prepare_controller(instrument::Session& session, const Plan& plan,
                        const PreparationOptions& options);

}  // namespace umov::scan
