#include "host/cli/diagnose_surface.hpp"

#include <fmt/format.h>

#include "host/cli/diagnosis_text.hpp"
#include "host/cli/output_file.hpp"
#include "host/cli/progress.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/brdf_h5.hpp"
#include "host/formats/sha256.hpp"
#include "host/gap/answer/diagnosis_json.hpp"
#include "host/gap/surface/surface_model.hpp"

namespace umov::cli {

void diagnose_surface(const std::string& brdf, const std::string& scene, const std::string& json,
                      const Common& common) {
  if (!json.empty()) require_product_output({brdf, scene}, json);
  const formats::BrdfTable table = formats::read_brdf_h5(brdf).table;
  Progress progress("diagnose", common.quiet || common.json);
  gap::SurfaceModelOptions how;
  how.seed = common.seed;
  how.threads = common.threads;
  how.progress = [&](double share) { progress.update(900.0 * share, 1000.0, "simulating"); };
  const gap::SurfaceModel model(table, formats::read_whole_file(scene), scene, how);
  gap::DiagnoseOptions options;
  options.search.seed = common.seed;
  options.search.threads = common.threads;
  const gap::Diagnosis answer = gap::diagnose(model, options);
  progress.finish();

  gap::AnswerSource source;
  source.records = source.used = static_cast<std::size_t>(model.observations().value.size());
  source.sha256 = formats::sha256_of_file(brdf);
  source.version = UMOV_VERSION;
  source.command = common.command_line;
  source.seed = common.seed;
  source.model = "linear mixture of " + scene;
  const std::string text = gap::diagnosis_to_json(answer, source);
  if (!json.empty()) formats::replace_file(json, text);
  if (common.json) {
    fmt::print("{}", text);
  } else if (!common.quiet) {
    print_diagnosis(answer, source);
  }
}

}  // namespace umov::cli
