#include "host/chamber/goniophotometer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"

namespace umov::chamber {

using optics::pi;

namespace {

// Launches of which each gives one value for the errors; few enough to scatter, many enough to
// tell how much.
constexpr std::size_t blocks = 64;

// Directions of a distribution, and the cells about them.
class Cells {
 public:
  Cells(std::size_t planes, std::size_t angles)
      : planes_(planes), angles_(angles), step_(pi / static_cast<double>(angles - 1)) {}

  std::size_t count() const { return planes_ * angles_; }
  /// Poles are shared by all planes: theirs is the cell in the first.
  std::size_t number(std::size_t plane, std::size_t angle) const {
    return (pole(angle) ? 0 : plane) * angles_ + angle;
  }
  std::size_t of(const Vec3& direction) const {
    const double gamma = std::acos(std::clamp(direction.z, -1.0, 1.0));
    double azimuth = std::atan2(direction.y, direction.x) / (2.0 * pi);
    if (azimuth < 0.0) azimuth += 1.0;
    const auto plane = std::lround(azimuth * static_cast<double>(planes_));
    return number(static_cast<std::size_t>(plane) % planes_,
                  static_cast<std::size_t>(std::lround(gamma / step_)));
  }
  double solid_angle(std::size_t angle) const {
    const double from = std::max(0.0, (static_cast<double>(angle) - 0.5) * step_);
    const double to = std::min(pi, (static_cast<double>(angle) + 0.5) * step_);
    return 2.0 * pi * (std::cos(from) - std::cos(to)) /
           (pole(angle) ? 1.0 : static_cast<double>(planes_));
  }

 private:
  bool pole(std::size_t angle) const { return angle == 0 || angle + 1 == angles_; }

  std::size_t planes_, angles_;
  double step_;
};

// Standard error of a sum of `blocks` independent parts.
double error(double sum, double squares) {
  constexpr double n = blocks;
  return std::sqrt(std::max(0.0, squares - sum * sum / n) * n / (n - 1.0));
}

}  // namespace

Distribution intensity_distribution(const Tracer& tracer, const DistributionRequest& request) {
  const double source = tracer.luminaire().flux_lm();
  if (!(source > 0.0)) throw Error("a luminaire without light", "add a [[source]] with flux_lm");
  if (request.planes < 1 || request.angles < 3 || request.rays < blocks) {
    throw Error(fmt::format("{} rays for {} planes of {} angles", request.rays, request.planes,
                            request.angles),
                "ask for a plane, 3 angles and 64 rays at least");
  }
  Distribution d;
  const Cells cells(request.planes, request.angles);
  for (std::size_t c = 0; c < request.planes; ++c) {
    d.c_deg.push_back(360.0 * static_cast<double>(c) / static_cast<double>(request.planes));
  }
  for (std::size_t g = 0; g < request.angles; ++g) {
    d.gamma_deg.push_back(180.0 * static_cast<double>(g) / static_cast<double>(request.angles - 1));
  }
  const std::uint64_t per_block = request.rays / blocks;
  d.rays_launched = per_block * blocks;
  d.source_lm = source;
  if (tracer.luminaire().bands) d.wavelengths_um = tracer.luminaire().bands->wavelengths_um();
  const double flux = source / static_cast<double>(d.rays_launched);
  // A block as numbers: its cells, then its fate.
  const auto trace = [&](std::size_t block, std::span<double> out) {
    Fate fate = tracer.empty_fate();
    const std::uint64_t first = block * per_block;
    const double width = 1.0 / static_cast<double>(per_block);
    for (std::uint64_t i = 0; i < per_block; ++i) {
      // Every block launches from all sources alike, as far as its number of rays goes.
      const Tracer::Stratum stratum{static_cast<double>(i) * width, width};
      const auto exit = tracer.launch(flux, stratum, request.seed, first + i, fate);
      if (exit) out[cells.of(exit->direction)] += exit->flux_lm;
    }
    const std::vector<double> numbers = fate.numbers();
    std::copy(numbers.begin(), numbers.end(),
              out.begin() + static_cast<std::ptrdiff_t>(cells.count()));
  };
  d.fate = tracer.empty_fate();
  const std::size_t numbers = cells.count() + d.fate.numbers().size();
  std::vector<double> sums(cells.count(), 0.0);
  std::vector<double> squares(cells.count(), 0.0);
  double out_squares = 0.0;
  const std::size_t at_once = 8 * (request.team == nullptr ? 1 : request.team->size());
  for (std::size_t start = 0; start < blocks; start += at_once) {
    if (request.progress) request.progress(static_cast<double>(start) / blocks);
    const std::size_t count = std::min(at_once, blocks - start);
    const std::vector<double> traced = for_each_index_of_team(
        count, numbers, request.threads, request.team,
        [&](std::size_t i, std::span<double> out) { trace(start + i, out); });
    for (std::size_t i = 0; i < count; ++i) {
      const std::span<const double> block(traced.data() + i * numbers, numbers);
      for (std::size_t k = 0; k < cells.count(); ++k) {
        sums[k] += block[k];
        squares[k] += block[k] * block[k];
      }
      Fate fate = tracer.empty_fate();
      fate.add(block.subspan(cells.count()));
      out_squares += fate.out * fate.out;
      d.fate.add(block.subspan(cells.count()));
    }
  }
  for (std::size_t c = 0; c < request.planes; ++c) {
    for (std::size_t g = 0; g < request.angles; ++g) {
      const std::size_t k = cells.number(c, g);
      d.intensity_cd.push_back(sums[k] / cells.solid_angle(g));
      d.intensity_se.push_back(error(sums[k], squares[k]) / cells.solid_angle(g));
    }
  }
  d.out_lm = d.fate.out;
  d.out_se = error(d.fate.out, out_squares);
  d.first_hit_fraction = d.fate.first_hit / d.fate.launched;
  d.absorbed_fraction = d.fate.absorbed / d.fate.launched;
  d.behind_fraction = d.fate.behind / d.fate.launched;
  d.lost_fraction = d.fate.lost / d.fate.launched;
  return d;
}

formats::Photometry Distribution::photometry() const {
  formats::Photometry p;
  p.c_deg = c_deg;
  p.gamma_deg = gamma_deg;
  p.candela = intensity_cd;
  p.lamp_lm = source_lm;
  return p;
}

}  // namespace umov::chamber
