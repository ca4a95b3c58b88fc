// umov import: foreign measurements into scan.h5 or brdf.h5.
#include <filesystem>
#include <memory>
#include <string>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "host/cli/command.hpp"
#include "host/cli/output_file.hpp"
#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/brdf_h5.hpp"
#include "host/formats/foreign_kind.hpp"
#include "host/formats/jsss_scan.hpp"
#include "host/formats/nist_ptfe.hpp"
#include "host/formats/scan_csv.hpp"
#include "host/formats/scan_h5.hpp"

namespace umov::cli {
namespace {

struct Options {
  std::string input;
  std::string output;
  std::string kind = "auto";
  std::string material;
  std::string emissivity;
  bool force = false;
};

struct Imported {
  const char* format;  ///< of the file written
  std::size_t rows;
};

formats::ForeignKind wanted_kind(const Options& options) {
  using formats::ForeignKind;
  if (options.kind == "scan-csv") return ForeignKind::scan_csv;
  if (options.kind == "nist-ptfe") return ForeignKind::nist_ptfe;
  if (options.kind == "jsss") return ForeignKind::jsss;
  return formats::foreign_kind(formats::read_whole_file(options.input));
}

Imported import_brdf(const formats::BrdfTable& table, const Options& options,
                     const formats::Provenance& provenance) {
  formats::write_brdf_h5(options.output, table, provenance);
  return {"brdf.h5", table.points.size()};
}

formats::BrdfTable read_jsss(const Options& options) {
  const auto scan = formats::read_jsss_scan(options.input);
  const auto materials = scan.materials();
  std::string material = options.material;
  if (material.empty() && materials.size() == 1) material = materials.front();
  if (material.empty()) {
    throw Error(Place{options.input}, fmt::format("holds {} materials", materials.size()),
                fmt::format("choose one with --material: {}", fmt::join(materials, ", ")));
  }
  if (options.emissivity.empty()) return formats::to_brdf_table(scan, material, nullptr);
  const auto emissivity = formats::read_jsss_emissivity(options.emissivity);
  return formats::to_brdf_table(scan, material, &emissivity);
}

Imported import_file(const Options& options, const formats::Provenance& provenance) {
  using formats::ForeignKind;
  switch (wanted_kind(options)) {
    case ForeignKind::scan_csv: {
      const auto table = formats::read_scan_csv(options.input);
      formats::write_scan_h5(options.output, table, provenance);
      return {"scan.h5", table.size()};
    }
    case ForeignKind::nist_ptfe:
      return import_brdf(formats::to_brdf_table(formats::read_nist_ptfe(options.input),
                                                formats::standard_states()),
                         options, provenance);
    case ForeignKind::jsss:
      return import_brdf(read_jsss(options), options, provenance);
    case ForeignKind::unknown:
      break;
  }
  throw Error(
      Place{options.input}, "is of no kind that can be imported",
      "kinds: a Scan CSV, the NIST PTFE table, a JSSS in-plane scan; or name it with --kind");
}

void run(const Options& options, const Common& common) {
  require_new_output(options.input, options.output, options.force);
  formats::Provenance provenance;
  provenance.program = std::string("umov ") + UMOV_VERSION;
  provenance.command = common.command_line;
  const Imported imported = import_file(options, provenance);
  if (common.json) {
    fmt::print("{}\n",
               nlohmann::json{
                   {"file", options.output}, {"format", imported.format}, {"rows", imported.rows}}
                   .dump());
  } else if (!common.quiet) {
    fmt::print("{}: {} with {} rows\n", options.output, imported.format, imported.rows);
  }
}

}  // namespace

void add_import_command(CLI::App& root, const Common& common) {
  auto options = std::make_shared<Options>();
  auto* command =
      root.add_subcommand("import", "Bring a foreign measurement into scan.h5 or brdf.h5");
  command->add_option("file", options->input, "file to read")->required();
  command->add_option("-o,--output", options->output, "scan.h5 or brdf.h5 to write")->required();
  command->add_option("--kind", options->kind, "what the file is; auto looks at its header line")
      ->check(CLI::IsMember({"auto", "scan-csv", "nist-ptfe", "jsss"}))
      ->capture_default_str();
  command->add_option("--material", options->material, "jsss: which of the file's materials");
  command->add_option("--emissivity", options->emissivity,
                      "jsss: emissivity table, from which DHR = 1 - emissivity is added");
  command->add_flag("--force", options->force, "replace an existing file");
  command->footer(
      "Examples:\n"
      "  umov import scan.csv -o scan.h5\n"
      "  umov import tests/data/nist_ptfe/ptfe_532_633.csv -o ptfe.h5\n"
      "  umov import tests/data/jsss_mwir/inplane.csv --material \"aluminium sandblasted\" -o "
      "al.h5");
  command->callback([options, &common] { run(*options, common); });
}

}  // namespace umov::cli
