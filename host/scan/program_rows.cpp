#include "host/scan/program_rows.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "host/errors/error.hpp"
#include "host/instrument/refusals.hpp"

namespace umov::scan {
namespace {

std::int32_t microdegrees(double deg) {
  return std::isnan(deg) ? protocol::open_position
                         : static_cast<std::int32_t>(std::lround(1e6 * deg));
}

int gain_range(const protocol::HelloReply& device, int gain) {
  for (std::size_t i = 0; i < device.gains.size(); ++i) {
    if (device.gains[i] == gain) return static_cast<int>(i);
  }
  throw Error(fmt::format("the controller has no amplifier range {}", gain),
              fmt::format("use gain = \"auto\" or one of {}, {}, {}, {}", device.gains[0],
                          device.gains[1], device.gains[2], device.gains[3]));
}

std::uint8_t laser_of(const protocol::HelloReply& device, double wavelength_nm) {
  for (std::size_t i = 0; i < device.wavelengths_nm.size(); ++i) {
    if (device.wavelengths_nm[i] == wavelength_nm) return static_cast<std::uint8_t>(i + 1);
  }
  throw Error(fmt::format("the instrument has no laser of {:g} nm", wavelength_nm),
              fmt::format("use wavelengths_nm out of {}, {}, {}", device.wavelengths_nm[0],
                          device.wavelengths_nm[1], device.wavelengths_nm[2]));
}

std::int32_t filter_position_udeg(const protocol::HelloReply& device, double optical_density) {
  for (std::size_t i = 0; i < device.filter_od_milli.size(); ++i) {
    if (device.filter_od_milli[i] == std::lround(1000 * optical_density)) {
      return static_cast<std::int32_t>(i) * 60'000'000;
    }
  }
  throw Error(fmt::format("the filter wheel has no optical density {:g}", optical_density),
              "use one of the densities that `umov device info` lists");
}

}  // namespace

protocol::ProgramRow program_row(const PlanRow& row, std::uint32_t index,
                                 const protocol::HelloReply& device) {
  protocol::ProgramRow out;
  out.index = index;
  out.target_udeg = {
      microdegrees(row.theta_i_deg),  microdegrees(row.theta_r_deg),
      microdegrees(row.phi_r_deg),    microdegrees(row.polarizer_deg),
      microdegrees(row.analyzer_deg), filter_position_udeg(device, row.optical_density)};
  out.laser = laser_of(device, row.wavelength_nm);
  out.shutter_open = row.shutter_open ? 1 : 0;
  out.gain = row.gain == gain_auto ? protocol::gain_auto
                                   : static_cast<std::uint8_t>(gain_range(device, row.gain));
  out.dwell_ms = static_cast<std::uint16_t>(row.dwell_ms);
  return out;
}

void check_against_device(const Plan& plan, const Program& program, instrument::Session& session) {
  std::array<protocol::AxisInfo, protocol::axis_count> axes;
  for (std::uint8_t axis = 0; axis < protocol::axis_count; ++axis) {
    axes[axis] = session.request(protocol::GetAxis{axis});
  }
  for (std::uint32_t index = 0; index < program.rows.size(); ++index) {
    const auto row = program_row(program.rows[index], index, session.device());
    for (std::size_t axis = 0; axis < axes.size(); ++axis) {
      const auto target = row.target_udeg[axis];
      if (target == protocol::open_position) continue;
      if (target >= axes[axis].min_udeg && target <= axes[axis].max_udeg) continue;
      throw Error(
          {plan.name},
          fmt::format("row {} asks the {} axis for {:g} degrees; its limits are {:g} to {:g}",
                      index, instrument::axis_name(static_cast<int>(axis)), 1e-6 * target,
                      1e-6 * axes[axis].min_udeg, 1e-6 * axes[axis].max_udeg),
          "change the plan, or the axis' limits with umov device config set");
    }
  }
}

}  // namespace umov::scan
