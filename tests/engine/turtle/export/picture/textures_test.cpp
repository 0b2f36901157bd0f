#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "engine/turtle/export/mesh/placed_meshes.h"
#include "engine/turtle/export/picture/page_drawing.h"
#include "engine/turtle/export/picture/picture.h"
#include "engine/turtle/export/picture/projection.h"
#include "engine/turtle/export/picture/raster_texture.h"
#include "tests/engine/turtle/textured_view.h"
#include "tests/engine/turtle/turtle_fixture.h"

namespace espalier::turtle::textures_test {
namespace {

using nlohmann::json;
using Use = files::Texture::Use;

// the materials that the parts of a string's scene wear, in order
std::vector<std::string> wornBy(const std::string& string, const files::ViewSettings& view) {
  TurtleRun run(string, view);
  run.draw();
  const ExportInput input{.scene = run.scene, .view = run.program.view};
  MaterialTable table;
  core::WorkerTeam team(2);
  const SceneMeshes meshes(input, table, team);
  std::vector<std::string> names;
  for (const MeshPart& part : meshes.parts()) {
    names.push_back(table.materials()[part.material].name);
  }
  return names;
}

std::array<int, 3> colourAt(const PictureImage& image, double x, double y) {
  const auto column = static_cast<std::size_t>(x * image.width);
  const auto row = static_cast<std::size_t>(y * image.height);
  const std::size_t at = (row * static_cast<std::size_t>(image.width) + column) * 4;
  return {image.pixels[at], image.pixels[at + 1], image.pixels[at + 2]};
}

PictureImage pictureOf(const std::string& string, files::ViewSettings view) {
  view.renderMode = files::RenderMode::Filled;  // plain colours
  TurtleRun run(string, view);
  run.draw();
  return renderPicture(run.scene, run.program.view, {.widthPixels = 100, .heightPixels = 100, .marginFraction = 0.0});
}

TEST(Textures, TheTurtlesTextureIsOnLinesCylindersSurfacesAndPatches) {
  using Names = std::vector<std::string>;
  const files::ViewSettings view = texturedView();
  EXPECT_EQ(wornBy(";(3)F@Tx(1)F@Tx(0)F", view), (Names{"bark", "bark_3", "bark"}));
  EXPECT_EQ(wornBy(";(3)@Tx(1)~p[@Tx(0)~p]", view), (Names{"leaf_3", "leaf"}));
  EXPECT_EQ(wornBy(";(3)@Tx(1){(1)f}(1)", view), Names{"bark"});
  // polygons, spheres and discs have no place for one in the language
  EXPECT_EQ(wornBy(";(3)@Tx(1){.f.+f.}@O@c", view), (Names{"leaf", "fruit", "fruit"}));
  EXPECT_EQ(wornBy(";(3)@Tx(2)F", view), Names{"bark"}) << "there is one texture";
}

TEST(Textures, ASurfaceMayHaveItsOwnOrNone) {
  files::ViewSettings view = texturedView();
  view.surfaces[0].texture = 1;
  EXPECT_EQ(wornBy(";(3)~p", view), std::vector<std::string>{"leaf"});
  view.surfaces[0].texture = 0;
  EXPECT_EQ(wornBy(";(3)@Tx(1)~p", view), std::vector<std::string>{"leaf"});
}

TEST(Textures, OnATubeOnePictureIsAsHighAsTheCircumferenceTimesItsRatio) {
  files::ViewSettings view = texturedView();
  view.textures[0].ratio = 2.0;
  TurtleRun run("@Tx(1)!(0.5)F(3)F(1)", view);
  run.draw();
  const ExportInput input{.scene = run.scene, .view = run.program.view};
  MaterialTable table;
  core::WorkerTeam team(2);
  const SceneMeshes meshes(input, table, team);
  ASSERT_EQ(meshes.parts().size(), 1U);
  Mesh mesh;
  meshes.make(meshes.parts()[0], mesh);
  double high = 0.0;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    high = std::max(high, mesh.coordinates[i][1]);
  }
  EXPECT_NEAR(high, 4.0 / (std::numbers::pi * 0.5) / 2.0, 1e-12);
}

TEST(Textures, PerSurfaceTheyGoOnceOverAllPatches) {
  files::ViewSettings view = texturedView();
  // a second patch beside the first
  files::SurfacePatch beside = view.surfaces[0].patches[0];
  for (core::Vec3& point : beside.points) {
    point.x += 1.0;
  }
  view.surfaces[0].patches.push_back(beside);
  const auto largestAt = [&](double x) {
    TurtleRun run("@Tx(1)~p", view);
    run.draw();
    const ExportInput input{.scene = run.scene, .view = run.program.view};
    MaterialTable table;
    core::WorkerTeam team(2);
    const SceneMeshes meshes(input, table, team);
    Mesh mesh = meshes.sharedMeshes()[meshes.sharedMeshOf(meshes.parts()[0])];
    double u = 0.0;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      u = std::abs(mesh.positions[i].x - x) < 1e-9 ? std::max(u, mesh.coordinates[i][0]) : u;
    }
    return u;
  };
  EXPECT_NEAR(largestAt(1.0), 1.0, 1e-12) << "each patch has the whole picture";
  view.textures[0].isPerSurface = true;
  EXPECT_NEAR(largestAt(1.0), 0.5, 1e-12);
  EXPECT_NEAR(largestAt(2.0), 1.0, 1e-12);
}

TEST(Textures, InGlbThePictureIsInsideAndTheMaterialNamesIt) {
  files::ViewSettings view = texturedView();
  view.textures[0].isSmoothNear = true;
  view.textures[0].minification = "mll";
  TurtleRun run(";(3)@Tx(1)F~p", view);
  run.draw();
  core::StringSink sink;
  ASSERT_EQ(findExportFormat("glb")->write({.scene = run.scene, .view = run.program.view},
                                           {.fileName = "a", .sink = sink, .openCompanion = {}, .progress = {}}),
            std::nullopt);
  const std::string bytes = sink.take();
  const std::size_t jsonBytes =
      static_cast<unsigned char>(bytes[12]) | static_cast<std::size_t>(static_cast<unsigned char>(bytes[13])) << 8U;
  const json text = json::parse(bytes.substr(20, jsonBytes));
  ASSERT_EQ(text["materials"].size(), 2U);
  EXPECT_EQ(text["materials"][0]["name"], "bark");
  EXPECT_EQ(text["materials"][1]["name"], "leaf");
  EXPECT_EQ(text["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"], 0);
  EXPECT_EQ(text["textures"][0]["source"], 0);
  EXPECT_EQ(text["samplers"][0], (json{{"magFilter", 9729}, {"minFilter", 9987}}));
  EXPECT_EQ(text["images"][0]["mimeType"], "image/png");
  const json& place = text["bufferViews"][text["images"][0]["bufferView"].get<std::size_t>()];
  EXPECT_EQ(
      bytes.substr(28 + jsonBytes + place["byteOffset"].get<std::size_t>(), place["byteLength"].get<std::size_t>()),
      *view.textures[0].bytes);
}

TEST(Textures, BesideObjAndUsdaThePictureIsAFileThatTheyName) {
  for (const std::string format : {"obj", "usda"}) {
    TurtleRun run(";(3)@Tx(1)F", texturedView());
    run.draw();
    core::StringSink sink;
    std::map<std::string, core::StringSink> companions;
    const ExportTarget target{
        .fileName = "tree." + format,
        .sink = sink,
        .openCompanion = [&](const std::string& name) -> core::ByteSink& { return companions[name]; },
        .progress = {}};
    ASSERT_EQ(findExportFormat(format)->write({.scene = run.scene, .view = run.program.view}, target), std::nullopt);
    EXPECT_EQ(companions["tree_texture_1.png"].text(), *run.program.view.textures[0].bytes) << format;
    const std::string named = format == "obj" ? companions["tree.mtl"].text() : sink.text();
    EXPECT_NE(
        named.find(format == "obj" ? "map_Kd tree_texture_1.png\n" : "asset inputs:file = @./tree_texture_1.png@\n"),
        std::string::npos)
        << named;
  }
}

TEST(Textures, DrawingsHaveTheMeanColourOfEachFace) {
  // the square seen from its front, cut into one face, which has the mean of red, green, blue and white; into four
  files::ViewSettings view = texturedView();
  view.textures[0].use = Use::Decal;
  const auto colours = [&view](std::string_view text, std::int32_t subdivision) {
    view.surfaces[0].subdivisionS = subdivision;
    view.surfaces[0].subdivisionT = subdivision;
    TurtleRun run(text, view);
    run.draw();
    const Palette palette(run.scene, {});
    const PageDrawing drawing(run.scene, run.program.view, palette, 100, 100, 0.0);
    std::vector<std::array<int, 3>> found;
    for (const PageShape& shape : drawing.shapes()) {
      found.push_back({shape.colour.red, shape.colour.green, shape.colour.blue});
    }
    for (const PageLines& lines : drawing.lines()) {
      found.push_back({lines.colour.red, lines.colour.green, lines.colour.blue});
    }
    return found;
  };
  // lines are not lit: the mean is (255 + 0 + 0 + 255) / 4 for each component
  const auto line = colours("@Tx(1)F", 1);
  ASSERT_EQ(line.size(), 1U);
  for (const int component : line[0]) {
    EXPECT_NEAR(component, 128, 1);
  }
  const auto whole = colours("@Tx(1)~p", 1);
  ASSERT_EQ(whole.size(), 1U);
  EXPECT_NEAR(whole[0][0], whole[0][2], 8) << "grey but for the shade";
  const auto quarters = colours("@Tx(1)~p", 2);
  ASSERT_EQ(quarters.size(), 4U);
  EXPECT_EQ(std::ranges::count_if(quarters, [](const auto& c) { return c[0] > 2 * c[1] && c[0] > 2 * c[2]; }), 1);
  EXPECT_EQ(std::ranges::count_if(quarters, [](const auto& c) { return c[1] > 2 * c[0] && c[1] > 2 * c[2]; }), 1);
  EXPECT_EQ(std::ranges::count_if(quarters, [](const auto& c) { return c[2] > 2 * c[0] && c[2] > 2 * c[1]; }), 1);
  // a picture with a hole in its lower half
  auto holed = std::make_shared<files::Image>(*view.textures[0].image);
  holed->pixels[11] = 0;
  holed->pixels[15] = 0;
  view.textures[0].image = holed;
  view.textures[0].use = Use::Modulate;
  EXPECT_EQ(colours("@Tx(1)~p", 2).size(), 2U);
}

TEST(Textures, APictureOfTheSurfaceShowsThePicture) {
  // the square is seen from behind its front: L points to the left, so u runs to the left, v upward
  files::ViewSettings view = texturedView();
  view.textures[0].use = Use::Decal;
  const PictureImage image = pictureOf("@Tx(1)~p", view);
  // within what is between the middle of a point of the picture and the middle of a point of the page
  const auto expectColour = [&image](double x, double y, const std::array<int, 3>& expected) {
    const std::array<int, 3> colour = colourAt(image, x, y);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(colour[k], expected[k], 6) << x << ", " << y;
    }
  };
  expectColour(0.75, 0.25, {255, 0, 0});
  expectColour(0.25, 0.25, {0, 255, 0});
  expectColour(0.75, 0.75, {0, 0, 255});
  expectColour(0.25, 0.75, {255, 255, 255});
}

TEST(Textures, TheColourBelowMultipliesShowsThroughOrIsLightened) {
  const Colour below{100, 50, 200};
  const auto at = [&below](Use use, int red, int opacity) {
    files::Texture texture = fourColours(use);
    texture.image = std::make_shared<const files::Image>(
        files::Image{1, 1, {static_cast<std::uint8_t>(red), 0, 255, static_cast<std::uint8_t>(opacity)}});
    return RasterTexture(texture, below).at(0.5, 0.5, 0);
  };
  // multiplied: the picture alone, the colour comes with the light
  EXPECT_NEAR(at(Use::Modulate, 51, 255)[0], 0.2, 1e-6);
  EXPECT_NEAR(at(Use::Modulate, 51, 100)[3], 100.0 / 255.0, 1e-6) << "a hole below one half";
  // over it, where it is opaque
  EXPECT_NEAR(at(Use::Decal, 255, 255)[0], 1.0, 1e-6);
  EXPECT_NEAR(at(Use::Decal, 255, 0)[0], 100.0 / 255.0, 1e-6);
  EXPECT_EQ(at(Use::Decal, 255, 0)[3], 1.0F);
  // white by its share
  EXPECT_NEAR(at(Use::Blend, 0, 255)[0], 100.0 / 255.0, 1e-6);
  EXPECT_NEAR(at(Use::Blend, 0, 255)[2], 1.0, 1e-6);
}

TEST(Textures, BetweenPointsTheColourIsInterpolatedAndFarAwayItIsTheMean) {
  const RasterTexture texture(fourColours(), {});
  // the middle of the picture is the mean of its four points: (255+0+0+255)/4 in each channel
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(texture.at(0.5, 0.5, 0)[k], 0.5, 1e-6);
    EXPECT_NEAR(texture.at(0.1, 0.9, 1)[k], 0.5, 3e-3);
  }
  EXPECT_NEAR(texture.at(0.25, 0.75, 0)[0], 1.0, 1e-6) << "the middle of the red point";
  EXPECT_NEAR(texture.at(-1.75, 4.75, 0)[0], 1.0, 1e-6) << "repeated";
  EXPECT_EQ(texture.levelOf(1.0, 1.0), 1U) << "four points to a sample";
  EXPECT_EQ(texture.levelOf(1.0, 4.0), 0U);
  EXPECT_EQ(texture.levelOf(1e9, 1.0), 1U);
}

TEST(Textures, HolesOfAPictureAreSeenThrough) {
  files::ViewSettings view = texturedView();
  view.textures[0].image =
      std::make_shared<const files::Image>(files::Image{2, 1, {255, 255, 255, 255, 255, 255, 255, 0}});
  const PictureImage image = pictureOf(";(200)@Tx(1)~p", view);
  const std::array<int, 3> page = colourAt(image, 0.25, 0.5);
  EXPECT_NE(colourAt(image, 0.75, 0.5), page);
  const Colour background = Palette(Scene{}, {}).background();
  EXPECT_EQ(page, (std::array<int, 3>{background.red, background.green, background.blue}));
}

TEST(Textures, InAPerspectiveTheyAreNotBent) {
  // a square that leans away, of two triangles: on the page the middle of the picture is not halfway
  files::ViewSettings view = texturedView();
  view.textures[0].use = Use::Decal;
  view.isPerspective = true;
  view.viewpoint = {-1.5, 1.0, 6.0};
  view.viewReferencePoint = {-1.5, 1.0, 0.0};
  view.surfaces[0].subdivisionS = 1;
  view.surfaces[0].subdivisionT = 1;
  TurtleRun run("&(60)@D(3)@Tx(1)~p", view);
  run.draw();
  const SurfaceInstance& square = run.scene.surfaces[0];
  const Projection projection(view);
  const auto heightOf = [&](double along) {
    return projection.project(square.position + along * 3.0 * square.frame.heading + 1.5 * square.frame.left).y;
  };
  const double expected = (heightOf(1.0) - heightOf(0.5)) / (heightOf(0.5) - heightOf(0.0));
  EXPECT_LT(expected, 0.8) << "the far half is shorter";
  const PictureImage image = pictureOf("&(60)@D(3)@Tx(1)~p", view);
  int far = 0;
  int near = 0;
  for (int y = 0; y < 100; ++y) {
    const std::array<int, 3> colour = colourAt(image, 0.55, (y + 0.5) / 100.0);
    far += colour[0] > 128 && colour[2] < 128 ? 1 : 0;   // red
    near += colour[2] > 128 && colour[0] < 128 ? 1 : 0;  // blue
  }
  EXPECT_NEAR(static_cast<double>(far) / near, expected, 0.06);
}

}  // namespace
}  // namespace espalier::turtle::textures_test
