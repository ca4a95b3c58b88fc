// Figures of the study `chamber`.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/chamber/figures.hpp"
#include "host/cli/study/page.hpp"

namespace umov::study {

struct NamedMap {
  std::string name;
  const chamber::Map* map;
};
/// Four maps on one grey scale, two by two; all of them or a part.
void add_maps(Page& page, const std::string& name, const std::string& caption,
              const std::vector<NamedMap>& maps, const std::optional<chamber::Region>& region);

struct NamedDistribution {
  std::string name;
  const chamber::Distribution* distribution;
};
/// C0–C180 and C45–C225 of distributions with eight planes.
void add_distributions(Page& page, const std::vector<NamedDistribution>& all);

}  // namespace umov::study
