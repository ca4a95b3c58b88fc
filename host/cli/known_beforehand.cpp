#include "host/cli/known_beforehand.hpp"

#include <algorithm>
#include <memory>

#include "host/calibrate/calibration_file.hpp"
#include "host/errors/error.hpp"
#include "host/gap/scan/tolerance_file.hpp"

namespace umov::cli {

gap::scan::Knowledge read_known(const KnownFiles& files) {
  gap::scan::Knowledge known;
  if (!files.calibration.empty())
    known.calibration =
        std::make_shared<calibrate::Calibration>(calibrate::read_calibration(files.calibration));
  if (!files.tolerances.empty()) known.tolerances = gap::scan::read_tolerances(files.tolerances);
  if (!files.fit.empty())
    known.fit = std::make_shared<formats::FitResult>(formats::read_fit(files.fit));
  if (files.hold && !known.fit)
    throw Error("--hold keeps the parameters of a fit, and none is named",
                "add --fit fit.json (made by `umov invert`)");
  known.hold_fit = files.hold;
  return known;
}

std::vector<gap::SizeLimit> limits_of(const std::vector<gap::scan::Tolerance>& tolerances) {
  std::vector<gap::SizeLimit> limits;
  for (const gap::scan::Tolerance& t : tolerances) {
    const bool there = std::any_of(limits.begin(), limits.end(), [&](const gap::SizeLimit& l) {
      return l.effect == t.effect && l.parameter == t.parameter;
    });
    if (!there) limits.push_back({t.effect, t.parameter, t.limit});
  }
  return limits;
}

std::vector<std::pair<std::string, std::string>> list_of(const KnownFiles& files) {
  std::vector<std::pair<std::string, std::string>> list;
  if (!files.calibration.empty()) list.emplace_back("calibration", files.calibration);
  if (!files.tolerances.empty()) list.emplace_back("tolerances", files.tolerances);
  if (!files.fit.empty()) list.emplace_back(files.hold ? "fit (held)" : "fit", files.fit);
  return list;
}

}  // namespace umov::cli
