// The state of a long simulation in a file, from which it goes on.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace umov::surface {

/// trace::Result::state() of each angle that has been begun, in order.
using RunState = std::vector<std::vector<double>>;

/// `run` says in any words what is simulated; a state is only taken up by the same words. Written
/// beside the target, then renamed: a crash leaves the older state. Throws umov::Error.
void save_state(const std::filesystem::path& path, const std::string& run, const RunState& state);

/// Throws umov::Error for a file that is missing, damaged, or of another run.
RunState load_state(const std::filesystem::path& path, const std::string& run);

}  // namespace umov::surface
