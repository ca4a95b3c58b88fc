// umov export: scans, measured points, tables, fits and models in the formats of other programs.
#include <algorithm>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "host/cli/command.hpp"
#include "host/cli/export_light.hpp"
#include "host/cli/model_values.hpp"
#include "host/cli/output_file.hpp"
#include "host/cli/progress.hpp"
#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/brdf_csv.hpp"
#include "host/formats/brdf_h5.hpp"
#include "host/formats/h5_kind.hpp"
#include "host/formats/hdf5_image.hpp"
#include "host/formats/klems_means.hpp"
#include "host/formats/klems_table.hpp"
#include "host/formats/scan_csv.hpp"
#include "host/formats/scan_h5.hpp"
#include "host/formats/table_comparison.hpp"
#include "host/formats/table_file.hpp"

namespace umov::cli {
namespace {

constexpr double default_wavelength_nm = 632.8;

struct Options {
  std::string input;
  std::string output;
  std::string format;  ///< empty: csv for scans and points; tables need one
  std::string model;
  std::vector<std::string> settings;
  std::vector<double> wavelengths_nm;
  bool force = false;
};

struct Exported {
  std::string format;
  std::size_t rows = 0;
  std::vector<std::string> notes = {};  ///< of tables, distributions and maps
  std::string light = {};               ///< what a distribution or map is
  bool table = false;
  std::optional<formats::TableDifference> difference = {};
  bool patch_means = false;  ///< `difference` is to means over the patches of the file
  std::optional<formats::ReflectanceDifference> reflectance = {};
  /// Where it is: to the source's own values. Not for several wavelengths, which have no such.
  std::optional<formats::TableDifference> pointwise = {};
  bool without_mirror_patches = false;  ///< in `pointwise`
};

formats::TableWriting writing_of(const Options& options, const Common& common) {
  formats::TableWriting writing;
  for (const double nm : options.wavelengths_nm)
    writing.wavelengths_um.push_back(checked_wavelength_um(nm));
  std::sort(writing.wavelengths_um.begin(), writing.wavelengths_um.end());
  writing.wavelengths_um.erase(
      std::unique(writing.wavelengths_um.begin(), writing.wavelengths_um.end()),
      writing.wavelengths_um.end());
  writing.program = std::string("umov ") + UMOV_VERSION;
  writing.command = common.command_line;
  return writing;
}

formats::TablePtr model_source(const Options& options, const formats::TableWriting& writing) {
  ModelValues model = model_values(options.model, options.settings);
  std::vector<double> wavelengths = writing.wavelengths_um;
  if (wavelengths.empty()) wavelengths = {default_wavelength_nm * 1e-3};
  std::vector<std::string> settings;
  for (const std::string& setting : options.settings) settings.push_back(setting);
  std::string description = fmt::format("model {}", options.model);
  if (!settings.empty()) description += fmt::format(" with {}", fmt::join(settings, ", "));
  return std::make_shared<formats::ModelTable>(
      std::move(model.model), std::move(wavelengths),
      std::vector<std::vector<double>>{std::move(model.values)}, std::move(description));
}

/// A table, fit or table file of any format.
formats::TablePtr table_source(const std::string& bytes, const std::string& name) {
  const auto first = bytes.find_first_not_of(" \t\r\n");
  if (first != std::string::npos && bytes[first] == '{') return formats::fitted_table(bytes, name);
  return formats::parse_table(bytes, name);
}

Exported export_points(const Options& options, const formats::TableWriting& writing) {
  const auto brdf = formats::read_brdf_h5(options.input);
  if (options.format.empty() || options.format == "csv") {
    formats::replace_file(options.output, formats::brdf_csv_text(brdf.table));
    return {"brdf csv", brdf.table.points.size()};
  }
  const formats::TableFormat& format = formats::table_format(options.format);
  if (format.write_points == nullptr)
    throw Error(Place{options.input},
                fmt::format("holds measured points; a {} file needs values in every direction",
                            format.name),
                "fit a model to the points (umov invert) and export the fit.json");
  formats::replace_file(options.output, format.write_points(brdf.table, writing));
  return {std::string(format.name) + " points", brdf.table.points.size()};
}

/// A file of patches against the source's means over the same patches, and what the patches cost.
void read_patches_back(const formats::KlemsTable& back, const brdf::Table& source,
                       const std::vector<double>& written, Exported& exported) {
  const formats::KlemsMeans means(source, back.matrix().incident, written);
  const std::vector<double>& band_um = back.wavelengths_um();
  exported.difference = formats::compare_tables(back, means, band_um);
  exported.patch_means = true;
  exported.reflectance =
      formats::compare_reflectances(back, band_um.front(), means, band_um.front(), true);
  if (written.size() > 1) return;
  std::function<bool(const brdf::Geometry<double>&)> mirror_patch;
  const auto* model = dynamic_cast<const formats::ModelTable*>(&source);
  if (model != nullptr && model->has_mirror())
    mirror_patch = [&back](const auto& geometry) { return back.in_mirror_patch(geometry); };
  exported.without_mirror_patches = mirror_patch != nullptr;
  exported.pointwise = formats::compare_tables(back, source, band_um, written, mirror_patch);
}

/// What reading the file again yields, against what was written.
void read_back(const Options& options, const formats::TableFormat& format,
               const brdf::Table& source, const formats::TableWriting& writing,
               Exported& exported) {
  if (format.read == nullptr) return;
  const formats::TablePtr back = formats::read_table(options.output, format.name);
  const std::vector<double>& stored = back->wavelengths_um();
  std::vector<double> written = formats::written_wavelengths(source, writing);
  if (const auto* klems = dynamic_cast<const formats::KlemsTable*>(back.get());
      klems != nullptr && dynamic_cast<const formats::KlemsTable*>(&source) == nullptr)
    return read_patches_back(*klems, source, written, exported);
  // A format with fixed channels was sampled at their wavelengths, or with one value for all.
  if (written.size() != stored.size() && writing.wavelengths_um.empty()) written = stored;
  if (written.size() == 1) written.assign(stored.size(), written.front());
  if (written.size() != stored.size()) return;
  exported.difference = formats::compare_tables(*back, source, stored, written);
  const std::size_t middle = stored.size() / 2;
  exported.reflectance = formats::compare_reflectances(*back, stored[middle], source,
                                                       written[middle], format.takes_mirror);
}

Exported export_table(const Options& options, const formats::TablePtr& source,
                      formats::TableWriting writing, const Common& common) {
  const std::string written = formats::format_names(formats::FormatUse::writing);
  if (options.format.empty())
    throw Error("a table or model is written in the format that you name",
                "give --format with one of " + written);
  if (options.format == "csv")
    throw Error("--format csv is for scans and measured points",
                "for a table or model give one of " + written);
  const formats::TableFormat& format =
      formats::table_format(options.format, formats::FormatUse::writing);
  if (const auto* model = dynamic_cast<const formats::ModelTable*>(source.get()))
    for (std::string& note : model->notes(format.takes_mirror))
      writing.notes.push_back(std::move(note));
  Progress progress("sampling", common.quiet);
  writing.progress = [&](double done, double total) { progress.update(done, total); };
  formats::write_table(options.output, format.name, *source, writing);
  progress.finish();
  Exported exported{std::string(format.name), 0, writing.notes, {}, true};
  read_back(options, format, *source, writing, exported);
  return exported;
}

Exported export_source(const Options& options, const Common& common) {
  const formats::TableWriting writing = writing_of(options, common);
  if (!options.model.empty())
    return export_table(options, model_source(options, writing), writing, common);
  const std::string bytes = formats::read_whole_file(options.input);
  if (is_light(bytes, options.input)) {
    LightExported light =
        export_light(options.input, bytes, options.output, options.format, writing.program);
    return {options.format, 0, std::move(light.notes), std::move(light.what)};
  }
  if (formats::looks_like_hdf5(bytes)) {
    switch (formats::h5_kind(bytes, options.input)) {
      case formats::H5Kind::scan: {
        if (!options.format.empty() && options.format != "csv")
          throw Error(Place{options.input}, "holds raw records, which only CSV can take",
                      "reduce it to a brdf.h5 first (umov reduce), or give --format csv");
        const auto scan = formats::read_scan_h5(options.input);
        formats::write_scan_csv(scan.table, std::filesystem::path(options.output));
        return {"scan csv", scan.table.size()};
      }
      case formats::H5Kind::brdf:
        return export_points(options, writing);
      case formats::H5Kind::table:
        break;
      case formats::H5Kind::sim:
      case formats::H5Kind::other:
        throw Error(Place{options.input},
                    "is none of scan.h5, brdf.h5, table.h5 and a luminaire's sim.h5",
                    "name a file of umov");
    }
  }
  return export_table(options, table_source(bytes, options.input), writing, common);
}

void require_sources(const Options& options) {
  if (options.input.empty() == options.model.empty())
    throw Error(options.input.empty() ? "there is nothing to export"
                                      : "a file and --model are given at once",
                "give a file, or --model NAME with --set NAME=VALUE");
  if (options.model.empty() && !options.settings.empty())
    throw Error("--set belongs to --model", "leave it away, or name a model");
  require_new_output(options.input, options.output, options.force);
  // Tables that a model reads are inputs too.
  for (const std::string& setting : options.settings)
    if (const auto equals = setting.find('='); equals != std::string::npos)
      require_new_output(setting.substr(equals + 1), options.output, options.force);
}

nlohmann::ordered_json difference_json(const formats::TableDifference& difference) {
  return {{"directions", difference.directions},
          {"median", difference.median},
          {"p95", difference.p95},
          {"worst", difference.worst}};
}

void print_differences(const Exported& exported) {
  const bool patches = exported.patch_means;
  if (exported.difference)
    fmt::print("read back, it {}\n",
               exported.difference->sentence(patches ? "its source's means over the patches"
                                                     : "its source"));
  if (exported.pointwise)
    fmt::print("a patch is no direction: it {}{}\n",
               exported.pointwise->sentence("its source in single directions"),
               exported.without_mirror_patches ? ", mirror patches left out" : "");
  if (exported.reflectance)
    fmt::print("{}\n", exported.reflectance->sentence(patches ? "the source over the same rings"
                                                              : "the source"));
}

void run(const Options& options, const Common& common) {
  require_sources(options);
  const Exported exported = export_source(options, common);
  if (common.json) {
    nlohmann::ordered_json out{{"file", options.output}, {"format", exported.format}};
    if (exported.table) {
      out["notes"] = exported.notes;
      if (exported.difference) out["difference"] = difference_json(*exported.difference);
      if (exported.patch_means) out["difference"]["of"] = "patch means";
      if (exported.pointwise) {
        out["pointwise"] = difference_json(*exported.pointwise);
        if (exported.without_mirror_patches) out["pointwise"]["without"] = "mirror patches";
      }
      if (exported.reflectance)
        out["dhr"] = {{"theta_i_deg", formats::ReflectanceDifference::theta_i_deg},
                      {"file", exported.reflectance->found},
                      {"source", exported.reflectance->expected},
                      {"largest_difference", exported.reflectance->largest()}};
    } else if (!exported.light.empty()) {
      out["holds"] = exported.light;
      out["notes"] = exported.notes;
    } else {
      out["rows"] = exported.rows;
    }
    fmt::print("{}\n", out.dump());
  } else if (!common.quiet) {
    if (!exported.light.empty()) {
      fmt::print("{}: {}, {}\n", options.output, exported.format, exported.light);
      for (const std::string& note : exported.notes) fmt::print("note: {}\n", note);
      return;
    }
    if (!exported.table) {
      fmt::print("{}: {} with {} rows\n", options.output, exported.format, exported.rows);
      return;
    }
    fmt::print("{}: {}\n", options.output, exported.format);
    for (const std::string& note : exported.notes) fmt::print("note: {}\n", note);
    print_differences(exported);
  }
}

std::vector<std::string> format_names() {
  std::vector<std::string> names;
  for (const formats::TableFormat& format : formats::table_formats())
    if (format.write != nullptr || format.write_points != nullptr) names.emplace_back(format.name);
  if (std::find(names.begin(), names.end(), "csv") == names.end()) names.emplace_back("csv");
  for (const LightFormat& format : light_formats()) names.emplace_back(format.name);
  return names;
}

std::string footer() {
  std::string text =
      "Formats and what they are written from (table: table.h5, fit.json, --model, or a table file "
      "of another format; points: brdf.h5):\n"
      "  csv         Scan CSV of a scan.h5, list of points of a brdf.h5\n";
  for (const formats::TableFormat& format : formats::table_formats()) {
    if (format.write == nullptr && format.write_points == nullptr) continue;
    text += fmt::format("  {:11} {}; from {}{}{}\n", format.name, format.title,
                        format.write != nullptr ? "a table" : "",
                        format.write != nullptr && format.write_points != nullptr ? " or " : "",
                        format.write_points != nullptr ? "points" : "");
  }
  for (const LightFormat& format : light_formats())
    text += fmt::format("  {:11} {}; from {}\n", format.name, format.title,
                        format.map ? "a sim.h5" : "a sim.h5, IES or EULUMDAT file");
  return text +
         "What the numbers in each mean: docs/formats.\n"
         "Examples:\n"
         "  umov export scan.h5 -o scan.csv\n"
         "  umov export brdf.h5 --format csv -o brdf.csv\n"
         "  umov export fit.json --format rgl -o paint.bsdf\n"
         "  umov export lamp.ldt --format ies -o lamp.ies\n"
         "  umov export --model microfacet+lambertian --set 0.slope_rms=0.1 --set 1.rho=0.3 "
         "--format "
         "zemax -o gloss.bsdf";
}

}  // namespace

void add_export_command(CLI::App& root, const Common& common) {
  auto options = std::make_shared<Options>();
  auto* command = root.add_subcommand(
      "export",
      "Write a scan, BRDF, table, fit, model, intensity distribution or luminance map in a format "
      "of other programs");
  command->add_option(
      "file", options->input,
      "scan.h5, brdf.h5, table.h5, fit.json, a table file; sim.h5, IES or EULUMDAT");
  command->add_option("-o,--output", options->output, "file to write")->required();
  command
      ->add_option("--format", options->format,
                   "one of the formats below; csv if it is left out for a scan or points")
      ->check(CLI::IsMember(format_names()));
  command->add_option("--model", options->model, "model, or sum such as microfacet+nef");
  command
      ->add_option("--set", options->settings,
                   "parameter or choice of the model, NAME=VALUE; repeatable")
      ->allow_extra_args(false);
  command
      ->add_option(
          "--wavelength-nm", options->wavelengths_nm,
          "wavelengths to write, repeatable; default: those of the source, 632.8 for --model")
      ->allow_extra_args(false);
  command->add_flag("--force", options->force, "replace an existing file");
  command->footer(footer());
  command->callback([options, &common] { run(*options, common); });
}

}  // namespace umov::cli
