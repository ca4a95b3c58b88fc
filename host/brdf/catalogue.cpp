#include "host/brdf/catalogue.hpp"

#include <array>
#include <utility>

namespace umov::brdf {
namespace {

constexpr std::array<CatalogueEntry, 8> entries{{
    {Kind::lambertian, "lambertian", "the same radiance in all directions, depolarised", false,
     false, false},
    {Kind::nef, "nef", "two-parameter diffuse term, depolarised", false, false, false},
    {Kind::microfacet, "microfacet", "polarised Fresnel facets with Gaussian or exponential slopes",
     true, true, true},
    {Kind::ggx, "ggx", "polarised Fresnel facets with Trowbridge-Reitz slopes", true, false, false},
    {Kind::he_torrance, "he-torrance",
     "wave-optical lobe and mirror part of a Gaussian rough surface", false, false, false},
    {Kind::li_torrance, "li-torrance",
     "He-Torrance lobe, uniform first-surface and subsurface light, forward-scattered lobe", false,
     false, false},
    {Kind::phong, "phong", "cosine-power lobe about the mirror direction, depolarised", false,
     false, false},
    {Kind::ward, "ward", "elliptical Gaussian lobe, depolarised", false, false, false},
}};

constexpr std::array<std::pair<Shadowing, std::string_view>, 5> shadowings{{
    {Shadowing::none, "none"},
    {Shadowing::v_groove, "vgroove"},
    {Shadowing::smith, "smith"},
    {Shadowing::smith_correlated, "smith-correlated"},
    {Shadowing::maxwell_beard, "maxwell-beard"},
}};

constexpr std::array<std::pair<Slopes, std::string_view>, 2> slope_laws{{
    {Slopes::gaussian, "gaussian"},
    {Slopes::exponential, "exponential"},
}};

const CatalogueEntry& entry_of(Kind kind) {
  for (const CatalogueEntry& entry : entries) {
    if (entry.kind == kind) return entry;
  }
  return entries.front();
}

bool allowed(const CatalogueEntry& entry, Shadowing shadowing) {
  return entry.has_shadowing && (shadowing != Shadowing::maxwell_beard || entry.has_maxwell_beard);
}

Parameter refractive_index() {
  return {"n", "1", 0.05, 20.0, 1.5, "real part of the refractive index", "Fresnel", false};
}

Parameter extinction() {
  return {"kappa", "1", 0.0, 100.0, 0.0, "imaginary part of the refractive index", "Fresnel", true};
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
      if (component.shadowing == Shadowing::maxwell_beard) {
        list.push_back({"omega", "rad", 1e-3, 100.0, 0.7, "facet angle at which shadowing sets in",
                        "P8, Maxwell-Beard", false});
        list.push_back({"tau", "rad", 1e-3, 100.0, 0.25, "bistatic angle over which it fades in",
                        "P8, Maxwell-Beard", false});
      }
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
  }
  return {};
}

std::vector<Choice> choices_of(const Component& component) {
  const CatalogueEntry& entry = entry_of(component.kind);
  std::vector<Choice> list;
  if (entry.has_shadowing) {
    Choice choice{"shadowing", {}, {}, "how facets hide each other"};
    for (const auto& [value, name] : shadowings) {
      if (allowed(entry, value)) choice.values.emplace_back(name);
      if (value == component.shadowing) choice.value = name;
    }
    list.push_back(std::move(choice));
  }
  if (entry.has_slopes) {
    Choice choice{"slopes", {}, {}, "distribution of the facets' slopes"};
    for (const auto& [value, name] : slope_laws) {
      choice.values.emplace_back(name);
      if (value == component.slopes) choice.value = name;
    }
    list.push_back(std::move(choice));
  }
  return list;
}

bool choose(Component& component, std::string_view choice, std::string_view value) {
  const CatalogueEntry& entry = entry_of(component.kind);
  if (choice == "shadowing") {
    for (const auto& [shadowing, name] : shadowings) {
      if (name == value && allowed(entry, shadowing)) {
        component.shadowing = shadowing;
        return true;
      }
    }
  } else if (choice == "slopes" && entry.has_slopes) {
    for (const auto& [slopes, name] : slope_laws) {
      if (name == value) {
        component.slopes = slopes;
        return true;
      }
    }
  }
  return false;
}

}  // namespace umov::brdf
