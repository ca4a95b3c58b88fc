#include "host/gap/chamber/diagnose_map.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>

#include "host/errors/error.hpp"
#include "host/gap/chamber/map_causes.hpp"
#include "host/gap/engine/effect_names.hpp"
#include "host/gap/engine/gap_bounds.hpp"

namespace umov::gap {
namespace {

constexpr std::size_t fewest_pixels = 200;
constexpr int bootstrap_draws = 1000;

/// Pixels to join, each way, for at most so many.
std::size_t joined_for(const chamber::Map& map, std::size_t most) {
  const double all = static_cast<double>(map.width * map.height);
  const auto n = static_cast<std::size_t>(std::ceil(std::sqrt(all / static_cast<double>(most))));
  return std::min({std::max<std::size_t>(1, n), map.width, map.height});
}

std::vector<std::string> notes_of(const chamber::MeasuredMap& measured, std::size_t n) {
  std::vector<std::string> notes = measured.notes;
  const chamber::Map& map = measured.map;
  if (n == 1) return notes;
  notes.push_back(fmt::format("{} × {} pixels were joined to one", n, n));
  if (map.width % n != 0 || map.height % n != 0)
    notes.push_back(
        fmt::format("of the {} × {} pixels {} columns at the right and {} rows at the top fill no "
                    "joined pixel and were left out",
                    map.width, map.height, map.width % n, map.height % n));
  return notes;
}

}  // namespace

MapDiagnosis diagnose_map(const chamber::Described& luminaire, const chamber::MeasuredMap& measured,
                          const MapDiagnoseOptions& options) {
  DiagnoseOptions engine = options.diagnose;
  static_cast<void>(effects_named(options.without, map_effects(luminaire)));  // before any ray
  MapOptions maps = options.signatures;
  maps.joined = joined_for(measured.map, options.most_pixels);
  const auto signatures = std::make_shared<const MapSignatures>(map_signatures(luminaire, maps));
  if (signatures->pixels.size() < fewest_pixels)
    throw Error(fmt::format("only {} pixels see the luminaire away from its outline, too few for a "
                            "diagnosis",
                            signatures->pixels.size()),
                fmt::format("give a map with {} or more", fewest_pixels));
  const ChamberModel model(signatures, chamber::joined(measured.map, maps.joined));
  for (std::size_t e = 0; e < model.effects().size(); ++e) {
    const std::string& name = model.effects()[e].name;
    if (std::find(options.without.begin(), options.without.end(), name) != options.without.end())
      engine.search.without.push_back(e);
  }
  MapDiagnosis result;
  result.answer = diagnose(model, engine);
  result.answer.bounds = gap_bounds(model, result.answer, bootstrap_draws, engine.search.seed + 5);
  result.picture = picture_of(model, result.answer);
  result.pixels = signatures->map.luminance_cd_m2.size();
  result.used = signatures->pixels.size();
  result.notes = notes_of(measured, maps.joined);
  for (const std::string& one : signatures->without_room)
    result.notes.push_back("no room to try " + one + ", which was left out");
  return result;
}

}  // namespace umov::gap
