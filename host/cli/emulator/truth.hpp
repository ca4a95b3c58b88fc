// The truth behind the emulated instrument, free of noise: what a measurement should find. For
// studies and tests; nothing that evaluates a measurement may ask here.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "host/cli/emulator/emulated_instrument.hpp"

namespace umov::emulator {

/// A sample of the catalogue, or a sample file, as the emulated light meets it. Angles in degrees
/// (signed θr in plane), wavelengths in nm, axes from p towards s, NaN = open.
class SampleTruth {
 public:
  /// Throws umov::Error for an unknown sample.
  explicit SampleTruth(const std::string& sample);

  /// BRDF in 1/sr as ideal polariser and analyser define it, mirror part left out.
  double brdf(double theta_i_deg, double theta_r_deg, double phi_r_deg, double wavelength_nm,
              double polarizer_deg, double analyzer_deg) const;
  /// (P4) for P-polarised light.
  double dolp(double theta_i_deg, double theta_r_deg, double phi_r_deg, double wavelength_nm) const;
  /// Directional-hemispherical reflectance for unpolarised light.
  double dhr(double theta_i_deg, double wavelength_nm, bool with_mirror = true) const;
  /// A parameter by the model's name, such as "k_uds"; throws umov::Error where the sample has
  /// none.
  double parameter(const std::string& name, double wavelength_nm) const;

 private:
  std::shared_ptr<const plant::Sample> sample_;
};

/// What a polarisation calibration should find of an instrument.
struct PolarizerTruth {
  double axis_deg = 0;    ///< true axis minus commanded one, play taken as zero
  double extinction = 0;  ///< power ratio crossed/parallel
};
PolarizerTruth polarizer_truth(const EmulatedInstrument& instrument);
PolarizerTruth analyzer_truth(const EmulatedInstrument& instrument);

/// Writes the true in-plane BRDF of a sample as CSV, as a calibration laboratory would certify it
/// for a standard that is not Lambertian: θi 0 to 75, θr -88 to 88 deg, every combination of P, S
/// and open. Throws umov::Error where it can't be written.
void write_certificate(const std::string& sample, const std::filesystem::path& path);

}  // namespace umov::emulator
