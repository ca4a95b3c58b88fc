// What each file says about its own making.
#include <fmt/format.h>

#include "host/calibrate/calibration.hpp"
#include "host/report/json_parts.hpp"
#include "host/report/numbers.hpp"

namespace umov::report {

namespace {

class Rows {
 public:
  void add(const std::string& key, const std::string& value) {
    if (!value.empty()) rows_.push_back(Json::array({key, value}));
  }
  void add(const formats::Provenance& p) {
    add("program", p.program);
    add("command", p.command);
    add("created", p.created);
    add("device", p.device);
    add("firmware hash", p.firmware_hash);
    add("role", p.role);
  }
  void add_long(const formats::Provenance& p) {
    add("settings", p.settings);
    add("plan", p.plan);
  }
  void add(const std::vector<std::pair<std::string, std::string>>& keys) {
    for (const auto& [key, value] : keys) add(key, value);
  }
  Json file(const Source& source, const std::string& kind) {
    return {{"name", source.name}, {"kind", kind}, {"rows", std::move(rows_)}};
  }

 private:
  Json rows_ = Json::array();
};

Json brdf_file(const BrdfInput& input) {
  Rows rows;
  rows.add("sha256 of the file", input.source.sha256);
  rows.add("sha256 of the data", input.file.content_sha256);
  rows.add(input.file.provenance);
  rows.add(input.file.table.keys);
  std::string names;
  for (const auto& factor : input.file.table.factors)
    names += (names.empty() ? "" : ", ") + factor.name;
  rows.add("calibration factors", names);
  rows.add_long(input.file.provenance);
  return rows.file(input.source, "reduced measurement");
}

Json scan_file(const ScanInput& input) {
  Rows rows;
  rows.add("sha256 of the file", input.source.sha256);
  rows.add("sha256 of the data", input.file.content_sha256);
  rows.add(input.file.provenance);
  rows.add(input.file.table.keys);
  rows.add_long(input.file.provenance);
  return rows.file(input.source, "raw scan");
}

Json fit_file(const FitInput& input) {
  const formats::FitResult& fit = input.fit;
  Rows rows;
  rows.add("sha256 of the file", input.source.sha256);
  rows.add("program", fit.program);
  rows.add("command", fit.command);
  rows.add("fitted to", fit.data_file);
  rows.add("sha256 of that", fit.data_sha256);
  rows.add("model", fit.model);
  rows.add("objective", fmt::format("{}, {}", fit.objective_kind, plain(fit.objective, 6)));
  rows.add("χ², degrees of freedom", fmt::format("{}, {}", plain(fit.chi2, 6), fit.dof));
  if (fit.g2_held_out) rows.add("mean z² − 1 of held-out rows", plain(*fit.g2_held_out, 3));
  rows.add("seed", fmt::format("{}", fit.seed));
  if (fit.seconds > 0) rows.add("time", fmt::format("{} s", plain(fit.seconds, 3)));
  return rows.file(input.source, "fit");
}

Json calibration_file(const CalibrationInput& input) {
  Rows rows;
  rows.add("sha256 of the file", input.source.sha256);
  rows.add(input.calibration->keys);
  for (const auto& from : input.calibration->inputs)
    rows.add(from.role.empty() ? "made from" : "made from (" + from.role + ")",
             from.name + "  " + from.sha256);
  return rows.file(input.source, "calibration");
}

}  // namespace

Json provenance(const Sample& sample) {
  Json files = Json::array();
  if (sample.brdf) files.push_back(brdf_file(*sample.brdf));
  if (sample.fit) files.push_back(fit_file(*sample.fit));
  for (const ScanInput& scan : sample.scans) files.push_back(scan_file(scan));
  if (sample.calibration) files.push_back(calibration_file(*sample.calibration));
  return files;
}

}  // namespace umov::report
