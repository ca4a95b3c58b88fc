#include "host/cli/device_choice.hpp"

#include <algorithm>
#include <filesystem>

#include <CLI/CLI.hpp>

#include "host/cli/emulator/emulated_instrument.hpp"
#include "host/instrument/device_names.hpp"
#include "host/instrument/hid_transport.hpp"
#include "host/instrument/serial_transport.hpp"
#include "host/instrument/tcp_transport.hpp"
#include "host/instrument/usb_transport.hpp"

namespace umov::cli {
namespace {

/// Plans call a sample "red gloss", the emulator's catalogue red-gloss.
std::string catalogue_name(std::string name) {
  std::replace(name.begin(), name.end(), ' ', '-');
  return name;
}

}  // namespace

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
  command
      .add_option("--device", choice.device,
                  "emulator, usb[:SERIAL], hid[:SERIAL], serial:PATH[?baud=N] or tcp:HOST:PORT")
      ->each([&choice](const std::string&) { choice.named = true; })
      ->capture_default_str();
  add_plant_options(command, choice);
}

std::function<std::unique_ptr<instrument::Transport>()> connector(const DeviceChoice& choice,
                                                                  const std::string& plan_sample,
                                                                  std::uint64_t seed) {
  return choose_instrument(choice, plan_sample, seed).connect;
}

Instrument choose_instrument(const DeviceChoice& choice, const std::string& plan_sample,
                             std::uint64_t seed) {
  const auto device = instrument::parse_device_name(choice.device);
  if (device.kind == instrument::DeviceKind::tcp) {
    return {[device] { return instrument::connect_tcp(device.host, device.port); }, {}};
  }
  if (device.kind == instrument::DeviceKind::usb) {
    return {[device] { return instrument::connect_usb(device.serial); }, {}};
  }
  if (device.kind == instrument::DeviceKind::hid) {
    return {[device] { return instrument::connect_hid(device.serial); }, {}};
  }
  if (device.kind == instrument::DeviceKind::serial) {
    return {[device] { return instrument::connect_serial_line(device.path, device.baud); }, {}};
  }
  emulator::BenchOptions bench;
  bench.sample = choice.sample.empty() ? catalogue_name(plan_sample) : choice.sample;
  bench.preset = choice.preset;
  bench.plant_file = choice.plant_file;
  bench.settings = choice.plant_settings;
  bench.seed = seed;
  bench.session = choice.session;
  // Started with the first connection: what is wrong with it is then told like any other refusal.
  const auto running = std::make_shared<std::shared_ptr<emulator::EmulatedInstrument>>();
  const auto instrument = [bench, running] {
    if (!*running) *running = std::make_shared<emulator::EmulatedInstrument>(bench);
    return *running;
  };
  return {[instrument] { return emulator::connect_embedded(instrument()); },
          [instrument](auto settings) {
            for (auto& [key, value] : settings)
              if (key == "sample") value = catalogue_name(value);
            instrument()->arrange(settings);
          }};
}

}  // namespace umov::cli
