#include "host/chamber/goniophotometer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"
#include "host/parallel/for_each_index.hpp"

namespace umov::chamber {

using optics::pi;

namespace {

// Launches of which each gives one value for the errors; few enough to scatter, many enough to
// tell how much.
constexpr std::size_t blocks = 64;

struct Block {
  std::vector<double> cells;
  Fate fate;
};

void add(Fate& sum, const Fate& one) {
  sum.launched += one.launched;
  sum.out += one.out;
  sum.absorbed += one.absorbed;
  sum.behind += one.behind;
  sum.lost += one.lost;
  sum.first_hit += one.first_hit;
  for (std::size_t i = 0; i < sum.incident.size(); ++i) {
    sum.incident[i] += one.incident[i];
    sum.taken[i] += one.taken[i];
  }
  sum.work.rays += one.work.rays;
  sum.work.endless += one.work.endless;
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
  const std::size_t planes = request.planes;
  const std::size_t angles = request.angles;
  const double step = pi / static_cast<double>(angles - 1);
  for (std::size_t c = 0; c < planes; ++c) {
    d.c_deg.push_back(360.0 * static_cast<double>(c) / static_cast<double>(planes));
  }
  for (std::size_t g = 0; g < angles; ++g) {
    d.gamma_deg.push_back(180.0 * static_cast<double>(g) / static_cast<double>(angles - 1));
  }
  // Of a cell; poles are shared by all planes.
  const auto solid_angle = [&](std::size_t g) {
    const double from = std::max(0.0, (static_cast<double>(g) - 0.5) * step);
    const double to = std::min(pi, (static_cast<double>(g) + 0.5) * step);
    const bool pole = g == 0 || g + 1 == angles;
    return 2.0 * pi * (std::cos(from) - std::cos(to)) / (pole ? 1.0 : static_cast<double>(planes));
  };
  const std::uint64_t per_block = request.rays / blocks;
  const std::uint64_t launches = per_block * blocks;
  const double flux = source / static_cast<double>(launches);
  std::vector<Block> all(blocks, {std::vector<double>(planes * angles, 0.0), tracer.empty_fate()});
  constexpr std::size_t at_once = 8;
  for (std::size_t start = 0; start < blocks; start += at_once) {
    if (request.progress) request.progress(static_cast<double>(start) / blocks);
    for_each_index(at_once, request.threads, [&](std::size_t number) {
      Block& block = all[start + number];
      const std::uint64_t first = (start + number) * per_block;
      for (std::uint64_t i = 0; i < per_block; ++i) {
        // Every block launches from all sources alike, as far as its number of rays goes.
        const double width = 1.0 / static_cast<double>(per_block);
        const Tracer::Stratum stratum{static_cast<double>(i) * width, width};
        const auto exit = tracer.launch(flux, stratum, request.seed, first + i, block.fate);
        if (!exit) continue;
        const Vec3& k = exit->direction;
        const double gamma = std::acos(std::clamp(k.z, -1.0, 1.0));
        const auto g = static_cast<std::size_t>(std::lround(gamma / step));
        double azimuth = std::atan2(k.y, k.x) / (2.0 * pi);
        if (azimuth < 0.0) azimuth += 1.0;
        const auto c =
            static_cast<std::size_t>(std::lround(azimuth * static_cast<double>(planes))) % planes;
        const bool pole = g == 0 || g + 1 == angles;
        block.cells[(pole ? 0 : c) * angles + g] += exit->flux_lm;
      }
    });
  }
  d.fate = tracer.empty_fate();
  double out_squares = 0.0;
  for (const Block& block : all) {
    add(d.fate, block.fate);
    out_squares += block.fate.out * block.fate.out;
  }
  const double n = blocks;
  // Of a sum of n independent parts.
  const auto error = [&](double sum, double squares) {
    return std::sqrt(std::max(0.0, squares - sum * sum / n) * n / (n - 1.0));
  };
  d.intensity_cd.assign(planes * angles, 0.0);
  d.intensity_se = d.intensity_cd;
  for (std::size_t c = 0; c < planes; ++c) {
    for (std::size_t g = 0; g < angles; ++g) {
      const bool pole = g == 0 || g + 1 == angles;
      double sum = 0.0;
      double squares = 0.0;
      for (const Block& block : all) {
        const double value = block.cells[(pole ? 0 : c) * angles + g];
        sum += value;
        squares += value * value;
      }
      d.intensity_cd[c * angles + g] = sum / solid_angle(g);
      d.intensity_se[c * angles + g] = error(sum, squares) / solid_angle(g);
    }
  }
  d.rays_launched = launches;
  d.source_lm = source;
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
