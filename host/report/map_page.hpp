// The page of a diagnosed luminance map: where the simulation misses it, what causes that, how far
// the gap closes.
#pragma once

#include <string>
#include <vector>

#include "host/gap/answer/diagnosis_json.hpp"
#include "host/gap/chamber/diagnose_map.hpp"

namespace umov::report {

struct MapPageInput {
  const gap::MapDiagnosis* diagnosis = nullptr;
  gap::AnswerSource source;
  std::vector<std::string> files;  ///< the map, then the scene, as the user named them
  std::string created;             ///< UTC, ISO 8601; empty: now
};

/// The page's data as JSON text that can stand inside a script element; the layout is that which
/// page/map_diagnosis.js reads.
std::string map_data(const MapPageInput& input);

/// The whole page, UTF-8. Loads nothing from anywhere.
std::string map_page(const MapPageInput& input);

}  // namespace umov::report
