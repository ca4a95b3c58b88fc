// The emulated instrument: the firmware core on the native board, wired to the plant.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "boards/native/native_board.hpp"
#include "boards/native/world.hpp"
#include "hil/plant/plant.hpp"
#include "host/instrument/transport.hpp"

namespace umov::emulator {

/// What the emulated bench is like.
struct BenchOptions {
  std::string sample;                 ///< shipped sample by name, or a sample file
  std::string preset = "ideal";       ///< or "realistic"
  std::string plant_file;             ///< TOML of plant parameters; replaces the preset
  std::vector<std::string> settings;  ///< "parameter=value", applied last
  std::uint64_t seed = 1;             ///< of all its randomness
  /// Which time it is switched on (PlantSetup::session); the same bench every time.
  std::uint64_t session = 0;
};

/// Serial number of the emulated instrument, "EMU-" and 8 hex digits: the same for every start with
/// the same options (and file contents), another one for another bench, sample or seed. A scan is
/// resumed only on the instrument it was begun on.
std::string bench_serial(const BenchOptions& options);

/// The plant of these options. Throws umov::Error for an unknown sample, preset or parameter.
plant::PlantSetup plant_setup(const BenchOptions& options);

/// Board and plant together. Owns both; not thread-safe.
class EmulatedInstrument {
 public:
  /// `link_time_us` as in NativeBoardOptions. Throws umov::Error for an unknown sample, preset or
  /// parameter.
  explicit EmulatedInstrument(const BenchOptions& options,
                              std::function<std::uint64_t()> link_time_us = {});

  /// What a person at the instrument does, in settings as a `# block:` line has them:
  /// sample_azimuth_deg, iris_fraction, sample_removed, filter=long_pass, sample=NAME (another one
  /// on the stage). What is not named is as usual. Throws umov::Error for anything else.
  void arrange(const std::vector<std::pair<std::string, std::string>>& settings);

  boards::native::NativeBoard& board() { return *board_; }
  const boards::native::NativeBoard& board() const { return *board_; }
  plant::Plant& plant() { return *plant_; }
  const plant::Plant& plant() const { return *plant_; }

 private:
  std::shared_ptr<const plant::Sample> own_sample_;
  std::unique_ptr<plant::Plant> plant_;
  std::unique_ptr<boards::native::World> wiring_;
  std::unique_ptr<boards::native::NativeBoard> board_;
};

/// An instrument in this process whose virtual time passes while the host waits for bytes.
std::unique_ptr<instrument::Transport> make_embedded(const BenchOptions& options);
/// A connection to one that lives on when it ends; one at a time.
std::unique_ptr<instrument::Transport> connect_embedded(
    std::shared_ptr<EmulatedInstrument> instrument);

/// How `serve` runs.
struct ServeOptions {
  std::uint16_t port = 5025;  ///< 0 = any free one
  std::string address = "127.0.0.1";
  bool real_time = false;  ///< virtual time follows the wall clock instead of running ahead
  std::optional<std::uint16_t> gdb_port{};  ///< of an emulated chip: a debugger's; 0 = any free one
  std::function<void(std::uint16_t port)> on_listening;    ///< may be empty
  std::function<void(std::uint16_t port)> on_gdb;          ///< a debugger can come; may be empty
  std::function<void(const std::string& event)> on_event;  ///< may be empty
};

/// How `serve_usb` runs.
struct UsbOptions {
  bool gpio_adapter = false;  ///< also a MCP2221A, wired to BOOT0, NRST and the interlock
  bool into_kernel = false;   ///< plug it into this machine's kernel instead of serving USB/IP
  std::uint16_t port = 3240;  ///< of the USB/IP server; 0 = any free one
  std::string address = "127.0.0.1";
  bool real_time = false;                                  ///< as in ServeOptions
  std::optional<std::uint16_t> gdb_port{};                 ///< as in ServeOptions
  std::function<void(std::uint16_t port)> on_gdb;          ///< as in ServeOptions
  std::function<void(std::uint16_t port)> on_ready;        ///< port 0: plugged in; may be empty
  std::function<void(const std::string& event)> on_event;  ///< may be empty
};

/// Serves an instrument as a USB device on a virtual cable until `keep_going` says no. One that
/// somebody unplugs from this machine's kernel is plugged in again after a second. Program and
/// records survive.
void serve_usb(const BenchOptions& bench, const UsbOptions& options,
               const std::function<bool()>& keep_going);

/// Serves an instrument on TCP, one host at a time, until `keep_going` says no. Program and records
/// survive a host that goes away.
void serve(const BenchOptions& bench, const ServeOptions& options,
           const std::function<bool()>& keep_going);

}  // namespace umov::emulator
