// A measured luminance map diagnosed against the description of its luminaire.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "host/chamber/departure.hpp"
#include "host/chamber/map_file.hpp"
#include "host/gap/chamber/map_picture.hpp"
#include "host/gap/chamber/map_signatures.hpp"

namespace umov::gap {

struct MapDiagnoseOptions {
  MapOptions signatures;  ///< `joined` is chosen by most_pixels
  std::size_t most_pixels = 2000;
  DiagnoseOptions diagnose;
  std::vector<std::string> without;  ///< effects that must not be named
};

struct MapDiagnosis {
  Diagnosis answer;
  MapPicture picture;
  std::size_t pixels = 0;  ///< of the map, joined
  std::size_t used = 0;    ///< of those, away from outlines
  std::vector<std::string> notes;
};

/// `measured`: with the camera of the luminaire. Deterministic for the seeds. Throws umov::Error
/// for a map that carries no diagnosis.
MapDiagnosis diagnose_map(const chamber::Described& luminaire, const chamber::MeasuredMap& measured,
                          const MapDiagnoseOptions& options);

}  // namespace umov::gap
