// Runs a plan on a controller: journal first, acknowledge after, scan.h5 at the end.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "host/instrument/transport.hpp"
#include "host/scan/arrangement.hpp"
#include "host/scan/plan.hpp"

namespace umov::scan {

/// Where a running scan stands.
struct RunProgress {
  std::uint32_t done = 0;   ///< records that are safe or about to be
  std::uint32_t total = 0;  ///< rows of the plan
  std::string note;         ///< what the instrument does besides measuring ("homing …")
};

struct RunOptions {
  std::filesystem::path output;  ///< scan.h5; the journal lies beside it
  bool resume = false;           ///< go on from the journal
  bool overwrite = false;        ///< replace what an earlier scan left
  std::string program;           ///< name and version, for provenance
  std::string command;           ///< command line, for provenance
  /// Opens the pipe to the controller; called again after a lost link.
  std::function<std::unique_ptr<instrument::Transport>()> connect;
  std::function<void(const RunProgress&)> progress;  ///< may be empty
  std::function<void(const std::string&)> tell;      ///< what the user should know of; may be empty
  std::function<bool()> keep_going;                  ///< false: stop and keep what is there
  /// Changes the set-up for blocks that need it, and undoes it; empty: such plans are refused.
  Arranger arrange;
  Arrangement standing;  ///< what every row of the plan needs besides (ScanPart)
  int reconnects = 25;   ///< tries after a lost link: some twelve seconds
  std::chrono::milliseconds reconnect_wait{250};  ///< before the first; then 500 ms at most
};

struct RunSummary {
  bool complete = false;
  std::uint32_t records = 0;       ///< in the file
  std::uint32_t total = 0;         ///< rows of the plan
  std::uint32_t resumed_from = 0;  ///< records that were there before
  int lost_links = 0;              ///< that were taken up again
  std::uint64_t saturated = 0;     ///< records with clipped samples
  double instrument_time_s = 0;    ///< time of the last record
};

/// Path of the journal that belongs to a scan file.
std::filesystem::path journal_path(const std::filesystem::path& output);

/// Measures every row of the plan once and writes `output`. When stopped early (keep_going, a
/// fault, a link that stays lost) `output` holds what was measured so far (no file when that is
/// nothing) and the journal stays, so that a run with `resume` finishes it. keep_going is obeyed
/// while homing and while a lost link is retried, too; then `complete` is false.
/// Where the set-up changes, the program is cut: the controller rests in the dark, `arrange` is
/// asked, and the next rows begin after it. A resumed scan asks again for the set-up it was
/// interrupted in, and so does a controller that was restarted meanwhile.
/// Throws umov::Error: output exists, journal of another plan or instrument, plan the device can't
/// do, fault, a set-up that nobody is there to change.
RunSummary run_scan(const Plan& plan, const RunOptions& options);

}  // namespace umov::scan
