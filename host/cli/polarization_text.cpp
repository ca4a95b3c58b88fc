#include "host/cli/polarization_text.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace umov::cli {

namespace {

nlohmann::json with_u(double value, double u) {
  return {{"value", value}, {"u", u}};
}

}  // namespace

std::string polarization_text(const calibrate::PolarizationCalibration& p) {
  std::string text = fmt::format(
      "Polariser and analyser from the reflection of {} ({})\n{:>7} {:>17} {:>17} {:>18} {:>18} "
      "{:>16} {:>16} {:>9}\n",
      p.mirror.empty() ? "a mirror" : p.mirror, p.index, "nm", "polariser [deg]", "analyser [deg]",
      "polariser 1:", "analyser 1:", "detector bias", "monitor bias", "chi2/dof");
  const auto ratio = [](double e, double u) {
    return e > 0 ? fmt::format("{:.0f} +- {:.1f}%", 1 / e, 100 * u / e) : std::string("-");
  };
  for (const auto& w : p.wavelengths)
    text += fmt::format(
        "{:>7g} {:>8.3f} +-{:>6.3f} {:>8.3f} +-{:>6.3f} {:>18} {:>18} {:>8.4f} "
        "+-{:>5.4f} {:>8.4f} +-{:>5.4f} {:>9.2f}\n",
        w.wavelength_nm, w.polarizer_axis_deg, w.polarizer_axis_u_deg, w.analyzer_axis_deg,
        w.analyzer_axis_u_deg, ratio(w.polarizer_extinction, w.polarizer_extinction_u),
        ratio(w.analyzer_extinction, w.analyzer_extinction_u), w.detector_bias, w.detector_bias_u,
        w.monitor_bias, w.monitor_bias_u, w.dof > 0 ? w.chi2 / w.dof : 0.0);
  text += fmt::format(
      "incidence {:+.3f} +- {:.3f} deg, wafer leans {:+.3f} +- {:.3f} deg out of plane, arm's "
      "azimuth {:+.3f} +- {:.3f} deg, play of polariser {:.3f} and analyser {:.3f} deg\n",
      p.incidence_offset_deg, p.incidence_offset_u_deg, p.tilt_out_of_plane_deg,
      p.tilt_out_of_plane_u_deg, p.azimuth_offset_deg, p.azimuth_offset_u_deg, p.polarizer_play_deg,
      p.analyzer_play_deg);
  for (const std::string& note : p.notes) text += "note: " + note + "\n";
  return text;
}

nlohmann::json polarization_json(const calibrate::PolarizationCalibration& p) {
  nlohmann::json waves = nlohmann::json::array();
  for (const auto& w : p.wavelengths)
    waves.push_back(
        {{"wavelength_nm", w.wavelength_nm},
         {"polarizer_axis_deg", with_u(w.polarizer_axis_deg, w.polarizer_axis_u_deg)},
         {"analyzer_axis_deg", with_u(w.analyzer_axis_deg, w.analyzer_axis_u_deg)},
         {"polarizer_extinction", with_u(w.polarizer_extinction, w.polarizer_extinction_u)},
         {"analyzer_extinction", with_u(w.analyzer_extinction, w.analyzer_extinction_u)},
         {"detector_bias", with_u(w.detector_bias, w.detector_bias_u)},
         {"monitor_bias", with_u(w.monitor_bias, w.monitor_bias_u)},
         {"source_q", with_u(w.source_q, w.source_q_u)},
         {"source_u", with_u(w.source_u, w.source_u_u)},
         {"leak_coherence", with_u(w.leak_coherence, w.leak_coherence_u)},
         {"index_n", with_u(w.index_n, w.index_n_u)},
         {"index_kappa", with_u(w.index_kappa, w.index_kappa_u)},
         {"slow_noise", w.slow_noise},
         {"chi2", w.chi2},
         {"degrees_of_freedom", w.dof},
         {"records", w.records},
         {"rejected", w.rejected}});
  return {{"mirror", p.mirror},
          {"index", p.index},
          {"wavelengths", waves},
          {"incidence_offset_deg", with_u(p.incidence_offset_deg, p.incidence_offset_u_deg)},
          {"tilt_out_of_plane_deg", with_u(p.tilt_out_of_plane_deg, p.tilt_out_of_plane_u_deg)},
          {"azimuth_offset_deg", with_u(p.azimuth_offset_deg, p.azimuth_offset_u_deg)},
          {"polarizer_play_deg", with_u(p.polarizer_play_deg, p.polarizer_play_u_deg)},
          {"analyzer_play_deg", with_u(p.analyzer_play_deg, p.analyzer_play_u_deg)},
          {"notes", p.notes}};
}

}  // namespace umov::cli
