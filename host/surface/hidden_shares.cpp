#include "host/surface/hidden_shares.hpp"

#include <algorithm>
#include <memory>

#include "host/optics/angles.hpp"

namespace umov::surface {
namespace {

Surface blackened(Surface surface) {
  trace::Scene& scene = surface.scene;
  scene.wavelengths_um = {1.0};
  for (trace::Medium& medium : scene.media) medium = {{1.0}, {0.0}};
  for (trace::MaterialId id = 0; id < scene.materials.size(); ++id) {
    const bool particle = std::any_of(surface.layers.begin(), surface.layers.end(),
                                      [&](const Layer& layer) { return layer.material == id; });
    if (particle || !std::holds_alternative<trace::Interface>(scene.materials[id])) {
      scene.materials[id] = trace::Lambertian{{0.0}};
    }
  }
  return surface;
}

}  // namespace

Lays black_lays(const ReadSurface& read, const Reading& reading) {
  const auto first = std::make_shared<const Surface>(read(reading));
  return {[read, first](Reading next) {
            next.like = first.get();
            return blackened(read(next));
          },
          reading};
}

trace::Request black_request(double theta_i_deg, const trace::Request& how) {
  trace::Request request;
  request.theta_i = optics::radians(theta_i_deg);
  request.seed = how.seed;
  request.threads = how.threads;
  request.samples = std::min<std::uint64_t>(how.samples, 1'000'000);
  request.emissivity = true;
  request.team = how.team;
  request.stop = how.stop;
  return request;
}

std::vector<trace::Estimate> hidden_shares(const Lays& lays, const trace::Result& result) {
  std::vector<trace::Estimate> shares;
  for (const Layer& layer : lays.first().layers) {
    shares.push_back(result.absorptance(layer.material, 0)[0]);
  }
  return shares;
}

std::vector<trace::Estimate> hidden_shares(const ReadSurface& read, const Reading& reading,
                                           double theta_i_deg, const trace::Request& how,
                                           std::uint64_t launches) {
  const Lays lays = black_lays(read, reading);
  return hidden_shares(lays, lays.simulate(one_ring(), black_request(theta_i_deg, how), launches));
}

trace::Hemisphere one_ring() {
  return {1, 0, 0.0};
}

}  // namespace umov::surface
