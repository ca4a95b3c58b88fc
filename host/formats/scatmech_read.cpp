#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "host/errors/error.hpp"
#include "host/formats/decimal.hpp"
#include "host/formats/scatmech_text.hpp"
#include "host/formats/text_lines.hpp"

namespace umov::formats {
namespace {

constexpr std::size_t most_parameters = 1000, most_parts = 16;
constexpr int deepest_sum = 4;
constexpr double largest_wavelength_um = 100;
constexpr double same_slope = 1e-6;  ///< relative; files have few digits

constexpr std::string_view classes =
    "Lambertian_BRDF_Model, Facet_BRDF_Model, Shadowed_Facet_BRDF_Model, "
    "Microroughness_BRDF_Model, "
    "Diffuse_Subsurface_BRDF_Model, First_Diffuse_BRDF_Model and sums of them (Two_, Three_, "
    "Four_Source_BRDF_Model)";

bool is_name(std::string_view text) {
  return !text.empty() &&
         (std::isalpha(static_cast<unsigned char>(text.front())) || text.front() == '_') &&
         std::all_of(text.begin(), text.end(),
                     [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '.'; });
}

/// Without what SCATMECH prints behind a value: " (double: RMS slope)".
std::string_view without_description(std::string_view value) {
  for (std::size_t open = value.find(" ("); open != std::string_view::npos;
       open = value.find(" (", open + 1)) {
    const std::size_t colon = value.find(": ", open);
    if (colon == std::string_view::npos) break;
    if (is_name(value.substr(open + 2, colon - open - 2))) return trimmed(value.substr(0, open));
  }
  return value;
}

struct Entry {
  std::string value;
  std::size_t line;
  bool understood = false;
};

struct Index {
  double n, kappa;
};

/// One term of the sum.
struct Part {
  std::string model;
  std::vector<std::pair<std::string, double>> values;
};

class Reader {
 public:
  Reader(std::string_view text, const std::string& file) : file_(file) { split(text); }

  ScatmechModel read() {
    const double wavelength_um = number("lambda", 0.532, 1e-3, 1e9);
    if (wavelength_um > largest_wavelength_um)
      fail(line_of("lambda"), "lambda", decimal_text(wavelength_um) + " um is out of range",
           "lambda is in um, not nm: up to " + decimal_text(largest_wavelength_um));
    add_model("", 1.0, wavelength_um, 0);
    for (const auto& [name, entry] : entries_)
      if (!entry.understood)
        fail(entry.line, name, "is no parameter of " + class_,
             "see docs/formats/scatmech.md for what is understood");
    std::string name;
    for (const Part& part : parts_) name += (name.empty() ? "" : "+") + part.model;
    ScatmechModel result{brdf::Model::by_name(name), {}, wavelength_um, std::move(defaults_)};
    result.values = result.model.initial_values();
    for (std::size_t p = 0; p < parts_.size(); ++p)
      for (const auto& [parameter, value] : parts_[p].values)
        result.values[result.model.index_of(parts_.size() > 1 ? std::to_string(p) + "." + parameter
                                                              : parameter)] = value;
    try {
      result.model.check(result.values);
    } catch (const Error& error) {
      throw Error(Place{file_}, error.problem(), error.remedy());
    }
    return result;
  }

 private:
  [[noreturn]] void fail(std::size_t line, const std::string& what, const std::string& problem,
                         const std::string& remedy) const {
    throw Error(Place{file_, line, what.substr(0, 80)}, problem, remedy);
  }

  void split(std::string_view text) {
    LineReader lines(text);
    std::string_view line;
    while (lines.next(line)) {
      lines.require_line_end(line, file_);
      line = trimmed(line.substr(0, line.find_first_of("#;")));
      if (line.empty()) continue;
      const std::size_t equals = line.find('=');
      if (equals == std::string_view::npos) {
        if (!class_.empty() || !is_name(line))
          fail(lines.line_number(), "", "is neither the name of a class nor `name = value`",
               "one parameter a line");
        class_ = line;
        class_line_ = lines.line_number();
        continue;
      }
      const std::string name(trimmed(line.substr(0, equals)));
      if (!is_name(name))
        fail(lines.line_number(), "", "is no name of a parameter", "write name = value");
      if (entries_.size() >= most_parameters)
        fail(lines.line_number(), name, "there are too many parameters", "is this a model?");
      const std::string value(without_description(trimmed(line.substr(equals + 1))));
      if (value.empty()) fail(lines.line_number(), name, "has no value", "write name = value");
      if (!entries_.try_emplace(name, Entry{value, lines.line_number()}).second)
        fail(lines.line_number(), name, "is given twice", "keep one line");
    }
    if (class_.empty())
      fail(lines.line_number(), "", "does not name a class",
           "begin with the class, such as Facet_BRDF_Model");
  }

  void note_default(const std::string& name, const std::string& value) {
    std::string line = name + " = " + value;
    if (std::find(defaults_.begin(), defaults_.end(), line) == defaults_.end())
      defaults_.push_back(std::move(line));
  }

  std::string text(const std::string& name, const char* otherwise) {
    const auto found = entries_.find(name);
    if (found == entries_.end()) {
      note_default(name, otherwise);
      return otherwise;
    }
    found->second.understood = true;
    return found->second.value;
  }

  std::size_t line_of(const std::string& name) const {
    const auto found = entries_.find(name);
    return found == entries_.end() ? class_line_ : found->second.line;
  }

  double number(const std::string& name, double otherwise, double low, double high) {
    const auto found = entries_.find(name);
    if (found == entries_.end()) {
      note_default(name, decimal_text(otherwise));
      return otherwise;
    }
    found->second.understood = true;
    double value = 0;
    if (const char* problem = read_decimal(found->second.value, value))
      fail(found->second.line, name,
           std::string(problem) + ": \"" + found->second.value.substr(0, 40) + "\"",
           "give a plain number; tables in files and expressions are not read");
    if (!(value >= low && value <= high))
      fail(found->second.line, name, decimal_text(value) + " is out of range",
           "values lie from " + decimal_text(low) + " to " + decimal_text(high));
    return value;
  }

  /// "(n,k)" or "n".
  Index substrate(const std::string& prefix) {
    const std::string name = prefix + "substrate";
    const std::string value = text(name, "(4.05,0.05)");
    Index index{0, 0};
    std::string_view inner = value;
    if (inner.starts_with('(') && inner.ends_with(')')) inner = inner.substr(1, inner.size() - 2);
    const std::size_t comma = inner.find(',');
    const bool good = read_decimal(trimmed(inner.substr(0, comma)), index.n) == nullptr &&
                      (comma == std::string_view::npos ||
                       read_decimal(trimmed(inner.substr(comma + 1)), index.kappa) == nullptr);
    if (!good)
      fail(line_of(name), name, "is no index: \"" + value.substr(0, 40) + "\"",
           "write (n,k); files are not read");
    return index;
  }

  std::string chosen(const std::string& name, const char* otherwise,
                     const std::map<std::string, std::string>& known) {
    const std::string value = text(name, otherwise);
    if (const auto found = known.find(value); found != known.end()) return found->second;
    std::string list;
    for (const auto& [key, unused] : known) list += (list.empty() ? "" : ", ") + key;
    fail(line_of(name), name, "`" + value.substr(0, 60) + "` has no exact counterpart here",
         "counterparts exist for " + list);
  }

  void require_no_films(const std::string& prefix) {
    chosen(prefix + "stack", "No_StackModel", {{"No_StackModel", ""}});
  }

  void add_model(const std::string& prefix, double factor, double wavelength_um, int depth) {
    const std::string name =
        prefix.empty() ? class_
                       : text(prefix.substr(0, prefix.size() - 1), "Microroughness_BRDF_Model");
    if (parts_.size() >= most_parts)
      fail(line_of(prefix), prefix, "there are too many terms", "a sum has at most 16");
    if (number(prefix + "lambda", 0.532, 1e-3, 1e9) != wavelength_um)
      fail(line_of(prefix + "lambda"), prefix + "lambda", "differs from the whole model's lambda",
           "all parts of a sum share one wavelength");
    number(prefix + "type", 0, 0, 0);  // 1 to 3 are transmission and the sample from behind
    if (name == "Lambertian_BRDF_Model") return add_lambertian(prefix, factor);
    if (name == "Facet_BRDF_Model") return add_facets(prefix, factor, false);
    if (name == "Shadowed_Facet_BRDF_Model") return add_facets(prefix, factor, true);
    if (name == "Microroughness_BRDF_Model") return add_microroughness(prefix, factor);
    if (name == "Diffuse_Subsurface_BRDF_Model") return add_subsurface(prefix, factor);
    if (name == "First_Diffuse_BRDF_Model") return add_single_scatter(prefix, factor);
    const std::map<std::string, int> sums{{"Two_Source_BRDF_Model", 2},
                                          {"Three_Source_BRDF_Model", 3},
                                          {"Four_Source_BRDF_Model", 4}};
    const auto sum = sums.find(name);
    if (sum == sums.end() || depth >= deepest_sum)
      fail(prefix.empty() ? class_line_ : line_of(prefix.substr(0, prefix.size() - 1)), name,
           "has no exact counterpart here", "counterparts exist for " + std::string(classes));
    number(prefix + "correlation", 0, 0, 0);  // fields that interfere
    const Index whole = substrate(prefix);
    for (int s = 1; s <= sum->second; ++s) {
      const std::string source = prefix + "source" + std::to_string(s);
      const Index part = substrate(source + ".");
      if (part.n != whole.n || part.kappa != whole.kappa)
        fail(line_of(source + ".substrate"), source + ".substrate",
             "differs from the substrate of the sum",
             "SCATMECH wants the same substrate for all parts of a sum");
      add_model(source + ".", factor * number(prefix + "factor" + std::to_string(s), 1, 0, 1e9),
                wavelength_um, depth + 1);
    }
  }

  double table_reflectance(const std::string& prefix) {
    chosen(prefix + "reflectance", "Table_Reflectance", {{"Table_Reflectance", ""}});
    return number(prefix + "reflectance.table", 1, 0, 1e6);
  }

  void add_lambertian(const std::string& prefix, double factor) {
    substrate(prefix);
    parts_.push_back({"lambertian", {{"rho", factor * table_reflectance(prefix)}}});
  }

  void add_facets(const std::string& prefix, double factor, bool shadowed) {
    require_no_films(prefix);
    const Index index = substrate(prefix);
    const std::string slopes = chosen(prefix + "sdf", "Exponential_Slope_Distribution_Function",
                                      {{"Gaussian_Slope_Distribution_Function", "gaussian"},
                                       {"Exponential_Slope_Distribution_Function", "exponential"}});
    // Their rms slope is that of both directions together.
    const double slope_rms = number(prefix + "sdf.s", 0.1, 1e-6, 1e3) / std::numbers::sqrt2;
    const std::string shadowing =
        shadowed ? chosen(prefix + "shadow", "Torrance_Sparrow_Shadow_Function",
                          {{"Unit_Shadow_Function", "none"},
                           {"Torrance_Sparrow_Shadow_Function", "vgroove"},
                           {"Smith_Shadow_Function", "smith"},
                           {"Maxwell_Beard_Shadow_Function", "maxwell-beard"}})
                 : "none";
    Part part{"microfacet:shadowing=" + shadowing + ",slopes=" + slopes,
              {{"n", index.n}, {"kappa", index.kappa}, {"slope_rms", slope_rms}, {"bias", factor}}};
    if (shadowing == "smith") {
      const double w = number(prefix + "shadow.w", 0.35, 1e-9, 1e3);
      if (std::abs(w - slope_rms) > same_slope * slope_rms)
        fail(line_of(prefix + "shadow.w"), prefix + "shadow.w",
             "shadows by another slope (" + decimal_text(w) +
                 ") than the facets have along one direction (" + decimal_text(slope_rms) + ")",
             "the counterpart exists for shadow.w = sdf.s/sqrt(2)");
    }
    if (shadowing == "maxwell-beard") {
      part.values.emplace_back("omega", number(prefix + "shadow.Omega", 0.7, 1e-9, 1e3));
      part.values.emplace_back("tau", number(prefix + "shadow.tau", 0.25, 1e-9, 1e3));
    }
    parts_.push_back(std::move(part));
  }

  void add_microroughness(const std::string& prefix, double factor) {
    const Index index = substrate(prefix);
    const std::string psd =
        chosen(prefix + "psd", "ABC_PSD_Function",
               {{"ABC_PSD_Function", "abc"}, {"Gaussian_PSD_Function", "gaussian"}});
    Part part{"rayleigh-rice:psd=" + psd, {{"n", index.n}, {"kappa", index.kappa}}};
    // The BRDF is proportional to the power spectrum, that is to A or to sigma².
    if (psd == "abc") {
      part.values.emplace_back("abc_a", factor * number(prefix + "psd.A", 0.01, 0, 1e9));
      part.values.emplace_back("abc_b", number(prefix + "psd.B", 362, 0, 1e9));
      part.values.emplace_back("abc_c", number(prefix + "psd.C", 2.5, -100, 100));
    } else {
      part.values.emplace_back("sigma_um",
                               std::sqrt(factor) * number(prefix + "psd.sigma", 0.05, 0, 1e6));
      part.values.emplace_back("correlation_um", number(prefix + "psd.length", 5, 0, 1e9));
    }
    parts_.push_back(std::move(part));
  }

  /// Bodies below an interface that does not absorb.
  double body_index(const std::string& prefix) {
    const Index index = substrate(prefix);
    if (index.kappa != 0)
      fail(line_of(prefix + "substrate"), prefix + "substrate", "absorbs",
           "the counterpart exists for (n,0)");
    require_no_films(prefix);
    return index.n;
  }

  void add_subsurface(const std::string& prefix, double factor) {
    const double n = body_index(prefix);
    if (factor != 1)
      fail(class_line_, prefix, "a subsurface term with a factor",
           "its counterpart has no factor; use 1");
    parts_.push_back({"subsurface", {{"n", n}, {"rho", table_reflectance(prefix)}}});
  }

  void add_single_scatter(const std::string& prefix, double factor) {
    const double n = body_index(prefix);
    number(prefix + "depoll", 0, 0, 0);
    number(prefix + "depolc", 0, 0, 0);
    const std::string phase = prefix + "phase_function";
    chosen(phase, "Unpolarized_Phase_Function", {{"Unpolarized_Phase_Function", ""}});
    chosen(phase + ".phase_function", "Henyey_Greenstein_Phase_Function",
           {{"Henyey_Greenstein_Phase_Function", ""}});
    // Natural logarithms of coefficients in 1/um.
    const double scattering = number(phase + ".log_scattering", 0, -200, 200);
    const double absorption = number(phase + ".log_absorption", -20, -200, 200);
    parts_.push_back({"single-scatter",
                      {{"n", n},
                       {"albedo", factor / (1 + std::exp(absorption - scattering))},
                       {"asymmetry", number(phase + ".phase_function.g", 0.01, -1, 1)}}});
  }

  std::string file_;
  std::string class_;
  std::size_t class_line_ = 0;
  std::map<std::string, Entry> entries_;
  std::vector<Part> parts_;
  std::vector<std::string> defaults_;
};

}  // namespace

ScatmechModel parse_scatmech(std::string_view text, const std::string& file) {
  return Reader(text, file).read();
}

bool is_scatmech(std::string_view bytes) {
  LineReader lines(bytes.substr(0, 65536));
  std::string_view line;
  while (lines.next(line)) {
    line = trimmed(line.substr(0, line.find_first_of("#;")));
    if (!line.empty()) return is_name(line) && line.ends_with("_BRDF_Model");
  }
  return false;
}

TablePtr read_scatmech(std::string_view bytes, const std::string& file) {
  ScatmechModel read = parse_scatmech(bytes, file);
  std::string description = "model " + read.model.name() + ", file " + file;
  std::vector<std::string> notes;
  if (!read.defaults.empty())
    notes.push_back(fmt::format("the file leaves out what has SCATMECH's defaults then: {}",
                                fmt::join(read.defaults, ", ")));
  return std::make_shared<ModelTable>(std::move(read.model),
                                      std::vector<double>{read.wavelength_um},
                                      std::vector<std::vector<double>>{std::move(read.values)},
                                      std::move(description), std::move(notes));
}

}  // namespace umov::formats
