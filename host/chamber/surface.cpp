#include "host/chamber/surface.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "host/chamber/bands.hpp"
#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"

namespace umov::chamber {
namespace {

/// Where it is asked which band reflects most.
constexpr double usual_incidence_deg = 45.0;

[[noreturn]] void refuse(const std::string& name, const std::string& problem,
                         const std::string& remedy) {
  throw Error(Place{name}, problem, remedy);
}

void check_share(const std::string& name, const char* what, double value) {
  if (value >= 0.0 && value <= 1.0) return;
  refuse(name, fmt::format("{} = {:g}", what, value), "a surface reflects between 0 and 1");
}

void check_rows(const std::string& name, const DiffuseSpecular& two) {
  check_share(name, "total", two.total());
  const auto& theta = two.theta_i_deg();
  const auto& specular = two.specular();
  if (theta.empty() || theta.size() != specular.size()) {
    refuse(name,
           fmt::format("{} incidences for {} specular reflectances", theta.size(), specular.size()),
           "give as many of one as of the other, one at least");
  }
  for (std::size_t i = 0; i < theta.size(); ++i) {
    if (!(theta[i] >= 0.0 && theta[i] < 90.0) || (i > 0 && theta[i] <= theta[i - 1])) {
      refuse(name, fmt::format("the incidence {:g}° does not rise or is not below 90°", theta[i]),
             "list incidences in rising order");
    }
    if (!(specular[i] >= 0.0 && specular[i] <= two.total())) {
      refuse(name, fmt::format("specular reflectance {:g} at {:g}°", specular[i], theta[i]),
             fmt::format("it is a part of the total {:g}", two.total()));
    }
  }
}

void check_count(const std::string& name, std::size_t bands) {
  if (bands >= 1 && bands <= Bands::most) return;
  refuse(name, fmt::format("{} bands", bands), fmt::format("give 1 to {}", Bands::most));
}

Surface brightest(const std::string& name, const std::vector<Surface::Kind>& bands) {
  check_count(name, bands.size());
  std::optional<Surface> best;
  double most = 0.0;
  for (const Surface::Kind& kind : bands) {
    if (kind.index() != bands.front().index() || std::holds_alternative<Modelled>(kind)) {
      refuse(name, "bands of several kinds, or of a model", "make all of one kind");
    }
    Surface one(name, kind);
    const double reflectance = one.reflectance(usual_incidence_deg);
    if (best && !(reflectance > most)) continue;
    most = reflectance;
    best.emplace(std::move(one));
  }
  return *best;
}

}  // namespace

Surface::Surface(std::string name, Kind kind) : name_(std::move(name)), kind_(std::move(kind)) {
  if (const auto* plain = std::get_if<Lambertian>(&kind_)) {
    check_share(name_, "rho", plain->rho);
  } else if (const auto* two = std::get_if<DiffuseSpecular>(&kind_)) {
    check_rows(name_, *two);
  } else {
    check_count(name_, this->bands());
    check();
  }
}

Surface::Surface(std::string name, std::vector<Kind> bands) : Surface(brightest(name, bands)) {
  if (bands.size() == 1) return;
  bands_ = std::move(bands);
  const auto* first = std::get_if<DiffuseSpecular>(&bands_.front());
  for (const Kind& kind : bands_) {
    if (first == nullptr) break;
    const auto& other = std::get<DiffuseSpecular>(kind);
    if (other.theta_i_deg() != first->theta_i_deg() || other.specular() != first->specular()) {
      refuse(name_, "mirrors another share in another band", "give all bands one specular");
    }
  }
}

void Surface::check() const {
  for (int theta = 1; theta <= 89; theta += 4) {
    const double r = reflectance(theta);
    if (r > 1.001) {
      refuse(name_, fmt::format("reflects {:.3f} of the light that comes in at {}°", r, theta),
             "scale its values down; where it is interpolated, add a row near that incidence");
    }
  }
}

double Surface::value(const Vec3& from, const Vec3& to) const {
  return facing(from, Sense::with_light, [&](const auto& f) { return f.value(to); });
}

std::optional<Drawn> Surface::draw(const Vec3& known, Sense sense, double u1, double u2,
                                   double u3) const {
  return facing(known, sense, [&](const auto& f) { return f.draw(u1, u2, u3); });
}

double Surface::density(const Vec3& known, const Vec3& drawn) const {
  return facing(known, Sense::with_light, [&](const auto& f) { return f.density(drawn); });
}

void Surface::values(const Vec3& from, const Vec3& to, std::span<double> bands) const {
  if (const auto* model = std::get_if<Modelled>(&kind_); model != nullptr && this->bands() > 1) {
    const Modelled::Facing facing(*model, from, Sense::with_light);
    for (std::size_t b = 0; b < bands.size(); ++b) bands[b] = facing.value(to, b);
    return;
  }
  if (bands_.empty()) {
    std::fill(bands.begin(), bands.end(), value(from, to));
    return;
  }
  for (std::size_t b = 0; b < bands.size(); ++b) {
    bands[b] = std::visit(
        [&](const auto& kind) {
          return typename std::decay_t<decltype(kind)>::Facing(kind, from, Sense::with_light)
              .value(to);
        },
        bands_[b]);
  }
}

void Surface::weigh(const Drawn& drawn, const Vec3& known, Sense sense,
                    std::span<double> bands) const {
  const auto* model = std::get_if<Modelled>(&kind_);
  const bool spectral_model = model != nullptr && this->bands() > 1;
  // Of other kinds the mirrored share is the same in all bands.
  if (this->bands() == 1 || (drawn.density == 0.0 && !spectral_model)) {
    for (double& band : bands) band *= drawn.weight;
    return;
  }
  if (drawn.density == 0.0) {
    const Modelled::Facing facing(*model, known, sense);
    const double probability = facing.mirror_probability();
    for (std::size_t b = 0; b < bands.size(); ++b) bands[b] *= facing.mirror(b) / probability;
    return;
  }
  std::array<double, Bands::most> room;
  const std::span<double> f = std::span(room).first(bands.size());
  if (sense == Sense::with_light) {
    values(known, drawn.direction, f);
  } else {
    values(drawn.direction, known, f);
  }
  const double scale = drawn.direction.z / drawn.density;
  for (std::size_t b = 0; b < bands.size(); ++b) bands[b] *= f[b] * scale;
}

double Surface::reflectance(double theta_i_deg) const {
  if (const auto* s = std::get_if<Lambertian>(&kind_)) return s->rho;
  if (const auto* s = std::get_if<DiffuseSpecular>(&kind_)) return s->total();
  // The mean of weights over a lattice of draws: their scatter is small, for they follow the lobe.
  constexpr double least_cosine = 1e-9;
  const double cosine = std::max(least_cosine, std::cos(optics::radians(theta_i_deg)));
  const Vec3 known(-std::sqrt(1.0 - cosine * cosine), 0.0, cosine);
  constexpr int count = 12'000;
  constexpr double golden = 0.6180339887498949;
  constexpr double plastic = 0.7548776662466927;
  std::vector<double> sums(bands(), 0.0);
  std::vector<double> weights(sums.size());
  for (int i = 0; i < count; ++i) {
    const double u2 = std::fmod(golden * i, 1.0);
    const double u3 = std::fmod(plastic * i, 1.0);
    const auto drawn = draw(known, Sense::with_light, (i + 0.5) / count, u2, u3);
    if (!drawn) continue;
    std::fill(weights.begin(), weights.end(), 1.0);
    weigh(*drawn, known, Sense::with_light, weights);
    for (std::size_t b = 0; b < sums.size(); ++b) sums[b] += weights[b];
  }
  return *std::max_element(sums.begin(), sums.end()) / count;
}

bool Surface::black() const {
  const auto* s = std::get_if<Lambertian>(&kind_);
  return s != nullptr && s->rho == 0.0;
}

std::size_t Surface::bands() const {
  if (const auto* model = std::get_if<Modelled>(&kind_)) return model->sampler.spectrum().size();
  return std::max<std::size_t>(1, bands_.size());
}

}  // namespace umov::chamber
