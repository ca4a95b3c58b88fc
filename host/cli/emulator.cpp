// umov emulator: an instrument without hardware, on TCP or a virtual USB cable; and what there is
// to put on its stage.
#include <memory>
#include <string>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "hil/plant/parameter_list.hpp"
#include "hil/plant/sample_catalog.hpp"
#include "host/cli/command.hpp"
#include "host/cli/device_choice.hpp"
#include "host/cli/emulator/emulated_instrument.hpp"
#include "host/cli/emulator/truth.hpp"
#ifdef UMOV_EMULATED_BOARD
#include "host/cli/emulator/mcu/serve_image.hpp"
#endif
#include "host/cli/interrupt.hpp"
#include "host/cli/output_file.hpp"
#include "host/errors/error.hpp"

namespace umov::cli {
namespace {

struct Options {
  DeviceChoice plant;
  std::uint16_t port = 0;
  bool usb = false;
  bool plug_in = false;
  bool gpio_adapter = false;
  std::string address = "127.0.0.1";
  std::string image;
  std::string boot_loader;
  int gdb_port = -1;
  bool real_time = false;
  bool list = false;
  bool parameters = false;
  std::string describe;
  std::string certificate;
  std::string output;
};

void list_samples(const Common& common) {
  if (common.json) {
    nlohmann::json out = nlohmann::json::array();
    for (const auto& name : plant::sample_names()) {
      out.push_back({{"sample", name}, {"about", plant::sample_title(name)}});
    }
    fmt::print("{}\n", out.dump());
    return;
  }
  for (const auto& name : plant::sample_names())
    fmt::print("{:<18} {}\n", name, plant::sample_title(name));
}

/// The true parameters of a sample: what an inversion should find.
void describe(const std::string& name, const Common& common) {
  const auto sample = plant::make_sample(name);
  nlohmann::json out{{"sample", name}, {"wavelengths_nm", plant::laser_names}};
  nlohmann::json parameters = nlohmann::json::object();
  for (const int wavelength_nm : plant::laser_names) {
    for (const auto& truth : sample->truth(wavelength_nm)) {
      parameters[truth.name]["unit"] = truth.unit;
      parameters[truth.name]["value"].push_back(truth.value);
    }
  }
  out["parameters"] = parameters;
  if (common.json) {
    fmt::print("{}\n", out.dump());
    return;
  }
  fmt::print("{:<18}", name);
  for (const int wavelength_nm : plant::laser_names) fmt::print("{:>9} nm", wavelength_nm);
  fmt::print("\n");
  for (const auto& [key, parameter] : parameters.items()) {
    fmt::print("{:<18}", key);
    for (const auto& value : parameter["value"]) fmt::print("{:>12.5g}", value.get<double>());
    fmt::print("  {}\n", parameter["unit"].get<std::string>());
  }
}

/// What `umov calibrate --reference-brdf` reads for a standard that is not Lambertian.
void write_certificate(const std::string& name, const std::string& path) {
  require_product_output({name}, path);
  emulator::write_certificate(name, path);
}

/// One line on stdout when hosts can come.
void announce(const std::string& line, const Common& common) {
  if (common.quiet) return;
  fmt::print("{}\n", line);
  std::fflush(stdout);
}

#ifndef UMOV_EMULATED_BOARD
[[noreturn]] void refuse_image() {
  throw Error("this program was built without the emulated controller board",
              "install libunicorn-dev and build again, or leave --image out");
}
#endif

/// For ServeOptions and UsbOptions alike.
template <class ServeOptions>
void offer_debugger(const Options& options, const Common& common, ServeOptions& serve_options) {
  if (options.gdb_port < 0) return;
  if (options.image.empty())
    throw Error("only an emulated chip can be debugged", "add --image ELF");
  serve_options.gdb_port = static_cast<std::uint16_t>(options.gdb_port);
  serve_options.on_gdb = [&](std::uint16_t port) {
    announce(fmt::format("debugger: target remote localhost:{}", port), common);
  };
}

void serve_usb(const emulator::BenchOptions& bench, const Options& options, const Common& common) {
  emulator::UsbOptions serve_options;
  serve_options.into_kernel = options.plug_in;
  serve_options.gpio_adapter = options.gpio_adapter;
  serve_options.port = options.port;
  serve_options.address = options.address;
  serve_options.real_time = options.real_time;
  offer_debugger(options, common, serve_options);
  serve_options.on_ready = [&](std::uint16_t port) {
    if (options.plug_in) {
      announce(bench.sample +
                   " on the stage, plugged into this machine; connect with --device usb "
                   "(Ctrl-C ends)",
               common);
    } else {
      announce(fmt::format("{} on the stage; plug it in with: usbip --tcp-port {} attach -r {} -b "
                           "1-1 (Ctrl-C ends)",
                           bench.sample, port, options.address),
               common);
    }
  };
  serve_options.on_event = [&](const std::string& event) {
    if (!common.quiet) fmt::print(stderr, "{}\n", event);
  };
  const auto keep_going = [] { return !interrupt_flag().load(); };
  if (options.image.empty()) return emulator::serve_usb(bench, serve_options, keep_going);
#ifdef UMOV_EMULATED_BOARD
  emulator::serve_image_usb(bench, {options.image, options.boot_loader}, serve_options, keep_going);
#else
  refuse_image();
#endif
}

void run(const Options& options, const Common& common) {
  if (options.list) return list_samples(common);
  if (options.parameters) {
    fmt::print("{}", plant::parameter_reference());
    return;
  }
  if (!options.describe.empty()) return describe(options.describe, common);
  if (!options.certificate.empty()) return write_certificate(options.certificate, options.output);
  if (options.plant.sample.empty()) {
    throw Error("no sample was named", "add --sample NAME; umov emulator --list shows the names");
  }
  catch_interrupts();
  emulator::BenchOptions bench{options.plant.sample, options.plant.preset, options.plant.plant_file,
                               options.plant.plant_settings, common.seed};
  if (options.gpio_adapter && !options.usb && !options.plug_in) {
    throw Error("a GPIO adapter needs USB", "add --usb or --plug-in");
  }
  if (options.usb || options.plug_in) return serve_usb(bench, options, common);
  emulator::ServeOptions serve_options;
  serve_options.port = options.port;
  serve_options.address = options.address;
  serve_options.real_time = options.real_time;
  offer_debugger(options, common, serve_options);
  serve_options.on_listening = [&](std::uint16_t port) {
    announce(fmt::format("{} on the stage; connect with --device tcp:{}:{} (Ctrl-C ends)",
                         bench.sample, options.address, port),
             common);
  };
  serve_options.on_event = [&](const std::string& event) {
    if (!common.quiet) fmt::print(stderr, "{}\n", event);
  };
  const auto keep_going = [] { return !interrupt_flag().load(); };
  if (options.image.empty()) return emulator::serve(bench, serve_options, keep_going);
#ifdef UMOV_EMULATED_BOARD
  emulator::serve_image(bench, {options.image, options.boot_loader}, serve_options, keep_going);
#else
  refuse_image();
#endif
}

}  // namespace

void add_emulator_command(CLI::App& root, const Common& common) {
  auto options = std::make_shared<Options>();
  auto* command = root.add_subcommand(
      "emulator",
      "An instrument without hardware: the real firmware core on emulated physics, on TCP or USB");
  add_plant_options(*command, options->plant);
  auto* port = command->add_option("--port", options->port,
                                   "TCP port, 0 = any free one; 5025 by default, with --usb 3240");
  auto* usb = command->add_flag("--usb", options->usb,
                                "be a USB device, served by USB/IP to this machine or another one");
  command
      ->add_flag("--plug-in", options->plug_in,
                 "be a USB device of this machine (as root, with the kernel module vhci-hcd)")
      ->excludes(usb)
      ->excludes(port);
  command->add_option("--address", options->address, "address to listen on")->capture_default_str();
  command->add_flag("--gpio-adapter", options->gpio_adapter,
                    "with --usb or --plug-in: also a MCP2221A GPIO adapter (USB device 1-2), its "
                    "lines wired to BOOT0, NRST and the interlock (low opens it)");
  auto* image =
      command
          ->add_option("--image", options->image,
                       "run this image of the controller board (umov-stm32f407.elf) on an emulated "
                       "STM32F407 instead of the firmware core as a process")
          ->type_name("ELF");
  command
      ->add_option(
          "--boot-loader", options->boot_loader,
          "with --image: start through this boot loader (umov-stm32f407-boot.elf), so that "
          "the board can be updated over USB")
      ->type_name("ELF")
      ->needs(image);
  command
      ->add_option(
          "--gdb", options->gdb_port,
          "with --image: a debugger's port, 0 = any free one (gdb-multiarch ELF -ex 'target "
          "remote localhost:PORT')")
      ->type_name("PORT")
      ->check(CLI::Range(0, 65535));
  command->add_flag("--real-time", options->real_time, "let emulated time follow the wall clock");
  command->add_flag("--list", options->list, "the shipped samples");
  command->add_flag("--parameters", options->parameters,
                    "every parameter of the emulated physics, with both presets");
  command->add_option("--describe", options->describe, "the true parameters of a sample");
  auto* output = command->add_option("-o,--output", options->output, "file for --certificate");
  command
      ->add_option("--certificate", options->certificate,
                   "write the true in-plane BRDF of a sample as CSV, as a calibration laboratory "
                   "would certify it")
      ->needs(output);
  command->footer("Example:\n  umov emulator --sample red-gloss --preset realistic --port 5025");
  command->callback([options, port, &common] {
    if (port->count() == 0) options->port = options->usb ? 3240 : 5025;
    run(*options, common);
  });
}

}  // namespace umov::cli
