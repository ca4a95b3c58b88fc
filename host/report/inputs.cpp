#include "host/report/inputs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "host/calibrate/calibration.hpp"
#include "host/calibrate/calibration_file.hpp"
#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/hdf5_image.hpp"
#include "host/formats/sha256.hpp"

namespace umov::report {

namespace {

using Keys = std::vector<std::pair<std::string, std::string>>;

std::string value_of(const Keys& keys, std::string_view name) {
  for (const auto& [key, value] : keys)
    if (key == name) return value;
  return {};
}

std::string digest(const std::string& bytes) {
  formats::Sha256 sha;
  sha.update(std::string_view(bytes));
  return sha.hex_digest();
}

/// First character that is not blank, skipping a byte order mark.
char first_mark(std::string_view bytes) {
  if (bytes.starts_with("\xEF\xBB\xBF")) bytes.remove_prefix(3);
  const auto at = bytes.find_first_not_of(" \t\r\n");
  return at == std::string_view::npos ? '\0' : bytes[at];
}

Input read_hdf5(const std::filesystem::path& path, const std::string& bytes, Source source) {
  const formats::Hdf5Reader reader(bytes, path.string());
  const std::string format = reader.attribute("format");
  if (format.find("brdf") != std::string::npos)
    return BrdfInput{std::move(source), formats::read_brdf_h5(path)};
  if (format.find("scan") != std::string::npos)
    return ScanInput{std::move(source), formats::read_scan_h5(path)};
  if (format.find("cal") != std::string::npos)
    return CalibrationInput{std::move(source), std::make_shared<const calibrate::Calibration>(
                                                   calibrate::read_calibration(path))};
  throw Error({path.string()},
              format.empty()
                  ? "is an HDF5 file, but none of Umov's"
                  : fmt::format("has the format \"{}\", which a report cannot show", format),
              "give scan.h5, cal.h5, brdf.h5 or fit.json files");
}

/// Does a measurement name this file among its keys (by digest or by name)?
bool mentions(const BrdfInput& brdf, const Source& source, const std::string& content_sha256) {
  for (const auto& [key, value] : brdf.file.table.keys) {
    if (value == source.name ||
        (value.size() > source.name.size() && value.ends_with("/" + source.name)))
      return true;
    if (!source.sha256.empty() && value.find(source.sha256) != std::string::npos) return true;
    if (!content_sha256.empty() && value.find(content_sha256) != std::string::npos) return true;
  }
  return false;
}

std::string name_of(const BrdfInput& brdf) {
  const std::string name = value_of(brdf.file.table.keys, "sample");
  return name.empty() ? brdf.source.name : name;
}

std::string base_name(const std::string& path) {
  return std::filesystem::path(path).filename().string();
}

/// Samples under construction; `order` is the position of the measurement among the inputs.
struct Draft {
  Sample sample;
  std::size_t order = 0;
};

constexpr std::size_t none = static_cast<std::size_t>(-1);

std::size_t find_measurement(const std::vector<Draft>& drafts, const formats::FitResult& fit,
                             std::size_t fit_order, std::string& warning) {
  const auto matches = [&](auto&& test) {
    for (std::size_t i = 0; i < drafts.size(); ++i)
      if (drafts[i].sample.brdf && test(drafts[i])) return i;
    return none;
  };
  if (!fit.data_sha256.empty()) {
    const std::size_t by_digest = matches([&](const Draft& d) {
      return d.sample.brdf->file.content_sha256 == fit.data_sha256 ||
             d.sample.brdf->source.sha256 == fit.data_sha256;
    });
    if (by_digest != none) return by_digest;
  }
  std::size_t found = none;
  if (!fit.data_file.empty())
    found = matches(
        [&](const Draft& d) { return d.sample.brdf->source.name == base_name(fit.data_file); });
  if (found == none) {
    for (std::size_t i = 0; i < drafts.size(); ++i)
      if (drafts[i].sample.brdf && drafts[i].order < fit_order) found = i;
  }
  if (found == none) found = matches([](const Draft&) { return true; });
  if (found != none && !fit.data_sha256.empty())
    warning = fmt::format(
        "The fit names other data than these (digest {}…{}); it is shown with {} nevertheless. Fit "
        "again "
        "before relying on the residuals.",
        fit.data_sha256.substr(0, 12),
        fit.data_file.empty() ? "" : ", file " + base_name(fit.data_file),
        drafts[found].sample.brdf->source.name);
  return found;
}

void place_fit(std::vector<Draft>& drafts, FitInput fit, std::size_t order) {
  std::string warning;
  const std::size_t at = find_measurement(drafts, fit.fit, order, warning);
  Draft* target = nullptr;
  if (at == none) {
    drafts.push_back({Sample{fit.source.name, {}, {}, {}, {}, {}}, order});
    target = &drafts.back();
    target->sample.warnings.push_back(
        "The measurement that this model was fitted to was not given: there is nothing to compare "
        "it with.");
  } else if (drafts[at].sample.fit) {
    Draft again{drafts[at].sample, drafts[at].order};
    again.sample.name = fmt::format("{} ({})", name_of(*again.sample.brdf), fit.fit.model);
    again.sample.warnings.clear();
    again.sample.scans.clear();
    // After the last section of the same measurement.
    std::size_t after = at;
    while (after + 1 < drafts.size() && drafts[after + 1].order == drafts[at].order) ++after;
    target =
        &*drafts.insert(drafts.begin() + static_cast<std::ptrdiff_t>(after) + 1, std::move(again));
  } else {
    target = &drafts[at];
  }
  if (!warning.empty()) target->sample.warnings.push_back(std::move(warning));
  target->sample.fit = std::move(fit);
}

void place_scan(std::vector<Draft>& drafts, ScanInput scan, std::size_t order) {
  const auto& keys = scan.file.table.keys;
  const std::string sample = value_of(keys, "sample");
  for (Draft& draft : drafts) {
    if (draft.sample.brdf && mentions(*draft.sample.brdf, scan.source, scan.file.content_sha256)) {
      draft.sample.scans.push_back(std::move(scan));
      return;
    }
  }
  for (Draft& draft : drafts) {
    if (draft.sample.brdf && !sample.empty() &&
        value_of(draft.sample.brdf->file.table.keys, "sample") == sample) {
      draft.sample.scans.push_back(std::move(scan));
      return;
    }
  }
  Draft own{Sample{sample.empty() ? scan.source.name : sample, {}, {}, {}, {}, {}}, order};
  own.sample.scans.push_back(std::move(scan));
  drafts.push_back(std::move(own));
}

void place_calibration(std::vector<Draft>& drafts, CalibrationInput calibration,
                       std::size_t order) {
  bool placed = false;
  std::vector<Draft*> measured;
  for (Draft& draft : drafts) {
    if (!draft.sample.brdf) continue;
    measured.push_back(&draft);
    if (mentions(*draft.sample.brdf, calibration.source, {})) {
      draft.sample.calibration = calibration;
      placed = true;
    }
  }
  if (!placed && measured.size() == 1) {
    measured.front()->sample.calibration = calibration;
    placed = true;
  }
  if (placed) return;
  Draft own{Sample{"Calibration " + calibration.source.name, {}, {}, {}, {}, {}}, order};
  own.sample.calibration = std::move(calibration);
  drafts.push_back(std::move(own));
}

}  // namespace

Input read_input(const std::filesystem::path& path) {
  const std::string bytes = formats::read_whole_file(path);
  Source source{path.filename().string(), digest(bytes)};
  if (formats::looks_like_hdf5(bytes)) return read_hdf5(path, bytes, std::move(source));
  const char mark = first_mark(bytes);
  if (mark == '{') return FitInput{std::move(source), formats::fit_from_json(bytes, path.string())};
  if (mark == '#' || std::string_view(bytes).substr(0, 6) == "index,")
    return ScanInput{std::move(source), formats::read_scan(path)};
  throw Error({path.string()}, "is neither one of Umov's HDF5 files nor a fit.json nor a Scan CSV",
              "give scan.h5, cal.h5, brdf.h5 or fit.json files");
}

std::vector<Sample> group(std::vector<Input> inputs) {
  std::vector<Draft> drafts;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    if (auto* brdf = std::get_if<BrdfInput>(&inputs[i])) {
      Draft draft;
      draft.order = i;
      draft.sample.name = name_of(*brdf);
      draft.sample.brdf = std::move(*brdf);
      drafts.push_back(std::move(draft));
    }
  }
  for (std::size_t i = 0; i < inputs.size(); ++i)
    if (auto* fit = std::get_if<FitInput>(&inputs[i])) place_fit(drafts, std::move(*fit), i);
  for (std::size_t i = 0; i < inputs.size(); ++i)
    if (auto* scan = std::get_if<ScanInput>(&inputs[i])) place_scan(drafts, std::move(*scan), i);
  for (std::size_t i = 0; i < inputs.size(); ++i)
    if (auto* cal = std::get_if<CalibrationInput>(&inputs[i]))
      place_calibration(drafts, std::move(*cal), i);

  std::vector<Sample> samples;
  for (Draft& draft : drafts) {
    // Two fits of one measurement need names that tell them apart.
    const auto same = std::count_if(drafts.begin(), drafts.end(), [&](const Draft& other) {
      return other.sample.brdf && draft.sample.brdf && other.order == draft.order;
    });
    if (same > 1 && draft.sample.fit)
      draft.sample.name =
          fmt::format("{} ({})", name_of(*draft.sample.brdf), draft.sample.fit->fit.model);
    samples.push_back(draft.sample);
  }
  return samples;
}

}  // namespace umov::report
