#include "host/cli/study/bench.hpp"

#include <utility>

#include <fmt/format.h>

#include "host/formats/scan_h5.hpp"
#include "host/scan/runner.hpp"
#include "host/scan/scan_part.hpp"

namespace umov::study {

Bench::Bench(const Options& options, std::filesystem::path folder, const std::string& preset,
             const std::string& first)
    : options_(options), folder_(std::move(folder)) {
  emulator::BenchOptions bench;
  bench.sample = first;
  bench.preset = preset;
  bench.seed = options.seed;
  instrument_ = std::make_shared<emulator::EmulatedInstrument>(bench);
  std::filesystem::create_directories(folder_);
}

void Bench::wait(double seconds) {
  instrument_->board().run_for(static_cast<std::uint64_t>(1e6 * seconds));
}

formats::ScanTable Bench::measure(const std::string& name, std::string_view plan_text,
                                  const std::string& sample, double from, double to) {
  const scan::Plan plan = scan::parse_plan(plan_text, name + ".toml");
  scan::RunOptions run;
  run.output = file(name);
  run.overwrite = true;
  run.program = UMOV_STUDY_PROGRAM;
  run.command = options_.command;
  run.standing = {{{"sample", sample}}};
  run.connect = [this] { return emulator::connect_embedded(instrument_); };
  run.arrange = [this](const scan::ArrangementRequest& request) {
    instrument_->arrange(request.wanted.settings);
    return true;
  };
  run.progress = [&](const scan::RunProgress& now) {
    if (options_.progress && now.total > 0)
      options_.progress(from + (to - from) * now.done / now.total, fmt::format("scan {}", name));
  };
  run.keep_going = [this] { return !options_.keep_going || options_.keep_going(); };
  const auto summary = scan::run_scan(plan, run);
  if (!summary.complete) throw Stopped{};
  records_ += summary.records;
  seconds_ += summary.instrument_time_s;
  return formats::read_scan_h5(run.output).table;
}

}  // namespace umov::study
