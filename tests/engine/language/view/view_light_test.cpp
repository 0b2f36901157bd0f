#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "engine/language/view/view_file.h"

namespace espalier::language::view_light_test {
namespace {

using core::Vec3;

ViewFileResult read(const std::string& text) {
  core::MemoryFileProvider files;
  files.add("model.v", text);
  return readViewFile("model.v", files, core::Compatibility::Espalier, core::Limits{});
}

std::string onlyMessage(const ViewFileResult& result) {
  return result.diagnostics.entries().size() == 1 ? result.diagnostics.entries().front().message : std::string{};
}

TEST(ViewLight, AllPartsOfALightAreRead) {
  const ViewFileResult result = read(
      "light: O 1 2 3 A: .1,.2,.3 D: 1 0 0 S: 0 1 0 P: 0 -1 0 2 30 T: 1 0.5 0.25\n"
      "light: V: 1,2,2\nlight:\n");
  EXPECT_TRUE(result.diagnostics.entries().empty());
  ASSERT_EQ(result.settings.lights.size(), 3U);
  const files::Light& point = result.settings.lights[0];
  EXPECT_FALSE(point.isDirectional);
  EXPECT_EQ(point.place, (Vec3{1, 2, 3}));
  EXPECT_EQ(point.ambient, (Vec3{.1, .2, .3}));
  EXPECT_EQ(point.diffuse, (Vec3{1, 0, 0}));
  EXPECT_EQ(point.specular, (Vec3{0, 1, 0}));
  EXPECT_EQ(point.spotDirection, (Vec3{0, -1, 0}));
  EXPECT_EQ(point.spotExponent, 2.0);
  EXPECT_EQ(point.spotCutoffDegrees, 30.0);
  EXPECT_EQ(point.attenuation, (Vec3{1, 0.5, 0.25}));
  EXPECT_TRUE(result.settings.lights[1].isDirectional);
  EXPECT_EQ(result.settings.lights[1].place, (Vec3{1, 2, 2}));
  // the defaults: a white point light at (0, 0, 1)
  EXPECT_EQ(result.settings.lights[2].place, (Vec3{0, 0, 1}));
  EXPECT_EQ(result.settings.lights[2].diffuse, (Vec3{1, 1, 1}));
}

TEST(ViewLight, AWrongLightIsDroppedAndNamed) {
  EXPECT_EQ(onlyMessage(read("light: O 1 2 3 X 4\n")),
            "the light is dropped: expected O, V, A, D, S, P or T, found 'X'");
  EXPECT_EQ(onlyMessage(read("light: D 1 2\n")), "the light is dropped: expected 3 numbers after 'D', found the end");
  EXPECT_EQ(onlyMessage(read("light: V 0 0 0\n")), "the light is dropped: its direction has no length");
  EXPECT_TRUE(read("light: D 1 2\n").settings.lights.empty());
}

TEST(ViewLight, ModesDirectionAndCapsAreRead) {
  const files::ViewSettings view = read("render mode: flat\nlight direction: 0,3,4\nPS linecap: 2\n").settings;
  EXPECT_EQ(view.renderMode, files::RenderMode::Flat);
  EXPECT_EQ(view.lightDirection, (Vec3{0, 0.6, 0.8}));
  EXPECT_EQ(view.postScriptLineCap, 2);
  EXPECT_EQ(read("render mode: 5\n").settings.renderMode, files::RenderMode::Shaded);
  EXPECT_EQ(read("shade mode: 4\n").settings.renderMode, files::RenderMode::Wireframe);
  EXPECT_EQ(read("").settings.renderMode, std::nullopt);
  EXPECT_EQ(onlyMessage(read("render mode: shady\n")), "unknown render mode 'shady'; the command is ignored");
  EXPECT_EQ(onlyMessage(read("light direction: 0,0,0\n")), "the light direction has no length and is ignored");
  EXPECT_EQ(onlyMessage(read("PS linecap: 3\n")), "a line cap is 0 (butt), 1 (round) or 2 (square); it stays 1");
}

}  // namespace
}  // namespace espalier::language::view_light_test
