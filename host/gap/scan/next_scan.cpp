#include "host/gap/scan/next_scan.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <Eigen/Cholesky>

#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"

namespace umov::gap::scan {
namespace {

/// Least distance that a further scan is offered for, standard deviations.
constexpr double worth_taking = 3.0;

/// Rows of the first scan without set-ups, thinned: every second angle of two incidences.
std::vector<Record> thinned(const std::vector<Record>& records) {
  std::set<double> incidences;
  for (const Record& r : records) incidences.insert(r.theta_i);
  std::vector<double> all(incidences.begin(), incidences.end());
  const std::set<double> kept{all[all.size() / 3], all.back()};
  std::vector<Record> result;
  int last_row = -1;
  bool take = true;
  for (const Record& r : records) {
    if (!r.shutter_open || r.sample_flipped || r.sample_removed || r.long_pass || r.phi_r != 0 ||
        !kept.contains(r.theta_i))
      continue;
    take = r.row != last_row || !take;
    last_row = r.row;
    if (take) result.push_back(r);
  }
  return result;
}

using Rows = std::vector<Record>;

/// One copy of each pair of angles and wavelength, to be given other settings.
Rows one_state(const Rows& rows) {
  Rows result;
  std::set<std::tuple<double, double, std::size_t>> seen;
  for (const Record& r : rows)
    if (seen.insert({r.theta_i, r.theta_r, r.wavelength}).second) result.push_back(r);
  return result;
}

/// Two points of one incidence and one state, eight times each.
Rows reference_points(const Rows& rows) {
  constexpr double reference = 20.0;
  constexpr int times = 8;
  const auto is_one_state = [&](const Record& r) {
    const Record& f = rows.front();
    return r.theta_i == f.theta_i && r.polarizer_open == f.polarizer_open &&
           r.analyzer_open == f.analyzer_open && r.polarizer == f.polarizer &&
           r.analyzer == f.analyzer;
  };
  std::map<std::pair<std::size_t, double>, Record> nearest;  // by wavelength and point
  for (const double point : {-optics::radians(reference), optics::radians(reference)}) {
    for (const Record& r : rows) {
      if (!is_one_state(r)) continue;
      const auto [known, added] = nearest.try_emplace({r.wavelength, point}, r);
      if (!added && std::abs(r.theta_r - point) < std::abs(known->second.theta_r - point))
        known->second = r;
    }
  }
  Rows result;
  for (int k = 0; k < times; ++k)
    for (const auto& [key, record] : nearest) result.push_back(record);
  return result;
}

struct MenuItem {
  const char* name;
  double set_up_minutes;  ///< somebody turns, takes away or exchanges something
  std::function<Rows(const Rows&)> rows;
};

template <class Change>
std::function<Rows(const Rows&)> changed(const Change& change) {
  return [change](const Rows& rows) {
    Rows result = rows;
    for (Record& r : result) change(r);
    return result;
  };
}

/// The menu as far as it shows in the signal chain. A white tile is another sample and comes in as
/// a calibration: it is not foretold here.
std::vector<MenuItem> menu() {
  return {
      {"reverse", 0, changed([](Record& r) { r.direction = -r.direction; })},
      {"serpentine", 0, changed([](Record& r) {
         if (r.row % 2 != 0) r.direction = -r.direction;
       })},
      {"flip", 2, changed([](Record& r) { r.sample_flipped = true; })},
      {"pm45", 0,
       [](const Rows& rows) {
         Rows result;
         const double quarter = optics::radians(45.0);
         for (const Record& own : one_state(rows)) {
           for (const auto& [polarizer, analyzer] : {std::pair{quarter, quarter},
                                                     {quarter, -quarter},
                                                     {0.0, quarter},
                                                     {0.0, -quarter},
                                                     {2 * quarter, quarter}}) {
             Record r = own;
             r.polarizer_open = r.analyzer_open = false;
             r.polarizer = polarizer;
             r.analyzer = analyzer;
             result.push_back(r);
           }
         }
         return result;
       }},
      {"shutter", 0,
       [](const Rows& rows) {
         Rows result = one_state(rows);
         if (result.size() > 60) result.resize(60);
         for (Record& r : result) r.shutter_open = false;
         return result;
       }},
      {"nd", 0,
       [](const Rows& rows) {
         Rows result;
         for (const double density : {1.0, 2.0}) {
           for (Record r : rows) {
             // Before the monitor's pick-off: it sees the light fall too.
             r.monitor_v *= std::pow(10.0, -density);
             result.push_back(r);
           }
         }
         return result;
       }},
      {"iris", 1, changed([](Record& r) { r.iris_fraction = 0.5; })},
      {"oop", 0,
       [](const Rows& rows) {
         Rows result;
         for (const double phi : {30.0, 90.0, 150.0}) {
           for (Record r : rows) {
             if (r.theta_r <= 0) continue;
             r.phi_r = optics::radians(phi);
             result.push_back(r);
           }
         }
         return result;
       }},
      {"repeat", 0, reference_points},
      {"long_pass", 1, changed([](Record& r) { r.long_pass = true; })},
      {"no_sample", 2, changed([](Record& r) { r.sample_removed = true; })},
  };
}

/// The largest amplifier range that the signal does not overdrive.
double range_for(double signal_v, double full_scale_v) {
  const double limit = 0.8 * (full_scale_v > 0 ? full_scale_v : 3.0);
  for (const double gain : {1000.0, 100.0, 10.0})
    if (std::abs(signal_v) * gain < limit) return gain;
  return 1.0;
}

/// A hypothetical measurement: these rows as the model sees them, behind the first scan.
ScanModel taken(const ScanModel& model, Rows rows, const Explanation& truth) {
  const Record& last = model.records().records.back();
  double time_s = last.time_s;
  const double step_s =
      last.time_s / std::max<double>(1, static_cast<double>(model.records().records.size()));
  for (Record& r : rows) {
    r.time_s = time_s += step_s;
    r.saturated = false;
    r.row += last.row + 1;
  }
  ScanModel other = model.with_records(rows);
  Eigen::VectorXd mean;
  other.predict(truth, mean, nullptr);
  for (std::size_t i = 0; i < rows.size(); ++i)
    rows[i].gain = range_for(mean[static_cast<Eigen::Index>(i)], model.records().adc_full_scale_v);
  return model.with_records(rows);
}

/// Distance between what `truth` foretells and the nearest that `rival` can, held by what the first
/// measurement said of its parameters.
double distance(const ScanModel& further, const Explanation& truth, const Refit& rival,
                const RelativeNoise& relative) {
  Eigen::VectorXd expected, foretold;
  Eigen::MatrixXd jacobian;
  further.predict(truth, expected, nullptr);
  further.predict(rival.explanation, foretold, &jacobian);
  // The slow noise of a single record counts as white: its memory is short against a row.
  RelativeNoise white{std::hypot(relative.white, relative.slow), 0, 0};
  const Whitening whitening(further.noise(expected), white);
  const Eigen::VectorXd apart = whitening.apply(expected - foretold);
  const Eigen::MatrixXd j = whitening.apply(jacobian(Eigen::all, rival.free));
  const Eigen::MatrixXd precision = rival.precision(rival.free, rival.free) + j.transpose() * j;
  const Eigen::VectorXd scale = precision.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  Eigen::MatrixXd scaled = scale.asDiagonal() * precision * scale.asDiagonal();
  scaled.diagonal().array() += 1e-10;
  const Eigen::VectorXd pull = scale.cwiseProduct(j.transpose() * apart);
  return std::sqrt(std::max(0.0, apart.squaredNorm() - pull.dot(scaled.ldlt().solve(pull))));
}

/// How well these places tell scatter that comes back from scatter that is new each time, as twice
/// the ln of the odds that either is expected to gain over the other (the smaller of both): each
/// place's measurements correlate with one another, or do not.
double told_by_repeats(const NoiseShape& shape, const RelativeNoise& noise) {
  const Whitening whitening(shape, {std::hypot(noise.white, noise.pattern), 0, 0});
  double if_fixed = 0, if_fresh = 0;
  for (const std::vector<Eigen::Index>& group : shape.same_place) {
    const auto m = static_cast<Eigen::Index>(group.size());
    Eigen::VectorXd part(m);
    for (Eigen::Index k = 0; k < m; ++k) {
      const Eigen::Index i = group[static_cast<std::size_t>(k)];
      part[k] = noise.pattern * shape.relative[i] / whitening.white_sigma()[i];
    }
    Eigen::MatrixXd correlation = part * part.transpose();
    correlation.diagonal().setOnes();
    const Eigen::LDLT<Eigen::MatrixXd> factor(correlation);
    const double ln_det = factor.vectorD().cwiseMax(1e-300).array().log().sum();
    const double trace = factor.solve(Eigen::MatrixXd::Identity(m, m)).trace();
    if_fixed -= ln_det;
    if_fresh += ln_det + trace - static_cast<double>(m);
  }
  return std::min(if_fixed, if_fresh);
}

/// The named cause that scatters, if this scan cannot tell it from fresh noise; else empty.
std::string unsettled_scatter(const Diagnosis& d) {
  for (const auto& set : d.ambiguity_sets)
    if (d.excess && std::find(set.begin(), set.end(), unseen_noise) != set.end())
      for (const Cause& cause : d.causes)
        if (std::find(set.begin(), set.end(), cause.effect) != set.end()) return cause.effect;
  return {};
}

/// Distance of scatter from fresh noise once these records are there too, in standard deviations.
double scatter_apart(const ScanModel& model, const ScanModel& further, const Diagnosis& d) {
  Rows all = model.records().records;
  const Rows& more = further.records().records;
  all.insert(all.end(), more.begin(), more.end());
  const ScanModel both = model.with_records(std::move(all));
  const auto told = [&](const ScanModel& m) {
    Eigen::VectorXd mean;
    m.predict(d.best.explanation, mean, nullptr);
    return told_by_repeats(m.noise(mean), d.excess->with);
  };
  return std::sqrt(std::max(0.0, told(both) - told(model)));
}

}  // namespace

std::vector<FurtherScan> further_scans(const ScanModel& model, const Diagnosis& diagnosis) {
  const auto& pairs = diagnosis.rivals;
  const std::string scatter = unsettled_scatter(diagnosis);
  if (pairs.empty() && scatter.empty()) return {};
  const Rows rows = thinned(model.records().records);
  if (rows.empty()) return {};
  const Record& last = model.records().records.back();
  const double minutes_a_record =
      last.time_s / 60 / static_cast<double>(model.records().records.size());

  std::vector<FurtherScan> found;
  for (const MenuItem& item : menu()) {
    const Rows further_rows = item.rows(rows);
    if (further_rows.empty()) continue;
    FurtherScan scan{item.name, {}, 0, 0};
    scan.minutes =
        item.set_up_minutes + minutes_a_record * static_cast<double>(further_rows.size());
    double least = 1e300;
    for (const Diagnosis::Rival& pair : pairs) {
      const ScanModel further = taken(model, further_rows, pair.best.explanation);
      const double apart = std::min(
          distance(further, pair.best.explanation, pair.rival, diagnosis.search.relative_noise),
          distance(further, pair.rival.explanation, pair.best, diagnosis.search.relative_noise));
      if (apart < worth_taking) continue;
      scan.separates.push_back({pair.effect, pair.rival_effect});
      least = std::min(least, apart);
    }
    if (!scatter.empty()) {
      const ScanModel further = taken(model, further_rows, diagnosis.best.explanation);
      const double apart = scatter_apart(model, further, diagnosis);
      if (apart >= worth_taking) {
        scan.separates.push_back({scatter, unseen_noise});
        least = std::min(least, apart);
      }
    }
    if (scan.separates.empty()) continue;
    scan.expected_separation = least;
    found.push_back(std::move(scan));
  }
  // Pairs told apart come first, then what each minute of them buys.
  std::stable_sort(found.begin(), found.end(), [](const FurtherScan& a, const FurtherScan& b) {
    if (a.separates.size() != b.separates.size()) return a.separates.size() > b.separates.size();
    const auto merit = [](const FurtherScan& s) {
      return std::min(s.expected_separation, 8.0) / std::max(s.minutes, 0.1);
    };
    return merit(a) > merit(b);
  });
  return found;
}

std::vector<Record> further_records(const ScanModel& model, const std::string& wanted,
                                    const Explanation& truth) {
  for (const MenuItem& item : menu())
    if (item.name == wanted)
      return taken(model, item.rows(thinned(model.records().records)), truth).records().records;
  throw Error(fmt::format("\"{}\" is no further scan that is weighed", wanted),
              "choose one of the menu, but white_tile");
}

std::string plan_of(const FurtherScan& scan, const ScanModel& model, const std::string& sample) {
  std::set<double> incidences;
  for (const Record& r : thinned(model.records().records))
    incidences.insert(std::round(optics::degrees(r.theta_i) * 1e6) / 1e6);
  double reach = 0;
  for (const Record& r : model.records().records)
    reach = std::max(reach, std::round(optics::degrees(std::abs(r.theta_r)) * 1e6) / 1e6);
  std::string escaped;
  for (const char c : sample) {
    if (c == '"' || c == '\\') escaped += '\\';
    if (static_cast<unsigned char>(c) >= 32) escaped += c;
  }
  return fmt::format(
      "# Tells apart: {}.\n"
      "# Expected separation {:.1f} sigma; {:.0f} min.\n"
      "sample = \"{}\"\n"
      "wavelengths_nm = [{:g}]\n"
      "theta_i_deg = [{:g}]\n"
      "theta_r_deg = {{ from = {:g}, to = {:g}, step = 4 }}\n"
      "states = [[\"P\", \"P\"], [\"P\", \"S\"], [\"S\", \"P\"], [\"S\", \"S\"]]\n"
      "dwell_ms = 50\n\n"
      "[[block]]\n"
      "menu = \"{}\"\n",
      [&] {
        std::vector<std::string> words;
        for (const auto& pair : scan.separates)
          words.push_back(fmt::format("{}", fmt::join(pair, " from ")));
        return fmt::format("{}", fmt::join(words, ", "));
      }(),
      scan.expected_separation, scan.minutes, escaped,
      fmt::join(model.records().wavelengths_nm, ", "), fmt::join(incidences, ", "), -reach, reach,
      scan.menu);
}

}  // namespace umov::gap::scan
