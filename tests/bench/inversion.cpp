// Measures the inversion: against the rivals of its trade from the same starts, and how often a
// single descent from anywhere within the limits ends at the same optimum. Prints JSON.
//
//   bench_inversion rivals brdf.h5 [STARTS]    quasi-Newton BFGS (Ceres' line search) with numeric
//                                              and with exact gradients, and this project's descent
//   bench_inversion starts brdf.h5 [COUNT]     uniformly random starts within the limits
//
// All minimise the same objective by the same stop rule: the relative fall of the objective in one
// step is below 1e-9. BFGS knows no limits; it gets them by the logistic substitution.
#include <ceres/ceres.h>
#include <ceres/numeric_diff_first_order_function.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "host/errors/error.hpp"
#include "host/formats/brdf_h5.hpp"
#include "host/invert/descent.hpp"
#include "host/invert/starts.hpp"

namespace {

using namespace umov::invert;

constexpr double function_tolerance = 1e-9;
constexpr int most_iterations = 20000;
/// li-torrance at three wavelengths: n, sigma, tau, fs_width, fs_polarization; kappa and four k
/// each.
constexpr int free_numbers = 20;

/// Processor time: all rivals run on one thread, and other work on the machine does not count.
double seconds_of(const std::function<void()>& work) {
  const std::clock_t start = std::clock();
  work();
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

/// Limits by x = lo + (hi − lo)/(1 + e^−z).
struct Logistic {
  const Layout& layout;

  std::vector<double> to_x(const double* z) const {
    std::vector<double> x(layout.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
      const Coordinate& k = layout.free()[i].coordinate;
      x[i] = k.lo_x() + (k.hi_x() - k.lo_x()) / (1 + std::exp(-z[i]));
    }
    return x;
  }
  std::vector<double> to_z(const std::vector<double>& x) const {
    std::vector<double> z(layout.size());
    for (std::size_t i = 0; i < z.size(); ++i) {
      const Coordinate& k = layout.free()[i].coordinate;
      const double share = std::clamp((x[i] - k.lo_x()) / (k.hi_x() - k.lo_x()), 1e-6, 1 - 1e-6);
      z[i] = std::log(share / (1 - share));
    }
    return z;
  }
};

/// The objective alone, for differences.
struct Value {
  const Problem& problem;
  bool operator()(const double* z, double* cost) const {
    *cost = objective_at(problem, Logistic{problem.layout}.to_x(z), {});
    return std::isfinite(*cost);
  }
};

/// The objective with its exact gradient.
class ExactGradient final : public ceres::FirstOrderFunction {
 public:
  explicit ExactGradient(const Problem& problem) : problem_(problem) {}
  int NumParameters() const override { return static_cast<int>(problem_.layout.size()); }
  bool Evaluate(const double* z, double* cost, double* gradient) const override {
    if (gradient == nullptr) return Value{problem_}(z, cost);
    const Layout& layout = problem_.layout;
    const std::vector<double> x = Logistic{layout}.to_x(z);
    *cost = 0;
    std::fill_n(gradient, layout.size(), 0.0);
    for (std::size_t w = 0; w < problem_.data.spectra.size(); ++w) {
      const SpectrumResiduals part =
          residuals(layout, problem_.data, w, x, {}, problem_.weighting, true);
      *cost += part.r.squaredNorm();
      const Eigen::VectorXd slope = 2 * part.by_x.transpose() * part.r;
      const auto& active = layout.active(w);
      for (std::size_t a = 0; a < active.size(); ++a) {
        const std::size_t i = *layout.slot(w, static_cast<std::size_t>(active[a]));
        const Coordinate& k = layout.free()[i].coordinate;
        const double s = 1 / (1 + std::exp(-z[i]));
        gradient[i] += slope[static_cast<Eigen::Index>(a)] * (k.hi_x() - k.lo_x()) * s * (1 - s);
      }
    }
    return std::isfinite(*cost);
  }

 private:
  const Problem& problem_;
};

struct Outcome {
  double seconds = 0, objective = 0;
  int iterations = 0;
};

Outcome bfgs(const Problem& problem, const std::vector<double>& start,
             ceres::FirstOrderFunction* function) {
  const ceres::GradientProblem gradient_problem(function);  // owns it
  std::vector<double> z = Logistic{problem.layout}.to_z(start);
  ceres::GradientProblemSolver::Options options;
  options.line_search_direction_type = ceres::BFGS;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = most_iterations;
  options.function_tolerance = function_tolerance;
  options.gradient_tolerance = 0;
  options.parameter_tolerance = 0;
  ceres::GradientProblemSolver::Summary summary;
  Outcome out;
  out.seconds = seconds_of([&] { ceres::Solve(options, gradient_problem, z.data(), &summary); });
  out.objective = objective_at(problem, Logistic{problem.layout}.to_x(z.data()), {});
  out.iterations = static_cast<int>(summary.iterations.size());
  return out;
}

/// Its preparation for these data (which points are few, what is linear) is part of the time.
Outcome descent(const Problem& problem, const std::vector<double>& start) {
  Outcome out;
  Solution solution;
  out.seconds = seconds_of([&] {
    solution = Descent(problem).from_near(start, {}, {most_iterations, function_tolerance});
  });
  out.objective = solution.objective;
  out.iterations = solution.iterations;
  return out;
}

void print(const char* name, const Outcome& outcome, const char* end) {
  std::printf(R"("%s":{"seconds":%.6g,"objective":%.10g,"iterations":%d}%s)", name, outcome.seconds,
              outcome.objective, outcome.iterations, end);
}

/// The measured points without calibration factors, and, for relative deviations, without those
/// below three times their uncertainty.
Observations measured(const umov::formats::BrdfTable& table, bool relative) {
  umov::formats::BrdfTable bare = table;
  bare.factors.clear();
  for (std::size_t i = 0; i < bare.points.size(); ++i) {
    if (relative && !(bare.points.brdf_per_sr[i] >= 3 * bare.points.brdf_u[i])) {
      bare.points.used[i] = 0;
    }
  }
  return observations(bare, 0);
}

void rivals(const umov::formats::BrdfTable& table, int starts) {
  const umov::brdf::Model model = umov::brdf::Model::by_name("li-torrance");
  std::printf("[");
  for (const bool relative : {true, false}) {
    const Observations data = measured(table, relative);
    const Layout layout(model, data.wavelengths_nm(), {});
    if (layout.size() != free_numbers) {
      throw umov::Error("the rivals are built for three wavelengths, this file has " +
                            std::to_string(data.wavelengths_nm().size()),
                        "measure 532, 633 and 814 nm");
    }
    const Priors priors;
    const Problem problem{layout, data, priors, {.relative = relative}};
    const auto points =
        starting_points(layout, thinned(data, 20, 0.03), lobe_slope(data), starts, 1, 1);
    for (int i = 0; i < starts; ++i) {
      const std::vector<double>& start = points[static_cast<std::size_t>(i)];
      std::printf("%s{\"objective\":\"%s\",\"points\":%zu,\"start\":%d,\"at_start\":%.8g,",
                  relative && i == 0 ? "" : ",\n", relative ? "paper" : "noise-weighted",
                  data.size(), i, objective_at(problem, start, {}));
      print("umov", descent(problem, start), ",");
      print("bfgs_exact", bfgs(problem, start, new ExactGradient(problem)), ",");
      using Numeric = ceres::NumericDiffFirstOrderFunction<Value, ceres::CENTRAL, free_numbers>;
      print("bfgs_numeric", bfgs(problem, start, new Numeric(new Value{problem})), "}");
      std::fflush(stdout);
    }
  }
  std::printf("]\n");
}

void random_starts(const umov::formats::BrdfTable& table, int count) {
  const umov::brdf::Model model = umov::brdf::Model::by_name("li-torrance");
  const Observations data = observations(table, 0);
  const Layout layout(model, data.wavelengths_nm(), {});
  const Priors priors;
  const Problem problem{layout, data, priors, {.huber_sigma = 4}};
  const Descent whole(problem);
  const std::vector<double> no_factors(data.factor_names.size(), 0.0);
  std::printf("[");
  for (const bool in_coordinates : {false, true}) {
    std::mt19937_64 engine(1);
    const auto uniform = [&] { return static_cast<double>(engine() >> 11) * 0x1.0p-53; };
    for (int i = 0; i < count; ++i) {
      std::vector<double> x;
      for (const FreeParameter& free : layout.free()) {
        const Coordinate& k = free.coordinate;
        const double share = uniform();
        x.push_back(in_coordinates ? k.lo_x() + share * (k.hi_x() - k.lo_x())
                                   : k.to_x(k.lo + share * (k.hi - k.lo)));
      }
      const Stop stop{.max_iterations = 500, .function_tolerance = 1e-10};
      Solution plain, eliminated, all;
      const double plain_s =
          seconds_of([&] { plain = least_squares(problem, x, no_factors, {}, stop); });
      const double eliminated_s = seconds_of(
          [&] { eliminated = least_squares(problem, x, no_factors, whole.linear(), stop); });
      const double all_s = seconds_of([&] { all = whole.from(x); });
      std::printf("%s{\"drawn\":\"%s\",\"at_start\":%.6g,", !in_coordinates && i == 0 ? "" : ",\n",
                  in_coordinates ? "coordinates" : "parameters",
                  objective_at(problem, x, no_factors));
      print("levenberg_marquardt", {plain_s, plain.objective, plain.iterations}, ",");
      print("linear_eliminated", {eliminated_s, eliminated.objective, eliminated.iterations}, ",");
      print("descent", {all_s, all.objective, all.iterations}, "}");
      std::fflush(stdout);
    }
  }
  std::printf("]\n");
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 3 || (std::strcmp(argv[1], "rivals") != 0 && std::strcmp(argv[1], "starts") != 0)) {
    std::fprintf(stderr, "usage: bench_inversion rivals|starts brdf.h5 [COUNT]\n");
    return 2;
  }
  const umov::formats::BrdfFile file = umov::formats::read_brdf_h5(argv[2]);
  const bool against = std::strcmp(argv[1], "rivals") == 0;
  const int count = argc > 3 ? std::max(1, std::atoi(argv[3])) : against ? 5 : 100;
  against ? rivals(file.table, count) : random_starts(file.table, count);
  return 0;
} catch (const umov::Error& error) {
  std::fprintf(stderr, "bench_inversion: %s\n", error.what());
  return 1;
}
