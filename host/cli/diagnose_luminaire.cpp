#include "host/cli/diagnose_luminaire.hpp"

#include <fmt/format.h>

#include "host/chamber/map_file.hpp"
#include "host/chamber/scene_file.hpp"
#include "host/cli/diagnosis_text.hpp"
#include "host/cli/interrupt.hpp"
#include "host/cli/output_file.hpp"
#include "host/cli/progress.hpp"
#include "host/cli/quick_diagnosis.hpp"
#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/sha256.hpp"
#include "host/gap/answer/diagnosis_json.hpp"
#include "host/gap/chamber/diagnose_map.hpp"
#include "host/gap/chamber/map_causes.hpp"
#include "host/report/map_page.hpp"

namespace umov::cli {
namespace {

gap::AnswerSource source_of(const LuminaireDiagnosis& asked, const gap::MapDiagnosis& result,
                            const Common& common) {
  gap::AnswerSource source;
  source.records = result.pixels;
  source.used = result.used;
  source.sha256 = formats::sha256_of_file(asked.map);
  source.version = UMOV_VERSION;
  source.command = common.command_line;
  source.seed = common.seed;
  source.model = "luminaire of " + asked.scene;
  source.notes = result.notes;
  source.quick = asked.quick;
  const gap::MapPicture& p = result.picture;
  source.likeness = {{p.before.ncc, p.before.nrmse}, {p.after.ncc, p.after.nrmse}};
  return source;
}

}  // namespace

void diagnose_luminaire(const LuminaireDiagnosis& asked, const Common& common) {
  for (const std::string& file : {asked.json, asked.report})
    if (!file.empty()) require_product_output({asked.map, asked.scene}, file);
  const chamber::Described luminaire = chamber::described_scene(asked.scene);
  const chamber::MeasuredMap measured =
      chamber::read_measured_map(asked.map, luminaire.view({}).camera);

  catch_interrupts();
  Progress progress("diagnose", common.quiet || common.json);
  gap::MapDiagnoseOptions options;
  options.without = asked.without;
  options.signatures.seed = options.diagnose.search.seed = common.seed;
  options.signatures.threads = options.diagnose.search.threads = common.threads;
  const auto watched = [&](double share, const char* stage) {
    if (interrupt_flag().load()) throw Interrupted("the diagnosis was stopped; nothing is kept");
    progress.update(1000.0 * share, 1000.0, stage);
  };
  constexpr double maps = 0.9;  // of the time
  options.signatures.progress = [&](double share) { watched(maps * share, "simulating"); };
  options.diagnose.search.progress = [&](double share, const char* stage) {
    watched(maps + (1.0 - maps) * share, stage);
  };
  if (asked.quick) make_quick(options);
  const gap::MapDiagnosis result = gap::diagnose_map(luminaire, measured, options);
  progress.finish();

  const gap::AnswerSource source = source_of(asked, result, common);
  const std::string text = gap::diagnosis_to_json(result.answer, source);
  if (!asked.json.empty()) formats::replace_file(asked.json, text);
  if (!asked.report.empty())
    formats::replace_file(asked.report,
                          report::map_page({&result, source, {asked.map, asked.scene}, ""}));
  if (common.json) {
    fmt::print("{}", text);
  } else if (!common.quiet) {
    print_diagnosis(result.answer, source);
  }
}

std::vector<gap::Effect> luminaire_effects(const std::string& scene) {
  return gap::map_effects(chamber::described_scene(scene));
}

}  // namespace umov::cli
