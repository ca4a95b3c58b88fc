#include "host/brdf/catalogue.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace umov::brdf {
namespace {

using enum Shadowing;

constexpr std::array facet_shadowings{smith, none, v_groove, smith_correlated, maxwell_beard};
constexpr std::array ggx_shadowings{smith, none, v_groove, smith_correlated};
constexpr std::array paint_shadowings{maxwell_beard, none, v_groove, smith, smith_correlated};
constexpr std::array facet_slopes{Slopes::gaussian, Slopes::exponential};
constexpr std::array paint_slopes{Slopes::angle, Slopes::gaussian, Slopes::exponential};
constexpr std::array all_psds{Psd::gaussian, Psd::abc};

constexpr std::array entries{
    CatalogueEntry{Kind::lambertian, "lambertian",
                   "the same radiance in all directions, depolarised", "ρ/π",
                   "conserves energy; reciprocal"},
    CatalogueEntry{Kind::nef, "nef", "two-parameter diffuse term, depolarised", "P9",
                   "reciprocal; the second term's reflectance, 2π rho_d2/cos θi, has no bound"},
    CatalogueEntry{
        Kind::microfacet, "microfacet",
        "polarised Fresnel facets with Gaussian or exponential slopes", "P8",
        "reciprocal; shadowed by vgroove or smith it loses light that meets a second facet and "
        "never "
        "gives more than it gets; none and maxwell-beard do towards grazing (1.26 and less at 80°, "
        "slope_rms .3)",
        facet_shadowings, facet_slopes},
    CatalogueEntry{Kind::ggx, "ggx", "polarised Fresnel facets with Trowbridge-Reitz slopes",
                   "P8, Trowbridge-Reitz 1975, Walter 2007",
                   "reciprocal; shadowed it loses light that meets a second facet and never gives "
                   "more than it gets",
                   ggx_shadowings},
    CatalogueEntry{
        Kind::he_torrance, "he-torrance",
        "wave-optical lobe and mirror part of a Gaussian rough surface", "P10, He-Torrance 1991",
        "reciprocal; lobe and mirror part of a perfect reflector exceed 1 by up to 4.5 % "
        "between 75° and 88°"},
    CatalogueEntry{
        Kind::li_torrance, "li-torrance",
        "He-Torrance lobe, uniform first-surface and subsurface light, forward-scattered lobe",
        "P11, after Li-Torrance 2005",
        "reciprocal; its weights are free, so that their sum decides whether energy is conserved"},
    CatalogueEntry{
        Kind::rayleigh_rice,
        "rayleigh-rice",
        "polarised scatter and mirror part of a nearly smooth surface with a given "
        "power spectrum of heights",
        "P13, Rayleigh-Rice, first order",
        "reciprocal; for 4π sigma/λ well below 1: lobe and mirror part of a smooth, perfect "
        "reflector sum to 1 up to the square of (4π sigma cos θ/λ)²",
        {},
        {},
        all_psds},
    CatalogueEntry{Kind::beard_maxwell, "beard-maxwell",
                   "paint: first-surface light from a zero-bistatic scan, depolarised volume light",
                   "P14, Maxwell-Beard 1973",
                   "reciprocal; empirical, no bound on the reflectance towards grazing",
                   paint_shadowings, paint_slopes},
    CatalogueEntry{
        Kind::subsurface, "subsurface",
        "Lambertian body below a smooth interface, polarised by the crossings",
        "P15, Saunderson 1942 with Fresnel transmittances",
        "reciprocal; with what the interface reflects it conserves energy (rho = 1: sum 1)"},
    CatalogueEntry{Kind::single_scatter, "single-scatter",
                   "cloudy medium below a smooth interface that scatters each ray once",
                   "P15, Chandrasekhar's first order",
                   "reciprocal; loses all light that is scattered more than once"},
    CatalogueEntry{Kind::phong, "phong",
                   "cosine-power lobe about the mirror direction, depolarised",
                   "Phong 1975, normalised", "reciprocal; falls off as cos θi towards grazing"},
    CatalogueEntry{Kind::ward, "ward", "elliptical Gaussian lobe, depolarised", "Ward 1992",
                   "reciprocal where alpha_x = alpha_y; not shadowed, loses light towards grazing"},
    CatalogueEntry{Kind::tabulated, "tabulated",
                   "values from a file, interpolated in the sampling it has",
                   "P16, linear between entries",
                   "as its data: reciprocity and energy are neither imposed nor known beforehand"},
};

constexpr std::array aliases{
    AliasEntry{"torrance-sparrow", "microfacet:shadowing=vgroove",
               "facets hidden by symmetric V-grooves"},
    AliasEntry{"priest-meier", "microfacet:shadowing=none",
               "polarised facets, P8 with its S left open: choose the shadowing"},
    AliasEntry{"cook-torrance", "microfacet:shadowing=vgroove",
               "the same facets and grooves, with n and kappa for the Fresnel term"},
    AliasEntry{"trowbridge-reitz", "ggx", "the older name of the GGX slopes"},
    AliasEntry{"microroughness", "rayleigh-rice", "as polished optics are described"},
};

constexpr std::array<std::pair<Shadowing, std::string_view>, 5> shadowings{{
    {Shadowing::none, "none"},
    {Shadowing::v_groove, "vgroove"},
    {Shadowing::smith, "smith"},
    {Shadowing::smith_correlated, "smith-correlated"},
    {Shadowing::maxwell_beard, "maxwell-beard"},
}};

constexpr std::array<std::pair<Slopes, std::string_view>, 3> slope_laws{{
    {Slopes::gaussian, "gaussian"},
    {Slopes::exponential, "exponential"},
    {Slopes::angle, "angle"},
}};

constexpr std::array<std::pair<Psd, std::string_view>, 2> spectra{{
    {Psd::gaussian, "gaussian"},
    {Psd::abc, "abc"},
}};

const CatalogueEntry& entry_of(Kind kind) {
  for (const CatalogueEntry& entry : entries) {
    if (entry.kind == kind) return entry;
  }
  return entries.front();
}

/// The choice among `offered`, in the order of `names`.
template <class Value, std::size_t count>
Choice choice_of(const char* name, const char* meaning,
                 const std::array<std::pair<Value, std::string_view>, count>& names,
                 std::span<const Value> offered, Value chosen) {
  Choice choice{name, {}, {}, meaning};
  for (const auto& [value, text] : names) {
    if (std::find(offered.begin(), offered.end(), value) == offered.end()) continue;
    choice.values.emplace_back(text);
    if (value == chosen) choice.value = text;
  }
  return choice;
}

template <class Value, std::size_t count>
bool pick(const std::array<std::pair<Value, std::string_view>, count>& names,
          std::span<const Value> offered, std::string_view text, Value& chosen) {
  for (const Value value : offered) {
    for (const auto& [named, name] : names) {
      if (named != value || name != text) continue;
      chosen = value;
      return true;
    }
  }
  return false;
}

Parameter refractive_index() {
  return {"n", "1", 0.05, 20.0, 1.5, "real part of the refractive index", "Fresnel", false};
}

/// Of a transparent body.
Parameter body_index() {
  return {"n", "1", 1.0, 5.0, 1.5, "refractive index of the body", "Fresnel", false};
}

Parameter extinction() {
  return {"kappa", "1", 0.0, 100.0, 0.0, "imaginary part of the refractive index", "Fresnel", true};
}

/// The two numbers of Maxwell and Beard's shadowing, where it is chosen.
void add_maxwell_beard(std::vector<Parameter>& list, const Component& component) {
  if (component.shadowing != Shadowing::maxwell_beard) return;
  list.push_back({"omega", "rad", 1e-3, 100.0, 0.7, "facet angle at which shadowing sets in",
                  "P8, Maxwell-Beard", false});
  list.push_back({"tau", "rad", 1e-3, 100.0, 0.25, "bistatic angle over which it fades in",
                  "P8, Maxwell-Beard", false});
}

Parameter height() {
  return {"sigma_um", "um", 1e-3, 100.0, 0.2, "rms height of the surface", "P10", false};
}

Parameter correlation_length() {
  return {"tau_um", "um", 0.05, 5000.0, 3.0, "autocorrelation length of the heights", "P10", false};
}

}  // namespace

std::span<const CatalogueEntry> catalogue() {
  return entries;
}

std::span<const AliasEntry> alias_entries() {
  return aliases;
}

Component default_component(Kind kind) {
  const CatalogueEntry& entry = entry_of(kind);
  Component component;
  component.kind = kind;
  if (!entry.shadowings.empty()) component.shadowing = entry.shadowings.front();
  if (!entry.slopes.empty()) component.slopes = entry.slopes.front();
  if (!entry.psds.empty()) component.psd = entry.psds.front();
  return component;
}

std::vector<Parameter> parameters_of(const Component& component) {
  switch (component.kind) {
    case Kind::lambertian:
      return {{"rho", "1", 0.0, 1.0, 0.5, "hemispherical reflectance", "P1", true}};
    case Kind::nef:
      return {
          {"rho_d1", "1/sr", 0.0, 10.0, 0.1, "constant part", "P9", true},
          {"rho_d2", "1/sr", 0.0, 10.0, 0.0, "part that grows as 1/(cos θi cos θr)", "P9", true}};
    case Kind::microfacet: {
      std::vector<Parameter> list{
          refractive_index(),
          extinction(),
          {"slope_rms", "1", 0.002, 3.0, 0.15, "rms slope of the facets along one direction", "P8",
           false},
          {"bias", "1", 0.0, 100.0, 1.0, "scale of the lobe; 1 conserves area", "P8", false, true}};
      add_maxwell_beard(list, component);
      return list;
    }
    case Kind::ggx:
      return {refractive_index(), extinction(),
              Parameter{"alpha", "1", 0.002, 3.0, 0.2, "width of the slope distribution",
                        "P8 with Trowbridge-Reitz slopes", false}};
    case Kind::he_torrance:
      return {refractive_index(), extinction(), height(), correlation_length()};
    case Kind::li_torrance:
      return {
          refractive_index(),
          extinction(),
          height(),
          correlation_length(),
          {"k_dd", "1", 0.0, 10.0, 1.0, "weight of the directional-diffuse lobe", "P11", true},
          {"k_udf", "1", 0.0, 1.0, 0.02, "uniform first-surface reflectance", "P11", true},
          {"k_uds", "1", 0.0, 1.0, 0.3, "uniform subsurface reflectance at normal incidence", "P11",
           true},
          {"k_fs", "1", 0.0, 10.0, 0.0, "forward-scattered reflectance at normal incidence", "P11",
           true},
          {"fs_width_deg", "deg", 0.5, 90.0, 15.0, "rms angle of the forward lobe", "P11", false},
          {"fs_polarization", "1", 0.0, 1.0, 0.5, "polarisation that forward light keeps", "P11",
           false}};
    case Kind::rayleigh_rice: {
      std::vector<Parameter> list{refractive_index(), extinction()};
      if (component.psd == Psd::gaussian) {
        list.push_back(
            {"sigma_um", "um", 1e-6, 1.0, 0.005, "rms height of the surface", "P13", false});
        list.push_back({"correlation_um", "um", 0.01, 5000.0, 1.0,
                        "autocorrelation length of the heights", "P13", false});
      } else {
        list.push_back({"abc_a", "um^4", 1e-14, 1e4, 1e-3, "spectral density at low frequencies",
                        "P13, ABC", false});
        list.push_back({"abc_b", "um", 1e-3, 1e5, 10.0,
                        "one over the spatial frequency where it falls off", "P13, ABC", false});
        list.push_back({"abc_c", "1", 0.0, 12.0, 2.5, "power of the fall-off", "P13, ABC", false});
      }
      return list;
    }
    case Kind::beard_maxwell: {
      std::vector<Parameter> list{
          refractive_index(),
          extinction(),
          {"slope_rms", "1", 0.002, 3.0, 0.15,
           "rms slope of the facets along one direction; 1/√2 of the scan's 1/e angle", "P14",
           false},
          {"bias", "1/sr", 0.0, 1e6, 0.2, "zero-bistatic BRDF at the normal", "P14", true}};
      add_maxwell_beard(list, component);
      list.push_back({"rho_d", "1/sr", 0.0, 10.0, 0.05, "constant volume light", "P14", true});
      list.push_back({"rho_v", "1/sr", 0.0, 10.0, 0.0,
                      "volume light that grows as 2/(cos θi + cos θr)", "P14", true});
      return list;
    }
    case Kind::subsurface:
      return {body_index(), Parameter{"rho", "1", 0.0, 1.0, 0.5,
                                      "reflectance of the body, seen from inside", "P15", true}};
    case Kind::single_scatter:
      return {
          body_index(),
          {"albedo", "1", 0.0, 1.0, 0.5, "share of light that survives scattering", "P15", true},
          {"asymmetry", "1", -0.9, 0.9, 0.0, "mean cosine of the scattering angle",
           "P15, Henyey-Greenstein", true}};
    case Kind::phong:
      return {{"ks", "1", 0.0, 10.0, 0.1, "reflectance at normal incidence",
               "Phong 1975, normalised", true},
              {"exponent", "1", 0.0, 1e6, 50.0, "power of the cosine", "Phong 1975", false}};
    case Kind::ward:
      return {{"ks", "1", 0.0, 10.0, 0.1, "reflectance of the lobe", "Ward 1992", true},
              {"alpha_x", "1", 0.002, 3.0, 0.2, "2-D rms slope in the plane of incidence",
               "Ward 1992", false},
              {"alpha_y", "1", 0.002, 3.0, 0.2, "2-D rms slope across the plane of incidence",
               "Ward 1992", false}};
    case Kind::tabulated:
      return {};
  }
  return {};
}

std::vector<Choice> choices_of(const Component& component) {
  const CatalogueEntry& entry = entry_of(component.kind);
  std::vector<Choice> list;
  if (!entry.shadowings.empty()) {
    list.push_back(choice_of("shadowing", "how facets hide each other", shadowings,
                             entry.shadowings, component.shadowing));
  }
  if (!entry.slopes.empty()) {
    list.push_back(choice_of("slopes", "distribution of the facets' slopes", slope_laws,
                             entry.slopes, component.slopes));
  }
  if (!entry.psds.empty()) {
    list.push_back(choice_of("psd", "power spectral density of the heights", spectra, entry.psds,
                             component.psd));
  }
  return list;
}

bool choose(Component& component, std::string_view choice, std::string_view value) {
  const CatalogueEntry& entry = entry_of(component.kind);
  if (choice == "shadowing") return pick(shadowings, entry.shadowings, value, component.shadowing);
  if (choice == "slopes") return pick(slope_laws, entry.slopes, value, component.slopes);
  if (choice == "psd") return pick(spectra, entry.psds, value, component.psd);
  return false;
}

}  // namespace umov::brdf
