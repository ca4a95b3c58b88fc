#include "host/gap/chamber/chamber_model.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "host/errors/error.hpp"

namespace umov::gap {
namespace {

/// How well a luminance camera's scale is known over that of the sources' flux, where both were
/// calibrated with one lamp.
constexpr double scale_u = 0.01;
/// Relative error that a pixel has at least: rays to a source seen directly do not scatter, yet
/// neither camera nor simulation is exact.
constexpr double surest = 1e-4;

}  // namespace

ChamberModel::ChamberModel(std::shared_ptr<const MapSignatures> signatures,
                           const chamber::Map& measured)
    : signatures_(std::move(signatures)) {
  const MapSignatures& s = *signatures_;
  if (measured.width != s.map.width || measured.height != s.map.height) {
    throw Error(fmt::format("the measured map has {} × {} pixels, the simulated one {} × {}",
                            measured.width, measured.height, s.map.width, s.map.height),
                "measure and simulate with the same window and pixels");
  }
  const auto count = static_cast<Eigen::Index>(s.pixels.size());
  observations_.value.resize(count);
  observations_.channels = {"luminance"};
  observations_.axes = {{"x", "mm", {}}, {"y", "mm", {}}, {"highlight", "1", {}}};
  sigma_.resize(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const std::size_t pixel = s.pixels[static_cast<std::size_t>(i)];
    const std::size_t x = pixel % measured.width;
    const std::size_t y = pixel / measured.width;
    observations_.value[i] = measured.luminance_cd_m2[pixel];
    const double brighter = std::max(measured.luminance_cd_m2[pixel], s.mean[i]);
    sigma_[i] = std::max(std::hypot(measured.luminance_se[pixel], s.se[i]), surest * brighter);
    observations_.row.push_back(static_cast<int>(y));
    observations_.channel.push_back(0);
    observations_.axes[0].value.push_back(measured.pixel_mm * (static_cast<double>(x) + 0.5));
    observations_.axes[1].value.push_back(measured.pixel_mm * (static_cast<double>(y) + 0.5));
    observations_.axes[2].value.push_back(s.highlight[i]);
  }
  Parameter scale{"scale", "1", "luminance of everything, over the simulation's"};
  scale.absent = 1.0;
  scale.lo = 0.5;
  scale.hi = 2.0;
  scale.prior_u = scale_u;
  base_ = {scale};
  for (const MapEffect& one : s.effects) effects_.push_back(one.effect);
}

void ChamberModel::predict(const Explanation& explanation, Eigen::VectorXd& mean,
                           Eigen::MatrixXd* jacobian, const std::vector<bool>& /*wanted*/) const {
  const MapSignatures& s = *signatures_;
  mean = explanation.base[0] * s.mean;
  Eigen::Index parameters = 1;
  for (std::size_t k = 0; k < explanation.effects.size(); ++k) {
    const Eigen::MatrixXd& columns = s.effects[explanation.effects[k]].columns;
    mean +=
        columns * Eigen::Map<const Eigen::VectorXd>(explanation.alpha[k].data(), columns.cols());
    parameters += columns.cols();
  }
  if (jacobian == nullptr) return;
  jacobian->resize(mean.size(), parameters);
  jacobian->col(0) = s.mean;
  Eigen::Index next = 1;
  for (const std::size_t effect : explanation.effects) {
    const Eigen::MatrixXd& columns = s.effects[effect].columns;
    jacobian->middleCols(next, columns.cols()) = columns;
    next += columns.cols();
  }
}

NoiseShape ChamberModel::noise(const Eigen::VectorXd& /*mean*/) const {
  return {sigma_, {}, {}};
}

}  // namespace umov::gap
