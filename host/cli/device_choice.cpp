#include "host/cli/device_choice.hpp"

#include <algorithm>
#include <filesystem>

#include <CLI/CLI.hpp>

#include "host/cli/emulator/emulated_instrument.hpp"
#include "host/instrument/device_names.hpp"
#include "host/instrument/tcp_transport.hpp"

namespace umov::cli {

void add_plant_options(CLI::App& command, DeviceChoice& choice) {
  auto* group = command.add_option_group("emulated instrument");
  group->add_option("--sample", choice.sample,
                    "shipped sample (umov emulator --list) or sample file");
  group->add_option("--preset", choice.preset, "ideal or realistic")->capture_default_str();
  group->add_option("--plant", choice.plant_file, "TOML file of plant parameters");
  group->add_option("--plant-set", choice.plant_settings,
                    "one plant parameter, name=value (repeatable)");
}

void add_device_options(CLI::App& command, DeviceChoice& choice) {
  command.add_option("--device", choice.device, "emulator or tcp:HOST:PORT")->capture_default_str();
  add_plant_options(command, choice);
}

std::function<std::unique_ptr<instrument::Transport>()> connector(const DeviceChoice& choice,
                                                                  const std::string& plan_sample,
                                                                  std::uint64_t seed) {
  const auto device = instrument::parse_device_name(choice.device);
  if (device.kind == instrument::DeviceKind::tcp) {
    return [device] { return instrument::connect_tcp(device.host, device.port); };
  }
  emulator::BenchOptions bench;
  bench.sample = choice.sample.empty() ? plan_sample : choice.sample;
  if (choice.sample.empty()) std::replace(bench.sample.begin(), bench.sample.end(), ' ', '-');
  bench.preset = choice.preset;
  bench.plant_file = choice.plant_file;
  bench.settings = choice.plant_settings;
  bench.seed = seed;
  return [bench] { return emulator::make_embedded(bench); };
}

}  // namespace umov::cli
