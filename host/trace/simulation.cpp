#include "host/trace/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "host/errors/error.hpp"
#include "host/parallel/for_each_index.hpp"
#include "host/trace/random_stream.hpp"

namespace umov::trace {

using optics::Mueller;

namespace {

// Blocks traced between two additions. Part of the meaning of `samples`, so it is no option.
constexpr std::size_t wave = 16;

// Exits of one block.
class Block : public Collector {
 public:
  Block(const Hemisphere& hemisphere, std::size_t wavelengths)
      : cells(hemisphere.size() * wavelengths),
        all(wavelengths),
        ledger(wavelengths),
        hemisphere_(hemisphere),
        wavelengths_(wavelengths) {}

  void clear() {
    std::fill(cells.begin(), cells.end(), Mueller<double>(0.0));
    std::fill(all.begin(), all.end(), Mueller<double>(0.0));
    ledger = Ledger(wavelengths_);
  }

  void collect(const Exit& exit) override {
    if (!(exit.direction.z > 0.0)) return;
    cells[hemisphere_.find(exit.direction) * wavelengths_ + exit.wavelength] += exit.weight;
    if (const auto strip = hemisphere_.find_in_strip(exit.direction)) {
      cells[*strip * wavelengths_ + exit.wavelength] += exit.weight;
    }
    all[exit.wavelength] += exit.weight;
  }

  std::vector<Mueller<double>> cells, all;
  Ledger ledger;

 private:
  const Hemisphere& hemisphere_;
  std::size_t wavelengths_;
};

void check(const PathTracer& tracer, const Request& request) {
  if (!(request.theta_i >= 0.0 && request.theta_i < 0.5 * optics::pi)) {
    throw Error(fmt::format("light from θi = {}°", optics::degrees(request.theta_i)),
                "choose an angle from 0 to below 90°");
  }
  if (request.samples == 0 || request.block == 0) {
    throw Error("a simulation without samples", "choose at least one");
  }
  if (!tracer.scene().periodic) {
    throw Error("the BRDF of a scene that is not periodic", "make its domain periodic");
  }
}

}  // namespace

Result::Result(Hemisphere hemisphere, std::size_t wavelengths)
    : hemisphere_(std::move(hemisphere)),
      ledger_(wavelengths),
      cells_(hemisphere_.size() * wavelengths, {Mueller<double>(0.0), Mueller<double>(0.0)}),
      hemisphere_sums_(wavelengths, {Mueller<double>(0.0), Mueller<double>(0.0)}),
      dop_products_(wavelengths, 0.0) {}

// Block means x: mean and √(Σ(x - mean)²/(B(B - 1))), both times `scale`.
MuellerEstimate Result::estimate(const Sums& sums, double scale) const {
  const double b = static_cast<double>(blocks_);
  MuellerEstimate e{};
  for (int c = 0; c < 4; ++c) {
    for (int r = 0; r < 4; ++r) {
      const double mean = sums.sum[c][r] / b;
      const double spread = std::max(0.0, sums.squares[c][r] / b - mean * mean);
      e.mean[c][r] = mean * scale / block_;
      e.error[c][r] = std::sqrt(spread / (b - 1.0)) * scale / block_;
    }
  }
  return e;
}

MuellerEstimate Result::brdf(std::size_t cell, std::size_t wavelength) const {
  const std::size_t wavelengths = hemisphere_sums_.size();
  return estimate(cells_[cell * wavelengths + wavelength], 1.0 / hemisphere_.cell(cell).projected);
}

MuellerEstimate Result::hemispherical(std::size_t wavelength) const {
  return estimate(hemisphere_sums_[wavelength], 1.0);
}

Estimate Result::hemispherical_dop(std::size_t wavelength) const {
  const MuellerEstimate e = hemispherical(wavelength);
  const double intensity = e.mean[0][0];
  if (!(intensity > 0.0)) return {0.0, std::numeric_limits<double>::infinity()};
  const double dop = e.mean[0][1] / intensity;
  const double b = static_cast<double>(blocks_);
  const Sums& sums = hemisphere_sums_[wavelength];
  const double covariance =
      (dop_products_[wavelength] / b - sums.sum[0][0] * sums.sum[0][1] / (b * b)) /
      ((b - 1.0) * block_ * block_);
  const double variance = e.error[0][1] * e.error[0][1] - 2.0 * dop * covariance +
                          dop * dop * e.error[0][0] * e.error[0][0];
  return {dop, std::sqrt(std::max(0.0, variance)) / intensity};
}

Result simulate(const PathTracer& tracer, const Hemisphere& hemisphere, const Request& request) {
  check(tracer, request);
  const Scene& scene = tracer.scene();
  const std::size_t wavelengths = scene.wavelengths_um.size();
  Result result(hemisphere, wavelengths);
  result.block_ = static_cast<double>(request.block);

  // Above the highest face by more than what counts as on it.
  const double height = tracer.geometry().top() + 1e-3 * std::max(scene.size_x, scene.size_y);
  const optics::Beam<double> beam = optics::incident_beam(request.theta_i);
  std::vector<Block> blocks(wave, Block(hemisphere, wavelengths));
  std::vector<PathTracer::Workspace> workspaces(wave, PathTracer::Workspace(tracer));

  while (result.samples_ < request.samples) {
    for_each_index(wave, request.threads, [&](std::size_t number) {
      Block& block = blocks[number];
      block.clear();
      const std::uint64_t first = (result.blocks_ + number) * request.block;
      for (std::uint64_t sample = first; sample < first + request.block; ++sample) {
        const auto u = uniforms(request.seed, sample, 0);
        tracer.trace(Vec3(u[0] * scene.size_x, u[1] * scene.size_y, height), beam, request.seed,
                     sample, workspaces[number], block, block.ledger);
      }
    });
    for (const Block& block : blocks) {
      const auto add = [](Result::Sums& sums, const Mueller<double>& value) {
        sums.sum += value;
        for (int c = 0; c < 4; ++c) sums.squares[c] += value[c] * value[c];
      };
      for (std::size_t i = 0; i < block.cells.size(); ++i) {
        if (block.cells[i][0][0] != 0.0) add(result.cells_[i], block.cells[i]);
      }
      for (std::size_t i = 0; i < wavelengths; ++i) {
        add(result.hemisphere_sums_[i], block.all[i]);
        result.dop_products_[i] += block.all[i][0][0] * block.all[i][0][1];
      }
      result.ledger_.add(block.ledger);
    }
    result.blocks_ += wave;
    result.samples_ += wave * request.block;

    double worst = 0.0;
    for (std::size_t i = 0; i < wavelengths; ++i) {
      const MuellerEstimate e = result.hemispherical(i);
      if (e.mean[0][0] > 0.0) worst = std::max(worst, e.error[0][0] / e.mean[0][0]);
    }
    if (request.progress) request.progress({result.samples_, worst});
    // The scatter of fewer blocks than 64 is too vague to stop by.
    if (worst <= request.dhr_relative_error && result.blocks_ >= 4 * wave) break;
  }
  return result;
}

}  // namespace umov::trace
