// --device and the options of the embedded emulator, shared by scan and device.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host/instrument/transport.hpp"

namespace CLI {
class App;
}

namespace umov::cli {

/// What the user said about the instrument. All but the first concern the embedded emulator only.
struct DeviceChoice {
  std::string device = "emulator";
  bool named = false;  ///< by --device
  std::string sample;  ///< empty: by the plan's sample name
  std::string preset = "ideal";
  std::string plant_file;
  std::vector<std::string> plant_settings;  ///< "key=value"
  /// Which of several scans on one bench: chance (noise, drift) differs between them, the bench and
  /// its speckle do not.
  std::uint64_t session = 0;
};

void add_device_options(CLI::App& command, DeviceChoice& choice);
/// Adds only what describes the emulated instrument.
void add_plant_options(CLI::App& command, DeviceChoice& choice);

/// Opens the pipe to that device each time it is called. `plan_sample` names the emulated sample
/// where --sample does not ("red gloss" = red-gloss).
std::function<std::unique_ptr<instrument::Transport>()> connector(const DeviceChoice& choice,
                                                                  const std::string& plan_sample,
                                                                  std::uint64_t seed);

/// An instrument for a whole run: connections, and the hand at it where the program itself has one.
struct Instrument {
  std::function<std::unique_ptr<instrument::Transport>()> connect;
  /// Changes the set-up of the embedded emulator (EmulatedInstrument::arrange); empty for others.
  std::function<void(const std::vector<std::pair<std::string, std::string>>& settings)> arrange;
};

/// As `connector`, but the embedded emulator lives on from connection to connection.
Instrument choose_instrument(const DeviceChoice& choice, const std::string& plan_sample,
                             std::uint64_t seed);

}  // namespace umov::cli
