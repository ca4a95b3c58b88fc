#include "host/gap/chamber/map_signatures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "host/chamber/figures.hpp"
#include "host/errors/error.hpp"
#include "host/gap/chamber/map_causes.hpp"
#include "host/gap/chamber/smoothing.hpp"

namespace umov::gap {
namespace {

using chamber::Map;
using chamber::View;

/// Maps of one camera, and which pixels see the luminaire in every view.
class Simulator {
 public:
  Simulator(const MapOptions& options, double maps_ahead)
      : options_(options), maps_ahead_(maps_ahead) {}

  /// `rays` for a joined pixel.
  Map simulate(const View& view, std::uint64_t rays, std::uint64_t seed) {
    const chamber::Tracer tracer(view.luminaire);
    const double maps =
        static_cast<double>(rays) / static_cast<double>(options_.rays_per_signature);
    chamber::MapRequest request;
    request.rays_per_pixel = std::max<std::uint64_t>(2, rays / (options_.joined * options_.joined));
    request.seed = seed;
    request.threads = options_.threads;
    request.progress = [&](double share) {
      if (options_.progress) options_.progress((done_ + share * maps) / maps_ahead_);
    };
    const Map fine = chamber::luminance_map(tracer, view.camera, request);
    done_ += maps;
    seen_.resize(fine.luminance_cd_m2.size(), false);
    for (std::size_t i = 0; i < seen_.size(); ++i)
      seen_[i] = seen_[i] || fine.luminance_cd_m2[i] > 0.0;
    width_ = fine.width;
    height_ = fine.height;
    return chamber::joined(fine, options_.joined);
  }

  /// No more maps of this view come: what is dark in all of them is beyond an outline, unless
  /// sources of the luminaire were put out in it.
  void end(const View& view) {
    const auto& emitters = view.luminaire.emitters;
    const auto out = std::count_if(emitters.begin(), emitters.end(),
                                   [](const auto& e) { return !(e.flux_lm > 0.0); });
    if (lit_.empty()) {
      lit_ = seen_;
      sources_out_ = out;
    } else if (out == sources_out_) {
      for (std::size_t i = 0; i < lit_.size(); ++i) lit_[i] = lit_[i] && seen_[i];
    }
    seen_.assign(seen_.size(), false);
  }

  /// Joined pixels away from all that is dark in a view: outlines, and what lies beyond them.
  std::vector<std::size_t> inner_pixels() const {
    const std::size_t n = options_.joined;
    const std::size_t margin = std::max<std::size_t>(2, n);
    std::vector<std::size_t> inner;
    for (std::size_t y = 0; y + n <= height_; y += n) {
      for (std::size_t x = 0; x + n <= width_; x += n) {
        if (all_lit(x, y, n, margin)) inner.push_back(y / n * (width_ / n) + x / n);
      }
    }
    return inner;
  }

 private:
  bool all_lit(std::size_t x, std::size_t y, std::size_t size, std::size_t margin) const {
    const auto before = [&](std::size_t at) { return at > margin ? at - margin : 0; };
    for (std::size_t j = before(y); j < std::min(height_, y + size + margin); ++j)
      for (std::size_t i = before(x); i < std::min(width_, x + size + margin); ++i)
        if (!lit_[j * width_ + i]) return false;
    return true;
  }

  const MapOptions& options_;
  double maps_ahead_, done_ = 0.0;
  std::vector<bool> seen_;  // of the present view: in some map of it
  std::vector<bool> lit_;   // in every view
  std::ptrdiff_t sources_out_ = 0;
  std::size_t width_ = 0, height_ = 0;
};

/// A map found twice, each time with half of the rays: where both agree on a change it is one, else
/// it is noise.
using Halves = std::array<Map, 2>;

Halves halves(Simulator& simulator, const View& view, const MapOptions& options) {
  const auto half = [&](std::uint64_t number) {
    return simulator.simulate(view, std::max<std::uint64_t>(2, options.rays_per_signature / 2),
                              options.seed + 1 + number);
  };
  Halves both{half(0), half(1)};
  simulator.end(view);
  return both;
}

/// A changed map, and how much of the parameter is in it.
struct Changed {
  const Parameter* parameter;
  Halves maps;
  double amount;
};

/// Where there is no room for a step, the other way or with a smaller one; nothing where there is
/// none for any.
std::optional<Changed> changed(Simulator& simulator, const MapChange& change,
                               const MapOptions& options) {
  constexpr int sizes = 4;
  double step = change.step;
  for (int size = 0; size < sizes; ++size, step *= 0.5) {
    for (const double amount : {step, -step}) {
      if (amount < change.parameter.lo) continue;
      try {
        return Changed{&change.parameter, halves(simulator, change.view(amount), options), amount};
      } catch (const Error&) {
        // No such luminaire, or none that this camera can look at.
      }
    }
  }
  return std::nullopt;
}

Eigen::VectorXd at_pixels(const std::vector<double>& values,
                          const std::vector<std::size_t>& pixels) {
  Eigen::VectorXd v(static_cast<Eigen::Index>(pixels.size()));
  for (std::size_t i = 0; i < pixels.size(); ++i)
    v[static_cast<Eigen::Index>(i)] = values[pixels[i]];
  return v;
}

/// An effect of the catalogue with the maps that show it.
struct Shown {
  const MapCause* cause;
  std::vector<Changed> maps;
};

/// Which pixels are used, and what becomes of a change at them.
class Reduction {
 public:
  Reduction(const std::vector<std::size_t>& pixels, std::size_t width)
      : pixels_(pixels), smoothing_(places(pixels, width, true), places(pixels, width, false)) {}

  Eigen::VectorXd change(const Halves& from, const Changed& to) const {
    const auto half = [&](std::size_t i) -> Eigen::VectorXd {
      return (at_pixels(to.maps[i].luminance_cd_m2, pixels_) -
              at_pixels(from[i].luminance_cd_m2, pixels_)) /
             to.amount;
    };
    return smoothing_.mean(half(0), half(1));
  }

 private:
  static std::vector<double> places(const std::vector<std::size_t>& pixels, std::size_t width,
                                    bool along_x) {
    std::vector<double> out;
    for (const std::size_t pixel : pixels)
      out.push_back(static_cast<double>(along_x ? pixel % width : pixel / width));
    return out;
  }

  const std::vector<std::size_t>& pixels_;
  Smoothing smoothing_;
};

MapEffect signature_of(const Shown& shown, const Halves& from, const Reduction& reduction) {
  MapEffect one{shown.cause->effect, {}};
  const std::size_t count = shown.maps.size();
  std::vector<Probe> probes;
  for (std::size_t k = 0; k < count; ++k) {
    const Eigen::VectorXd column = reduction.change(from, shown.maps[k]);
    one.columns.conservativeResize(column.size(), static_cast<Eigen::Index>(k + 1));
    one.columns.col(static_cast<Eigen::Index>(k)) = column;
    const Parameter& parameter = *shown.maps[k].parameter;
    one.effect.parameters.push_back(parameter);
    Probe probe(count, 0.0);
    probe[k] = parameter.prior_u;
    probes.push_back(std::move(probe));
  }
  one.effect.probes = {std::move(probes)};
  return one;
}

}  // namespace

MapSignatures map_signatures(const chamber::Described& luminaire, const MapOptions& options) {
  MapSignatures s;
  s.options = options;
  const View plain = luminaire.view({});
  const MapCauses list = map_causes(luminaire, size_of(plain.camera));
  double maps = static_cast<double>(options.rays_per_pixel) /
                    static_cast<double>(options.rays_per_signature) +
                1.0 + static_cast<double>(list.origins.size());
  for (const MapCause& cause : list.causes) maps += static_cast<double>(cause.changes.size());
  Simulator simulator(options, maps);

  // Changes share the random numbers of what they are taken from, and none with the map itself.
  s.map = simulator.simulate(plain, options.rays_per_pixel, options.seed);
  const Halves own = halves(simulator, plain, options);
  std::vector<Halves> origins;
  for (const auto& view : list.origins) origins.push_back(halves(simulator, view(), options));
  std::vector<Shown> all;
  for (const MapCause& cause : list.causes) {
    Shown shown{&cause, {}};
    for (const MapChange& change : cause.changes) {
      std::optional<Changed> one = changed(simulator, change, options);
      if (one)
        shown.maps.push_back(std::move(*one));
      else
        s.without_room.push_back(cause.effect.name + ": " + change.parameter.name);
    }
    if (!shown.maps.empty()) all.push_back(std::move(shown));
  }

  s.pixels = simulator.inner_pixels();
  if (s.pixels.empty())
    throw Error("no pixel of the map sees the luminaire away from its outline",
                "let the [camera] look at it, with smaller pixels");
  s.mean = at_pixels(s.map.luminance_cd_m2, s.pixels);
  s.se = at_pixels(s.map.luminance_se, s.pixels);
  s.highlight = Eigen::VectorXd::Zero(s.mean.size());
  const Reduction reduction(s.pixels, s.map.width);
  for (const Shown& shown : all) {
    s.effects.push_back(
        signature_of(shown, shown.cause->origin ? origins[*shown.cause->origin] : own, reduction));
    const Eigen::VectorXd& first = s.effects.back().columns.col(0);
    if (shown.cause->effect.name == "near_specular_lobe" && first.maxCoeff() > 0.0)
      s.highlight = s.highlight.cwiseMax(first / first.maxCoeff());
  }
  return s;
}

}  // namespace umov::gap
