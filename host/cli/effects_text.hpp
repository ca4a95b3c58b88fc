// The catalogue of effects that a diagnosis of a scan knows, on the terminal.
#pragma once

namespace umov::cli {

/// Name, stage, parameters with units, physics and source of every effect; as JSON where `json`.
void print_effects(bool json);

}  // namespace umov::cli
