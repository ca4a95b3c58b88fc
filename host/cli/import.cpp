// umov import: foreign measurements and tables into scan.h5, brdf.h5 or table.h5.
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "host/cli/command.hpp"
#include "host/cli/output_file.hpp"
#include "host/cli/progress.hpp"
#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/brdf_h5.hpp"
#include "host/formats/decimal.hpp"
#include "host/formats/foreign_kind.hpp"
#include "host/formats/hdf5_image.hpp"
#include "host/formats/image_file.hpp"
#include "host/formats/jsss_scan.hpp"
#include "host/formats/nist_ptfe.hpp"
#include "host/formats/photometry.hpp"
#include "host/formats/scan_csv.hpp"
#include "host/formats/scan_h5.hpp"
#include "host/formats/table_comparison.hpp"
#include "host/formats/table_file.hpp"

namespace umov::cli {
namespace {

struct Options {
  std::string input;
  std::string output;
  std::string kind = "auto";
  std::string as = "auto";
  std::string material;
  std::string emissivity;
  bool force = false;
};

struct Imported {
  std::string format;  ///< of the file written
  std::size_t rows = 0;
  std::string table;       ///< what a table is; empty otherwise
  std::string difference;  ///< of a table that had to be sampled anew
  std::vector<std::string> notes;
  std::string evaluation;  ///< command line that gives the same values without a table
};

/// The command that evaluates the very model of which a table holds samples.
std::string evaluation_of(const formats::ModelTable& table) {
  std::string line = "umov model eval " + table.model().name();
  for (std::size_t p = 0; p < table.model().parameters().size(); ++p)
    line += " --set " + table.model().parameters()[p].name + "=" +
            formats::decimal_text(table.values(0)[p]);
  return line + " --wavelength-nm " + formats::decimal_text(1e3 * table.wavelengths_um().front()) +
         " --theta-i 30 --theta-r 30";
}

Imported import_brdf(const formats::BrdfTable& table, const Options& options,
                     const formats::Provenance& provenance) {
  formats::write_brdf_h5(options.output, table, provenance);
  return {"brdf.h5", table.points.size(), {}, {}, {}, {}};
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

Imported import_table(const formats::TableFormat& format, const std::string& bytes,
                      const Options& options, const formats::Provenance& provenance,
                      const Common& common) {
  const formats::TablePtr table = format.read(bytes, options.input);
  formats::TableWriting writing;
  writing.program = provenance.program;
  writing.command = provenance.command;
  Imported imported{"table.h5", 0, table->description(), {}, {}, {}};
  if (const auto* model = dynamic_cast<const formats::ModelTable*>(table.get())) {
    imported.notes = model->notes();
    imported.evaluation = evaluation_of(*model);
    writing.notes = imported.notes;
    writing.notes.push_back("sampled from a model, whose parameters are: " + imported.evaluation);
  }
  Progress progress("sampling", common.quiet);
  writing.progress = [&](double done, double total) { progress.update(done, total); };
  formats::write_table(options.output, "table", *table, writing);
  progress.finish();
  const auto difference = formats::compare_tables(*formats::read_table(options.output, "table"),
                                                  *table, table->wavelengths_um());
  if (difference.worst > 1e-6) imported.difference = difference.sentence();
  return imported;
}

/// By --kind or by content; nothing where the file is no table.
const formats::TableFormat* wanted_format(const Options& options, const std::string& bytes) {
  if (options.kind != "auto") {
    for (const formats::TableFormat& format : formats::table_formats())
      if (format.name == options.kind) return &format;
    return nullptr;
  }
  return formats::recognised_format(bytes);
}

formats::ForeignKind wanted_kind(const Options& options, const std::string& bytes) {
  using formats::ForeignKind;
  if (options.kind == "scan-csv") return ForeignKind::scan_csv;
  if (options.kind == "nist-ptfe") return ForeignKind::nist_ptfe;
  if (options.kind == "jsss") return ForeignKind::jsss;
  return formats::foreign_kind(bytes);
}

Imported import_file(const Options& options, const formats::Provenance& provenance,
                     const Common& common) {
  const std::string bytes = formats::read_whole_file(options.input);
  if (const formats::TableFormat* format = wanted_format(options, bytes)) {
    if (format->name == "table")
      throw Error(Place{options.input}, "is a table.h5 already",
                  "umov export writes it in other formats");
    const bool points = options.as == "points" || (options.as == "auto" && format->read == nullptr);
    if (points && format->read_points != nullptr)
      return import_brdf(format->read_points(bytes, options.input), options, provenance);
    if (!points && format->read != nullptr)
      return import_table(*format, bytes, options, provenance, common);
    throw Error(
        Place{options.input},
        fmt::format("{} files are not read as {}", format->name, points ? "points" : "a table"),
        "leave --as away; umov import --help lists what is read");
  }
  using formats::ForeignKind;
  switch (wanted_kind(options, bytes)) {
    case ForeignKind::scan_csv: {
      const auto table = formats::parse_scan_csv(bytes, options.input);
      formats::write_scan_h5(options.output, table, provenance);
      return {"scan.h5", table.size(), {}, {}, {}, {}};
    }
    case ForeignKind::nist_ptfe:
      return import_brdf(formats::independent_channels(formats::read_nist_ptfe(options.input)),
                         options, provenance);
    case ForeignKind::jsss:
      return import_brdf(read_jsss(options), options, provenance);
    case ForeignKind::unknown:
      break;
  }
  if (formats::looks_like_photometry(bytes))
    throw Error(Place{options.input}, "is an intensity distribution",
                "scenes read it as it is ([[source]] file = …); umov export --format ies or ldt "
                "writes it in the other format");
  if (formats::looks_like_exr(bytes))
    throw Error(Place{options.input}, "is an OpenEXR image",
                "umov diagnose MAP --luminaire SCENE reads luminance maps as they are");
  if (formats::looks_like_hdf5(bytes))
    throw Error(Place{options.input}, "is an HDF5 file, not a foreign measurement",
                "umov reads its own files directly; umov export writes them in other formats");
  throw Error(Place{options.input}, "is of no kind that can be imported",
              "umov import --help lists the kinds; name one with --kind");
}

void run(const Options& options, const Common& common) {
  require_new_output(options.input, options.output, options.force);
  formats::Provenance provenance;
  provenance.program = std::string("umov ") + UMOV_VERSION;
  provenance.command = common.command_line;
  const Imported imported = import_file(options, provenance, common);
  if (common.json) {
    nlohmann::ordered_json out{{"file", options.output}, {"format", imported.format}};
    if (imported.table.empty()) {
      out["rows"] = imported.rows;
    } else {
      out["table"] = imported.table;
      if (!imported.difference.empty()) out["note"] = imported.difference;
      out["notes"] = imported.notes;
      if (!imported.evaluation.empty()) out["model"] = imported.evaluation;
    }
    fmt::print("{}\n", out.dump());
  } else if (!common.quiet) {
    if (imported.table.empty()) {
      fmt::print("{}: {} with {} rows\n", options.output, imported.format, imported.rows);
    } else {
      fmt::print("{}: {}, {}\n", options.output, imported.format, imported.table);
      if (!imported.difference.empty()) fmt::print("sampled anew: {}\n", imported.difference);
      for (const std::string& note : imported.notes) fmt::print("note: {}\n", note);
      if (!imported.evaluation.empty())
        fmt::print("the model itself, not sampled: {}\n", imported.evaluation);
    }
  }
}

std::vector<std::string> kinds() {
  std::vector<std::string> names = {"auto", "scan-csv", "nist-ptfe", "jsss"};
  for (const formats::TableFormat& format : formats::table_formats())
    if (format.name != "table" && (format.read != nullptr || format.read_points != nullptr))
      names.emplace_back(format.name);
  return names;
}

std::string footer() {
  std::string text =
      "Kinds and what they become:\n"
      "  scan-csv    Scan CSV -> scan.h5\n"
      "  nist-ptfe   NIST PTFE Mueller matrices -> brdf.h5\n"
      "  jsss        JSSS in-plane scans -> brdf.h5\n";
  for (const formats::TableFormat& format : formats::table_formats()) {
    if (format.name == "table" || (format.read == nullptr && format.read_points == nullptr))
      continue;
    text += fmt::format("  {:11} {} -> {}{}{}\n", format.name, format.title,
                        format.read != nullptr ? "table.h5" : "",
                        format.read != nullptr && format.read_points != nullptr ? " or " : "",
                        format.read_points != nullptr ? "brdf.h5" : "");
  }
  return text +
         "Examples:\n"
         "  umov import scan.csv -o scan.h5\n"
         "  umov import tests/data/nist_ptfe/ptfe_532_633.csv -o ptfe.h5\n"
         "  umov import tests/data/jsss_mwir/inplane.csv --material \"aluminium sandblasted\" -o "
         "al.h5\n"
         "  umov import red-fabric.binary -o red-fabric.h5";
}

}  // namespace

void add_import_command(CLI::App& root, const Common& common) {
  auto options = std::make_shared<Options>();
  auto* command = root.add_subcommand(
      "import", "Bring a foreign measurement or table into scan.h5, brdf.h5 or table.h5");
  command->add_option("file", options->input, "file to read")->required();
  command->add_option("-o,--output", options->output, "scan.h5, brdf.h5 or table.h5 to write")
      ->required();
  command->add_option("--kind", options->kind, "what the file is; auto looks at its content")
      ->check(CLI::IsMember(kinds()))
      ->capture_default_str();
  command
      ->add_option("--as", options->as,
                   "for kinds that can be either: measured points (brdf.h5) or a table (table.h5)")
      ->check(CLI::IsMember({"auto", "points", "table"}))
      ->capture_default_str();
  command->add_option("--material", options->material, "jsss: which of the file's materials");
  command->add_option("--emissivity", options->emissivity,
                      "jsss: emissivity table, from which DHR = 1 - emissivity is added");
  command->add_flag("--force", options->force, "replace an existing file");
  command->footer(footer());
  command->callback([options, &common] { run(*options, common); });
}

}  // namespace umov::cli
