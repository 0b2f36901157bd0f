#include "engine/turtle/export/picture/picture.h"

#include <array>
#include <cmath>
#include <numbers>

#include "tests/engine/turtle/turtle_fixture.h"

namespace espalier::turtle::picture_test {
namespace {

Scene sceneOf(std::string_view text, const files::ViewSettings& view) {
  TurtleRun run(text, view);
  run.draw();
  return run.scene;
}

files::ViewSettings viewOf(files::LineStyle style, double width = 1.0) {
  files::ViewSettings view;
  view.lineStyle = style;
  view.initialLineWidth = width;
  return view;
}

// points covered, in whole points
double coverage(const PictureImage& image) {
  double sum = 0.0;
  for (std::size_t at = 3; at < image.pixels.size(); at += 4) {
    sum += image.pixels[at] / 255.0;
  }
  return sum;
}

std::array<int, 4> pixelAt(const PictureImage& image, int x, int y) {
  const std::size_t at =
      (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x)) * 4;
  return {image.pixels[at], image.pixels[at + 1], image.pixels[at + 2], image.pixels[at + 3]};
}

const PictureOptions kTransparent{
    .widthPixels = 200, .heightPixels = 100, .marginFraction = 0.0, .background = PictureBackground::Transparent};

TEST(Picture, ABallFillsACircleOfThePage) {
  const files::ViewSettings view = viewOf(files::LineStyle::Cylinder);
  const PictureImage image = renderPicture(sceneOf("@O(3)", view), view, kTransparent);
  // the height decides: a circle of diameter 100, drawn with 40 corners: 0.4 % smaller
  EXPECT_NEAR(coverage(image), 0.996 * std::numbers::pi * 50 * 50, 8.0);
  EXPECT_EQ(pixelAt(image, 10, 50)[3], 0);
  EXPECT_EQ(pixelAt(image, 100, 50)[3], 255);
}

TEST(Picture, LinesHaveTheWidthThatTheirStyleSays) {
  // a line of length 10 and width 2; in world units the page shows a rectangle of 5 to 1, which the margin of 10 % of
  // 200 pixels makes 160 long and 32 wide
  PictureOptions options = kTransparent;
  options.marginFraction = 0.1;
  for (const auto style : {files::LineStyle::Polygon, files::LineStyle::Cylinder}) {
    const files::ViewSettings view = viewOf(style, 2.0);
    const double covered = coverage(renderPicture(sceneOf("-(90)F(10)", view), view, options));
    // fitted with the radius on all sides: length 12, and a cylinder's free end is round
    const double scale = 160.0 / 12.0;
    const double end = style == files::LineStyle::Cylinder ? std::numbers::pi / 2 * scale * scale : 0.0;
    EXPECT_NEAR(covered, 10 * 2 * scale * scale + end, 30.0);
  }
  // pixels: 160 long, 7 wide, with round ends, whatever the scale
  files::ViewSettings view = viewOf(files::LineStyle::Pixel, 7.0);
  view.isLineStyleGiven = true;
  EXPECT_NEAR(coverage(renderPicture(sceneOf("-(90)F(10)", view), view, options)),
              160 * 7 + std::numbers::pi * 3.5 * 3.5, 10.0);
  EXPECT_NEAR(coverage(renderPicture(sceneOf("-(90)F(0.1)", view), view, options)),
              160 * 7 + std::numbers::pi * 3.5 * 3.5, 10.0);
}

TEST(Picture, AStripLiesInThePlaneOfTheTurtleAndStaysVisibleFromItsEdge) {
  const files::ViewSettings view = viewOf(files::LineStyle::Polygon, 2.0);
  PictureOptions options = kTransparent;
  options.marginFraction = 0.1;
  const double flat = coverage(renderPicture(sceneOf("F(10)", view), view, options));
  const double turned = coverage(renderPicture(sceneOf("/(60)F(10)", view), view, options));
  const double edge = coverage(renderPicture(sceneOf("/(90)F(10)", view), view, options));
  EXPECT_NEAR(turned / flat, 0.5, 0.02);
  // 80 pixels of length 12 for the line of 10, at least 0.6 pixels wide
  EXPECT_NEAR(edge, 0.6 * 80 * 10 / 12, 12.0);
}

TEST(Picture, WhatIsNearerHidesWhatIsBehind) {
  files::ViewSettings view = viewOf(files::LineStyle::Cylinder);
  view.renderMode = files::RenderMode::Filled;
  // two discs facing the viewer at z = 1 and z = -1 (the viewer is at +z), the nearer one drawn first
  const char* const near = "@M(0,0,1);(200)@c(1)@M(0,0,-1);(10)@c(2)";
  const PictureImage image = renderPicture(sceneOf(near, view), view, kTransparent);
  const Colour front = defaultColour(200);
  const auto centre = pixelAt(image, 100, 50);
  // unlit and nearest: exactly the colour of the index
  EXPECT_EQ(centre, (std::array<int, 4>{front.red, front.green, front.blue, 255}));
  EXPECT_NE(pixelAt(image, 100, 10)[0], front.red);
}

std::string longCylinder(int points) {
  std::string text = "@Gs";
  for (int i = 0; i < points; ++i) {
    text += "F(0.3)+(7)&(3)@Gc(2)";
  }
  return text + "@Ge";
}

TEST(Picture, TheSamePictureForAnyNumberOfThreadsAndStrips) {
  files::ViewSettings view = viewOf(files::LineStyle::Cylinder, 0.3);
  view.viewpoint = {1, 1, 2};
  std::string text = "!(0.4)";
  for (int i = 0; i < 300; ++i) {
    text += "F(1)+(37)/(71)[&(40)F(2)@O(0.7)][^(20)F(1){.+(30)f.+(60)f.}@c(0.5)]";
  }
  // a cylinder that is drawn in pieces
  text += longCylinder(700);
  const Scene scene = sceneOf(text, view);
  PictureOptions options{.widthPixels = 301, .heightPixels = 207};
  const PictureImage image = renderPicture(scene, view, options);
  options.threads = 3;
  EXPECT_EQ(renderPicture(scene, view, options), image);
  // strips of 13 rows
  options.sampleBytes = 128 * 301 * 13;
  EXPECT_EQ(renderPicture(scene, view, options), image);
}

TEST(Picture, ARoundIsBoundedByItsTriangles) {
  const files::ViewSettings view = viewOf(files::LineStyle::Cylinder, 0.3);
  const auto roundsOf = [&](const std::string& text) {
    const Scene scene = sceneOf(text, view);
    const ExportInput input{.scene = scene, .view = view};
    const ScenePlacement here;
    std::vector<std::size_t> reports;
    static_cast<void>(renderPlaced({{&input, 1}, {&here, 1}}, kTransparent, [&](std::size_t done, std::size_t all) {
      EXPECT_LE(done, all);
      reports.push_back(done);
    }));
    EXPECT_TRUE(std::ranges::is_sorted(reports));
    return reports;
  };
  // 2 strips of 8 sides for each of 20,000 points: 640,000 triangles, 65,536 a round
  const std::vector<std::size_t> one = roundsOf(longCylinder(20'000));
  EXPECT_EQ(one.size(), 10U);
  EXPECT_EQ(one.front(), 0U) << "the cylinder is not done";
  EXPECT_EQ(one.back(), 1U);
  // 3,200 triangles each, two in one of the 16 tasks of a round
  std::string many;
  for (int i = 0; i < 200; ++i) {
    many += longCylinder(100);
  }
  EXPECT_EQ(roundsOf(many).size(), 7U);
  EXPECT_EQ(roundsOf(longCylinder(100)).size(), 1U);
}

TEST(Picture, ThePiecesOfALongCylinderAreOneOrgan) {
  // the coils lie over one another: a translucent organ covers the same samples in all of them
  const files::ViewSettings view = viewOf(files::LineStyle::Cylinder);
  files::Palette palette;
  palette.usesMaterials = true;
  palette.materials[1].fill({.opacity = 0.5});
  PictureOptions options = kTransparent;
  options.palette = &palette;
  const PictureImage image = renderPicture(sceneOf(longCylinder(1000), view), view, options);
  int most = 0;
  for (std::size_t at = 3; at < image.pixels.size(); at += 4) {
    most = std::max<int>(most, image.pixels[at]);
  }
  EXPECT_EQ(most, 127);
}

TEST(Picture, PerspectiveShowsTheNearerLarger) {
  files::ViewSettings view = viewOf(files::LineStyle::Cylinder);
  view.isPerspective = true;
  view.viewpoint = {0, 0, 10};
  const auto diameters = [&](const files::ViewSettings& settings) {
    // two spheres side by side at z = 0 and z = 5
    const PictureImage image =
        renderPicture(sceneOf("@M(-2,0,0)@O(2)@M(2,0,5)@O(2)", settings), settings, kTransparent);
    double left = 0.0;
    double right = 0.0;
    for (int x = 0; x < image.width; ++x) {
      bool isDrawn = false;
      for (int y = 0; y < image.height; ++y) {
        isDrawn = isDrawn || pixelAt(image, x, y)[3] > 127;
      }
      (x < 60 ? left : right) += isDrawn ? 1.0 : 0.0;
    }
    return right / left;
  };
  // at distances 10 and 5: twice as large
  EXPECT_NEAR(diameters(view), 2.0, 0.1);
  view.isPerspective = false;
  EXPECT_NEAR(diameters(view), 2.0 / 2.0, 0.5);
}

TEST(Picture, AViewerWithinTheSceneGetsAParallelPicture) {
  files::ViewSettings view = viewOf(files::LineStyle::Cylinder);
  view.isPerspective = true;
  view.viewpoint = {0, 0, 1};
  const Scene scene = sceneOf("@M(0,0,5)@O(1)@M(0,0,0)@O(3)", view);
  const PictureImage image = renderPicture(scene, view, kTransparent);
  view.isPerspective = false;
  EXPECT_EQ(renderPicture(scene, view, kTransparent), image);
}

TEST(Picture, TheViewFilesFramingUsesItsBoxAndScaleAndAngle) {
  files::ViewSettings view = viewOf(files::LineStyle::Cylinder);
  view.box = files::Box{{-4, -2, -1}, {4, 2, 1}};
  PictureOptions options = kTransparent;
  options.framing = PictureFraming::View;
  const auto area = [&] { return coverage(renderPicture(sceneOf("@O(2)", view), view, options)); };
  // 25 pixels a unit
  EXPECT_NEAR(area(), std::numbers::pi * 25 * 25, 20.0);
  view.scaleFactor = 1.5;
  EXPECT_NEAR(area(), std::numbers::pi * 25 * 25 * 2.25, 40.0);
  // perspective: half the height is tan(45°) of the distance 10
  view.scaleFactor = 1.0;
  view.isPerspective = true;
  view.viewingAngleDegrees = 90.0;
  view.viewpoint = {0, 0, 10};
  // the drawn front half of a ball of radius 1 at distance 10 is seen within asin(1/10)
  EXPECT_NEAR(area(), std::numbers::pi * 5 * 5, 4.0);
}

TEST(Picture, RenderModesAreThoseOfTheViewFile) {
  files::ViewSettings view = viewOf(files::LineStyle::Cylinder);
  const Scene scene = sceneOf(";(200)@O(2)", view);
  const Colour colour = defaultColour(200);
  const auto brightest = [&] {
    const PictureImage image = renderPicture(scene, view, kTransparent);
    int largest = 0;
    int smallest = 255;
    for (std::size_t at = 0; at < image.pixels.size(); at += 4) {
      if (image.pixels[at + 3] == 255) {
        largest = std::max<int>(largest, image.pixels[at]);
        smallest = std::min<int>(smallest, image.pixels[at]);
      }
    }
    return std::array{smallest, largest, static_cast<int>(coverage(image))};
  };
  view.renderMode = files::RenderMode::Filled;
  const auto filled = brightest();
  EXPECT_EQ(filled[0], colour.red);
  EXPECT_EQ(filled[1], colour.red);
  view.renderMode = files::RenderMode::Shaded;
  const auto shaded = brightest();
  EXPECT_GT(shaded[1] - shaded[0], 60);
  EXPECT_EQ(shaded[2], filled[2]);
  view.renderMode = files::RenderMode::Wireframe;
  EXPECT_LT(brightest()[2], filled[2] / 5);
}

TEST(Picture, LightsOfTheViewFileGiveTheirColourAndDirection) {
  files::ViewSettings view = viewOf(files::LineStyle::Cylinder);
  files::Light light;
  light.isDirectional = true;
  light.place = {1, 0, 0};
  light.diffuse = {1, 0, 0};
  view.lights = {light};
  files::Palette palette;
  palette.base = 0;
  palette.maps[0].fill({200, 200, 200});
  PictureOptions options = kTransparent;
  options.palette = &palette;
  const PictureImage image = renderPicture(sceneOf("@O(2)", view), view, options);
  // the ball's right edge is in red light, its left one in the dark
  EXPECT_GT(pixelAt(image, 145, 50)[0], 180);
  EXPECT_LT(pixelAt(image, 145, 50)[1], 60);
  EXPECT_EQ(pixelAt(image, 55, 50)[0], pixelAt(image, 55, 50)[1]);
  // a spot from the viewer lights the middle only
  light = {};
  light.place = {0, 0, 10};
  light.spotCutoffDegrees = 3.0;
  view.lights = {light};
  const PictureImage spot = renderPicture(sceneOf("@O(2)", view), view, options);
  EXPECT_GT(pixelAt(spot, 100, 50)[0], pixelAt(spot, 100, 15)[0] + 50);
}

TEST(Picture, LightComesThroughALeafToTheSideThatIsTurnedAway) {
  // the key light from behind the leaf, along it, and from the viewer
  files::ViewSettings view = viewOf(files::LineStyle::Cylinder);
  view.lightDirection = core::Vec3{0, 0, -1};
  const auto brightness = [&](const std::string& string) {
    return static_cast<int>(pixelAt(renderPicture(sceneOf(string, view), view, kTransparent), 100, 50)[1]);
  };
  const std::string leaf = "{.f.+(90)f.+(90)f.}";
  const int behind = brightness(leaf);
  view.lightDirection = core::Vec3{0, 1, 0};
  const int along = brightness(leaf);
  view.lightDirection = core::Vec3{0, 0, 1};
  const int before = brightness(leaf);
  EXPECT_GT(behind, along + 20) << "it comes through";
  EXPECT_GT(before, behind + 20) << "it does not all come through";
  // nothing comes through a ball
  view.lightDirection = core::Vec3{0, 0, -1};
  EXPECT_LT(brightness("@O(2)"), along + 5);
}

TEST(Picture, LabelsAreReadableText) {
  const files::ViewSettings view = viewOf(files::LineStyle::Pixel);
  Scene scene;
  scene.labels.push_back({.position = {0, 0, 0}, .text = "I", .colour = 10});
  const double one = coverage(renderPicture(scene, view, kTransparent));
  scene.labels[0].text = "III";
  EXPECT_NEAR(coverage(renderPicture(scene, view, kTransparent)), 3 * one, 0.5);
  // an I of eleven points, each 1.5 by 1.5 pixels
  EXPECT_NEAR(one, 11 * 1.5 * 1.5, 0.5);
}

TEST(Picture, AnEmptySceneIsAnEmptyPage) {
  const PictureImage image = renderPicture({}, {}, kTransparent);
  EXPECT_EQ(coverage(image), 0.0);
  PictureOptions options = kTransparent;
  options.background = PictureBackground::White;
  EXPECT_EQ(pixelAt(renderPicture({}, {}, options), 3, 3), (std::array<int, 4>{255, 255, 255, 255}));
}

}  // namespace
}  // namespace espalier::turtle::picture_test
