// What is known of the bench from elsewhere (data sheets, alignment) and no scan of a campaign
// shows: declared standard uncertainties (GUM type B).
#pragma once

#include <array>

namespace umov::calibrate {

/// One standard deviation each, but for the aperture; 0 = not declared.
struct DeclaredDoubts {
  double theta_i_zero_u_deg = 0;  ///< zero of the incidence arm
  double theta_r_zero_u_deg = 0;  ///< zero of the detector arm, in the standard's scan as in others
  /// How a sample leans on its plate in the plane of incidence; the standard on its own.
  double sample_lean_u_deg = 0;
  /// Error of the detector arm that runs once a turn (an axis beside the circle's middle): of its
  /// cosine and of its sine.
  double theta_r_eccentricity_u_deg = 0;
  double theta_r_play_u_deg = 0;  ///< of the detector's drive: it stops half of it behind
  /// Finer periodic errors of gears and encoders: where a drive stops, the same at each visit.
  double position_u_deg = 0;
  /// Relative: slow noise of the source that the monitor misses. Common to a wavelength from the
  /// standard's scan to another one, and again to all points of an incidence, which are measured
  /// within minutes.
  double source_relative_u = 0;
  /// Half-angle of the detector disc seen from the sample at the standard's solid angle: no doubt,
  /// but a size that is corrected for (P27). 0 = a point, or unknown.
  double aperture_half_angle_deg = 0;
  /// Of the detector's solid angle, relative: matters only where a scan's differs from the
  /// standard's.
  double solid_angle_relative_u = 0;
};

/// The keys of DeclaredDoubts in campaign.toml and cal.h5, with the largest value that makes sense.
struct DeclaredKey {
  const char* name;
  double DeclaredDoubts::*value;
  double largest;
  const char* unit;
};
inline constexpr std::array declared_keys = {
    DeclaredKey{"theta_i_zero_u_deg", &DeclaredDoubts::theta_i_zero_u_deg, 10, "deg"},
    DeclaredKey{"theta_r_zero_u_deg", &DeclaredDoubts::theta_r_zero_u_deg, 10, "deg"},
    DeclaredKey{"sample_lean_u_deg", &DeclaredDoubts::sample_lean_u_deg, 10, "deg"},
    DeclaredKey{"theta_r_eccentricity_u_deg", &DeclaredDoubts::theta_r_eccentricity_u_deg, 10,
                "deg"},
    DeclaredKey{"theta_r_play_u_deg", &DeclaredDoubts::theta_r_play_u_deg, 10, "deg"},
    DeclaredKey{"position_u_deg", &DeclaredDoubts::position_u_deg, 10, "deg"},
    DeclaredKey{"source_relative_u", &DeclaredDoubts::source_relative_u, 1, "1"},
    DeclaredKey{"aperture_half_angle_deg", &DeclaredDoubts::aperture_half_angle_deg, 10, "deg"},
    DeclaredKey{"solid_angle_relative_u", &DeclaredDoubts::solid_angle_relative_u, 1, "1"},
};

}  // namespace umov::calibrate
