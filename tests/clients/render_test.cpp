// `--render`: pictures by the light of sun and sky.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "clients/espalier/rendering/path_tracer.h"
#include "clients/espalier/rendering/render.h"
#include "clients/espalier/rendering/render_light.h"
#include "clients/espalier/rendering/render_scene.h"
#include "engine/core/vec3.h"
#include "engine/files/view_settings.h"
#include "engine/turtle/export/exporters.h"
#include "engine/turtle/export/picture/picture.h"
#include "engine/turtle/export/picture/projection.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::command::render_test {
namespace {

using core::Vec3;
using turtle::PictureImage;

turtle::Segment line(const Vec3& start, const Vec3& end, std::uint32_t order, std::uint32_t parent) {
  turtle::Segment segment;
  segment.start = start;
  segment.end = end;
  segment.startWidth = segment.endWidth = 0.2;
  segment.branchOrder = order;
  segment.parent = parent;
  return segment;
}

// a stem with a branch and a level square leaf at its tip
turtle::Scene plant() {
  turtle::Scene scene;
  scene.lineStyle = files::LineStyle::Cylinder;
  scene.segments = {line({0, 0, 0}, {0, 2, 0}, 0, turtle::kNoParent), line({0, 1, 0}, {0.6, 1.4, 0}, 1, 0)};
  turtle::Polygon leaf;
  leaf.vertices = {{-1, 2, -1}, {-1, 2, 1}, {1, 2, 1}, {1, 2, -1}};
  leaf.parent = 0;
  scene.polygons.push_back(leaf);
  return scene;
}

struct Drawn {
  explicit Drawn(turtle::Scene drawn) : scene(std::move(drawn)) {
    options.widthPixels = 96;
    options.heightPixels = 96;
    options.background = turtle::PictureBackground::White;
    render.samples = 32;
  }
  PictureImage picture() {
    const files::ViewSettings seen = viewToRender(view, render);
    const turtle::ExportInput input{.scene = scene, .view = seen};
    const turtle::ScenePlacement here;
    PictureImage image;
    EXPECT_EQ(renderInDaylight({{&input, 1}, {&here, 1}}, options, render, image), std::nullopt);
    return image;
  }

  turtle::Scene scene;
  files::ViewSettings view;
  turtle::PictureOptions options;
  RenderOptions render;
};

std::array<int, 4> at(const PictureImage& image, int x, int y) {
  const auto place = static_cast<std::size_t>(y * image.width + x) * 4;
  return {image.pixels[place], image.pixels[place + 1], image.pixels[place + 2], image.pixels[place + 3]};
}

double meanBrightness(const PictureImage& image) {
  double sum = 0.0;
  for (std::size_t place = 0; place < image.pixels.size(); place += 4) {
    sum += image.pixels[place] + image.pixels[place + 1] + image.pixels[place + 2];
  }
  return sum / (3.0 * static_cast<double>(image.pixels.size()) / 4.0);
}

TEST(Render, IsTheSamePictureForAnyNumberOfThreads) {
  Drawn drawn(plant());
  const PictureImage one = drawn.picture();
  for (const unsigned threads : {2U, 4U}) {
    drawn.options.threads = threads;
    EXPECT_EQ(drawn.picture().pixels, one.pixels) << threads;
  }
}

TEST(Render, LeavesThePageAsItIsWhereNoShadowFalls) {
  Drawn drawn(plant());
  const PictureImage image = drawn.picture();
  EXPECT_EQ(at(image, 0, 0), (std::array{255, 255, 255, 255}));
  EXPECT_EQ(at(image, 95, 0), (std::array{255, 255, 255, 255}));
}

TEST(Render, ThrowsAShadowOnTheGroundWhereAPlantStands) {
  Drawn drawn(plant());
  drawn.render.height = 60.0;
  const double standing = meanBrightness(drawn.picture());
  drawn.options.hasGround = false;
  EXPECT_GT(meanBrightness(drawn.picture()), standing + 3.0);
}

TEST(Render, KeepsTheShadowOnATransparentPage) {
  Drawn drawn(plant());
  drawn.render.height = 60.0;
  drawn.options.background = turtle::PictureBackground::Transparent;
  const PictureImage image = drawn.picture();
  EXPECT_LT(at(image, 0, 0)[3], 10);  // the plant hides a little of the sky
  int shadows = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const auto [red, green, blue, opacity] = at(image, x, y);
      shadows += opacity > 60 && opacity < 220 && red + green + blue == 0 ? 1 : 0;
    }
  }
  EXPECT_GT(shadows, 30);
}

TEST(Render, LetsLightThroughLeaves) {
  // a level leaf below the sun: from below it is seen by the light that comes through, which is yellower
  Drawn drawn(plant());
  drawn.scene.segments.clear();
  drawn.options.hasGround = false;
  drawn.render.height = 60.0;
  const std::array<int, 4> above = at(drawn.picture(), 48, 48);
  drawn.render.height = -60.0;
  const std::array<int, 4> below = at(drawn.picture(), 48, 48);
  EXPECT_GT(below[1], above[1] / 2);
  EXPECT_LT(below[2] * above[1], 0.9 * above[2] * below[1]);
}

TEST(Render, RaisesAViewerWhoWouldLookAlongTheGround) {
  files::ViewSettings view;
  view.viewpoint = view.viewReferencePoint + Vec3{0, 0, 5};
  RenderOptions render;
  const auto heightOf = [](const files::ViewSettings& seen) {
    return std::asin(turtle::Projection(seen).towardViewer().y) * 180.0 / 3.14159265358979;
  };
  EXPECT_NEAR(heightOf(viewToRender(view, render)), 8.0, 1e-9);
  render.height = 30.0;
  EXPECT_NEAR(heightOf(viewToRender(view, render)), 30.0, 1e-9);
  // a quarter turn to the right
  render.height = 0.0;
  render.turn = 90.0;
  const Vec3 toward = turtle::Projection(viewToRender(view, render)).towardViewer();
  EXPECT_NEAR(toward.x, 1.0, 1e-9);
  EXPECT_NEAR(toward.z, 0.0, 1e-9);
}

TEST(RenderLight, OfSunAndSkyOnLevelGroundIsOne) {
  for (const double height : {0.3, 0.8}) {
    const Daylight above(core::normalised({0.4, height, -0.2}));
    // a grid over the hemisphere that is not the one that the class uses
    std::array<double, 3> sum = above.sunOnGround();
    constexpr int kRings = 300;
    constexpr int kAzimuths = 300;
    for (int ring = 0; ring < kRings; ++ring) {
      const double cosine = (ring + 0.5) / kRings;
      const double level = std::sqrt(1.0 - cosine * cosine);
      for (int k = 0; k < kAzimuths; ++k) {
        const double azimuth = 2.0 * 3.14159265358979 * k / kAzimuths;
        const auto sky = above.sky({level * std::cos(azimuth), cosine, level * std::sin(azimuth)});
        for (std::size_t part = 0; part < 3; ++part) {
          sum[part] += sky[part] * cosine * 2.0 / kRings / kAzimuths;
        }
      }
    }
    for (const double part : sum) {
      EXPECT_NEAR(part, 1.0, 0.005) << height;
    }
  }
}

TEST(RenderLight, ALowSunIsRaisedToFiveDegrees) {
  const Vec3 sun = Daylight(core::normalised({3, -0.5, 4})).towardSun(0.0, 0.0);
  EXPECT_NEAR(core::length(sun), 1.0, 1e-12);
  EXPECT_NEAR(std::asin(sun.y) * 180.0 / 3.14159265358979, 5.0, 0.01);
  EXPECT_NEAR(sun.x / sun.z, 0.75, 1e-12);
  EXPECT_GT(sun.x, 0.0);
  // one straight below has no side to be raised on
  EXPECT_EQ(Daylight({0, -1, 0}).towardSun(0.0, 0.0), (Vec3{0, 1, 0}));
}

// a level square of side 2 at a height, in the third colour
turtle::Scene leafAt(double height) {
  turtle::Scene scene;
  turtle::Polygon leaf;
  leaf.vertices = {{-1, height, -1}, {-1, height, 1}, {1, height, 1}, {1, height, -1}};
  leaf.colour = 3;
  scene.polygons.push_back(leaf);
  return scene;
}

TEST(PathTracer, AGroundInTheShadeOfALeafHasTheLightOfTheSky) {
  const turtle::Scene scene = leafAt(10.0);
  const files::ViewSettings view;
  const turtle::ExportInput input{.scene = scene, .view = view};
  const turtle::ScenePlacement here;
  const RenderScene leaf({{&input, 1}, {&here, 1}});
  const Daylight above({0, 1, 0});
  const PathTracer tracer(leaf, above, 0.0);
  const auto shadeAt = [&](double x) {
    double sum = 0.0;
    constexpr std::uint32_t kSamples = 1024;
    for (std::uint32_t sample = 0; sample < kSamples; ++sample) {
      SampleNumbers numbers(1, sample);
      sum += tracer.look({x + 5.0, 1, 0}, core::normalised({-5, -1, 0}), numbers).shade;
    }
    return sum / kSamples;
  };
  const auto& [red, green, blue] = above.sunOnGround();
  const double ofSky = 1.0 - (0.2126 * red + 0.7152 * green + 0.0722 * blue);
  // the leaf hides the sun, and of the sky about its area by pi times the squared distance, 0.0127; a plant throws
  // back 0.15 of that
  EXPECT_NEAR(shadeAt(0.0), ofSky * (1.0 - 0.85 * 0.0127), 0.005);
  EXPECT_NEAR(shadeAt(40.0), 1.0, 0.005);
}

TEST(RenderScene, ATranslucentLeafLetsTheRestOfTheLightThrough) {
  turtle::Scene scene = leafAt(1.0);
  scene.polygons.push_back(leafAt(2.0).polygons.front());
  files::Palette palette;
  palette.usesMaterials = true;
  palette.materials[palette.base].fill({.opacity = 0.25});
  const files::ViewSettings view;
  const turtle::ExportInput input{.scene = scene, .view = view, .palette = &palette};
  const turtle::ScenePlacement here;
  const RenderScene leaves({{&input, 1}, {&here, 1}});
  // from below both, from between them, from beside them
  EXPECT_NEAR(leaves.arriving({0.2, 0, 0.3}, {0, 1, 0}), 0.75 * 0.75, 1e-12);
  EXPECT_NEAR(leaves.arriving({0.2, 1.5, 0.3}, {0, 1, 0}), 0.75, 1e-12);
  EXPECT_EQ(leaves.arriving({2, 0, 0}, {0, 1, 0}), 1.0);
  // a viewer sees one of them where a ray does not pass both
  const Daylight above({0, 1, 0});
  const PathTracer tracer(leaves, above, std::nullopt);
  int plants = 0;
  for (std::uint32_t sample = 0; sample < 2000; ++sample) {
    SampleNumbers numbers(1, sample);
    plants += tracer.look({0.2, 5, 0.3}, {0, -1, 0}, numbers).isPlant ? 1 : 0;
  }
  // 2000 draws of probability 7/16: 875, standard deviation 22; four of them
  EXPECT_NEAR(plants, 875, 89);
}

TEST(Render, RefusesAPlaceThatIsNoNumberThatFilesHold) {
  Drawn drawn(plant());
  drawn.scene.segments[0].end.y = 1e300;
  const turtle::ExportInput input{.scene = drawn.scene, .view = drawn.view};
  const turtle::ScenePlacement here;
  PictureImage image;
  drawn.options.frame.emplace();
  EXPECT_NE(renderInDaylight({{&input, 1}, {&here, 1}}, drawn.options, drawn.render, image), std::nullopt);
}

}  // namespace
}  // namespace espalier::command::render_test
