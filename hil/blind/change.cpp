#include "hil/blind/change.hpp"

#include <cmath>
#include <utility>

#include "hil/blind/record_noise.hpp"

namespace umov::blind {

double length(std::span<const double> vector) {
  double sum = 0.0;
  for (const double v : vector) sum += v * v;
  return std::sqrt(sum);
}

void Subspace::add(std::vector<double> direction) {
  const double before = length(direction);
  // Twice is enough to be orthogonal to rounding (Kahan, Parlett).
  direction = rest(rest(std::move(direction)));
  const double after = length(direction);
  if (!(after > 1e-9 * before)) return;
  for (double& v : direction) v /= after;
  basis_.push_back(std::move(direction));
}

std::vector<double> Subspace::rest(std::vector<double> vector) const {
  for (const std::vector<double>& axis : basis_) {
    double along = 0.0;
    for (std::size_t i = 0; i < vector.size(); ++i) along += axis[i] * vector[i];
    for (std::size_t i = 0; i < vector.size(); ++i) vector[i] -= along * axis[i];
  }
  return vector;
}

ChangeMeter::ChangeMeter(World world) : world_(std::move(world)) {
  const RecordNoise noise(world_.config, world_.acquisition);
  Bench bench(world_.config, world_.material.sample(), world_.seed, world_.acquisition);
  const std::vector<CleanRecord> records = bench.clean(world_.blocks);
  std::vector<int> laser;
  for (const RowBlock& block : world_.blocks) {
    for (const Row& row : block.rows) laser.push_back(row.laser);
  }
  for (std::size_t i = 0; i < records.size(); ++i) {
    const RecordVariance variance = noise.of(laser[i], records[i]);
    base_.push_back(records[i].x_v);
    base_.push_back(records[i].y_v);
    deviation_.push_back(std::sqrt(variance.x_v2));
    deviation_.push_back(std::sqrt(variance.y_v2));
    base_monitor_v_.push_back(records[i].monitor_v);
  }
  const Signals zero(base_.size(), 0.0);
  for (int l = 0; l < plant::laser_count; ++l) {
    Signals gain = base_;
    for (std::size_t i = 0; i < laser.size(); ++i) {
      if (laser[i] != l) gain[2 * i] = gain[2 * i + 1] = 0.0;
    }
    std::vector<double> column = whitened(gain, zero);
    column[gain.size() + static_cast<std::size_t>(l)] = 1.0 / stated_gain_u;
    refit_.add(std::move(column));
  }
  for (const Perturbed& changed : perturbed(world_.material)) {
    std::vector<double> derivative = whitened(run(world_.config, changed.material.sample()), base_);
    for (double& v : derivative) v /= changed.step;
    refit_.add(std::move(derivative));
  }
}

Signals ChangeMeter::run(const plant::PlantConfig& config,
                         const std::shared_ptr<const plant::Sample>& sample) const {
  Bench bench(config, sample, world_.seed, world_.acquisition);
  const std::vector<CleanRecord> records = bench.clean(world_.blocks);
  Signals signals;
  signals.reserve(2 * records.size());
  for (std::size_t i = 0; i < records.size(); ++i) {
    const double scale = base_monitor_v_[i] / records[i].monitor_v;
    signals.push_back(records[i].x_v * scale);
    signals.push_back(records[i].y_v * scale);
  }
  return signals;
}

Signals ChangeMeter::signals(std::span<const Effect> effects) const {
  plant::PlantConfig config = world_.config;
  for (const Effect& effect : effects) {
    if (effect.name != "speckle") apply(effect, world_.context, config);
  }
  return run(config, world_.material.sample());
}

std::vector<double> ChangeMeter::whitened(const Signals& with, const Signals& without) const {
  std::vector<double> z(with.size() + plant::laser_count, 0.0);
  for (std::size_t i = 0; i < with.size(); ++i) z[i] = (with[i] - without[i]) / deviation_[i];
  return z;
}

std::vector<double> ChangeMeter::left(std::span<const Effect> effects) const {
  return refit_.rest(whitened(signals(effects), base_));
}

double ChangeMeter::rho_of_speckle(double contrast) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < base_.size(); i += 2) {
    const double v = std::pow(contrast * base_[i] / deviation_[i], 2.0);
    sum += 0.5 * std::pow(v / (1.0 + v), 2.0);
  }
  return std::sqrt(sum);
}

double ChangeMeter::rho(std::span<const Effect> effects) const {
  double speckle = 0.0;
  for (const Effect& effect : effects) {
    if (effect.name == "speckle") speckle = rho_of_speckle(effect.size());
  }
  const bool others = effects.size() > (speckle > 0.0 ? 1u : 0u);
  return std::hypot(speckle, others ? length(left(effects)) : 0.0);
}

}  // namespace umov::blind
