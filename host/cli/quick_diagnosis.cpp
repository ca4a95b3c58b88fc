#include "host/cli/quick_diagnosis.hpp"

namespace umov::cli {

void make_quick(gap::scan::ScanDiagnoseOptions& options) {
  options.diagnose.draws = 100;
  options.diagnose.search.max_effects = 3;
  options.diagnose.search.beam = 8;
  options.diagnose.search.refits = 6;
  options.diagnose.search.folds = 5;
  options.diagnose.search.max_structure = 3;
  options.model.most_records = 1500;
}

}  // namespace umov::cli
