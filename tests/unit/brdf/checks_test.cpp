// Energy, reciprocity and realisability as numbers.
#include "host/brdf/checks.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "host/brdf/dhr.hpp"
#include "host/brdf/evaluate.hpp"
#include "tests/unit/brdf/variants.hpp"

namespace umov::brdf {
namespace {

using optics::radians;

TEST(Checks, FindEveryModelReciprocalButWard) {
  for (const Variant& v : all_variants()) {
    const Model model = Model::by_name(v.name);
    const WorstCase worst = reciprocity_violation(model, v.values, 0.633, 500);
    if (std::string(v.name) == "ward") {
      // Its axes turn with the plane of incidence.
      EXPECT_GT(worst.amount, 0.5);
      EXPECT_GT(worst.geometry.phi_r, 0.0);
    } else {
      EXPECT_LT(worst.amount, 1e-6) << v.name;
    }
  }
}

TEST(Checks, FindEveryModelRealisable) {
  for (const Variant& v : all_variants()) {
    EXPECT_LT(realisability_violation(Model::by_name(v.name), v.values, 0.633, 300).amount, 1e-9)
        << v.name;
  }
}

TEST(Checks, SeeWhatIsNotRealisable) {
  optics::Mueller<double> m = optics::identity_mueller<double>();
  EXPECT_NEAR(unrealisable_share(m), 0.0, 1e-12);
  EXPECT_NEAR(unrealisable_share(optics::depolarizer<double>()), -0.25, 1e-12);
  // Turns no light into more than fully polarised light, and yet no optics does it: it would turn
  // the sense of circular light alone.
  optics::set_element(m, 3, 3, -1.0);
  EXPECT_NEAR(unrealisable_share(m), 0.5, 1e-12);
  EXPECT_NEAR(unrealisable_share(optics::reflection_mueller(0.2, 3.0, 0.4)), 0.0, 1e-12);
}

TEST(Checks, TakeOutEveryLoss) {
  for (const char* name :
       {"lambertian", "microfacet", "ggx", "he-torrance", "li-torrance", "phong"}) {
    const Model model = Model::by_name(name);
    std::vector<double> values = model.initial_values();
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (model.parameters()[i].name == "slope_rms" || model.parameters()[i].name == "alpha")
        values[i] = 0.02;
      if (model.parameters()[i].name == "sigma_um") values[i] = 0.001;
    }
    const auto without_loss = lossless(model, values);
    ASSERT_TRUE(without_loss) << name;
    const double total = dhr(model, *without_loss, 0.633, 0.0).unpolarized +
                         mirror_dhr(model, *without_loss, 0.633, 0.0).unpolarized;
    EXPECT_NEAR(total, 1.0, 1e-3) << name;
  }
  EXPECT_FALSE(lossless(Model::by_name("nef"), std::vector{0.1, 0.1}));
  EXPECT_FALSE(lossless(Model::by_name("microfacet+lambertian"),
                        Model::by_name("microfacet+lambertian").initial_values()));
}

}  // namespace
}  // namespace umov::brdf
