// Launches into a scene, and what a few lines of statistics make of the exits.
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "host/trace/path_tracer.hpp"
#include "host/trace/random_stream.hpp"

namespace umov::trace::test {

/// Hands every exit to a function.
class Each : public Collector {
 public:
  explicit Each(std::function<void(const Exit&)> act) : act_(std::move(act)) {}
  void collect(const Exit& exit) override { act_(exit); }

 private:
  std::function<void(const Exit&)> act_;
};

/// Sample mean and its standard error, value by value.
class Mean {
 public:
  void add(double x) {
    ++count_;
    const double step = x - mean_;
    mean_ += step / static_cast<double>(count_);
    squares_ += step * (x - mean_);
  }
  double value() const { return mean_; }
  double error() const {
    const double n = static_cast<double>(count_);
    return std::sqrt(squares_ / (n * (n - 1.0)));
  }

 private:
  std::size_t count_ = 0;
  double mean_ = 0.0, squares_ = 0.0;
};

/// Light at `theta_i` (radians) on a uniformly drawn point of the domain; `act` sees the exits of
/// one launch after the other, `end` is called after each launch.
inline Ledger shine(
    const Scene& scene, double theta_i, std::uint64_t launches, std::uint64_t seed,
    const std::function<void(const Exit&)>& act, const std::function<void()>& end = [] {}) {
  const Geometry geometry(scene);
  const PathTracer tracer(scene, geometry);
  PathTracer::Workspace workspace(tracer);
  Ledger ledger(scene.wavelengths_um.size());
  Each collector(act);
  for (std::uint64_t i = 0; i < launches; ++i) {
    const auto u = uniforms(seed, i, 0);
    tracer.trace(Vec3(u[0] * scene.size_x, u[1] * scene.size_y, geometry.top() + 0.01),
                 optics::incident_beam(theta_i), seed, i, workspace, collector, ledger);
    end();
  }
  return ledger;
}

}  // namespace umov::trace::test
