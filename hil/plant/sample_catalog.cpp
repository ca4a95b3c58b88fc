#include "hil/plant/sample_catalog.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <utility>

#include "hil/plant/diffuser_sample.hpp"
#include "hil/plant/embedded_samples.hpp"
#include "hil/plant/facet_sample.hpp"
#include "hil/plant/mirror_sample.hpp"
#include "hil/plant/paint_sample.hpp"
#include "hil/plant/table_sample.hpp"
#include "host/errors/error.hpp"
#include "host/toml/parse.hpp"

namespace umov::plant {
namespace {

Place place_of(const toml::node& node, const std::string& origin) {
  return {origin, node.source().begin.line, {}};
}

/// Reads keys of one sample file and remembers which were asked for, so that the rest can be
/// refused.
class SampleFile {
 public:
  SampleFile(std::string_view text, std::string origin)
      : origin_(std::move(origin)), table_(parse_toml(text, origin_, "correct the TOML")) {
    if (const toml::node* node = find("wavelengths_nm"))
      wavelengths_nm_ = list(*node, "wavelengths_nm");
    for (std::size_t i = 1; i < wavelengths_nm_.size(); ++i) {
      if (!(wavelengths_nm_[i] > wavelengths_nm_[i - 1])) {
        throw Error(place_of(*table_.get("wavelengths_nm"), origin_),
                    "\"wavelengths_nm\" does not ascend", "sort it");
      }
    }
  }

  std::string text(const char* key) {
    const toml::node* node = find(key);
    if (node == nullptr) throw Error({origin_}, missing(key), "add it");
    const auto value = node->value<std::string>();
    if (!value)
      throw Error(place_of(*node, origin_), quoted(key) + " is not text", "put it in quotes");
    return *value;
  }

  std::string text_or(const char* key, const std::string& standard) {
    return find(key) == nullptr ? standard : text(key);
  }

  /// A number between the bounds; `standard` where the key is absent.
  double number(const char* key, double standard, double low, double high) {
    const toml::node* node = find(key);
    if (node == nullptr) return standard;
    return bounded(*node, key, low, high);
  }

  /// A number, or a list with one entry a wavelength.
  Spectrum spectrum(const char* key, double standard, double low, double high) {
    const toml::node* node = find(key);
    if (node == nullptr) return Spectrum(standard);
    if (!node->is_array()) return Spectrum(bounded(*node, key, low, high));
    std::vector<double> values = list(*node, key);
    if (values.size() != wavelengths_nm_.size()) {
      throw Error(place_of(*node, origin_),
                  quoted(key) + " has " + std::to_string(values.size()) +
                      " entries, \"wavelengths_nm\" " + std::to_string(wavelengths_nm_.size()),
                  "give one entry a wavelength");
    }
    for (const double value : values) check(value, *node, key, low, high);
    return Spectrum(wavelengths_nm_, std::move(values));
  }

  /// To be called last.
  void refuse_unknown_keys() const {
    for (const auto& [key, node] : table_) {
      if (known_.contains(std::string(key.str()))) continue;
      std::string names;
      for (const std::string& name : known_) names += (names.empty() ? "" : ", ") + name;
      throw Error(place_of(node, origin_), "unknown key \"" + std::string(key.str()) + "\"",
                  "this kind of sample has " + names);
    }
  }

  const std::string& origin() const { return origin_; }

 private:
  static std::string quoted(const char* key) { return "\"" + std::string(key) + "\""; }
  static std::string missing(const char* key) { return "key " + quoted(key) + " is missing"; }

  const toml::node* find(const char* key) {
    known_.insert(key);
    return table_.get(key);
  }

  void check(double value, const toml::node& node, const char* key, double low, double high) const {
    if (value >= low && value <= high) return;
    std::ostringstream range;
    range << "give a value from " << low << " to " << high;
    throw Error(place_of(node, origin_), quoted(key) + " is out of range", range.str());
  }

  double bounded(const toml::node& node, const char* key, double low, double high) const {
    const auto value = node.value<double>();
    if (!value || !std::isfinite(*value)) {
      throw Error(
          place_of(node, origin_), quoted(key) + " is not a number",
          "give a number" + std::string(wavelengths_nm_.empty() ? "" : " or a list of numbers"));
    }
    check(*value, node, key, low, high);
    return *value;
  }

  std::vector<double> list(const toml::node& node, const char* key) const {
    const toml::array* array = node.as_array();
    if (array == nullptr || array->empty()) {
      throw Error(place_of(node, origin_), quoted(key) + " is not a list of numbers",
                  "write [532, 633, 814]");
    }
    std::vector<double> values;
    for (const toml::node& entry : *array) {
      const auto value = entry.value<double>();
      if (!value || !std::isfinite(*value)) {
        throw Error(place_of(entry, origin_), quoted(key) + " has an entry that is not a number",
                    "write numbers only");
      }
      values.push_back(*value);
    }
    return values;
  }

  std::string origin_;
  toml::table table_;
  std::vector<double> wavelengths_nm_;
  std::set<std::string> known_;
};

std::unique_ptr<Sample> make_paint(SampleFile& file, std::string name) {
  PaintParameters p;
  p.n = file.spectrum("n", 1.5, 1.0, 10.0);
  p.kappa = file.spectrum("kappa", 0.0, 0.0, 20.0);
  p.sigma_um = file.number("sigma_um", 1.0, 0.01, 1000.0);
  p.tau_um = file.number("tau_um", 20.0, 0.1, 1e5);
  p.k_dd = file.spectrum("k_dd", 1.0, 0.0, 10.0);
  p.k_udf = file.spectrum("k_udf", 0.0, 0.0, 1.0);
  p.k_uds = file.spectrum("k_uds", 0.0, 0.0, 1.0);
  p.k_fs = file.spectrum("k_fs", 0.0, 0.0, 1.0);
  p.fs_polarization = file.spectrum("fs_polarization", 0.0, 0.0, 1.0);
  p.fs_width_deg = file.number("fs_width_deg", 10.0, 0.1, 60.0);
  file.refuse_unknown_keys();
  return std::make_unique<PaintSample>(std::move(name), std::move(p));
}

std::unique_ptr<Sample> make_diffuser(SampleFile& file, std::string name) {
  DiffuserParameters p;
  p.dhr = file.spectrum("dhr", 0.99, 0.0, 1.0);
  p.roll_off = file.number("roll_off", 0.0, 0.0, 1.0);
  p.kept = file.number("kept", 0.0, 0.0, 1.0);
  p.surface = file.number("surface", 0.0, 0.0, 1.0);
  p.surface_n = file.number("surface_n", 1.35, 1.0, 3.0);
  p.surface_slope = file.number("surface_slope", 0.5, 0.05, 1.0);
  file.refuse_unknown_keys();
  return std::make_unique<DiffuserSample>(std::move(name), std::move(p));
}

SlopeDistribution distribution(SampleFile& file, const char* key) {
  const std::string name = file.text_or(key, "gaussian");
  if (name == "gaussian") return SlopeDistribution::gaussian;
  if (name == "ggx") return SlopeDistribution::ggx;
  if (name == "ring") return SlopeDistribution::ring;
  throw Error({file.origin()}, "unknown distribution of slopes \"" + name + "\"",
              "it is gaussian, ggx or ring");
}

std::unique_ptr<Sample> make_facets(SampleFile& file, std::string name) {
  FacetParameters p;
  p.n = file.spectrum("n", 1.5, 1.0, 10.0);
  p.kappa = file.spectrum("kappa", 0.0, 0.0, 20.0);
  p.rho_d1 = file.spectrum("rho_d1", 0.0, 0.0, 1.0);
  p.rho_d2 = file.spectrum("rho_d2", 0.0, 0.0, 1.0);
  p.forward_per_sr = file.spectrum("forward_per_sr", 0.0, 0.0, 100.0);
  p.forward_width_deg = file.number("forward_width_deg", 20.0, 0.1, 60.0);
  FacetLobe& first = p.lobes.front();
  first.distribution = distribution(file, "distribution");
  first.weight = file.number("weight", 1.0, 0.0, 10.0);
  first.slope = file.number("slope", 0.15, 0.005, 2.0);
  first.slope_y = file.number("slope_y", 0.0, 0.0, 2.0);
  first.steepness = file.number("steepness", 0.3, 0.0, 2.0);
  FacetLobe second;
  second.distribution = distribution(file, "distribution_2");
  second.weight = file.number("weight_2", 0.0, 0.0, 10.0);
  second.slope = file.number("slope_2", 0.05, 0.005, 2.0);
  second.slope_y = file.number("slope_y_2", 0.0, 0.0, 2.0);
  second.steepness = file.number("steepness_2", 0.3, 0.0, 2.0);
  if (second.weight > 0.0) p.lobes.push_back(second);
  file.refuse_unknown_keys();
  return std::make_unique<FacetSample>(std::move(name), std::move(p));
}

std::unique_ptr<Sample> make_from(SampleFile& file, const std::string& folder) {
  const std::string name = file.text("name");
  file.text("title");
  const std::string kind = file.text("kind");
  if (kind == "paint") return make_paint(file, name);
  if (kind == "diffuser") return make_diffuser(file, name);
  if (kind == "facets") return make_facets(file, name);
  if (kind == "mirror") {
    const std::string index = file.text("index");
    file.refuse_unknown_keys();
    const bool is_file = index.ends_with(".yml");
    return std::make_unique<MirrorSample>(
        name, is_file
                  ? optics::IndexTable::from_file((std::filesystem::path(folder) / index).string())
                  : optics::IndexTable::embedded(index));
  }
  if (kind == "table") {
    const std::string path = file.text("file");
    file.refuse_unknown_keys();
    return std::make_unique<TableSample>(
        TableSample::from_file((std::filesystem::path(folder) / path).string()));
  }
  throw Error({file.origin()}, "unknown kind of sample \"" + kind + "\"",
              "kind is paint, diffuser, facets, mirror or table");
}

const EmbeddedSample* find_embedded(const std::string& name) {
  for (const EmbeddedSample& entry : embedded_samples()) {
    if (entry.name == name) return &entry;
  }
  return nullptr;
}

[[noreturn]] void refuse_name(const std::string& name) {
  std::string names;
  for (const std::string& known : sample_names()) names += (names.empty() ? "" : ", ") + known;
  throw Error("no sample is called \"" + name + "\"",
              "shipped samples are " + names + "; a path must end in .toml or .csv");
}

}  // namespace

std::vector<std::string> sample_names() {
  std::vector<std::string> names;
  for (const EmbeddedSample& entry : embedded_samples()) names.emplace_back(entry.name);
  return names;
}

std::string sample_title(const std::string& name) {
  const EmbeddedSample* entry = find_embedded(name);
  if (entry == nullptr) refuse_name(name);
  return SampleFile(entry->text, name + ".toml").text("title");
}

std::unique_ptr<Sample> make_sample(const std::string& name_or_path) {
  if (const EmbeddedSample* entry = find_embedded(name_or_path)) {
    return sample_from_toml(entry->text, name_or_path + ".toml");
  }
  if (name_or_path.ends_with(".csv")) {
    return std::make_unique<TableSample>(TableSample::from_file(name_or_path));
  }
  if (!name_or_path.ends_with(".toml")) refuse_name(name_or_path);
  std::ifstream file(name_or_path, std::ios::binary);
  if (!file) throw Error({name_or_path}, "cannot be read", "check the path and its permissions");
  std::ostringstream text;
  text << file.rdbuf();
  return sample_from_toml(text.str(), name_or_path,
                          std::filesystem::path(name_or_path).parent_path().string());
}

std::unique_ptr<Sample> sample_from_toml(std::string_view text, const std::string& origin,
                                         const std::string& folder) {
  SampleFile file(text, origin);
  return make_from(file, folder);
}

}  // namespace umov::plant
