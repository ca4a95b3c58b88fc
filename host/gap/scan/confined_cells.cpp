#include "host/gap/scan/confined_cells.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include <fmt/format.h>

namespace umov::gap::scan {
namespace {

/// "0" as P, "90" as S, "U" as open.
std::string letter_of(const std::string& axis) {
  if (axis == "0") return "P";
  if (axis == "90" || axis == "-90") return "S";
  return axis == "U" ? "open" : axis;
}

/// Numbers of the members at the wavelength that makes the cell bad; empty where no single one
/// does.
std::vector<Eigen::Index> at_one_wavelength(const Cell& cell, const std::vector<double>& nm,
                                            const Eigen::VectorXd& residual) {
  constexpr double nearly_all = 0.9;
  constexpr double significant = 4;  // standard deviations of a sum of squares
  std::map<double, std::vector<Eigen::Index>> members;
  for (const Eigen::Index i : cell.members) members[nm[static_cast<std::size_t>(i)]].push_back(i);
  if (members.size() == 1) return members.begin()->second;
  double whole = 0, most = 0;
  const std::vector<Eigen::Index>* worst = nullptr;
  for (const auto& [wavelength, own] : members) {
    const double n = static_cast<double>(own.size());
    const double excess = residual(own).squaredNorm() - n;
    whole += std::max(0.0, excess);
    if (excess > most && excess > significant * std::sqrt(2 * n)) {
      most = excess;
      worst = &own;
    }
  }
  return worst != nullptr && most > nearly_all * whole ? *worst : std::vector<Eigen::Index>{};
}

}  // namespace

void confine(Where& where, const ScanModel& model, const Refit& fit) {
  const auto& axes = model.observations().axes;
  const auto nm = std::find_if(axes.begin(), axes.end(),
                               [](const Axis& a) { return a.name == "wavelength_nm"; });
  for (Cell& cell : where.cells) {
    const auto slash = cell.channel.find('/');
    if (slash != std::string::npos) {
      const auto blank = cell.channel.find(' ');
      const std::string polarizer = letter_of(cell.channel.substr(0, slash));
      const std::string analyzer = letter_of(cell.channel.substr(slash + 1, blank - slash - 1));
      const bool in_phase = blank == std::string::npos;
      cell.also.emplace_back("polarizer", polarizer);
      cell.also.emplace_back("analyzer", analyzer);
      cell.also.emplace_back("component", in_phase ? "x" : "y");
      cell.channel = fmt::format("{}/{}{}", polarizer, analyzer, in_phase ? "" : " Y");
    }
    std::vector<Eigen::Index> own = at_one_wavelength(cell, nm->value, fit.residual);
    if (own.empty()) continue;
    cell.also.emplace_back("wavelength_nm",
                           fmt::format("{:g}", nm->value[static_cast<std::size_t>(own.front())]));
    cell.members = std::move(own);
  }
}

}  // namespace umov::gap::scan
