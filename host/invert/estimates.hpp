// The numbers of a fit with their intervals: parameters, what is derived of them, reflectance.
#pragma once

#include "host/formats/brdf_table.hpp"
#include "host/formats/fit_file.hpp"
#include "host/invert/invert.hpp"
#include "host/invert/posterior.hpp"

namespace umov::invert {

/// Fills `parameters` and `at_bound`.
void set_parameters(const Layout& layout, const Solution& solution, const Posterior& posterior,
                    formats::FitResult& fit);
/// Fills `derived`: the slope 2 sigma/tau of a rough surface, the sum of both diffuse coefficients.
void set_derived(const Layout& layout, const Solution& solution, const Posterior& posterior,
                 formats::FitResult& fit);
/// Fills `dhr` at the incidences of the options, else at normal incidence and at those of the data.
void set_dhr(const Layout& layout, const formats::BrdfTable& table, const Solution& solution,
             const Posterior& posterior, const Options& options, formats::FitResult& fit);

/// Fills `covariance`: all that predictions with intervals need.
void set_covariance(const Layout& layout, const Solution& solution, const Posterior& posterior,
                    formats::FitResult& fit);

}  // namespace umov::invert
