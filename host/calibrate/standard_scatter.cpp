#include "host/calibrate/standard_scatter.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <Eigen/Dense>

#include "host/formats/order_statistics.hpp"
#include "host/formats/scan_table.hpp"

namespace umov::calibrate {

namespace {

/// Residuals over their standard deviations with what is smooth in the angle taken out, state by
/// state: a standard that polarises a little is no noise. States of few records are left out.
void add_rough_pulls(const std::vector<StandardRow>& rows, const StandardFit& fit,
                     const std::vector<std::size_t>& members, std::vector<std::size_t>& record,
                     std::vector<double>& pull) {
  constexpr std::size_t fewest = 12;
  if (members.size() < fewest) return;
  const auto n = static_cast<Eigen::Index>(members.size());
  const Eigen::Index terms = 1 + std::min<Eigen::Index>(6, n / 4);
  Eigen::MatrixXd powers(n, terms);
  Eigen::VectorXd relative(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const std::size_t i = members[static_cast<std::size_t>(k)];
    const double t = rows[i].theta_r_deg / 90.0;
    for (Eigen::Index term = 0; term < terms; ++term)
      powers(k, term) = std::pow(t, static_cast<double>(term));
    relative(k) = fit.pull[i] * std::sqrt(rows[i].variance) / rows[i].signal_v;
  }
  const Eigen::VectorXd rough = relative - powers * powers.colPivHouseholderQr().solve(relative);
  const double lost = std::sqrt(static_cast<double>(n) / static_cast<double>(n - terms));
  for (Eigen::Index k = 0; k < n; ++k) {
    const std::size_t i = members[static_cast<std::size_t>(k)];
    record.push_back(i);
    pull.push_back(rough(k) * lost * rows[i].signal_v / std::sqrt(rows[i].variance));
  }
}

/// Relative scatter that brings pulls to their noise, one sigma; 0 where the noise explains them.
/// By the median, which outliers do not move. `record` holds the row of each pull.
double excess_scatter(const std::vector<StandardRow>& rows, const std::vector<std::size_t>& record,
                      const std::vector<double>& pull) {
  constexpr double worth_mentioning = 1.25;
  if (record.size() < 20) return 0;
  const auto excess = [&](double relative) {
    std::vector<double> size;
    for (std::size_t k = 0; k < record.size(); ++k) {
      const double slow = relative * rows[record[k]].signal_v;
      size.push_back(std::abs(pull[k]) / std::sqrt(1.0 + slow * slow / rows[record[k]].variance));
    }
    return formats::median(std::move(size)) / 0.6745;
  };
  if (excess(0.0) < worth_mentioning) return 0;
  double low = 1e-7, high = 0.3;
  for (int k = 0; k < 40; ++k) {
    const double middle = std::sqrt(low * high);
    (excess(middle) > 1.0 ? low : high) = middle;
  }
  return std::sqrt(low * high);
}

}  // namespace

double scatter_about_fit(const std::vector<StandardRow>& rows, const StandardFit& fit) {
  std::vector<std::size_t> record;
  for (std::size_t i = 0; i < rows.size(); ++i) record.push_back(i);
  return excess_scatter(rows, record, fit.pull);
}

double scatter_between_angles(const std::vector<StandardRow>& rows, const StandardFit& fit) {
  std::map<std::pair<long long, long long>, std::vector<std::size_t>> states;
  const auto axis = [](double deg) {
    return formats::is_open(deg) ? -1LL : std::llround(deg * 100);
  };
  for (std::size_t i = 0; i < rows.size(); ++i)
    states[{axis(rows[i].polarizer_deg), axis(rows[i].analyzer_deg)}].push_back(i);
  std::vector<std::size_t> record;
  std::vector<double> pull;
  for (const auto& [state, members] : states) add_rough_pulls(rows, fit, members, record, pull);
  return excess_scatter(rows, record, pull);
}

}  // namespace umov::calibrate
