// Samples by name or file.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "hil/plant/sample.hpp"

namespace umov::plant {

/// Names of the samples compiled into the library, sorted.
std::vector<std::string> sample_names();

/// One line on what a shipped sample is. Throws umov::Error listing the names for an unknown one.
std::string sample_title(const std::string& name);

/// A shipped sample by name, or a file by path: `.toml` (a sample file, see hil/plant/README.md) or
/// `.csv` (a BRDF table). Throws umov::Error for an unknown name, with the names; for a bad file,
/// with file and line.
std::unique_ptr<Sample> make_sample(const std::string& name_or_path);

/// A sample from the text of a sample file; `origin` names it in errors, and relative table paths
/// are taken from `folder`.
std::unique_ptr<Sample> sample_from_toml(std::string_view text, const std::string& origin,
                                         const std::string& folder = ".");

}  // namespace umov::plant
