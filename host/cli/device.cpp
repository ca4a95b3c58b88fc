// umov device: look at a controller, home it, move an axis, change settings, read its fault log.
#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "host/cli/command.hpp"
#include "host/cli/device_choice.hpp"
#include "host/cli/device_config.hpp"
#include "host/cli/device_flash.hpp"
#include "host/cli/device_selftest.hpp"
#include "host/cli/device_session.hpp"
#include "host/cli/interrupt.hpp"
#include "host/errors/error.hpp"
#include "host/instrument/program_control.hpp"
#include "host/instrument/refusals.hpp"
#include "host/instrument/session.hpp"
#include "host/instrument/usb_devices.hpp"
#include "host/instrument/usb_update.hpp"
#include "host/instrument/usb_watch.hpp"

namespace umov::cli {
namespace {

using instrument::Session;
using nlohmann::json;

struct Options {
  DeviceChoice device;
  std::string axis;
  std::string target;
  std::vector<std::string> axes;
  bool clear = false;
  bool watch = false;
};

Session open_session(const Options& options, const Common& common) {
  return open_session(options.device, common);
}

std::string text(const protocol::Name& name) {
  const std::string whole(name.begin(), name.end());
  return whole.substr(0, whole.find('\0'));
}

json status_json(const protocol::Status& status) {
  json positions;
  for (int axis = 0; axis < protocol::axis_count; ++axis) {
    positions[instrument::axis_name(axis)] =
        1e-6 * status.position_udeg[static_cast<std::size_t>(axis)];
  }
  return {{"state", instrument::state_name(status.state)},
          {"fault", instrument::fault_name(status.fault)},
          {"interlock_closed", status.interlock_closed != 0},
          {"homed_mask", status.homed_mask},
          {"program_id", status.program_id},
          {"records_waiting", status.next_record - status.first_unacknowledged},
          {"reference_input", instrument::reference_state_name(status.reference_state)},
          {"reference_input_hz", 1e-3 * status.reference_mhz},
          {"position_deg", positions}};
}

void info(const Options& options, const Common& common) {
  auto session = open_session(options, common);
  const auto& device = session.device();
  const auto status = session.request(protocol::GetStatus{});
  json axes = json::array();
  for (std::uint8_t axis = 0; axis < protocol::axis_count; ++axis) {
    const auto properties = session.request(protocol::GetAxis{axis});
    axes.push_back({{"name", instrument::axis_name(axis)},
                    {"steps_per_turn", properties.steps_per_turn},
                    {"min_deg", 1e-6 * properties.min_udeg},
                    {"max_deg", 1e-6 * properties.max_udeg},
                    {"speed_deg_s", 1e-3 * properties.speed_mdeg_s},
                    {"acceleration_deg_s2", 1e-3 * properties.acceleration_mdeg_s2},
                    {"jerk_deg_s3", 1e-3 * properties.jerk_mdeg_s3},
                    {"take_up_deg", 1e-6 * properties.take_up_udeg}});
  }
  if (common.json) {
    std::vector<double> densities;
    for (const auto milli : device.filter_od_milli) densities.push_back(1e-3 * milli);
    const json out{{"device", text(device.device_name)},
                   {"serial", text(device.serial)},
                   {"protocol", device.version},
                   {"schema_hash", fmt::format("{:016x}", device.schema_hash)},
                   {"firmware_hash", fmt::format("{:016x}", device.firmware_hash)},
                   {"boot_id", device.boot_id},
                   {"sample_rate_hz", device.sample_rate_hz},
                   {"adc_step_v", 1e-9 * device.adc_step_nv},
                   {"gains", device.gains},
                   {"wavelengths_nm", device.wavelengths_nm},
                   {"filter_optical_density", densities},
                   {"status", status_json(status)},
                   {"axes", axes}};
    fmt::print("{}\n", out.dump(2));
    return;
  }
  fmt::print("{} {} at {}\n", text(device.device_name), text(device.serial), session.name());
  fmt::print("  protocol {}, schema {:016x}, firmware {:016x}, boot {}\n", device.version,
             device.schema_hash, device.firmware_hash, device.boot_id);
  fmt::print("  lasers {}, {}, {} nm; amplifier ranges {}, {}, {}, {}; {} kS/s, {:.4g} mV a code\n",
             device.wavelengths_nm[0], device.wavelengths_nm[1], device.wavelengths_nm[2],
             device.gains[0], device.gains[1], device.gains[2], device.gains[3],
             device.sample_rate_hz / 1000, 1e-6 * device.adc_step_nv);
  fmt::print("  filter wheel: optical density");
  for (const auto milli : device.filter_od_milli) fmt::print(" {:g}", 1e-3 * milli);
  fmt::print("\n  state {}, fault {}, interlock {}\n", instrument::state_name(status.state),
             instrument::fault_name(status.fault),
             status.interlock_closed != 0 ? "closed" : "open");
  fmt::print("  reference input {}", instrument::reference_state_name(status.reference_state));
  if (status.reference_mhz != 0) fmt::print(" at {:.3f} Hz", 1e-3 * status.reference_mhz);
  fmt::print("\n  {:<10} {:>10} {:>8} {:>8} {:>9} {:>7}\n", "axis", "position/°", "min/°", "max/°",
             "speed °/s", "homed");
  for (std::size_t axis = 0; axis < axes.size(); ++axis) {
    fmt::print("  {:<10} {:>10.3f} {:>8g} {:>8g} {:>9g} {:>7}\n",
               axes[axis]["name"].get<std::string>(), 1e-6 * status.position_udeg[axis],
               axes[axis]["min_deg"].get<double>(), axes[axis]["max_deg"].get<double>(),
               axes[axis]["speed_deg_s"].get<double>(),
               (status.homed_mask >> axis & 1) != 0 ? "yes" : "no");
  }
}

void print_positions(Session& session, const Common& common) {
  const auto status = session.request(protocol::GetStatus{});
  if (common.json) {
    fmt::print("{}\n", status_json(status).dump());
    return;
  }
  for (int axis = 0; axis < protocol::axis_count; ++axis) {
    fmt::print("{}{} {:.4f}°", axis > 0 ? ", " : "", instrument::axis_name(axis),
               1e-6 * status.position_udeg[static_cast<std::size_t>(axis)]);
  }
  fmt::print("\n");
}

void home(const Options& options, const Common& common) {
  std::uint8_t mask = 0;
  for (const auto& axis : options.axes)
    mask = static_cast<std::uint8_t>(mask | 1u << axis_by_name(axis));
  if (mask == 0) mask = 0x3f;
  catch_interrupts();
  auto session = open_session(options, common);
  session.request(protocol::Home{mask});
  wait_until_arrived(session, std::popcount(mask));
  print_positions(session, common);
}

void jog(const Options& options, const Common& common) {
  protocol::Move move;
  move.axis = axis_by_name(options.axis);
  if (options.target == "open") {
    move.target_udeg = protocol::open_position;
  } else {
    const double target_deg = finite_number(options.target, "an angle",
                                            "give degrees, or open for a polariser or analyser");
    move.target_udeg = scaled_integer<std::int32_t>(target_deg, 1e6, "the angle");
  }
  catch_interrupts();
  auto session = open_session(options, common);
  const auto status = session.request(protocol::GetStatus{});
  if ((status.homed_mask >> move.axis & 1) == 0) {
    session.request(protocol::Home{static_cast<std::uint8_t>(1u << move.axis)});
    wait_until_arrived(session, 1);
  }
  session.request(move);
  wait_until_arrived(session, 1);
  print_positions(session, common);
}

/// Clears one fault after the other until none is latched; returns their names.
std::vector<std::string> clear_faults(Session& session) {
  constexpr std::chrono::seconds patience{10};
  const auto deadline = session.clock_us() + instrument::to_us(patience);
  std::vector<std::string> cleared;
  for (;;) {
    const auto fault = session.request(protocol::GetStatus{}).fault;
    if (fault == 0) return cleared;
    try {
      session.request(protocol::ClearFault{fault});
      cleared.push_back(instrument::fault_name(fault));
      continue;
    } catch (const instrument::Refused& refused) {
      // Busy: the axes still come to rest.
      if (refused.refusal() != protocol::Refusal::busy || session.clock_us() >= deadline) throw;
    }
    let_work(session);
  }
}

void log(const Options& options, const Common& common) {
  auto session = open_session(options, common);
  if (options.clear) {
    const auto cleared = clear_faults(session);
    // On stderr where stdout is for the entries alone.
    for (const auto& fault : cleared)
      fmt::print(common.json ? stderr : stdout, "cleared {}\n", fault);
    if (cleared.empty() && !common.json) fmt::print("no fault was latched\n");
  }
  json entries = json::array();
  for (std::uint16_t index = 0;; ++index) {
    const auto entry = session.request(protocol::ReadLog{index});
    if (entry.fault == 0) break;
    entries.push_back({{"boot_id", entry.boot_id},
                       {"time_s", 1e-6 * static_cast<double>(entry.time_us)},
                       {"fault", instrument::fault_name(entry.fault)},
                       {"detail", entry.detail},
                       {"about", instrument::fault_detail(entry.fault, entry.detail)}});
  }
  if (common.json) {
    fmt::print("{}\n", entries.dump());
    return;
  }
  if (entries.empty()) fmt::print("the fault log is empty\n");
  for (const auto& entry : entries) {
    fmt::print("boot {} at {:.3f} s: {} ({})\n", entry["boot_id"].get<std::uint32_t>(),
               entry["time_s"].get<double>(), entry["fault"].get<std::string>(),
               entry["about"].get<std::string>());
  }
}

/// Tells of controllers on USB that come and go, one line each, until Ctrl-C.
void watch(const Common& common) {
  catch_interrupts();
  instrument::watch_usb_devices(
      [&](const instrument::UsbDeviceInfo& device, bool present) {
        const std::string name = device.serial.empty() ? "usb" : "usb:" + device.serial;
        const char* what = !present            ? "unplugged"
                           : device.accessible ? "plugged in"
                                               : "plugged in, but you may not open it";
        if (common.json) {
          fmt::print("{}\n", json{{"device", name},
                                  {"node", device.node},
                                  {"present", present},
                                  {"accessible", device.accessible}}
                                 .dump());
        } else {
          fmt::print("{} at {} {}\n", name, device.node, what);
        }
        std::fflush(stdout);
      },
      [] { return !interrupt_flag().load(); });
}

/// Controllers that run no program: their boot loaders, and why they wait.
json waiting_controllers() {
  json devices = json::array();
  for (const auto& device : instrument::list_update_devices()) {
    std::string about = "at " + device.node + ", but you may not open it";
    if (device.accessible) {
      about = "boot loader on " + device.node + ", waits for an image (umov device flash)";
      const std::string trouble = instrument::boot_loader_trouble(device.serial);
      if (!trouble.empty()) about += ": " + trouble;
    }
    devices.push_back({{"device", device.serial.empty() ? "usb" : "usb:" + device.serial},
                       {"about", about},
                       {"node", device.node},
                       {"accessible", device.accessible},
                       {"boot_loader", true}});
  }
  return devices;
}

/// What can be named after --device, and what is there.
void list(const Common& common) {
  json devices =
      json::array({{{"device", "emulator"}, {"about", "emulated instrument in this process"}}});
  const auto add = [&](const std::string& kind, const std::string& pipe,
                       const std::vector<instrument::UsbDeviceInfo>& found) {
    for (const auto& device : found) {
      const std::string about = device.accessible
                                    ? device.product + " on " + device.node + ", " + pipe
                                    : "at " + device.node + ", but you may not open it";
      devices.push_back({{"device", device.serial.empty() ? kind : kind + ":" + device.serial},
                         {"about", about},
                         {"node", device.node},
                         {"accessible", device.accessible}});
    }
  };
  std::string trouble;
  const auto look = [&](auto find) {
    try {
      find();
    } catch (const Error& error) {  // none of that kind here: no reason not to name the rest
      trouble += (trouble.empty() ? "" : "\n") + error.problem();
    }
  };
  look([&] {
    add("usb", "bulk pipes", instrument::list_usb_devices());
    for (const auto& waiting : waiting_controllers()) devices.push_back(waiting);
  });
  look([&] { add("hid", "HID reports", instrument::list_hid_devices()); });
  if (common.json) {
    fmt::print("{}\n", devices.dump());
    return;
  }
  bool closed = false;
  for (const auto& device : devices) {
    fmt::print("{:<32} {}\n", device["device"].get<std::string>(),
               device["about"].get<std::string>());
    closed = closed || !device.value("accessible", true);
  }
  fmt::print("{:<32} controller's serial line, 1,000,000 baud unless ?baud= is added\n",
             "serial:/dev/ttyUSB0");
  fmt::print("{:<32} controller or `umov emulator` on the network\n", "tcp:HOST:PORT");
  if (common.quiet) return;
  if (!trouble.empty()) fmt::print(stderr, "{}\n", trouble);
  if (closed) fmt::print(stderr, "{}\n", instrument::permission_remedy());
}

}  // namespace

void add_device_command(CLI::App& root, const Common& common) {
  auto options = std::make_shared<Options>();
  auto* command = root.add_subcommand(
      "device", "Look at a controller, home it, move an axis, read its fault log");
  command->require_subcommand(1);
  auto* list_command =
      command->add_subcommand("list", "what is there, and kinds of device that can be named");
  list_command->add_flag("--watch", options->watch,
                         "tell of controllers on USB that come and go, until Ctrl-C");
  list_command->callback([options, &common] { options->watch ? watch(common) : list(common); });
  command
      ->add_subcommand("udev-rule",
                       "print the rule for udev that lets users open controllers on USB")
      ->callback([] { fmt::print("{}", instrument::udev_rule()); });

  const auto add = [&](const char* name, const char* about,
                       void (*run)(const Options&, const Common&)) {
    auto* sub = command->add_subcommand(name, about);
    add_device_options(*sub, options->device);
    sub->callback([options, &common, run] { run(*options, common); });
    return sub;
  };
  add("info", "who it is, its axes and its state", info);
  add("home", "home all axes, or those named", home)
      ->add_option("axes", options->axes, "axes to home");
  auto* jog_command = add("jog", "move one axis to an angle", jog);
  jog_command
      ->add_option("axis", options->axis,
                   "incidence, detector, azimuth, polarizer, analyzer or filter")
      ->required();
  jog_command->add_option("target", options->target, "degrees, or open")->required();
  add_device_config_command(*command, common);
  add_device_flash_commands(*command, common);
  add_device_selftest_command(*command, common);
  add("log", "the fault log, newest first", log)
      ->add_flag("--clear", options->clear, "clear the latched faults as well");
}

}  // namespace umov::cli
