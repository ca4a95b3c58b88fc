// Changes of the set-up that take a hand at the instrument: what a block needs, and where a scan is
// cut for it.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/formats/scan_table.hpp"
#include "host/scan/plan.hpp"

namespace umov::scan {

/// How the instrument is set up beyond what the controller moves: settings of a `# block:` line
/// (`sample_azimuth_deg`, `iris_fraction`, `filter`, `sample_removed`), and `sample` where another
/// one lies on the stage. None: plain, as the main block is taken.
struct Arrangement {
  std::vector<std::pair<std::string, std::string>> settings;

  bool plain() const { return settings.empty(); }
  /// Text of a setting; nullptr where it is as usual.
  const std::string* find(std::string_view key) const;
  /// "sample_azimuth_deg=180", "plain" for none.
  std::string text() const;
  bool operator==(const Arrangement&) const = default;
};

/// What of a block's settings the controller can't bring about by itself.
Arrangement arrangement_of(const formats::Block& block);

/// Consecutive rows taken in one arrangement.
struct Stretch {
  std::uint32_t first = 0, end = 0;  ///< rows first … end - 1
  std::string blocks;                ///< names of the blocks, "flip" or "main, reverse"
  Arrangement arrangement;
};

/// The program cut where the set-up changes; never empty. `standing` holds for every row besides.
std::vector<Stretch> stretches(const Program& program, const Arrangement& standing);

/// Throws umov::Error where a stretch needs a hand at the instrument: for runs that nobody attends.
/// `plan` names the plan in the message.
void require_plain(const std::vector<Stretch>& all, const std::string& plan);

/// One request to whoever stands at the instrument.
struct ArrangementRequest {
  Arrangement wanted;
  std::optional<Arrangement> present;  ///< nullopt: not known, as a scan was interrupted
  std::string blocks;                  ///< for which blocks; empty: afterwards, to undo it
};

/// Brings the instrument into `wanted` and returns when that is done; false: the scan was called
/// off instead. The controller is dark and at rest meanwhile. May throw umov::Error.
using Arranger = std::function<bool(const ArrangementRequest&)>;

/// What to do, one sentence each: "Turn the sample by 180 deg about its normal." Empty where
/// nothing changes.
std::vector<std::string> instructions(const ArrangementRequest& request);

}  // namespace umov::scan
