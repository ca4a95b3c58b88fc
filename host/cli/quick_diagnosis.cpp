#include "host/cli/quick_diagnosis.hpp"

namespace umov::cli {
namespace {

void search_less(gap::DiagnoseOptions& options) {
  options.draws = 100;
  options.search.max_effects = 3;
  options.search.beam = 8;
  options.search.refits = 6;
  options.search.folds = 5;
  options.search.max_structure = 3;
}

}  // namespace

void make_quick(gap::scan::ScanDiagnoseOptions& options) {
  search_less(options.diagnose);
  options.model.most_records = 1500;
}

void make_quick(gap::MapDiagnoseOptions& options) {
  search_less(options.diagnose);
  options.most_pixels /= 2;
  options.signatures.rays_per_pixel /= 4;
  options.signatures.rays_per_signature /= 4;
}

}  // namespace umov::cli
