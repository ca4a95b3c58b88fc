// The emulated instrument of a study: one that runs on from scan to scan, as a bench does.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "host/cli/emulator/emulated_instrument.hpp"
#include "host/cli/study/study.hpp"
#include "host/formats/scan_table.hpp"

namespace umov::study {

/// Signal constants of the emulated instrument as its data sheet has them, V: for scans that are
/// used without a calibration.
inline constexpr std::array<std::pair<const char*, const char*>, 4> data_sheet{
    {{"gain_constant_532", "760"},
     {"gain_constant_633", "820"},
     {"gain_constant_814", "800"},
     {"gain_constant_relative_u", "0.02"}}};

/// Measures plans. Its lasers warm up once; what drifts, drifts through all scans.
class Bench {
 public:
  /// `preset` as in `umov emulator`. Scans are written to `folder`. `first` is the sample it starts
  /// with; nothing depends on it but the serial number.
  Bench(const Options& options, std::filesystem::path folder, const std::string& preset,
        const std::string& first);

  /// Lets virtual time pass with the lasers off or warm, as an operator waits for them.
  void wait(double seconds);

  /// Measures the plan on a sample of the catalogue, which is put on the stage; blocks with a
  /// changed set-up included. The file is folder/NAME.h5; an older one is replaced. `from` … `to`
  /// is the share of the study's work that this is. Throws Stopped.
  formats::ScanTable measure(const std::string& name, std::string_view plan_text,
                             const std::string& sample, double from, double to);

  std::filesystem::path file(const std::string& name) const { return folder_ / (name + ".h5"); }
  const emulator::EmulatedInstrument& instrument() const { return *instrument_; }
  std::size_t records() const { return records_; }       ///< of all scans so far
  double instrument_time_s() const { return seconds_; }  ///< spent in them

 private:
  const Options& options_;
  std::filesystem::path folder_;
  std::shared_ptr<emulator::EmulatedInstrument> instrument_;
  std::size_t records_ = 0;
  double seconds_ = 0;
};

}  // namespace umov::study
