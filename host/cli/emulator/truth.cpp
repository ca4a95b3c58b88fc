#include "host/cli/emulator/truth.hpp"

#include <array>
#include <cmath>
#include <fstream>
#include <limits>

#include <fmt/format.h>

#include "hil/plant/plant_config.hpp"
#include "hil/plant/sample_catalog.hpp"
#include "host/errors/error.hpp"
#include "host/optics/mueller.hpp"

namespace umov::emulator {
namespace {

constexpr double open = std::numeric_limits<double>::quiet_NaN();
constexpr int polarizer_axis = 3, analyzer_axis = 4;

optics::Stokes<double> source(double axis_deg) {
  return std::isnan(axis_deg) ? optics::unpolarized<double>()
                              : optics::polarizer_stokes<double>(axis_deg);
}

optics::Stokes<double> detector(double axis_deg) {
  return std::isnan(axis_deg) ? optics::unpolarized<double>()
                              : optics::analyzer_stokes<double>(axis_deg);
}

PolarizerTruth truth_of(const plant::AxisErrors& axis, const plant::PolarizerConfig& element) {
  return {axis.zero_deg, element.extinction};
}

}  // namespace

SampleTruth::SampleTruth(const std::string& sample) : sample_(plant::make_sample(sample)) {}

double SampleTruth::brdf(double theta_i_deg, double theta_r_deg, double phi_r_deg,
                         double wavelength_nm, double polarizer_deg, double analyzer_deg) const {
  const auto mueller = plant::brdf_at(*sample_, theta_i_deg, theta_r_deg, phi_r_deg, wavelength_nm);
  return optics::contract(detector(analyzer_deg), mueller, source(polarizer_deg));
}

double SampleTruth::dolp(double theta_i_deg, double theta_r_deg, double phi_r_deg,
                         double wavelength_nm) const {
  const auto state = [&](double analyzer_deg) {
    return brdf(theta_i_deg, theta_r_deg, phi_r_deg, wavelength_nm, 0, analyzer_deg);
  };
  return (state(0) - state(90)) / state(open);
}

double SampleTruth::dhr(double theta_i_deg, double wavelength_nm, bool with_mirror) const {
  return plant::dhr(*sample_, theta_i_deg, wavelength_nm, with_mirror).unpolarized;
}

double SampleTruth::parameter(const std::string& name, double wavelength_nm) const {
  return plant::truth_value(*sample_, name, wavelength_nm);
}

PolarizerTruth polarizer_truth(const EmulatedInstrument& instrument) {
  const auto& config = instrument.plant().config();
  return truth_of(config.axis[polarizer_axis], config.polarizer);
}

PolarizerTruth analyzer_truth(const EmulatedInstrument& instrument) {
  const auto& config = instrument.plant().config();
  return truth_of(config.axis[analyzer_axis], config.analyzer);
}

void write_certificate(const std::string& sample, const std::filesystem::path& path) {
  const SampleTruth truth(sample);
  struct Axis {
    const char* text;
    double deg;
  };
  constexpr std::array<Axis, 3> axes{{{"0", 0.0}, {"90", 90.0}, {"open", open}}};
  std::ofstream file(path);
  file << "# BRDF of " << sample
       << " in the plane of incidence, 1/sr; polariser and analyser axes from p towards s\n"
       << "theta_i_deg,theta_r_deg,phi_r_deg,wavelength_nm,polarizer_deg,analyzer_deg,"
          "brdf_per_sr\n";
  for (const int wavelength_nm : plant::laser_names) {
    for (int theta_i_deg = 0; theta_i_deg <= 75; theta_i_deg += 5) {
      for (int theta_r_deg = -88; theta_r_deg <= 88; ++theta_r_deg) {
        for (const auto& polarizer : axes) {
          for (const auto& analyzer : axes) {
            file << fmt::format("{},{},0,{},{},{},{:.9g}\n", theta_i_deg, theta_r_deg,
                                wavelength_nm, polarizer.text, analyzer.text,
                                truth.brdf(theta_i_deg, theta_r_deg, 0, wavelength_nm,
                                           polarizer.deg, analyzer.deg));
          }
        }
      }
    }
  }
  if (!file.flush())
    throw Error({path.string()}, "cannot write the certificate",
                "check the folder and the space on the disk");
}

}  // namespace umov::emulator
