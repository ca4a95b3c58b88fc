// Tables of the fit, reflectances, and the key numbers of a sample.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "host/report/json_parts.hpp"
#include "host/report/numbers.hpp"

namespace umov::report {

namespace {

constexpr double sigmas_95 = 1.96;
constexpr std::size_t largest_correlation_figure = 40;

/// Value ± half width of the 95 % interval, with the interval and the reason to distrust it.
Json estimate_json(const formats::Estimate& e, bool fixed) {
  Json cell;
  // On a bound the data give a limit, and an interval about the bound would say otherwise.
  cell["text"] = fixed                   ? plain(e.value)
                 : e.at_bound == "lower" ? "< " + plain(e.hi, 2)
                 : e.at_bound == "upper" ? "> " + plain(e.lo, 3)
                                         : with_uncertainty(e.value, 0.5 * (e.hi - e.lo));
  if (!fixed)
    cell["interval"] = fmt::format("95 % interval {} … {}", plain(e.lo, 5), plain(e.hi, 5));
  if (fixed)
    cell["mark"] = "fixed";
  else if (!e.at_bound.empty())
    cell["mark"] = e.at_bound;
  else if (!e.identifiable)
    cell["mark"] = "weak";
  return cell;
}

std::string unit_name(const std::string& unit) {
  if (unit == "1" || unit.empty()) return "";
  if (unit == "um") return "µm";
  if (unit == "deg") return "°";
  if (unit == "1/sr") return "sr⁻¹";
  return unit;
}

Json row_json(const formats::FitParameter& parameter, const brdf::Model& model) {
  Json cells = Json::array();
  for (const formats::Estimate& e : parameter.estimates)
    cells.push_back(estimate_json(e, parameter.fixed));
  Json row{{"name", parameter.name},
           {"unit", unit_name(parameter.unit)},
           {"shared", parameter.shared},
           {"cells", std::move(cells)}};
  for (const brdf::Parameter& p : model.parameters())
    if (p.name == parameter.name) row["meaning"] = p.meaning;
  return row;
}

/// K_N of the paper (eq. 8): its four rows in the paper's order with what each stands for.
Json k_n(const formats::FitResult& fit, const brdf::Model& model) {
  if (model.name() != "li-torrance") return nullptr;
  static const std::array<std::pair<const char*, const char*>, 4> rows{
      {{"k_dd", "surface, directional"},
       {"k_uds", "subsurface, diffuse"},
       {"k_udf", "surface, diffuse"},
       {"k_fs", "subsurface, forward"}}};
  Json out = Json::array();
  for (const auto& [name, role] : rows) {
    const formats::FitParameter* parameter = fit.find(name);
    if (parameter == nullptr) return nullptr;
    Json row = row_json(*parameter, model);
    row["role"] = role;
    out.push_back(std::move(row));
  }
  return out;
}

bool in_k_n(const std::string& name) {
  return name == "k_dd" || name == "k_uds" || name == "k_udf" || name == "k_fs";
}

Json correlation(const formats::FitResult::Covariance& covariance) {
  const std::size_t n = covariance.names.size();
  if (n < 2 || n > largest_correlation_figure || covariance.values.size() != n * n) return nullptr;
  Json values = Json::array();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      const double scale = std::sqrt(covariance.values[i * n + i] * covariance.values[j * n + j]);
      values.push_back(rounded(scale > 0 ? covariance.values[i * n + j] / scale : NAN, 3));
    }
  }
  return {{"names", covariance.names}, {"values", std::move(values)}};
}

double reduced_chi2(const formats::FitResult& fit) {
  return fit.dof > 0 ? fit.chi2 / static_cast<double>(fit.dof) : NAN;
}

std::string number_of(std::size_t n) {
  return count(static_cast<long long>(n));
}

std::string summary(const formats::FitResult& fit) {
  std::string text = fmt::format("Model {}, fitted to {} points at {} wavelength{} together, ",
                                 fit.model, number_of(fit.points), fit.wavelengths_nm.size(),
                                 fit.wavelengths_nm.size() == 1 ? "" : "s");
  if (fit.objective_kind == "paper") {
    text += "by relative squared deviations (the objective of the original method). ";
  } else {
    text += "each weighted by its uncertainty";
    if (fit.robust_scale_sigma > 0)
      text += fmt::format(" and counting linearly beyond {} σ", plain(fit.robust_scale_sigma, 2));
    text += ". ";
  }
  text += fmt::format("χ²/dof = {}", plain(reduced_chi2(fit), 4));
  if (fit.interval_scale > 1.001)
    text += fmt::format(", intervals widened by {}", plain(fit.interval_scale, 3));
  if (fit.starts > 1)
    text += fmt::format("; {} of {} starts end at this optimum", fit.starts_agreeing, fit.starts);
  text += fmt::format("; {} iterations", number_of(fit.iterations));
  if (!fit.converged) text += ", not converged";
  return text + ".";
}

/// With a capital at the beginning, unless that is the name of a parameter.
std::vector<std::string> sentences(std::vector<std::string> list) {
  for (std::string& text : list) {
    const std::string first = text.substr(0, text.find(' '));
    const bool word = first.size() > 1 && std::all_of(first.begin(), first.end(),
                                                      [](char c) { return c >= 'a' && c <= 'z'; });
    if (word && first != "kappa" && first != "rho" && first != "alpha")
      text.front() = static_cast<char>(text.front() - 'a' + 'A');
  }
  return list;
}

/// Cells by wavelength of the view.
Json empty_cells(const SampleView& view) {
  return Json(std::vector<std::string>(view.wavelengths_nm.size()));
}

}  // namespace

Json rounded(double value, int digits) {
  if (!std::isfinite(value)) return nullptr;
  if (value == 0) return 0;
  const double scale =
      std::pow(10.0, digits - 1 - static_cast<int>(std::floor(std::log10(std::abs(value)))));
  if (!std::isfinite(scale) || scale == 0) return value;
  const double near = std::round(value * scale) / scale;
  // Whole numbers print without a trailing ".0".
  if (std::abs(near) < 1e9 && near == std::floor(near)) return static_cast<long long>(near);
  return near;
}

Json rounded(std::span<const double> values, int digits) {
  Json out = Json::array();
  for (const double v : values) out.push_back(rounded(v, digits));
  return out;
}

Json fit_tables(const SampleView& view) {
  if (!view.model) return nullptr;
  const formats::FitResult& fit = *view.fit;
  const brdf::Model model = brdf::Model::by_name(fit.model);
  Json weights = k_n(fit, model);
  Json parameters = Json::array(), derived = Json::array(), factors = Json::array();
  for (const auto& parameter : fit.parameters)
    if (weights.is_null() || !in_k_n(parameter.name))
      parameters.push_back(row_json(parameter, model));
  for (const auto& quantity : fit.derived) derived.push_back(row_json(quantity, model));
  for (const auto& factor : fit.factors)
    factors.push_back(
        {{"name", factor.name},
         {"value", rounded(factor.value, 4)},
         {"text", with_uncertainty(factor.value, sigmas_95 * factor.standard_error)}});
  Json out{{"model", fit.model},
           {"wavelengths_nm", rounded(fit.wavelengths_nm, 6)},
           {"summary", summary(fit)},
           {"parameters", std::move(parameters)},
           {"derived", std::move(derived)},
           {"identifiability", sentences(fit.identifiability)},
           {"notes", sentences(fit.notes)},
           {"factors", std::move(factors)}};
  if (!weights.is_null()) out["k_n"] = std::move(weights);
  if (Json figure = correlation(fit.covariance); !figure.is_null())
    out["correlation"] = std::move(figure);
  return out;
}

Json dhr_table(const SampleView& view) {
  // Rows by incidence, then source; cells by wavelength.
  std::map<std::pair<double, bool>, Json> rows;
  const auto put = [&](double theta_i, const char* source, double wavelength,
                       const std::string& text) {
    const auto key = std::pair{std::round(theta_i * 10) / 10, std::string(source) != "measured"};
    const auto [row, fresh] = rows.try_emplace(key, empty_cells(view));
    row->second[nearest(view.wavelengths_nm, wavelength)] = text;
  };
  bool measured = false, fitted = false;
  if (view.table) {
    const auto& dhr = view.table->dhr;
    for (std::size_t i = 0; i < dhr.dhr.size(); ++i) {
      put(dhr.theta_i_deg[i], "measured", dhr.wavelength_nm[i],
          with_uncertainty(dhr.dhr[i], sigmas_95 * dhr.dhr_u[i]));
      measured = true;
    }
  }
  if (view.fit != nullptr) {
    for (const auto& entry : view.fit->dhr) {
      put(entry.theta_i_deg, "fitted model", entry.wavelength_nm,
          with_uncertainty(entry.value, 0.5 * (entry.hi - entry.lo)));
      fitted = true;
    }
  }
  if (rows.empty()) return nullptr;
  Json list = Json::array();
  for (const auto& [key, cells] : rows)
    list.push_back({{"theta_i_deg", key.first},
                    {"source", key.second ? "fitted model" : "measured"},
                    {"cells", cells}});
  std::string note = "Share of unpolarised light that leaves into the whole hemisphere, ± 95 %.";
  if (measured)
    note +=
        " Measured: the scan at normal incidence turned about the normal and integrated, which "
        "supposes an isotropic sample.";
  if (fitted) note += " Fitted: the model integrated, mirror part included.";
  return {{"wavelengths_nm", view.wavelengths_nm}, {"note", note}, {"rows", std::move(list)}};
}

namespace {

/// Incidence nearest 30° at which DOLP was measured within a degree of the mirror direction.
void add_mirror_dolp(const SampleView& view, Json& rows) {
  if (!view.table) return;
  const auto& dolp = view.table->dolp;
  const auto off_mirror = [&](std::size_t i) {
    return view.dolp_place[i].in_plane
               ? std::abs(signed_theta_r(dolp.theta_r_deg[i], dolp.phi_r_deg[i]) -
                          dolp.theta_i_deg[i])
               : 180.0;
  };
  double best = INFINITY;
  std::size_t theta = 0;
  for (std::size_t i = 0; i < dolp.dolp.size(); ++i) {
    if (off_mirror(i) > 1 || dolp.theta_i_deg[i] < 1) continue;
    const double distance = std::abs(dolp.theta_i_deg[i] - 30);
    if (distance < best) best = distance, theta = view.dolp_place[i].theta_i;
  }
  if (!std::isfinite(best)) return;
  Json measured = empty_cells(view), model = empty_cells(view);
  std::vector<double> nearest_off(view.wavelengths_nm.size(), INFINITY);
  for (std::size_t i = 0; i < dolp.dolp.size(); ++i) {
    const std::size_t w = view.dolp_place[i].wavelength;
    if (view.dolp_place[i].theta_i != theta || off_mirror(i) > 1 || off_mirror(i) >= nearest_off[w])
      continue;
    nearest_off[w] = off_mirror(i);
    measured[w] = with_uncertainty(dolp.dolp[i], sigmas_95 * dolp.dolp_u[i]);
    if (const auto fitted = view.fitted(w); fitted && view.model)
      model[w] = plain(dolp_p4(view.model->mueller(*fitted, dolp.theta_i_deg[i],
                                                   dolp.theta_r_deg[i], dolp.phi_r_deg[i])),
                       3);
  }
  const std::string incidence = fmt::format("θi = {}°", plain(view.theta_i_deg[theta], 3));
  rows.push_back({{"name", "DOLP in the mirror direction, " + incidence}, {"cells", measured}});
  if (view.model) rows.push_back({{"name", "the same, model"}, {"cells", model}});
}

void add_dhr(const SampleView& view, Json& rows) {
  Json dhr = dhr_table(view);
  if (dhr.is_null()) return;
  // The smallest incidence of each source.
  for (const char* source : {"measured", "fitted model"}) {
    for (const auto& row : dhr["rows"]) {
      if (row["source"] != source) continue;
      rows.push_back(
          {{"name", fmt::format("DHR {}, θi = {}°",
                                source == std::string("measured") ? "measured" : "of the model",
                                plain(row["theta_i_deg"].get<double>(), 3))},
           {"cells", row["cells"]}});
      break;
    }
  }
}

}  // namespace

Json key_numbers(const SampleView& view) {
  Json rows = Json::array(), facts = Json::array();
  add_dhr(view, rows);
  add_mirror_dolp(view, rows);
  if (view.fit != nullptr) {
    const double chi2 = reduced_chi2(*view.fit);
    Json fact{{"name", "χ²/dof of the fit"}, {"value", plain(chi2, 3)}};
    if (chi2 > 1.5) fact["tone"] = "warn", fact["note"] = "more than noise remains";
    facts.push_back(std::move(fact));
    facts.push_back({{"name", "Model"},
                     {"value", view.fit->model},
                     {"note", fmt::format("{} numbers free", view.fit->covariance.names.size())}});
  }
  if (view.table) {
    std::size_t flagged = 0;
    for (const int used : view.table->points.used) flagged += used == 0;
    facts.push_back({{"name", "Measured points"}, {"value", number_of(view.table->points.size())}});
    facts.push_back({{"name", "Flagged, not used"}, {"value", number_of(flagged)}});
  }
  if (view.fit != nullptr && view.fit->outliers > 0)
    facts.push_back({{"name", "Outliers"},
                     {"value", number_of(view.fit->outliers)},
                     {"note", "weighted down"}});
  return {{"rows", std::move(rows)}, {"facts", std::move(facts)}};
}

}  // namespace umov::report
