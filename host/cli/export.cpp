// umov export: scan.h5 and brdf.h5 as text for other programs.
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
#include "host/formats/brdf_csv.hpp"
#include "host/formats/brdf_h5.hpp"
#include "host/formats/h5_kind.hpp"
#include "host/formats/scan_csv.hpp"
#include "host/formats/scan_h5.hpp"

namespace umov::cli {
namespace {

struct Options {
  std::string input;
  std::string output;
  std::string format = "csv";
  bool force = false;
};

struct Exported {
  const char* format;
  std::size_t rows;
};

Exported export_file(const Options& options) {
  switch (formats::h5_kind(options.input)) {
    case formats::H5Kind::scan: {
      const auto scan = formats::read_scan_h5(options.input);
      formats::write_scan_csv(scan.table, std::filesystem::path(options.output));
      return {"scan csv", scan.table.size()};
    }
    case formats::H5Kind::brdf: {
      const auto brdf = formats::read_brdf_h5(options.input);
      formats::replace_file(options.output, formats::brdf_csv_text(brdf.table));
      return {"brdf csv", brdf.table.points.size()};
    }
    case formats::H5Kind::other:
      break;
  }
  throw Error(Place{options.input}, "is neither a scan.h5 nor a brdf.h5", "name a file of umov");
}

void run(const Options& options, const Common& common) {
  require_new_output(options.input, options.output, options.force);
  const Exported exported = export_file(options);
  if (common.json) {
    fmt::print("{}\n",
               nlohmann::json{
                   {"file", options.output}, {"format", exported.format}, {"rows", exported.rows}}
                   .dump());
  } else if (!common.quiet) {
    fmt::print("{}: {} with {} rows\n", options.output, exported.format, exported.rows);
  }
}

}  // namespace

void add_export_command(CLI::App& root, const Common& common) {
  auto options = std::make_shared<Options>();
  auto* command =
      root.add_subcommand("export", "Write scan.h5 or brdf.h5 as text for other programs");
  command->add_option("file", options->input, "scan.h5 or brdf.h5")->required();
  command->add_option("-o,--output", options->output, "file to write")->required();
  command->add_option("--format", options->format, "csv: Scan CSV of a scan, point list of a BRDF")
      ->check(CLI::IsMember({"csv"}))
      ->capture_default_str();
  command->add_flag("--force", options->force, "replace an existing file");
  command->footer(
      "Examples:\n"
      "  umov export scan.h5 -o scan.csv\n"
      "  umov export brdf.h5 --format csv -o brdf.csv");
  command->callback([options, &common] { run(*options, common); });
}

}  // namespace umov::cli
