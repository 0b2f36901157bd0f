#include "engine/turtle/export/background_drawing.h"

#include <array>
#include <cmath>

#include "engine/turtle/export/picture/picture.h"
#include "tests/engine/turtle/turtle_fixture.h"

namespace espalier::turtle::background_drawing_test {
namespace {

files::BackgroundScene sceneOf(std::string_view text) {
  std::vector<files::BackgroundProblem> problems;
  files::BackgroundScene scene = files::readBackgroundScene(text, problems);
  EXPECT_TRUE(problems.empty());
  return scene;
}

// a plant of one line, two units high, with a background
struct Folder {
  explicit Folder(std::string_view background) {
    view.lineStyle = files::LineStyle::Cylinder;
    view.background = std::make_shared<files::BackgroundScene>(sceneOf(background));
    TurtleRun run("F(2)", view);
    run.draw();
    scene = run.scene;
  }
  [[nodiscard]] std::string fileOf(const char* format) const {
    core::StringSink sink;
    EXPECT_EQ(findExportFormat(format)->write({.scene = scene, .view = view}, {"plant", sink, {}, {}}), std::nullopt);
    return sink.take();
  }
  files::ViewSettings view;
  Scene scene;
};

TEST(BackgroundDrawing, FacesAreFlatAndRoundSolidsSmooth) {
  const BackgroundDrawing drawing(sceneOf("prism 1 1 1 material 0 0 0 1 0 0 1 1 cylinder 1 2 sphere 3"));
  const Scene empty;
  const files::ViewSettings view;
  const ExportInput input = drawing.input({.scene = empty, .view = view});
  ASSERT_EQ(input.scene.surfaces.size(), 2U);
  ASSERT_EQ(input.scene.balls.size(), 1U);
  EXPECT_EQ(input.scene.balls[0].diameter, 6.0);
  EXPECT_EQ(input.palette->material(input.scene.balls[0].colour).diffuse, (std::array<double, 3>{0, 0, 1}));
  for (const files::SurfaceTriangle& triangle : input.view.triangleSurfaces[0].triangles) {
    EXPECT_EQ(triangle.normals[0], triangle.normals[2]);  // of a prism: one normal a face
  }
  // the side of a cylinder: normals point away from its axis, except at the caps
  std::size_t sides = 0;
  for (const files::SurfaceTriangle& triangle : input.view.triangleSurfaces[1].triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (std::abs(triangle.normals[k].y) < 0.5) {
        const core::Vec3 outward{triangle.points[k].x, 0.0, triangle.points[k].z};
        EXPECT_GT(core::dot(triangle.normals[k], core::normalised(outward)), 0.99);
        ++sides;
      }
    }
  }
  EXPECT_EQ(sides, 32U * 2U * 3U);
}

TEST(BackgroundDrawing, APictureShowsItBehindThePlantAndKeepsThePlantsExtent) {
  // a red wall behind the plant, far wider than it; a blue ball out of sight
  const Folder folder(
      "material 0 0 0 1 1 0 0 1 0 0 0 1 1 0 0 1 pushmatrix translate -50 -50 -5 rectangle 100 100 popmatrix "
      "material 0 0 0 1 0 0 1 1 translate 80 0 0 sphere 1");
  const BackgroundDrawing drawing(*folder.view.background);
  const ExportInput plant{.scene = folder.scene, .view = folder.view};
  const std::array scenes{plant, drawing.input(plant)};
  const std::array placements{ScenePlacement{}, ScenePlacement{.scene = 1}};
  PictureOptions options{.widthPixels = 100, .heightPixels = 100};
  const PictureImage image = renderPlaced({scenes, placements}, options);
  const PictureImage alone = renderPicture(folder.scene, folder.view, options);
  const auto isRed = [](const PictureImage& picture, int x, int y) {
    return picture.at(x, y, 0) > 150 && picture.at(x, y, 1) < 60 && picture.at(x, y, 2) < 60;
  };
  EXPECT_TRUE(isRed(image, 3, 3));
  EXPECT_TRUE(isRed(image, 97, 50));
  EXPECT_FALSE(isRed(alone, 3, 3));
  // the plant stands where it stood, before the wall
  EXPECT_FALSE(isRed(image, 50, 50));
  const PictureFrame framed = pictureFrame({scenes, placements}, options);
  EXPECT_EQ(framed.bounds.top, pictureFrame({{&plant, 1}, std::span(placements).first(1)}, options).bounds.top);
}

TEST(BackgroundDrawing, FormatsForLookingHoldIt) {
  const Folder with("prism 10 10 10");
  Folder without("prism 10 10 10");
  without.view.background = nullptr;
  for (const char* format : {"png", "glb", "obj", "usda"}) {
    EXPECT_NE(with.fileOf(format), without.fileOf(format)) << format;
  }
  // meshes for printing and for science have the plant only
  for (const char* format : {"stl", "ply"}) {
    EXPECT_EQ(with.fileOf(format), without.fileOf(format)) << format;
  }
}

}  // namespace
}  // namespace espalier::turtle::background_drawing_test
