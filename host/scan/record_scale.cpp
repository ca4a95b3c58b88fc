#include "host/scan/record_scale.hpp"

namespace umov::scan {

formats::ScanRecord scaled(const protocol::Record& record, const PlanRow& row,
                           const protocol::HelloReply& device, double start_us) {
  const double gain = device.gains[record.gain];
  const double adc_v = 1e-9 * device.adc_step_nv;
  const double monitor_scale =
      2.0 * adc_v / (static_cast<double>(record.samples) * device.sine_amplitude);
  const double signal_scale = monitor_scale / gain;

  formats::ScanRecord scan;
  scan.index = record.index;
  scan.time_s = 1e-6 * (static_cast<double>(record.time_us) - start_us);
  scan.theta_i_deg = row.theta_i_deg;
  scan.theta_r_deg = row.theta_r_deg;
  scan.phi_r_deg = row.phi_r_deg;
  scan.wavelength_nm = row.wavelength_nm;
  scan.polarizer_deg = row.polarizer_deg;
  scan.analyzer_deg = row.analyzer_deg;
  scan.direction = record.direction >= 0 ? 1 : -1;
  scan.gain = gain;
  scan.x_v = signal_scale * static_cast<double>(record.signal_x);
  scan.y_v = signal_scale * static_cast<double>(record.signal_y);
  scan.x_se_v = signal_scale * static_cast<double>(record.signal_x_se);
  scan.y_se_v = signal_scale * static_cast<double>(record.signal_y_se);
  // The projection, not the modulus: noise must average out where there is hardly any light.
  scan.monitor_v = monitor_scale * static_cast<double>(record.monitor_x);
  scan.saturated = record.saturated > 0;
  scan.shutter_open = record.shutter_open != 0;
  return scan;
}

}  // namespace umov::scan
