// The catalogue of effects that a diagnosis knows, on the terminal.
#pragma once

#include <vector>

#include "host/gap/engine/forward_model.hpp"

namespace umov::cli {

/// Those of a scan. Some parameters come once a wavelength; the list has those of a usual
/// instrument.
std::vector<gap::Effect> scan_effects();

/// Name, stage, parameters with units, physics and source of every effect; as JSON where `json`.
void print_effects(const std::vector<gap::Effect>& effects, bool json);

}  // namespace umov::cli
