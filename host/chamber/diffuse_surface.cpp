#include "host/chamber/diffuse_surface.hpp"

#include <algorithm>
#include <utility>

namespace umov::chamber {
namespace {

double linear(const std::vector<double>& x, const std::vector<double>& y, double at) {
  const auto above = std::upper_bound(x.begin(), x.end(), at);
  if (above == x.begin()) return y.front();
  if (above == x.end()) return y.back();
  const auto i = static_cast<std::size_t>(above - x.begin());
  return y[i - 1] + (at - x[i - 1]) / (x[i] - x[i - 1]) * (y[i] - y[i - 1]);
}

}  // namespace

DiffuseSpecular::DiffuseSpecular(double total, std::vector<double> theta_i_deg,
                                 std::vector<double> specular)
    : total_(total), theta_i_deg_(std::move(theta_i_deg)), specular_(std::move(specular)) {
  if (theta_i_deg_.empty() || specular_.size() != theta_i_deg_.size()) return;
  for (std::size_t i = 0; i <= steps + 1; ++i) {
    const double s = std::min(1.0, static_cast<double>(i) / steps);
    table_.push_back(linear(theta_i_deg_, specular_, angle_deg(1.0 - s * s)));
  }
}

}  // namespace umov::chamber
