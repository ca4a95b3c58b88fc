// The uncertainty budget as a table for a spreadsheet, or as JSON.
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/calibrate/budget.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/scan_table.hpp"

namespace umov::calibrate {

namespace {

std::string number(double value) {
  if (std::isnan(value)) return "";
  return std::isinf(value) ? "inf" : fmt::format("{:.6g}", value);
}

nlohmann::json json_number(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

std::string axis(double axis_deg) {
  return formats::is_open(axis_deg) ? "open" : fmt::format("{:g}", axis_deg);
}

std::string csv(const Reduction& reduction, const std::vector<PointBudget>& budget,
                const std::vector<double>& monte_carlo_u) {
  const auto& p = reduction.table.points;
  std::string text =
      "# brdf_per_sr, u_per_sr and expanded_u_per_sr in 1/sr; sensitivity in 1/(sr unit); share of "
      "the variance; coverage 95 %\n"
      "point,theta_i_deg,theta_r_deg,phi_r_deg,wavelength_nm,polarizer,analyzer,brdf_per_sr,"
      "contribution,type,unit,input_u,sensitivity,u_per_sr,share,dof,coverage_factor,"
      "expanded_u_per_sr,monte_carlo_u_per_sr\n";
  for (const PointBudget& point : budget) {
    const std::size_t i = point.point;
    const std::string place =
        fmt::format("{},{:g},{:g},{:g},{:g},{},{},{:.8g}", i, p.theta_i_deg[i], p.theta_r_deg[i],
                    p.phi_r_deg[i], p.wavelength_nm[i], axis(p.polarizer_deg[i]),
                    axis(p.analyzer_deg[i]), p.brdf_per_sr[i]);
    for (const Contribution& c : point.contributions)
      text += fmt::format("{},{},{},{},{},{},{},{},{},,,\n", place, c.name, c.type, c.unit,
                          number(c.input_u), number(c.sensitivity), number(c.u_per_sr),
                          number(std::pow(c.u_per_sr / point.combined_u, 2)), number(c.dof));
    text +=
        fmt::format("{},combined,,1/sr,,,{},1,{},{:.4f},{},{}\n", place, number(point.combined_u),
                    number(point.effective_dof), point.coverage_factor, number(point.expanded_u),
                    i < monte_carlo_u.size() ? number(monte_carlo_u[i]) : "");
  }
  return text;
}

std::string json(const Reduction& reduction, const std::vector<PointBudget>& budget,
                 const std::vector<double>& monte_carlo_u) {
  const auto& p = reduction.table.points;
  nlohmann::json points = nlohmann::json::array();
  for (const PointBudget& point : budget) {
    const std::size_t i = point.point;
    nlohmann::json contributions = nlohmann::json::array();
    for (const Contribution& c : point.contributions)
      contributions.push_back({{"name", c.name},
                               {"type", std::string(1, c.type)},
                               {"unit", c.unit},
                               {"input_u", json_number(c.input_u)},
                               {"sensitivity", json_number(c.sensitivity)},
                               {"u_per_sr", c.u_per_sr},
                               {"dof", json_number(c.dof)}});
    nlohmann::json entry{{"point", i},
                         {"theta_i_deg", p.theta_i_deg[i]},
                         {"theta_r_deg", p.theta_r_deg[i]},
                         {"phi_r_deg", p.phi_r_deg[i]},
                         {"wavelength_nm", p.wavelength_nm[i]},
                         {"polarizer", axis(p.polarizer_deg[i])},
                         {"analyzer", axis(p.analyzer_deg[i])},
                         {"used", p.used[i] != 0},
                         {"brdf_per_sr", p.brdf_per_sr[i]},
                         {"combined_u_per_sr", point.combined_u},
                         {"effective_dof", json_number(point.effective_dof)},
                         {"coverage_factor", point.coverage_factor},
                         {"expanded_u_per_sr", point.expanded_u},
                         {"contributions", contributions}};
    if (i < monte_carlo_u.size()) entry["monte_carlo_u_per_sr"] = json_number(monte_carlo_u[i]);
    points.push_back(std::move(entry));
  }
  return nlohmann::json{{"coverage", 0.95}, {"points", points}}.dump(1) + "\n";
}

}  // namespace

void write_budget(const std::filesystem::path& path, const Reduction& reduction,
                  const std::vector<PointBudget>& budget,
                  const std::vector<double>& monte_carlo_u) {
  const bool as_json = path.extension() == ".json";
  formats::replace_file(path, as_json ? json(reduction, budget, monte_carlo_u)
                                      : csv(reduction, budget, monte_carlo_u));
}

}  // namespace umov::calibrate
