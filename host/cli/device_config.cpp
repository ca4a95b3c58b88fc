#include "host/cli/device_config.hpp"

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "host/cli/device_session.hpp"
#include "host/instrument/refusals.hpp"

namespace umov::cli {
namespace {

using instrument::Session;
using nlohmann::json;

const std::string lockin_name = "lockin";

struct Options {
  DeviceChoice device;
  std::string name;
  std::vector<std::string> settings;
};

json axis_json(const protocol::AxisInfo& now) {
  return {{"axis", instrument::axis_name(now.axis)},
          {"min_deg", 1e-6 * now.min_udeg},
          {"max_deg", 1e-6 * now.max_udeg},
          {"speed_deg_s", 1e-3 * now.speed_mdeg_s},
          {"acceleration_deg_s2", 1e-3 * now.acceleration_mdeg_s2},
          {"jerk_deg_s3", 1e-3 * now.jerk_mdeg_s3},
          {"take_up_deg", 1e-6 * now.take_up_udeg}};
}

constexpr auto external = static_cast<std::uint8_t>(protocol::ReferenceSource::external);

json lockin_json(const protocol::LockinInfo& now) {
  return {{"reference_source", now.source == external ? "external" : "internal"},
          {"reference_hz", 1e-3 * now.reference_mhz},
          {"harmonic", now.harmonic},
          {"phase_deg", 1e-6 * now.phase_udeg},
          {"settle_ms", now.settle_ms},
          {"blocks", now.blocks}};
}

void print(const json& out, const Common& common) {
  fmt::print("{}\n", common.json ? out.dump() : out.dump(2));
}

void get(const Options& options, const Common& common) {
  auto session = open_session(options.device, common);
  if (options.name == lockin_name) {
    return print(lockin_json(session.request(protocol::GetLockin{})), common);
  }
  if (!options.name.empty()) {
    return print(axis_json(session.request(protocol::GetAxis{axis_by_name(options.name)})), common);
  }
  json all{{"axes", json::array()}};
  for (std::uint8_t axis = 0; axis < protocol::axis_count; ++axis) {
    all["axes"].push_back(axis_json(session.request(protocol::GetAxis{axis})));
  }
  all[lockin_name] = lockin_json(session.request(protocol::GetLockin{}));
  print(all, common);
}

/// "key=number" taken apart.
std::pair<std::string, double> setting_of(const std::string& text, const char* example) {
  const auto equals = text.find('=');
  if (equals == std::string::npos) {
    throw Error(fmt::format("'{}' is not key=number", text), example);
  }
  return {text.substr(0, equals), finite_number(text.substr(equals + 1), "a number", example)};
}

/// What "reference_source=…" asks for; nothing where `setting` sets something else.
std::optional<std::uint8_t> source_of(const std::string& setting) {
  constexpr std::string_view key = "reference_source=";
  if (!setting.starts_with(key)) return std::nullopt;
  const std::string value = setting.substr(key.size());
  if (value == "external") return external;
  if (value == "internal") return std::uint8_t{0};
  throw Error(
      fmt::format("'{}' is no source of a reference", value),
      "write reference_source=internal (the modulation output) or reference_source=external "
      "(the reference input)");
}

void set_lockin(const Options& options, const Common& common) {
  auto session = open_session(options.device, common);
  const auto now = session.request(protocol::GetLockin{});
  protocol::SetLockin set{now.reference_mhz, now.harmonic, now.phase_udeg,
                          now.settle_ms,     now.blocks,   now.source};
  for (const auto& setting : options.settings) {
    if (const auto source = source_of(setting)) {
      set.source = *source;
      continue;
    }
    const auto [key, value] = setting_of(setting, "write for instance reference_hz=1000");
    if (key == "reference_hz")
      set.reference_mhz = scaled_integer<std::uint32_t>(value, 1e3, key);
    else if (key == "harmonic")
      set.harmonic = scaled_integer<std::uint8_t>(value, 1, key);
    else if (key == "phase_deg")
      set.phase_udeg = scaled_integer<std::int32_t>(value, 1e6, key);
    else if (key == "settle_ms")
      set.settle_ms = scaled_integer<std::uint16_t>(value, 1, key);
    else if (key == "blocks")
      set.blocks = scaled_integer<std::uint8_t>(value, 1, key);
    else
      throw Error(fmt::format("the lock-in has no setting '{}'", key),
                  "settings are reference_source, reference_hz, harmonic, phase_deg, settle_ms, "
                  "blocks");
  }
  session.request(set);
  print(lockin_json(session.request(protocol::GetLockin{})), common);
}

void set(const Options& options, const Common& common) {
  if (options.name == lockin_name) return set_lockin(options, common);
  const auto axis = axis_by_name(options.name);
  auto session = open_session(options.device, common);
  const auto now = session.request(protocol::GetAxis{axis});
  protocol::SetAxis set{axis,
                        now.min_udeg,
                        now.max_udeg,
                        now.speed_mdeg_s,
                        now.acceleration_mdeg_s2,
                        now.jerk_mdeg_s3,
                        now.take_up_udeg};
  for (const auto& setting : options.settings) {
    const auto [key, value] = setting_of(setting, "write for instance speed_deg_s=10");
    if (key == "min_deg")
      set.min_udeg = scaled_integer<std::int32_t>(value, 1e6, key);
    else if (key == "max_deg")
      set.max_udeg = scaled_integer<std::int32_t>(value, 1e6, key);
    else if (key == "speed_deg_s")
      set.speed_mdeg_s = scaled_integer<std::uint32_t>(value, 1e3, key);
    else if (key == "acceleration_deg_s2")
      set.acceleration_mdeg_s2 = scaled_integer<std::uint32_t>(value, 1e3, key);
    else if (key == "jerk_deg_s3")
      set.jerk_mdeg_s3 = scaled_integer<std::uint32_t>(value, 1e3, key);
    else if (key == "take_up_deg")
      set.take_up_udeg = scaled_integer<std::uint32_t>(value, 1e6, key);
    else
      throw Error(fmt::format("an axis has no setting '{}'", key),
                  "settings are min_deg, max_deg, speed_deg_s, acceleration_deg_s2, jerk_deg_s3, "
                  "take_up_deg");
  }
  print(axis_json(session.request(set)), common);
}

void keep(const Options& options, const Common& common, std::uint8_t action, const char* done) {
  auto session = open_session(options.device, common);
  session.request(protocol::SaveSettings{action});
  if (!common.quiet) fmt::print(common.json ? stderr : stdout, "{}\n", done);
}

void save(const Options& options, const Common& common) {
  keep(options, common, 0, "the settings in force are saved");
}
void defaults(const Options& options, const Common& common) {
  keep(options, common, 1, "the built-in settings are in force, and saved");
}

}  // namespace

void add_device_config_command(CLI::App& device, const Common& common) {
  auto options = std::make_shared<Options>();
  auto* command = device.add_subcommand("config", "settings: show, change, keep over restarts");
  command->require_subcommand(1);
  const auto add = [&](const char* name, const char* about,
                       void (*run)(const Options&, const Common&)) {
    auto* sub = command->add_subcommand(name, about);
    add_device_options(*sub, options->device);
    sub->callback([options, &common, run] { run(*options, common); });
    return sub;
  };
  const char* about_name = "an axis, or lockin";
  add("get", "show the settings in force", get)->add_option("name", options->name, about_name);
  auto* set_command = add("set", "change settings until the next restart", set);
  set_command->add_option("name", options->name, about_name)->required();
  set_command->add_option("settings", options->settings, "key=value …")->required();
  add("save", "keep the settings in force over restarts", save);
  add("defaults", "go back to the built-in settings and save these", defaults);
}

}  // namespace umov::cli
