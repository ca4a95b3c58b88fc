#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "host/brdf/catalogue.hpp"
#include "host/errors/error.hpp"
#include "host/formats/decimal.hpp"
#include "host/formats/scatmech_text.hpp"

namespace umov::formats {
namespace {

using brdf::Component;
using brdf::Kind;

constexpr std::array<std::string_view, 5> sums{"", "", "Two_Source_BRDF_Model",
                                               "Three_Source_BRDF_Model", "Four_Source_BRDF_Model"};

struct Line {
  std::string name, value;
};

/// One term: its class, its parameters without substrate and lambda, and a factor before it.
struct Term {
  std::string name;
  std::vector<Line> lines;
  double factor = 1;
  std::optional<std::pair<double, double>> index;  ///< n, kappa
};

[[noreturn]] void refuse(const std::string& what) {
  throw Error(
      what + " has no exact counterpart in SCATMECH",
      "counterparts exist for lambertian, nef without rho_d2, microfacet (shadowing none, vgroove, "
      "smith, "
      "maxwell-beard), rayleigh-rice, subsurface, single-scatter and sums of up to four of them");
}

std::string number(double value) {
  std::string text;
  append_shortest(text, value);
  return text;
}

Term lambertian(double reflectance) {
  return {"Lambertian_BRDF_Model",
          {{"reflectance", "Table_Reflectance"}, {"reflectance.table", number(reflectance)}},
          1,
          {}};
}

Term facets(const Component& part, std::span<const double> p) {
  Term term{"Shadowed_Facet_BRDF_Model", {}, p[3], std::pair(p[0], p[1])};
  if (part.slopes != brdf::Slopes::gaussian && part.slopes != brdf::Slopes::exponential)
    refuse("microfacet with this slope distribution");
  term.lines.push_back({"sdf", part.slopes == brdf::Slopes::gaussian
                                   ? "Gaussian_Slope_Distribution_Function"
                                   : "Exponential_Slope_Distribution_Function"});
  term.lines.push_back({"sdf.s", number(p[2] * std::numbers::sqrt2)});
  term.lines.push_back({"stack", "No_StackModel"});
  switch (part.shadowing) {
    case brdf::Shadowing::none:
      term.name = "Facet_BRDF_Model";
      break;
    case brdf::Shadowing::v_groove:
      term.lines.push_back({"shadow", "Torrance_Sparrow_Shadow_Function"});
      break;
    case brdf::Shadowing::smith:
      term.lines.push_back({"shadow", "Smith_Shadow_Function"});
      term.lines.push_back({"shadow.w", number(p[2])});
      break;
    case brdf::Shadowing::maxwell_beard:
      term.lines.push_back({"shadow", "Maxwell_Beard_Shadow_Function"});
      term.lines.push_back({"shadow.Omega", number(p[4])});
      term.lines.push_back({"shadow.tau", number(p[5])});
      break;
    case brdf::Shadowing::smith_correlated:
      refuse("microfacet with shadowing smith-correlated");
  }
  return term;
}

Term microroughness(const Component& part, std::span<const double> p) {
  Term term{"Microroughness_BRDF_Model", {}, 1, std::pair(p[0], p[1])};
  if (part.psd == brdf::Psd::gaussian) {
    term.lines = {{"psd", "Gaussian_PSD_Function"},
                  {"psd.sigma", number(p[2])},
                  {"psd.length", number(p[3])}};
  } else {
    term.lines = {{"psd", "ABC_PSD_Function"},
                  {"psd.A", number(p[2])},
                  {"psd.B", number(p[3])},
                  {"psd.C", number(p[4])}};
  }
  return term;
}

Term single_scatter(std::span<const double> p) {
  if (!(p[1] > 0)) refuse("single-scatter with albedo 0");
  // Only the ratio of the two coefficients matters; -40 leaves out 4e-18 of the light.
  const double absorption = p[1] < 1 ? std::log((1 - p[1]) / p[1]) : -40;
  return {"First_Diffuse_BRDF_Model",
          {{"depoll", "0"},
           {"depolc", "0"},
           {"phase_function", "Unpolarized_Phase_Function"},
           {"phase_function.phase_function", "Henyey_Greenstein_Phase_Function"},
           {"phase_function.phase_function.g", number(p[2])},
           {"phase_function.log_absorption", number(std::max(absorption, -40.0))},
           {"phase_function.log_scattering", "0"},
           {"stack", "No_StackModel"}},
          1,
          std::pair(p[0], 0.0)};
}

Term term_of(const Component& part, std::span<const double> p) {
  switch (part.kind) {
    case Kind::lambertian:
      return lambertian(p[0]);
    case Kind::nef:
      if (p[1] != 0) refuse("nef with rho_d2");
      return lambertian(p[0] * std::numbers::pi);
    case Kind::microfacet:
      return facets(part, p);
    case Kind::rayleigh_rice:
      return microroughness(part, p);
    case Kind::subsurface: {
      Term term = lambertian(p[1]);
      term.name = "Diffuse_Subsurface_BRDF_Model";
      term.lines.push_back({"stack", "No_StackModel"});
      term.index = std::pair(p[0], 0.0);
      return term;
    }
    case Kind::single_scatter:
      return single_scatter(p);
    default:
      for (const brdf::CatalogueEntry& entry : brdf::catalogue())
        if (entry.kind == part.kind) refuse(std::string(entry.name));
      refuse("the model");
  }
}

void append(std::string& out, const std::string& prefix, const Term& term, double wavelength_um,
            const std::string& substrate) {
  out += prefix + "lambda = " + number(wavelength_um) + "\n" + prefix + "type = 0\n" + prefix +
         "substrate = " + substrate + "\n";
  for (const Line& line : term.lines) out += prefix + line.name + " = " + line.value + "\n";
}

/// The substrate that all terms share.
std::string shared_substrate(const std::vector<Term>& terms) {
  std::pair<double, double> index{1.5, 0};
  bool known = false;
  for (const Term& term : terms) {
    if (!term.index) continue;
    if (known && *term.index != index)
      throw Error(
          "terms of the sum have different indices of refraction",
          "SCATMECH wants one substrate for all parts of a sum; fit or set n and kappa alike");
    index = *term.index;
    known = true;
  }
  return "(" + number(index.first) + "," + number(index.second) + ")";
}

}  // namespace

std::string scatmech_text(const brdf::Model& model, std::span<const double> values,
                          double wavelength_um, std::span<const std::string> comments) {
  model.check(values);
  std::vector<Term> terms;
  for (const Component& part : model.components())
    terms.push_back(term_of(part, values.subspan(part.first, part.count)));
  if (terms.size() >= sums.size()) refuse("a sum of " + std::to_string(terms.size()) + " terms");
  if (terms.size() == 1 && terms[0].factor != 1)
    refuse("microfacet with bias " + number(terms[0].factor) + " outside a sum");

  std::string out;
  for (const std::string& line : comments) out += "# " + line + "\n";
  const std::string substrate = shared_substrate(terms);
  if (terms.size() == 1) {
    out += terms[0].name + "\n";
    append(out, "", terms[0], wavelength_um, substrate);
    return out;
  }
  out += std::string(sums[terms.size()]) + "\nlambda = " + number(wavelength_um) +
         "\ntype = 0\nsubstrate = " + substrate + "\n";
  for (std::size_t t = 0; t < terms.size(); ++t) {
    const std::string position = std::to_string(t + 1);
    out += "factor" + position + " = " + number(terms[t].factor) + "\nsource" + position + " = " +
           terms[t].name + "\n";
    append(out, "source" + position + ".", terms[t], wavelength_um, substrate);
  }
  return out + "correlation = 0\n";
}

std::string write_scatmech(const brdf::Table& table, const TableWriting& writing) {
  const auto* model = dynamic_cast<const ModelTable*>(&table);
  if (!model)
    throw Error("SCATMECH text holds a model, not a table of values",
                "export a fit.json, or give --model and its parameters");
  const double um = single_wavelength(table, writing, "scatmech");
  const auto& own = model->wavelengths_um();
  const auto found =
      std::find_if(own.begin(), own.end(), [&](double w) { return std::abs(w - um) < 1e-5; });
  if (found == own.end() && !model->shared())
    throw Error("the model has no parameters at " + decimal_text(um * 1e3) + " nm",
                "choose a wavelength that was fitted");
  const std::size_t index = found == own.end() ? 0 : static_cast<std::size_t>(found - own.begin());
  // What the values mean is said by the class that computes them, not by this file.
  std::vector<std::string> comments{
      "parameters of a model: lengths in um, sdf.s is the rms slope of both directions together"};
  for (const std::string& line : table_header(table, writing, {um}, true).lines())
    for (const char* kept : {"origin:", "program:", "command:", "note:"})
      if (line.starts_with(kept)) comments.push_back(line);
  return scatmech_text(model->model(), model->values(index), um, comments);
}

}  // namespace umov::formats
