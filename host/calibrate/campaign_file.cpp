// campaign.toml and the scans that it names.
#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include <fmt/format.h>

#include "host/calibrate/campaign.hpp"
#include "host/calibrate/published_reflectance.hpp"
#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/scan_h5.hpp"
#include "host/formats/sha256.hpp"
#include "host/toml/parse.hpp"

namespace umov::calibrate {

namespace {

namespace fs = std::filesystem;

/// One table of the file; notes the keys that were asked for, so that the others can be refused.
class Table {
 public:
  Table(const toml::table* table, std::string file, std::string path)
      : table_(table), file_(std::move(file)), path_(std::move(path)) {}

  const toml::node* find(std::string_view key) {
    known_.emplace(key);
    return table_ == nullptr ? nullptr : table_->get(key);
  }

  Table inner(std::string_view key) {
    const toml::node* node = find(key);
    if (node != nullptr && !node->is_table())
      fail(*node, key, "is no table", fmt::format("write [{}] on a line of its own", key));
    return Table(node == nullptr ? nullptr : node->as_table(), file_, std::string(key));
  }

  void text(std::string_view key, std::string& value) {
    if (const toml::node* node = find(key)) value = text_of(*node, key);
  }

  void number(std::string_view key, double lowest, double highest, double& value) {
    const toml::node* node = find(key);
    if (node == nullptr) return;
    const auto given = node->is_number() ? node->value<double>() : std::nullopt;
    if (!given || !std::isfinite(*given) || *given < lowest || *given > highest)
      fail(*node, key, "is no number within the limits",
           fmt::format("permitted: {:g} to {:g}", lowest, highest));
    value = *given;
  }

  void flag(std::string_view key, bool& value) {
    const toml::node* node = find(key);
    if (node == nullptr) return;
    const auto given = node->value_exact<bool>();
    if (!given) fail(*node, key, "is neither true nor false", "write true or false");
    value = *given;
  }

  /// All entries `name = "text"`.
  std::vector<std::pair<std::string, std::string>> entries() {
    std::vector<std::pair<std::string, std::string>> result;
    if (table_ == nullptr) return result;
    for (const auto& [key, node] : *table_) {
      known_.emplace(key.str());
      result.emplace_back(std::string(key.str()), text_of(node, key.str()));
    }
    return result;
  }

  std::string text_of(const toml::node& node, std::string_view key) const {
    const auto value = node.value_exact<std::string>();
    if (!value || value->empty())
      fail(node, key, "is not a text", "write it between quotation marks");
    return *value;
  }

  void refuse_unknown() const {
    if (table_ == nullptr) return;
    for (const auto& [key, node] : *table_) {
      if (known_.contains(key.str())) continue;
      std::string all;
      for (const std::string& name : known_) all += (all.empty() ? "" : ", ") + name;
      fail(node, key.str(), "is unknown here", "known are " + all);
    }
  }

  [[noreturn]] void fail(const toml::node& at, std::string_view key, const std::string& problem,
                         const std::string& remedy) const {
    throw Error(Place{file_, at.source().begin.line,
                      path_.empty() ? std::string(key) : path_ + "." + std::string(key)},
                problem, remedy);
  }

 private:
  const toml::table* table_;
  std::string file_, path_;
  std::set<std::string, std::less<>> known_;
};

bool matches(std::string_view pattern, std::string_view name) {
  if (pattern.empty()) return name.empty();
  if (pattern.front() == '*') {
    for (std::size_t k = 0; k <= name.size(); ++k)
      if (matches(pattern.substr(1), name.substr(k))) return true;
    return false;
  }
  return !name.empty() && (pattern.front() == '?' || pattern.front() == name.front()) &&
         matches(pattern.substr(1), name.substr(1));
}

fs::path beside(const fs::path& file, const std::string& named) {
  const fs::path path = named;
  return path.is_absolute() ? path : file.parent_path() / path;
}

void read_scan_list(Table& root, const fs::path& file, CampaignOptions& options) {
  const toml::node* node = root.find("scans");
  if (node == nullptr) return;
  const toml::array* list = node->as_array();
  if (list == nullptr || list->empty())
    root.fail(*node, "scans", "is no list of files", "write scans = [\"scans/*.h5\"]");
  for (const toml::node& entry : *list)
    options.scans.push_back(beside(file, root.text_of(entry, "scans")));
}

void read_bias(Table& root, CampaignOptions& options) {
  std::string bias = "auto";
  root.text("detector_bias", bias);
  using Bias = CalibrateOptions::Bias;
  if (bias != "auto" && bias != "on" && bias != "off")
    root.fail(*root.find("detector_bias"), "detector_bias", "is none of auto, on, off",
              "choose one of them");
  options.bias = bias == "on" ? Bias::on : bias == "off" ? Bias::off : Bias::automatic;
}

CampaignOptions options_of(const toml::table& parsed, const fs::path& file) {
  CampaignOptions options;
  options.file = file.string();
  Table root(&parsed, options.file, "");
  read_scan_list(root, file, options);
  root.text("standard", options.standard);
  read_bias(root, options);
  double degree = options.max_degree;
  root.number("max_degree", 0, 16, degree);
  if (degree != std::floor(degree))
    root.fail(*root.find("max_degree"), "max_degree", "is no whole number", "drop the decimals");
  options.max_degree = static_cast<int>(degree);

  Table tolerance = root.inner("tolerance");
  tolerance.number("amplifier_range", 1e-9, 1, options.linearity.range_tolerance);
  tolerance.number("nonlinearity_per_v", 1e-9, 10, options.linearity.kappa_tolerance_per_v);
  tolerance.number("drift", 1e-9, 1, options.linearity.drift);
  tolerance.number("stray_per_sr", 0, 1, options.stray.tolerance_per_sr);
  tolerance.refuse_unknown();

  Table declared = root.inner("declared");
  for (const DeclaredKey& key : declared_keys)
    declared.number(key.name, 0, key.largest, options.declared.*key.value);
  declared.refuse_unknown();

  Table mirror = root.inner("mirror");
  mirror.text("index", options.polarization.index);
  if (options.polarization.index.ends_with(".yml"))
    options.polarization.index = beside(file, options.polarization.index).string();
  mirror.number("n_relative_u", 0, 1, options.polarization.n_relative_u);
  mirror.number("kappa_u", 0, 10, options.polarization.kappa_u);
  mirror.number("incidence_offset_u_deg", 1e-6, 10, options.polarization.incidence_offset_u_deg);
  mirror.number("tilt_out_of_plane_u_deg", 1e-6, 10, options.polarization.tilt_out_of_plane_u_deg);
  mirror.number("bias_u", 1e-6, 1, options.polarization.bias_u);
  mirror.number("position_u_deg", 0, 10, options.polarization.position_u_deg);
  mirror.refuse_unknown();

  Table reciprocity = root.inner("reciprocity");
  reciprocity.text("scan", options.reciprocity_scan);
  reciprocity.number("within_deg", 0, 90, options.reciprocity.within_deg);
  reciprocity.number("tolerance_deg", 1e-6, 10, options.reciprocity.tolerance_deg);
  reciprocity.number("target", 1e-6, 1, options.reciprocity_target);
  reciprocity.flag("shape_of_standard", options.shape_from_reciprocity);
  reciprocity.refuse_unknown();

  Table reference = root.inner("reference_brdf");
  for (const auto& [name, table] : reference.entries())
    options.reference_brdf.emplace_back(name, beside(file, table));
  Table compare = root.inner("compare");
  options.compare = compare.entries();
  for (const auto& [name, published] : options.compare)
    if (!published_reflectance(published, 532))
      throw Error(Place{options.file, 0, "compare." + name},
                  fmt::format("no published table has `{}`", published),
                  "known are SRS-99, SRS-70, SRS-50");
  root.refuse_unknown();
  return options;
}

}  // namespace

std::vector<fs::path> files_of(const fs::path& pattern) {
  const std::string name = pattern.filename().string();
  if (name.find_first_of("*?") == std::string::npos) return {pattern};
  const fs::path folder = pattern.has_parent_path() ? pattern.parent_path() : fs::path(".");
  std::vector<fs::path> found;
  std::error_code problem;
  for (const auto& entry : fs::directory_iterator(folder, problem))
    if (entry.is_regular_file() && matches(name, entry.path().filename().string()))
      found.push_back(entry.path());
  if (found.empty())
    throw Error(Place{pattern.string()}, "no file matches",
                "measure the scans first, or correct the pattern");
  std::sort(found.begin(), found.end());
  return found;
}

CampaignOptions read_campaign(const fs::path& path) {
  const std::string text = formats::read_whole_file(path);
  return options_of(parse_toml(text, path.string(), "compare with examples/campaign/campaign.toml"),
                    path);
}

std::vector<CampaignScan> read_campaign_scans(const CampaignOptions& options) {
  std::vector<CampaignScan> scans;
  for (const fs::path& pattern : options.scans)
    for (const fs::path& file : files_of(pattern)) {
      CampaignScan scan;
      scan.table = formats::read_scan(file).table;
      scan.file = file.string();
      scan.name = scan.table.key("sample").value_or(file.stem().string());
      scan.role = scan.table.key("role").value_or("");
      scan.sha256 = formats::sha256_of_file(file);
      scans.push_back(std::move(scan));
    }
  if (scans.empty())
    throw Error(Place{options.file, 0, "scans"}, "the campaign names no scans",
                "write scans = [\"scans/*.h5\"], or name files on the command line");
  check_campaign_scans(scans, options);
  return scans;
}

}  // namespace umov::calibrate
