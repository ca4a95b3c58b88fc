// Setting one plant parameter by name, for the readers of files and command lines.
#pragma once

#include <string_view>

#include "hil/plant/plant_config.hpp"
#include "host/errors/error.hpp"

namespace umov::plant {

/// Throws umov::Error at `place` for an unknown name (telling the nearest one) or a value out of
/// range.
void set_parameter(PlantConfig& config, std::string_view name, double value, const Place& place);

}  // namespace umov::plant
