#include "host/brdf/sampling_parts.hpp"

#include <functional>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include "host/brdf/evaluate.hpp"

namespace umov::brdf {
namespace {

/// One component as a model of its own.
std::vector<Model> components_alone(const Model& model) {
  std::vector<Model> alone;
  const std::string& name = model.name();
  for (std::size_t from = 0, i = 0; from <= name.size(); ++i) {
    const std::size_t end = std::min(name.find('+', from), name.size());
    Model one = Model::by_name(name.substr(from, end - from));
    if (const auto& table = model.components()[i].table) one = one.with_table(table);
    alone.push_back(std::move(one));
    from = end + 1;
  }
  return alone;
}

/// Some of a component's light at one wavelength. Without a lobe it needs a table.
struct Share {
  std::optional<Lobe> lobe;
  std::vector<double> values;  ///< the component's, with what belongs to other shares set to 0
};

/// Nothing where none is close: exponential slopes with the Smith factor of Gaussian ones.
std::optional<Lobe> facet_lobe(const Component& part, double slope_rms) {
  if (part.slopes == Slopes::exponential) {
    if (part.shadowing == Shadowing::smith || part.shadowing == Shadowing::smith_correlated)
      return std::nullopt;
    return GrooveLobe{GrooveLobe::Law::exponential, slope_rms};
  }
  if (part.shadowing == Shadowing::v_groove)
    return GrooveLobe{GrooveLobe::Law::gaussian, slope_rms};
  return GaussianFacetLobe{slope_rms, slope_rms};
}

/// `values` with those at `positions` set to 0.
std::vector<double> without(std::vector<double> values,
                            std::initializer_list<std::size_t> positions) {
  for (const std::size_t i : positions) values[i] = 0.0;
  return values;
}

std::vector<Share> shares_of(const Component& part, const std::vector<double>& p) {
  std::vector<Share> shares;
  switch (part.kind) {
    case Kind::lambertian:
      if (p[0] > 0.0) shares.push_back({CosineLobe{}, p});
      break;
    case Kind::nef:  // ρ_d2/(cos θi cos θr) times cos θr is even over the hemisphere
      if (p[0] > 0.0) shares.push_back({CosineLobe{}, without(p, {1})});
      if (p[1] > 0.0) shares.push_back({UniformLobe{}, without(p, {0})});
      break;
    case Kind::microfacet:
      if (p[3] > 0.0) shares.push_back({facet_lobe(part, p[2]), p});
      break;
    case Kind::ggx:
      if (part.shadowing == Shadowing::v_groove) {
        shares.push_back({GrooveLobe{GrooveLobe::Law::trowbridge_reitz, p[2]}, p});
      } else {
        shares.push_back({GgxFacetLobe{p[2]}, p});
      }
      break;
    case Kind::phong:
      if (p[0] > 0.0) shares.push_back({CosinePowerLobe{p[1]}, p});
      break;
    case Kind::ward:
      if (p[0] > 0.0) {
        shares.push_back(
            {GaussianFacetLobe{p[1] / std::numbers::sqrt2, p[2] / std::numbers::sqrt2}, p});
      }
      break;
    case Kind::li_torrance:
      if (p[4] > 0.0) shares.push_back({std::nullopt, without(p, {5, 6, 7})});
      if (p[5] + p[6] > 0.0) shares.push_back({CosineLobe{}, without(p, {4, 7})});
      if (p[7] > 0.0) shares.push_back({ChordLobe{optics::radians(p[8])}, without(p, {4, 5, 6})});
      break;
    case Kind::subsurface:
      if (p[1] > 0.0) shares.push_back({CosineLobe{}, p});
      break;
    case Kind::beard_maxwell: {
      const std::size_t d = p.size() - 2, v = p.size() - 1;
      if (p[3] > 0.0) shares.push_back({std::nullopt, without(p, {d, v})});
      if (p[d] > 0.0) shares.push_back({CosineLobe{}, without(p, {3, v})});
      // 2 ρv cos θr/(cos θi + cos θr) is even over the hemisphere at grazing incidence.
      if (p[v] > 0.0) shares.push_back({UniformLobe{}, without(p, {3, d})});
      break;
    }
    default:  // lobes without a closed form to draw from
      shares.push_back({std::nullopt, p});
      break;
  }
  return shares;
}

TableLobe::Brdf value_of_share(const Model& alone, std::vector<double> values, double wavelength_um,
                               double scale) {
  return [alone, values = std::move(values), wavelength_um, scale](const Geometry<double>& g) {
    return scale * optics::element(evaluate<double>(alone, values, wavelength_um, g), 0, 0);
  };
}

TableLobe::Brdf sum(TableLobe::Brdf a, TableLobe::Brdf b) {
  return [a = std::move(a), b = std::move(b)](const Geometry<double>& g) { return a(g) + b(g); };
}

bool same_lobe(const Lobe& a, const Lobe& b) {
  return std::visit(
      [](const auto& x, const auto& y) {
        if constexpr (std::is_same_v<decltype(x), decltype(y)> &&
                      std::equality_comparable<std::decay_t<decltype(x)>>) {
          return x == y;
        } else {
          return false;
        }
      },
      a, b);
}

}  // namespace

std::vector<SampledPart> sampled_parts(const Model& model,
                                       std::span<const SpectralValues> spectrum) {
  const double scale = 1.0 / static_cast<double>(spectrum.size());
  const std::vector<Model> alone = components_alone(model);
  std::vector<SampledPart> parts;
  for (std::size_t i = 0; i < alone.size(); ++i) {
    const Component& component = model.components()[i];
    TableLobe::Brdf without_lobe;
    for (const SpectralValues& s : spectrum) {
      const auto first = s.values.begin() + static_cast<std::ptrdiff_t>(component.first);
      const std::vector<double> own(first, first + static_cast<std::ptrdiff_t>(component.count));
      for (Share& share : shares_of(component, own)) {
        TableLobe::Brdf brdf =
            value_of_share(alone[i], std::move(share.values), s.wavelength_um, scale);
        if (!share.lobe) {
          without_lobe =
              without_lobe ? sum(std::move(without_lobe), std::move(brdf)) : std::move(brdf);
          continue;
        }
        bool known = false;
        for (SampledPart& part : parts) {
          if (!same_lobe(part.lobe, *share.lobe)) continue;
          part.brdf = sum(std::move(part.brdf), std::move(brdf));
          known = true;
          break;
        }
        if (!known) parts.push_back({std::move(*share.lobe), std::move(brdf)});
      }
    }
    if (without_lobe) {
      TableLobe table(without_lobe);
      parts.push_back({std::move(table), std::move(without_lobe)});
    }
  }
  return parts;
}

}  // namespace umov::brdf
