// The scans that a diagnosis asks for, taken and diagnosed together with what was there.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "host/cli/command.hpp"
#include "host/cli/device_choice.hpp"
#include "host/formats/scan_table.hpp"
#include "host/gap/answer/diagnosis_json.hpp"
#include "host/gap/scan/diagnose_scan.hpp"

namespace CLI {
class App;
}

namespace umov::cli {

struct FollowUpOptions {
  std::string device;       ///< emulator or tcp:HOST:PORT; empty: no further scans
  DeviceChoice instrument;  ///< what the emulated one is like
  int rounds = 2;           ///< at most
  std::string keep;         ///< folder of the further scans; empty: beside the first scan
};

/// A further scan that was taken, or why it was not.
struct FollowUps {
  std::vector<gap::FollowUpRound> rounds;
  std::string ended;  ///< a sentence where a prescribed scan was not taken; else empty
};

void add_follow_up_options(CLI::App& command, FollowUpOptions& options);

/// Takes the prescribed scan as `scan.next-1.h5` (its plan beside it as TOML) and diagnoses anew,
/// for as long as something is ambiguous, a scan is prescribed and rounds are left. `files`,
/// `scans` and `result` grow with it. A scan that is there already, as far as it got, is gone on
/// with. A set-up that the program can't change is asked for at a terminal; without one the round
/// is not taken, and `ended` says what to do. Throws umov::Error where the instrument is another
/// one than the first scan's, Interrupted after Ctrl-C.
FollowUps take_follow_ups(const FollowUpOptions& options, const Common& common,
                          std::vector<std::string>& files, std::vector<formats::ScanTable>& scans,
                          gap::scan::ScanDiagnosis& result,
                          const std::function<gap::scan::ScanDiagnosis()>& diagnose);

}  // namespace umov::cli
