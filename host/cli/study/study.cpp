#include "host/cli/study/study.hpp"

#include <array>

#include "host/cli/study/ceilings.hpp"
#include "host/cli/study/chamber.hpp"
#include "host/cli/study/chamber_gap.hpp"
#include "host/cli/study/contaminants.hpp"
#include "host/cli/study/effects.hpp"
#include "host/cli/study/pointing.hpp"
#include "host/cli/study/real_data.hpp"
#include "host/cli/study/reflectometer.hpp"
#include "host/cli/study/surface_gap.hpp"
#include "host/errors/error.hpp"

namespace umov::study {
namespace {

constexpr std::array all{
    Study{"reflectometer",
          "the paper's instrument repeated: calibration, paints, inversion (minutes)",
          reflectometer},
    Study{"real-data", "in-plane fits foretell real data out of the plane (minutes; UMOV_DATA)",
          real_data, true},
    Study{"effects", "the effects that a diagnosis knows, each with its signature (seconds)",
          effects},
    Study{"ceilings", "how often a single effect could be named, by plan and visibility (a minute)",
          ceilings},
    Study{"pointing", "withheld terms of a telescope's pointing, real runs (seconds; UMOV_DATA)",
          pointing},
    Study{"contaminants",
          "soil and water drops on paint, simulated: figures 4 to 9 of the paper (minutes)",
          contaminants},
    Study{"chamber", "which BRDF model foretells a luminaire's map, which its intensity (minutes)",
          chamber},
    Study{"chamber-gap", "what a simulated luminance map has wrong, named from the map (minutes)",
          chamber_gap},
    Study{"surface-gap",
          "what linear mixing leaves out of dirty, wet and rough surfaces, named (minutes)",
          surface_gap},
};

}  // namespace

std::span<const Study> studies() {
  return all;
}

void step(const Options& options, double share, const std::string& what) {
  if (options.keep_going && !options.keep_going()) throw Stopped{};
  if (options.progress) options.progress(share, what);
}

const Study& find_study(std::string_view name) {
  std::string names;
  for (const Study& study : all) {
    if (study.name == name) return study;
    names += (names.empty() ? "" : ", ") + std::string(study.name);
  }
  throw Error("there is no study `" + std::string(name) + "`", "there are: " + names);
}

}  // namespace umov::study
