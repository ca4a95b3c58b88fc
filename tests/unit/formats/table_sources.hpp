// Models as tables, and how far a table is off one, for the tests of table formats.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host/errors/error.hpp"
#include "host/formats/table_comparison.hpp"
#include "host/formats/table_file.hpp"
#include "host/optics/angles.hpp"
#include "host/optics/mueller.hpp"

namespace umov::formats::testing {

inline ModelTable model_table(const std::string& name,
                              const std::vector<std::pair<std::string, double>>& settings = {},
                              std::vector<double> wavelengths_um = {0.55}) {
  const brdf::Model model = brdf::Model::by_name(name);
  std::vector<double> values = model.initial_values();
  for (const auto& [parameter, value] : settings) values[model.index_of(parameter)] = value;
  return {model, std::move(wavelengths_um), {values}, "model " + name};
}

/// A satin paint: lobe of some 6 degrees over a diffuse ground.
inline ModelTable satin() {
  return model_table("microfacet+lambertian", {{"0.slope_rms", 0.1}, {"1.rho", 0.3}});
}

inline double m00(const brdf::Table& table, double um, double theta_i_deg, double theta_r_deg,
                  double phi_deg) {
  return optics::element(table.at(um, {optics::radians(theta_i_deg), optics::radians(theta_r_deg),
                                       optics::radians(phi_deg)}),
                         0, 0);
}

/// `action` throws an umov::Error that says all of this.
template <class Action>
void expect_refused(Action action, const std::vector<std::string>& says) {
  try {
    action();
    ADD_FAILURE() << "nothing was refused";
  } catch (const Error& error) {
    for (const std::string& part : says)
      EXPECT_THAT(std::string(error.what()), ::testing::HasSubstr(part));
  }
}

}  // namespace umov::formats::testing
