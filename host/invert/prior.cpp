#include "host/invert/prior.hpp"

#include <charconv>
#include <cmath>
#include <cstdio>

#include "host/errors/error.hpp"

namespace umov::invert {
namespace {

constexpr const char* order_word = "kappa-order";

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

[[noreturn]] void refuse(const std::string& text) {
  throw Error("'" + text + "' is not a prior",
              "write NAME=VALUE±U (or +-), NAME@NM=VALUE±U, kappa-order or kappa-order@NM=RATIO");
}

double number(const std::string& part, const std::string& text) {
  double value = 0;
  const auto [end, code] = std::from_chars(part.data(), part.data() + part.size(), value);
  if (code != std::errc{} || end != part.data() + part.size() || !std::isfinite(value)) {
    refuse(text);
  }
  return value;
}

}  // namespace

Prior parse_prior(const std::string& text) {
  const auto equals = text.find('=');
  std::string name = text.substr(0, equals);
  const std::string rest = equals == std::string::npos ? "" : text.substr(equals + 1);
  Prior out;
  if (const auto at = name.find('@'); at != std::string::npos) {
    out.wavelength_nm = number(name.substr(at + 1), text);
    name.resize(at);
  }
  if (name.ends_with(order_word)) {
    out.kind = Prior::Kind::order;
    out.name = name.substr(0, name.size() - std::string("-order").size());
    if (equals != std::string::npos) out.ratio = number(rest, text);
    if (!(out.ratio > 0)) refuse(text);
    return out;
  }
  out.name = name;
  std::size_t width = 0;
  std::size_t split = std::string::npos;
  for (const std::string sign : {"±", "+-", "+/-"}) {
    if (const auto found = rest.find(sign); found != std::string::npos) {
      split = found;
      width = sign.size();
      break;
    }
  }
  if (name.empty() || split == std::string::npos) refuse(text);
  out.value = number(rest.substr(0, split), text);
  out.u = number(rest.substr(split + width), text);
  return out;
}

std::string prior_text(const Prior& prior) {
  const std::string at =
      prior.wavelength_nm ? " at " + wavelength_text(*prior.wavelength_nm) + " nm" : "";
  if (prior.kind == Prior::Kind::normal) {
    return prior.name + at + " = " + number_text(prior.value) + " ± " + number_text(prior.u);
  }
  return prior.name + (at.empty() ? " at the shortest wavelength" : at) + " at least " +
         number_text(prior.ratio) + " times that at the others";
}

Priors::Priors(const Layout& layout, const std::vector<Prior>& priors) : layout_(&layout) {
  const auto& list = layout.model().parameters();
  const auto& wavelengths = layout.wavelengths_nm();
  for (const Prior& prior : priors) {
    std::size_t parameter = list.size();
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (list[i].name == prior.name) parameter = i;
    }
    if (parameter == list.size()) {
      throw Error("model " + layout.model().name() + " has no parameter \"" + prior.name +
                      "\" for the prior \"" + prior_text(prior) + "\"",
                  "umov model show " + layout.model().name() + " lists its parameters");
    }
    if (!(prior.u > 0)) {
      throw Error("the prior \"" + prior_text(prior) + "\" has no positive width",
                  "give one standard deviation, or use --fix");
    }
    std::optional<std::size_t> where;
    for (std::size_t w = 0; w < wavelengths.size(); ++w) {
      if (prior.wavelength_nm && std::abs(wavelengths[w] - *prior.wavelength_nm) < 0.01) where = w;
    }
    if (prior.wavelength_nm && !where) {
      throw Error("the prior \"" + prior_text(prior) + "\" names a wavelength the data do not have",
                  "take a wavelength of the data");
    }
    const bool shared = layout.is_shared(parameter);
    const auto slot = [&](std::size_t w) {
      const auto free = layout.slot(w, parameter);
      if (!free) {
        throw Error("the prior \"" + prior_text(prior) + "\" is on a parameter that is fixed",
                    "leave out the prior, or --fix; --free fits what a model holds");
      }
      return *free;
    };
    if (prior.kind == Prior::Kind::normal) {
      if (shared && where && wavelengths.size() > 1) {
        throw Error(
            "\"" + prior.name + "\" is shared by all wavelengths, so a prior cannot be at one",
            "leave out the wavelength or add --spectral " + prior.name);
      }
      const std::size_t first = where.value_or(0);
      const std::size_t last = where || shared ? first + 1 : wavelengths.size();
      for (std::size_t w = first; w < last; ++w) {
        terms_.push_back({.order = false, .free = slot(w), .value = prior.value, .u = prior.u});
      }
      continue;
    }
    if (shared || wavelengths.size() < 2) {
      throw Error("\"" + prior.name + "\" has one value only, which has no order",
                  "fit several wavelengths, or add --spectral " + prior.name);
    }
    const std::size_t strong = where.value_or(0);  // wavelengths ascend
    for (std::size_t w = 0; w < wavelengths.size(); ++w) {
      if (w == strong) continue;
      terms_.push_back({.order = true,
                        .free = slot(w),
                        .greater = slot(strong),
                        .u = prior.u,
                        .ratio = prior.ratio});
    }
  }
}

double Priors::signed_value(const Term& term, std::span<const double> x) const {
  const double p = layout_->free()[term.free].coordinate.to_parameter(x[term.free]);
  if (!term.order) return (p - term.value) / term.u;
  const double large = layout_->free()[term.greater].coordinate.to_parameter(x[term.greater]);
  return (term.ratio * term.ratio * p * p - large * large) / term.u;
}

Eigen::RowVectorXd Priors::slope(const Term& term, std::span<const double> x) const {
  Eigen::RowVectorXd out = Eigen::RowVectorXd::Zero(static_cast<Eigen::Index>(layout_->size()));
  const Coordinate& k = layout_->free()[term.free].coordinate;
  const auto column = static_cast<Eigen::Index>(term.free);
  if (!term.order) {
    out[column] = k.slope(x[term.free]) / term.u;
    return out;
  }
  // In the coordinate κ² the term is linear.
  const Coordinate& large = layout_->free()[term.greater].coordinate;
  out[column] =
      term.ratio * term.ratio * 2 * k.to_parameter(x[term.free]) * k.slope(x[term.free]) / term.u;
  out[static_cast<Eigen::Index>(term.greater)] =
      -2 * large.to_parameter(x[term.greater]) * large.slope(x[term.greater]) / term.u;
  return out;
}

double Priors::objective(std::span<const double> x) const {
  double sum = 0;
  for (const Term& term : terms_) {
    const double r = signed_value(term, x);
    if (!term.order || r > 0) sum += r * r;
  }
  return sum;
}

Priors::Rows Priors::rows(std::span<const double> x) const {
  const auto count = static_cast<Eigen::Index>(terms_.size());
  Rows out{Eigen::VectorXd::Zero(count),
           Eigen::MatrixXd::Zero(count, static_cast<Eigen::Index>(x.size()))};
  for (Eigen::Index i = 0; i < count; ++i) {
    const Term& term = terms_[static_cast<std::size_t>(i)];
    const double r = signed_value(term, x);
    if (term.order && r <= 0) continue;
    out.r[i] = r;
    out.by_x.row(i) = slope(term, x);
  }
  return out;
}

Priors::Rows Priors::normal_rows(std::span<const double> x) const {
  Rows out = rows(x);
  for (std::size_t i = 0; i < terms_.size(); ++i) {
    if (!terms_[i].order) continue;
    out.r[static_cast<Eigen::Index>(i)] = 0;
    out.by_x.row(static_cast<Eigen::Index>(i)).setZero();
  }
  return out;
}

std::vector<Hinge> Priors::hinges(std::span<const double> x) const {
  std::vector<Hinge> out;
  for (const Term& term : terms_) {
    if (term.order) out.push_back({signed_value(term, x), slope(term, x).transpose()});
  }
  return out;
}

}  // namespace umov::invert
