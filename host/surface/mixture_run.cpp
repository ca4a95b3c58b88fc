#include "host/surface/mixture_run.hpp"

#include <algorithm>
#include <utility>

#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"
#include "host/surface/hidden_shares.hpp"

namespace umov::surface {
namespace {

struct Stopped {};

class Analysis {
 public:
  Analysis(const ReadSurface& read, const MixtureRequest& request)
      : read_(read),
        request_(request),
        cells_(request.rings, request.strip, optics::radians(request.strip_half_width_deg)) {
    if (request.coverage_factors.empty() || whole(1.0).layers.empty()) {
      throw Error("a mixture needs particles or drops", "add [[particles]] or [[drops]]");
    }
    layers_ = whole(1.0).layers.size();
    launches_ = request.launches.value_or(preset_launches());
    count_ = request.theta_i_deg.size() * (1 + layers_ + 2 * request.coverage_factors.size());
  }

  std::vector<MixtureAngle> run() {
    std::vector<MixtureAngle> angles;
    try {
      for (const double theta : request_.theta_i_deg) angles.push_back(at(theta));
    } catch (const Stopped&) {
      // Angles that are whole stay.
    }
    return angles;
  }

 private:
  // One answer for all: the share that is hidden and the light are of one lay, or of many each.
  std::uint64_t preset_launches() const {
    std::uint64_t most = 0;
    for (const double factor : request_.coverage_factors) {
      const std::uint64_t launches = launches_a_lay(whole(factor), request_.how.samples);
      if (launches == 0) return 0;
      most = std::max(most, launches);
    }
    return most;
  }

  Surface whole(double factor) const {
    return read_({.seed = request_.how.seed, .coverage_scale = factor});
  }

  MixtureAngle at(double theta) {
    MixtureAngle angle{theta, of_part({.part = Part::bare}, theta), {}, {}, {}, {}, {}};
    for (std::size_t layer = 0; layer < layers_; ++layer) {
      angle.contaminants.push_back(of_part({.part = Part::contaminant, .layer = layer}, theta));
    }
    std::vector<const trace::Result*> flat;
    for (const trace::Result& result : angle.contaminants) flat.push_back(&result);
    for (const double factor : request_.coverage_factors) {
      const Reading reading{.coverage_scale = factor};
      angle.wholes.push_back(of_part(reading, theta));
      const Lays black = black_lays(read_, with_seed(reading));
      const auto shares =
          hidden_shares(black, simulated(black, one_ring(), black_request(theta, how(theta))));
      const Surface described = whole(factor);
      angle.points.push_back(
          mixed(angle.wholes.back(), angle.bare, flat, shares, described.scene.wavelengths_um));
      angle.points.back().theta_i_deg = theta;
      angle.points.back().coverage = described.covered;
      if (launches_ > 0 && described.random)
        angle.points.back().lays = angle.wholes.back().blocks();
    }
    fit(angle);
    return angle;
  }

  static void fit(MixtureAngle& angle) {
    std::vector<trace::Estimate> fractions;
    std::vector<EffectiveFraction> effective;
    for (const MixturePoint& point : angle.points) {
      fractions.push_back(point.fraction);
      effective.push_back(point.effective);
    }
    angle.law = fit_law(fractions, effective);
    for (std::size_t w = 0; w < angle.points.front().bands.size(); ++w) {
      std::vector<EffectiveFraction> in_band;
      for (const MixturePoint& point : angle.points) in_band.push_back(point.bands[w].effective);
      angle.band_laws.push_back(fit_law(fractions, in_band));
    }
  }

  trace::Result of_part(const Reading& reading, double theta) {
    return simulated(Lays(read_, with_seed(reading)), cells_, how(theta));
  }

  // Lays of the next simulation: its own, unless all have one.
  Reading with_seed(Reading reading) const {
    reading.seed = launches_ == 0 ? request_.how.seed : lay_seed(request_.how.seed, own_part());
    return reading;
  }

  // Random numbers of the next simulation: with the same as others, errors would go together.
  trace::Request how(double theta) const {
    trace::Request request = request_.how;
    request.theta_i = optics::radians(theta);
    request.seed += own_part();
    return request;
  }
  std::uint64_t own_part() const { return (std::uint64_t{next_} + 1) << 40; }

  trace::Result simulated(const Lays& lays, const trace::Hemisphere& hemisphere,
                          const trace::Request& how) {
    std::vector<double> begun;
    if (request_.begin) begun = request_.begin(next_, count_);
    trace::Result result = lays.simulate(hemisphere, how, launches_, begun);
    if (request_.ended) request_.ended(next_, result);
    ++next_;
    if (trace::stop_asked(how)) throw Stopped{};
    return result;
  }

  const ReadSurface& read_;
  const MixtureRequest& request_;
  const trace::Hemisphere cells_;
  std::size_t layers_ = 0;
  std::uint64_t launches_ = 0;        // of a lay
  std::size_t next_ = 0, count_ = 0;  // simulations
};

}  // namespace

std::vector<MixtureAngle> analyse_mixture(const ReadSurface& read, const MixtureRequest& request) {
  return Analysis(read, request).run();
}

}  // namespace umov::surface
