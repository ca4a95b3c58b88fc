#include "host/report/geometry.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/optics/angles.hpp"
#include "host/report/numbers.hpp"

namespace umov::report {

bool in_plane(double theta_r_deg, double phi_r_deg) {
  const double out = std::sin(optics::radians(theta_r_deg)) * std::sin(optics::radians(phi_r_deg));
  return std::abs(out) <= std::sin(optics::radians(in_plane_within_deg));
}

double signed_theta_r(double theta_r_deg, double phi_r_deg) {
  return std::cos(optics::radians(phi_r_deg)) >= 0 ? theta_r_deg : -theta_r_deg;
}

std::vector<double> clusters(std::vector<double> values, double within) {
  std::sort(values.begin(), values.end());
  std::vector<double> out;
  std::size_t first = 0;
  for (std::size_t i = 1; i <= values.size(); ++i) {
    if (i < values.size() && values[i] - values[i - 1] <= within) continue;
    double sum = 0;
    for (std::size_t k = first; k < i; ++k) sum += values[k];
    const double mean = std::round(100 * sum / static_cast<double>(i - first)) / 100;
    out.push_back(mean == 0 ? 0 : mean);  // no −0
    first = i;
  }
  return out;
}

std::size_t nearest(const std::vector<double>& list, double value) {
  const auto above = std::lower_bound(list.begin(), list.end(), value);
  if (above == list.begin()) return 0;
  const auto index = static_cast<std::size_t>(above - list.begin());
  if (above == list.end()) return index - 1;
  return *above - value < value - list[index - 1] ? index : index - 1;
}

bool State::operator==(const State& other) const {
  const auto same = [](double a, double b) {
    return (std::isnan(a) && std::isnan(b)) || std::abs(a - b) < 1e-6;
  };
  return same(polarizer_deg, other.polarizer_deg) && same(analyzer_deg, other.analyzer_deg);
}

std::string State::id() const {
  return axis_name(polarizer_deg) + "," + axis_name(analyzer_deg);
}

std::vector<State> distinct_states(const std::vector<double>& polarizer_deg,
                                   const std::vector<double>& analyzer_deg) {
  static const std::array<std::string, 9> order{"U,U", "P,U", "S,U", "P,P", "P,S",
                                                "S,S", "S,P", "U,P", "U,S"};
  const auto rank = [](const State& state) {
    return std::find(order.begin(), order.end(), state.id()) - order.begin();
  };
  std::vector<State> states;
  for (std::size_t i = 0; i < polarizer_deg.size(); ++i) {
    const State state{polarizer_deg[i], analyzer_deg[i]};
    if (std::find(states.begin(), states.end(), state) == states.end()) states.push_back(state);
  }
  std::stable_sort(states.begin(), states.end(), [&](const State& a, const State& b) {
    return rank(a) != rank(b) ? rank(a) < rank(b) : a.id() < b.id();
  });
  return states;
}

}  // namespace umov::report
