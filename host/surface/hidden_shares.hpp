// What particles hide of the ground along the incident light.
#pragma once

#include <cstdint>
#include <vector>

#include "host/surface/lays.hpp"

namespace umov::surface {

/// The faces of a surface, all black, without films: light ends where it first meets a particle or
/// the ground.
Lays black_lays(const ReadSurface& read, const Reading& reading);

/// What black_lays() are to be simulated with: a million launches at most; seed, threads, ranks and
/// stop are those of `how`.
trace::Request black_request(double theta_i_deg, const trace::Request& how);

/// Share of the light that each layer of particles meets first, from a simulation of `lays`.
std::vector<trace::Estimate> hidden_shares(const Lays& lays, const trace::Result& result);

/// All in one; `launches` of each lay, 0: one lay.
std::vector<trace::Estimate> hidden_shares(const ReadSurface& read, const Reading& reading,
                                           double theta_i_deg, const trace::Request& how,
                                           std::uint64_t launches);

/// Directions do not matter to it.
trace::Hemisphere one_ring();

}  // namespace umov::surface
