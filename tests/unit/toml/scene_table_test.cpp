// What a table of a scene file gives, and what it says of what it refuses.
#include "host/toml/scene_table.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/unit/failure.hpp"

namespace umov {
namespace {

const std::string file = "scene.toml";

TEST(SceneTable, StepsOfARangeAreTheNumbersThatPeopleMean) {
  const toml::table read = toml::parse("at = { from = 0.40, to = 0.90, step = 0.05 }");
  const std::vector<double> expected{0.4, 0.45, 0.5, 0.55, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85, 0.9};
  EXPECT_EQ(SceneTable(read, file, "").numbers("at", 0.0, 1.0), expected);
  const toml::table through_zero = toml::parse("at = { from = -0.3, to = 0.3, step = 0.1 }");
  const std::vector<double> around{-0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3};
  EXPECT_EQ(SceneTable(through_zero, file, "").numbers("at", -1.0, 1.0), around);
  const toml::table tiny = toml::parse("at = { from = 0, to = 1e-300, step = 1e-300 }");
  for (const double x : SceneTable(tiny, file, "").numbers("at", 0.0, 1e-296)) {
    EXPECT_TRUE(x >= 0.0 && x <= 1e-300);
  }
}

TEST(SceneTable, FilesThatAreNotThereAreRefusedWithTheLineThatNamesThem) {
  const toml::table read = toml::parse("a = 1\n\nshape = \"no/such.stl\"\n");
  const std::string said = failure_of([&] { SceneTable(read, file, "lamp").file("shape"); });
  EXPECT_NE(said.find("scene.toml:3"), std::string::npos) << said;
  EXPECT_NE(said.find("lamp.shape is 'no/such.stl'"), std::string::npos) << said;
}

TEST(SceneTable, MisspeltKeysAreToldAllThatThereCouldBe) {
  const toml::table read = toml::parse("roh = 1\n");
  SceneTable table(read, file, "wall");
  EXPECT_FALSE(table.has("rho"));
  EXPECT_EQ(table.number("edge", 0.0, 1.0, 0.5), 0.5);
  const std::string said = failure_of([&] { table.refuse_unknown(); });
  EXPECT_NE(said.find("known are: edge, rho"), std::string::npos) << said;
}

}  // namespace
}  // namespace umov
