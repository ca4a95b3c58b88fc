// Plans that studies measure, compiled into the program.
#pragma once

#include <string_view>

namespace umov::study {

/// Text of examples/campaign/NAME.toml or host/cli/study/plans/NAME.toml. Throws umov::Error for an
/// unknown name.
std::string_view embedded_plan(std::string_view name);

}  // namespace umov::study
