#include "host/gap/scan/diagnose_scan.hpp"

#include "host/gap/engine/effect_names.hpp"
#include "host/gap/engine/gap_bounds.hpp"
#include "host/gap/scan/confined_cells.hpp"
#include "host/gap/scan/next_scan.hpp"

namespace umov::gap::scan {
namespace {

/// A negative amplitude is a positive one half a turn away: reported so.
void make_amplitudes_positive(std::vector<Cause>& causes) {
  for (Cause& cause : causes) {
    if (cause.effect != "detector_eccentricity" || cause.parameters[0].interval.value >= 0)
      continue;
    Interval& amplitude = cause.parameters[0].interval;
    amplitude = {-amplitude.value, -amplitude.hi, -amplitude.lo};
    Interval& phase = cause.parameters[1].interval;
    const double turn = phase.value > 0 ? -180.0 : 180.0;
    phase = {phase.value + turn, phase.lo + turn, phase.hi + turn};
  }
}

}  // namespace

ScanDiagnosis diagnose_scans(const std::vector<formats::ScanTable>& scans,
                             const ScanDiagnoseOptions& options) {
  const ScanModel model(scans, options.model);
  DiagnoseOptions engine = options.diagnose;
  engine.search.without = effects_named(options.without, model.effects());
  ScanDiagnosis result{diagnose(model, engine),
                       model.reflectance(),
                       0,
                       model.used(),
                       model.records().notes,
                       {},
                       {},
                       {}};
  result.limits = model.limits();
  make_amplitudes_positive(result.answer.causes);
  result.answer.next_scan = further_scans(model, result.answer);
  if (!result.answer.next_scan.empty())
    result.next_plan = plan_of(result.answer.next_scan.front(), model,
                               scans.front().key("sample").value_or("sample"));
  for (const formats::ScanTable& scan : scans) result.records += scan.size();
  constexpr int bootstrap_draws = 1000;
  result.answer.bounds = gap_bounds(model, result.answer, bootstrap_draws, engine.search.seed + 5);
  if (options.picture)
    result.picture =
        std::make_shared<const Picture>(picture_of(model, result.answer, engine.search.threads));
  const Diagnosis& answer = result.answer;
  confine(result.answer.where, model, answer.search.hypotheses[answer.search.base].refit);
  confine(result.answer.unexplained, model, answer.best);
  return result;
}

}  // namespace umov::gap::scan
