// What a place of a residual is confined to, in the words of a scan: polariser, analyser, component
// of the lock-in, wavelength.
#pragma once

#include "host/gap/engine/refit.hpp"
#include "host/gap/engine/where.hpp"
#include "host/gap/scan/scan_model.hpp"

namespace umov::gap::scan {

/// Fills Cell::also: `polarizer` and `analyzer` (P, S, open, or the angle in degrees) and
/// `component` (x, y) of cells that lie in one channel; `wavelength_nm` of cells that lie at one
/// wavelength, or whose misfit does: more than nine tenths of it, and significantly. `fit` is what
/// left the residual.
void confine(Where& where, const ScanModel& model, const Refit& fit);

}  // namespace umov::gap::scan
