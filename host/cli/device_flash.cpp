#include "host/cli/device_flash.hpp"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "host/cli/progress.hpp"
#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/instrument/boot_lines.hpp"
#include "host/instrument/device_names.hpp"
#include "host/instrument/firmware_image.hpp"
#include "host/instrument/refusals.hpp"
#include "host/instrument/rom_loader.hpp"
#include "host/instrument/session.hpp"
#include "host/instrument/usb_transport.hpp"
#include "host/instrument/usb_update.hpp"
#include "host/toml/parse.hpp"

namespace umov::cli {
namespace {

using instrument::FirmwareImage;
using nlohmann::json;

struct Options {
  std::string image;
  std::string device = "usb";
  std::string backup;
  bool older_too = false;
  std::string rom;
  std::string boot_loader;
  std::string key;
  std::string version;
  std::string output;
};

/// A controller comes back within a second or two, one that gives up its image within half a
/// minute, under a slow emulation within many times that.
constexpr std::chrono::seconds reappears_within{120};

void write_file(const std::string& path, const std::vector<std::uint8_t>& bytes) {
  formats::replace_file(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

std::string describe(const FirmwareImage& image) {
  return fmt::format("{} {}, {} bytes", image.header.board_name(),
                     instrument::version_text(image.header.version), image.bytes.size());
}

std::string serial_from(const std::string& device) {
  const auto name = instrument::parse_device_name(device);
  if (name.kind != instrument::DeviceKind::usb) {
    throw Error(fmt::format("device '{}': a controller is updated over USB", device),
                "give --device usb or usb:SERIAL");
  }
  return name.serial;
}

/// Into the boot loader, unless the controller is there already (an update was cut short); returns
/// its serial number.
std::string enter_boot_loader(const std::string& serial) {
  const auto waiting = instrument::list_update_devices();
  auto all = instrument::list_usb_devices();
  all.insert(all.end(), waiting.begin(), waiting.end());
  const auto device = instrument::choose_device(all, "usb", serial);
  const auto is_device = [&](const auto& other) { return other.node == device.node; };
  if (std::any_of(waiting.begin(), waiting.end(), is_device)) return device.serial;
  const std::string found = instrument::restart_in_boot_loader(device.serial);
  if (!instrument::wait_for_device(instrument::list_update_devices, found, reappears_within)) {
    throw Error({"usb:" + found}, "its boot loader does not appear on USB",
                "plug it in again (a cable of USB/IP: attach again) and repeat the command");
  }
  return found;
}

/// The file that takes the running image: whether it can be written shows before the program is
/// left.
class Backup {
 public:
  explicit Backup(const std::string& path)
      : path_(path), file_(path), stream_(file_.temporary(), std::ios::binary) {
    if (!stream_) fail();
  }
  void keep(instrument::DfuPipe& boot_loader) {
    const auto running = instrument::dfu_upload(boot_loader);
    if (running.empty()) {
      throw Error({boot_loader.name()}, "the controller has no image that could be kept",
                  "leave --backup out");
    }
    stream_.write(reinterpret_cast<const char*>(running.data()),
                  static_cast<std::streamsize>(running.size()));
    stream_.close();
    if (!stream_) fail();
    file_.commit();
  }

 private:
  [[noreturn]] void fail() const {
    throw Error(Place{.file = path_}, "cannot be written", "check permissions and free space");
  }

  std::string path_;
  formats::ReplacedFile file_;
  std::ofstream stream_;
};

/// Sends the image and lets it be installed; returns what the controller has to say to that.
std::string send(instrument::DfuPipe& boot_loader, const FirmwareImage& image,
                 const Common& common) {
  Progress progress("sending", common.quiet);
  bool installing = false;
  const auto tell = [&](instrument::UpdatePhase phase, std::size_t done, std::size_t total) {
    if (phase == instrument::UpdatePhase::sending) {
      progress.update(static_cast<double>(done), static_cast<double>(total));
    } else if (!installing) {
      installing = true;
      progress.finish();
      if (!common.quiet) fmt::print(stderr, "checking and installing\n");
    }
  };
  return instrument::dfu_download(boot_loader, image.bytes, tell);
}

/// Waits until the controller runs a program, or its boot loader has given up.
void wait_for_program(const std::string& serial) {
  std::string trouble;
  const auto settled = [&] {
    auto found = instrument::list_usb_devices();
    for (const auto& device : instrument::list_update_devices()) {
      if (device.serial != serial) continue;
      trouble = instrument::boot_loader_trouble(serial);
      if (!trouble.empty()) found.push_back(device);
    }
    return found;
  };
  const bool back = instrument::wait_for_device(settled, serial, reappears_within);
  if (!trouble.empty()) {
    throw Error({"usb:" + serial}, "the image was installed, but it does not run: " + trouble,
                "flash an image that works");
  }
  if (!back) {
    throw Error(
        {"usb:" + serial}, "the image was installed, but the controller does not come back",
        "plug it in again; umov device list shows whether it, or its boot loader, is there");
  }
}

/// Throws when the controller has noted, at this very start, that it went back to the image before.
void refuse_roll_back(instrument::Session& session) {
  constexpr auto rolled_back = static_cast<std::uint8_t>(protocol::Fault::rolled_back);
  for (std::uint16_t index = 0;; ++index) {
    const auto entry = session.request(protocol::ReadLog{index});
    if (entry.fault == 0) return;
    if (entry.fault != rolled_back || entry.boot_id != session.device().boot_id) continue;
    throw Error({session.name()},
                "the controller has gone back to the image before: " +
                    instrument::fault_detail(entry.fault, entry.detail),
                instrument::fault_remedy(rolled_back));
  }
}

/// The program that answers now must be the one that was sent.
void check_running(const std::string& serial, const FirmwareImage& image) {
  const std::string name = "usb:" + serial;
  wait_for_program(serial);
  instrument::Session session(instrument::connect_usb(serial));
  refuse_roll_back(session);
  if (session.device().firmware_hash != image.header.source_hash) {
    throw Error({name},
                fmt::format("the controller runs firmware {:016x}, not {:016x} of the image",
                            session.device().firmware_hash, image.header.source_hash),
                "repeat the command");
  }
}

/// "[reset] chip = …, boot0 = N, nrst = N" of a TOML file.
instrument::BootLineNames read_lines(const std::string& path) {
  constexpr const char* remedy =
      "write [reset] and below it, a line each, chip = \"mcp2221_gpio\", boot0 = 0, nrst = 1";
  const auto table = parse_toml(formats::read_whole_file(path, 1 << 20), path, remedy);
  const auto chip = table["reset"]["chip"].value<std::string>();
  const auto boot0 = table["reset"]["boot0"].value<std::int64_t>();
  const auto nrst = table["reset"]["nrst"].value<std::int64_t>();
  constexpr std::int64_t most_lines = 1024;
  const auto is_line = [](const std::optional<std::int64_t>& line) {
    return line && *line >= 0 && *line < most_lines;
  };
  if (!chip || !is_line(boot0) || !is_line(nrst)) {
    throw Error(Place{.file = path}, "[reset] needs chip, boot0 and nrst", remedy);
  }
  return {*chip, static_cast<unsigned>(*boot0), static_cast<unsigned>(*nrst)};
}

/// By the loader in the chip's ROM, which needs nothing in the flash and checks nothing. Returns
/// the controllers that were on USB meanwhile, which are other ones.
std::vector<instrument::UsbDeviceInfo> flash_by_rom(const Options& options,
                                                    const FirmwareImage& image,
                                                    const Common& common) {
  constexpr std::chrono::seconds appears_within{5};
  std::string boot_loader;
  if (!options.boot_loader.empty()) {
    boot_loader = formats::read_whole_file(options.boot_loader, instrument::rom::boot_loader_room);
  }
  instrument::BootLines lines(instrument::open_boot_pins(read_lines(options.rom)));
  lines.reset(true);
  std::vector<instrument::UsbDeviceInfo> others;
  {
    const auto loader = instrument::open_rom_loader(appears_within);
    others = instrument::list_usb_devices();
    Progress progress("writing", common.quiet);
    const auto tell = [&](instrument::UpdatePhase, std::size_t done, std::size_t total) {
      progress.update(static_cast<double>(done), static_cast<double>(total));
    };
    instrument::rom_flash(
        *loader, {reinterpret_cast<const std::uint8_t*>(boot_loader.data()), boot_loader.size()},
        image.bytes, tell);
  }
  lines.reset(false);
  return others;
}

void flash(const Options& options, const Common& common) {
  const std::string wanted = serial_from(options.device);
  const auto image = instrument::read_firmware_image(options.image);
  if (!common.quiet) fmt::print(stderr, "{}: {}\n", options.image, describe(image));
  std::string serial, note;
  if (!options.rom.empty()) {
    const auto others = flash_by_rom(options, image, common);
    serial = !wanted.empty() ? wanted
                             : instrument::wait_for_new_device(instrument::list_usb_devices, others,
                                                               reappears_within)
                                   .serial;
  } else {
    std::optional<Backup> backup;
    if (!options.backup.empty()) backup.emplace(options.backup);
    serial = enter_boot_loader(wanted);
    const auto boot_loader = instrument::open_boot_loader(serial, options.older_too);
    const std::string trouble = instrument::dfu_trouble(*boot_loader);
    if (!trouble.empty() && !common.quiet) {
      fmt::print(stderr, "usb:{} waits in its boot loader: {}\n", serial, trouble);
    }
    instrument::dfu_work_and_leave(*boot_loader, [&] {
      if (backup) backup->keep(*boot_loader);
      note = send(*boot_loader, image, common);
    });
  }
  if (!note.empty()) fmt::print(stderr, "usb:{}: {}\n", serial, note);
  check_running(serial, image);
  if (common.json) {
    fmt::print("{}\n", json{{"device", "usb:" + serial},
                            {"board", image.header.board_name()},
                            {"version", instrument::version_text(image.header.version)},
                            {"firmware_hash", fmt::format("{:016x}", image.header.source_hash)},
                            {"bytes", image.bytes.size()}}
                           .dump());
  } else {
    fmt::print("usb:{} runs {} {}\n", serial, image.header.board_name(),
               instrument::version_text(image.header.version));
  }
}

void sign(const Options& options, const Common& common) {
  auto image = instrument::read_firmware_image(options.image);
  const auto key = instrument::read_key(options.key);
  if (!options.version.empty()) {
    image.header.version = instrument::version_from_text(options.version);
  }
  instrument::sign_image(image, key);
  const bool dfu = options.output.ends_with(".dfu");
  write_file(options.output, dfu ? instrument::with_dfu_suffix(image.bytes) : image.bytes);
  if (!common.quiet) fmt::print(stderr, "{}: {}\n", options.output, describe(image));
}

}  // namespace

void add_device_flash_commands(CLI::App& device, const Common& common) {
  auto options = std::make_shared<Options>();
  auto* flash_command = device.add_subcommand(
      "flash", "put another program into a controller, over USB and its boot loader");
  flash_command->add_option("image", options->image, "umov-BOARD.bin or .dfu")->required();
  flash_command->add_option("--device", options->device, "usb or usb:SERIAL")
      ->capture_default_str();
  flash_command->add_flag("--allow-older", options->older_too,
                          "also an image older than the one that runs");
  flash_command->add_option("--backup", options->backup,
                            "first read the running image into a file");
  auto* rom = flash_command->add_option(
      "--rom", options->rom,
      "use the loader in the chip's ROM, entered by the GPIO lines that this TOML file names");
  flash_command
      ->add_option("--boot-loader", options->boot_loader,
                   "with --rom: umov-BOARD-boot.bin, written first")
      ->needs(rom);
  flash_command->callback([options, &common] { flash(*options, common); });

  auto* sign_command = device.add_subcommand("sign", "sign an image with a key of one's own");
  sign_command->add_option("image", options->image, "umov-BOARD.bin or .dfu")->required();
  sign_command->add_option("--key", options->key, "key file (umov device key)")->required();
  sign_command->add_option("--version", options->version, "change the version, such as 0.2.0");
  sign_command->add_option("-o,--output", options->output, "the signed image, .bin or .dfu")
      ->required();
  sign_command->callback([options, &common] { sign(*options, common); });

  auto* key_command = device.add_subcommand("key", "make a key that signs images");
  key_command->add_option("file", options->key, "a new file")->required();
  key_command->callback([options] { instrument::make_key(options->key); });
}

}  // namespace umov::cli
