#include "host/trace/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "host/errors/error.hpp"
#include "host/parallel/for_each_index.hpp"
#include "host/trace/launch.hpp"

namespace umov::trace {

using optics::Mueller;

namespace {

// Blocks between two decisions to stop. Part of the meaning of `samples`, so it is no option.
constexpr std::size_t wave = 16;
// Blocks traced at once, on one rank: at the end of a round threads wait for the slowest block.
constexpr std::size_t least_round = 2 * wave;
// Launches of a block: with fewer, a block takes no longer than what is done once for each.
constexpr std::uint64_t least_block = 2048;
// Blocks whose scatter tells errors to 6 %.
constexpr std::uint64_t enough_blocks = 128;

// What one block gives.
class Block : public Collector {
 public:
  Block(const Hemisphere& hemisphere, std::size_t wavelengths, std::size_t owners,
        std::uint32_t most_meetings)
      : Collector(owners > 0),
        cells(hemisphere.size() * wavelengths),
        all(wavelengths),
        absorbed(owners * wavelengths),
        ledger(wavelengths),
        hemisphere_(hemisphere),
        wavelengths_(wavelengths),
        most_meetings_(most_meetings > 0 ? most_meetings
                                         : std::numeric_limits<std::uint32_t>::max()) {}

  void clear() {
    std::fill(cells.begin(), cells.end(), Mueller<double>(0.0));
    std::fill(all.begin(), all.end(), Mueller<double>(0.0));
    std::fill(absorbed.begin(), absorbed.end(), std::array<double, 4>{});
    ledger = Ledger(wavelengths_);
  }

  void collect(const Exit& exit) override {
    if (!(exit.direction.z > 0.0) || exit.meetings > most_meetings_) return;
    cells[hemisphere_.find(exit.direction) * wavelengths_ + exit.wavelength] += exit.weight;
    if (const auto strip = hemisphere_.find_in_strip(exit.direction)) {
      cells[*strip * wavelengths_ + exit.wavelength] += exit.weight;
    }
    all[exit.wavelength] += exit.weight;
  }

  void absorb(const Absorbed& a) override {
    for (std::size_t c = 0; c < 4; ++c) {
      absorbed[a.owner * wavelengths_ + a.wavelength][c] += a.power[c];
    }
  }

  // Appends all numbers to a message, or reads them off one.
  void pack(std::vector<double>& message) {
    each_number([&](double& x) { message.push_back(x); });
    for (std::uint64_t* n : ledger.counts()) message.push_back(static_cast<double>(*n));
  }
  const double* unpack(const double* message) {
    each_number([&](double& x) { x = *message++; });
    for (std::uint64_t* n : ledger.counts()) *n = static_cast<std::uint64_t>(*message++);
    return message;
  }

  std::vector<Mueller<double>> cells, all;
  std::vector<std::array<double, 4>> absorbed;
  Ledger ledger;

 private:
  template <class Visitor>
  void each_number(const Visitor& visit) {
    for (auto* matrices : {&cells, &all}) {
      for (Mueller<double>& m : *matrices) {
        for (int c = 0; c < 4; ++c) {
          for (int r = 0; r < 4; ++r) visit(m[c][r]);
        }
      }
    }
    for (auto& row : absorbed) std::for_each(row.begin(), row.end(), visit);
    for (auto* sums : ledger.sums()) std::for_each(sums->begin(), sums->end(), visit);
  }

  const Hemisphere& hemisphere_;
  std::size_t wavelengths_;
  std::uint32_t most_meetings_;
};

void check(const PathTracer& tracer, const Hemisphere& hemisphere, const Request& request) {
  if (!(request.theta_i >= 0.0 && request.theta_i < 0.5 * optics::pi)) {
    throw Error(fmt::format("light from θi = {}°", optics::degrees(request.theta_i)),
                "choose an angle from 0 to below 90°");
  }
  if (request.samples == 0) {
    throw Error("a simulation without samples", "choose at least one");
  }
  const CellGoal& goal = request.cells;
  if (!(goal.percentile > 0.0 && goal.percentile <= 100.0)) {
    throw Error(fmt::format("an error at percentile {} of the cells", goal.percentile),
                "choose above 0 and up to 100");
  }
  if (goal.cell && *goal.cell >= hemisphere.cells()) {
    throw Error(fmt::format("an error of cell {} of {}", *goal.cell, hemisphere.cells()),
                "choose a cell that there is");
  }
  if (!tracer.scene().periodic) {
    throw Error("the BRDF of a scene that is not periodic", "make its domain periodic");
  }
}

}  // namespace

std::uint64_t block_of(const Request& request, const Scene& scene) {
  const bool ends_itself =
      request.dhr_relative_error > 0.0 || request.cells.relative_error > 0.0 || request.rays > 0;
  if (ends_itself) return least_block;
  return std::max(least_block, std::min(scene.faces(), request.samples / enough_blocks));
}

bool stop_asked(const Request& request) {
  return on_any_rank(request.team, request.stop && request.stop());
}

Result::Result(Hemisphere hemisphere, std::size_t wavelengths, std::size_t owners)
    : hemisphere_(std::move(hemisphere)),
      ledger_(wavelengths),
      cells_(hemisphere_.size() * wavelengths, {Mueller<double>(0.0), Mueller<double>(0.0)}),
      hemisphere_sums_(wavelengths, {Mueller<double>(0.0), Mueller<double>(0.0)}),
      dop_products_(wavelengths, 0.0),
      owners_(owners),
      absorbed_(owners * wavelengths) {}

// Block means x: mean and √(Σ(x - mean)²/(B(B - 1))), both times `scale`.
MuellerEstimate Result::estimate(const Sums& sums, double scale) const {
  const double b = static_cast<double>(blocks_);
  MuellerEstimate e{};
  for (int c = 0; c < 4; ++c) {
    for (int r = 0; r < 4; ++r) {
      const double mean = sums.sum[c][r] / b;
      const double spread = std::max(0.0, sums.squares[c][r] / b - mean * mean);
      e.mean[c][r] = mean * scale / block_;
      e.error[c][r] = std::sqrt(spread / (b - 1.0)) * scale / block_;
    }
  }
  return e;
}

MuellerEstimate Result::brdf(std::size_t cell, std::size_t wavelength) const {
  const std::size_t wavelengths = hemisphere_sums_.size();
  return estimate(cells_[cell * wavelengths + wavelength], 1.0 / hemisphere_.cell(cell).projected);
}

MuellerEstimate Result::hemispherical(std::size_t wavelength) const {
  return estimate(hemisphere_sums_[wavelength], 1.0);
}

Estimate Result::hemispherical_dop(std::size_t wavelength) const {
  const MuellerEstimate e = hemispherical(wavelength);
  const double intensity = e.mean[0][0];
  if (!(intensity > 0.0)) return {0.0, std::numeric_limits<double>::infinity()};
  const double dop = e.mean[0][1] / intensity;
  const double b = static_cast<double>(blocks_);
  const Sums& sums = hemisphere_sums_[wavelength];
  const double covariance =
      (dop_products_[wavelength] / b - sums.sum[0][0] * sums.sum[0][1] / (b * b)) /
      ((b - 1.0) * block_ * block_);
  const double variance = e.error[0][1] * e.error[0][1] - 2.0 * dop * covariance +
                          dop * dop * e.error[0][0] * e.error[0][0];
  return {dop, std::sqrt(std::max(0.0, variance)) / intensity};
}

std::array<Estimate, 4> Result::absorptance(std::size_t owner, std::size_t wavelength) const {
  const auto& sums = absorbed_.at(owner * hemisphere_sums_.size() + wavelength);
  const double b = static_cast<double>(blocks_);
  std::array<Estimate, 4> found{};
  for (std::size_t c = 0; c < 4; ++c) {
    const double mean = sums[c] / b;
    const double spread = std::max(0.0, sums[4 + c] / b - mean * mean);
    found[c] = {mean / block_, std::sqrt(spread / (b - 1.0)) / block_};
  }
  return found;
}

double Result::dhr_relative_error() const {
  double worst = 0.0;
  for (std::size_t i = 0; i < hemisphere_sums_.size(); ++i) {
    const MuellerEstimate e = hemispherical(i);
    if (e.mean[0][0] > 0.0) worst = std::max(worst, e.error[0][0] / e.mean[0][0]);
  }
  return worst;
}

double Result::cell_relative_error(const CellGoal& goal) const {
  const auto relative = [&](std::size_t cell, std::size_t wavelength) {
    const Sums& sums = cells_[cell * hemisphere_sums_.size() + wavelength];
    const double b = static_cast<double>(blocks_);
    const double mean = sums.sum[0][0] / b;
    if (!(mean > 0.0)) return std::numeric_limits<double>::infinity();
    const double spread = std::max(0.0, sums.squares[0][0] / b - mean * mean);
    return std::sqrt(spread / (b - 1.0)) / mean;
  };
  double worst = 0.0;
  std::vector<double> errors(goal.cell ? 0 : hemisphere_.cells());
  for (std::size_t w = 0; w < hemisphere_sums_.size(); ++w) {
    if (goal.cell) {
      worst = std::max(worst, relative(*goal.cell, w));
      continue;
    }
    for (std::size_t cell = 0; cell < errors.size(); ++cell) errors[cell] = relative(cell, w);
    const double rank = std::ceil(0.01 * goal.percentile * static_cast<double>(errors.size()));
    const auto at = errors.begin() + static_cast<std::ptrdiff_t>(std::max(1.0, rank)) - 1;
    std::nth_element(errors.begin(), at, errors.end());
    worst = std::max(worst, *at);
  }
  return worst;
}

// The numbers of a state, in its order. Counts are exact up to 2⁵³.
template <class Visitor>
void Result::each_number(Visitor visit) {
  const auto count = [&](std::uint64_t& n) {
    double x = static_cast<double>(n);
    visit(x);
    n = static_cast<std::uint64_t>(x);
  };
  count(samples_);
  count(blocks_);
  visit(block_);
  for (auto* all : {&cells_, &hemisphere_sums_}) {
    for (Sums& sums : *all) {
      for (auto* m : {&sums.sum, &sums.squares}) {
        for (int c = 0; c < 4; ++c) {
          for (int r = 0; r < 4; ++r) visit((*m)[c][r]);
        }
      }
    }
  }
  for (double& x : dop_products_) visit(x);
  for (auto& sums : absorbed_) std::for_each(sums.begin(), sums.end(), visit);
  for (auto* sums : ledger_.sums()) std::for_each(sums->begin(), sums->end(), visit);
  for (std::uint64_t* n : ledger_.counts()) count(*n);
}

std::vector<double> Result::state() const {
  std::vector<double> numbers;
  Result copy = *this;
  copy.each_number([&](double& x) { numbers.push_back(x); });
  return numbers;
}

void Result::restore(const std::vector<double>& state) {
  std::size_t wanted = 0;
  each_number([&](double&) { ++wanted; });
  if (state.size() != wanted) {
    throw Error(
        fmt::format("the state of a run has {} numbers instead of {}", state.size(), wanted),
        "continue it with the scene and the options that it was begun with");
  }
  std::size_t next = 0;
  each_number([&](double& x) { x = state[next++]; });
}

// A simulation on its way: rounds of blocks, each on all threads of all ranks, then added in the
// order of their numbers by everybody.
class Run {
 public:
  Run(const TracerOfBlock& tracers, const PathTracer& any, const Hemisphere& hemisphere,
      const Request& request)
      : tracers_(tracers),
        request_(request),
        block_(request.block > 0 ? request.block : block_of(request, any.scene())),
        ranks_(request.team != nullptr ? request.team->size() : 1),
        rank_(request.team != nullptr ? request.team->rank() : 0),
        round_(std::max(least_round, wave * ((ranks_ + wave - 1) / wave))),
        result_(hemisphere, any.scene().wavelengths_um.size(),
                request.emissivity ? any.scene().materials.size() + any.scene().media.size() : 0),
        blocks_(round_, Block(result_.hemisphere_, any.scene().wavelengths_um.size(),
                              result_.owners_, request.most_meetings)),
        workspaces_(own_blocks(), PathTracer::Workspace(any)) {
    result_.block_ = static_cast<double>(block_);
  }

  Result take(const std::vector<double>& begun) {
    if (!begun.empty()) {
      result_.restore(begun);
      block_ = static_cast<std::uint64_t>(result_.block_);  // of fewer or more samples, it may be
    }
    bool go_on = !done();
    while (go_on) {
      trace_own();
      const bool stopped = share();
      for (std::size_t first = 0; go_on && first < round_; first += wave) {
        add_wave(first);
        if (request_.progress) report();
        go_on = !done();
      }
      go_on = go_on && !stopped;
    }
    return std::move(result_);
  }

 private:
  bool done() const {
    if (result_.samples_ >= request_.samples) return true;
    if (request_.rays > 0 && result_.ledger_.rays >= request_.rays) return true;
    const bool by_dhr = request_.dhr_relative_error > 0.0;
    const bool by_cells = request_.cells.relative_error > 0.0;
    // The scatter of fewer blocks than 64 is too vague to stop by.
    if (!(by_dhr || by_cells) || result_.blocks_ < 4 * wave) return false;
    return !(by_dhr && result_.dhr_relative_error() > request_.dhr_relative_error) &&
           !(by_cells &&
             result_.cell_relative_error(request_.cells) > request_.cells.relative_error);
  }

  // By the launches or the rays, whichever end it sooner, or by the error that is farther off.
  void report() const {
    const bool by_cells = request_.cells.relative_error > 0.0;
    Progress p{result_.samples_, result_.dhr_relative_error(),
               by_cells ? result_.cell_relative_error(request_.cells) : 0.0, 0.0, result_};
    p.done = static_cast<double>(p.samples) / static_cast<double>(request_.samples);
    if (request_.rays > 0) {
      p.done = std::max(
          p.done, static_cast<double>(result_.ledger_.rays) / static_cast<double>(request_.rays));
    }
    // Errors fall as the root of the launches.
    double by_error = std::numeric_limits<double>::infinity();
    const auto goal = [&](double wanted, double found) {
      if (wanted > 0.0 && found > 0.0) by_error = std::min(by_error, std::pow(wanted / found, 2));
    };
    goal(request_.dhr_relative_error, p.dhr_relative_error);
    goal(request_.cells.relative_error, p.cell_relative_error);
    if (std::isfinite(by_error)) p.done = std::max(p.done, by_error);
    p.done = std::min(1.0, p.done);
    request_.progress(p);
  }

  // Until the launches asked for are made, in whole waves.
  std::size_t blocks_to_go() const {
    const std::uint64_t left = request_.samples - std::min(request_.samples, result_.samples_);
    const std::uint64_t of_wave = wave * block_;
    return wave * (left / of_wave + (left % of_wave > 0 ? 1 : 0));
  }

  std::size_t own_blocks() const { return (round_ + ranks_ - 1) / ranks_; }

  void trace_own() {
    const optics::Beam<double> beam = optics::incident_beam(request_.theta_i);
    const std::size_t wanted = std::min(round_, blocks_to_go());
    for_each_index(own_blocks(), request_.threads, [&](std::size_t own) {
      const std::size_t number = rank_ + own * ranks_;
      if (number >= wanted) return;
      const std::shared_ptr<const PathTracer> tracer = tracers_(result_.blocks_ + number);
      const Scene& scene = tracer->scene();
      // Above the highest face by more than what counts as on it.
      const double height = tracer->geometry().top() + 1e-3 * std::max(scene.size_x, scene.size_y);
      Block& block = blocks_[number];
      block.clear();
      const std::uint64_t first = (result_.blocks_ + number) * block_;
      for (std::uint64_t i = 0; i < block_; ++i) {
        const std::uint64_t sample = first + i;
        const auto at = launch_point(i, block_, uniforms(request_.seed, sample, 0));
        tracer->trace(Vec3(at[0] * scene.size_x, at[1] * scene.size_y, height), beam, request_.seed,
                      sample, workspaces_[own], block, block.ledger);
      }
    });
  }

  // Everybody gets all blocks. Whether one of the ranks is asked to stop.
  bool share() {
    const bool stop = request_.stop && request_.stop();
    if (ranks_ == 1) return stop;
    std::vector<double> message{stop ? 1.0 : 0.0};
    for (std::size_t own = 0; own < own_blocks(); ++own) {
      // Where ranks have not equally many blocks, the last one of some is sent for its length only.
      blocks_[std::min(rank_ + own * ranks_, round_ - 1)].pack(message);
    }
    const std::vector<double> all = request_.team->gather(message);
    const double* next = all.data();
    bool stopped = false;
    Block unused = blocks_.front();
    for (std::size_t rank = 0; rank < ranks_; ++rank) {
      stopped = stopped || *next > 0.0;
      ++next;
      for (std::size_t own = 0; own < own_blocks(); ++own) {
        const std::size_t number = rank + own * ranks_;
        next = (number < round_ ? blocks_[number] : unused).unpack(next);
      }
    }
    return stopped;
  }

  void add_wave(std::size_t first) {
    const auto add = [](Result::Sums& sums, const Mueller<double>& value) {
      sums.sum += value;
      for (int c = 0; c < 4; ++c) sums.squares[c] += value[c] * value[c];
    };
    // Cells by far outnumber the rest: shares of them on all threads, each in the order of blocks.
    constexpr std::size_t shares = 16;
    const std::size_t cells = result_.cells_.size();
    for_each_index(shares, request_.threads, [&](std::size_t share) {
      const std::size_t end = cells * (share + 1) / shares;
      for (std::size_t number = first; number < first + wave; ++number) {
        const Block& block = blocks_[number];
        for (std::size_t i = cells * share / shares; i < end; ++i) {
          if (block.cells[i][0][0] != 0.0) add(result_.cells_[i], block.cells[i]);
        }
      }
    });
    for (std::size_t number = first; number < first + wave; ++number) {
      const Block& block = blocks_[number];
      for (std::size_t i = 0; i < block.all.size(); ++i) {
        add(result_.hemisphere_sums_[i], block.all[i]);
        result_.dop_products_[i] += block.all[i][0][0] * block.all[i][0][1];
      }
      for (std::size_t i = 0; i < block.absorbed.size(); ++i) {
        for (std::size_t c = 0; c < 4; ++c) {
          result_.absorbed_[i][c] += block.absorbed[i][c];
          result_.absorbed_[i][4 + c] += block.absorbed[i][c] * block.absorbed[i][c];
        }
      }
      result_.ledger_.add(block.ledger);
    }
    result_.blocks_ += wave;
    result_.samples_ += wave * block_;
  }

  const TracerOfBlock& tracers_;
  const Request& request_;
  std::uint64_t block_;  // launches
  const std::size_t ranks_, rank_, round_;
  Result result_;
  std::vector<Block> blocks_;  // of a round, by number
  std::vector<PathTracer::Workspace> workspaces_;
};

Result simulate(const PathTracer& tracer, const Hemisphere& hemisphere, const Request& request,
                const std::vector<double>& begun) {
  const std::shared_ptr<const PathTracer> not_owned(std::shared_ptr<void>(), &tracer);
  return simulate([&](std::uint64_t) { return not_owned; }, hemisphere, request, begun);
}

Result simulate(const TracerOfBlock& tracers, const Hemisphere& hemisphere, const Request& request,
                const std::vector<double>& begun) {
  const std::shared_ptr<const PathTracer> any = tracers(0);
  check(*any, hemisphere, request);
  return Run(tracers, *any, hemisphere, request).take(begun);
}

}  // namespace umov::trace
