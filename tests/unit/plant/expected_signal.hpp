// The noise-free signal of a bench at a geometry, in one line.
#pragma once

#include "bench.hpp"

namespace umov::plant::test {

inline constexpr int red_laser = 1;

/// Polarisation state and laser; both carriers open and 633 nm unless said otherwise.
struct View {
  double polarizer = open, analyzer = open;
  int laser = red_laser;
};

/// X in volts at range 1.
inline double signal(Bench& bench, double ti, double tr, double phi = 0.0, View view = {}) {
  bench.laser(view.laser);
  bench.polarization(view.polarizer, view.analyzer);
  bench.geometry(ti, tr, phi);
  return bench.plant().expected(bench.time_s()).x_v;
}

}  // namespace umov::plant::test
