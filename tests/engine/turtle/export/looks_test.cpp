// The looks that pictures and meshes add to a model without them: widths, colours, and the ground below a plant.

#include <algorithm>
#include <cmath>
#include <string>

#include "engine/core/streams.h"
#include "engine/turtle/export/exporters.h"
#include "engine/turtle/export/ground_contact.h"
#include "engine/turtle/export/line_look.h"
#include "engine/turtle/export/palette.h"
#include "engine/turtle/export/picture/picture.h"
#include "tests/engine/turtle/turtle_fixture.h"

namespace espalier::turtle::looks_test {
namespace {

Scene drawn(const std::string& string, const files::ViewSettings& view = {}) {
  TurtleRun run(string, view);
  run.draw();
  return run.scene;
}

TEST(LineLook, AModelWithoutAViewFileHasRoundLinesOfAFixedPartOfItsSize) {
  // an upright axis of 10 with a short branch: the extent is the diagonal of 10 by 1
  const Scene scene = drawn("F(5)[+(90)F(1)]F(5)");
  const LineLook look = lineLookOf(scene, {});
  EXPECT_EQ(look.style, files::LineStyle::Cylinder);
  const double extent = std::hypot(10.0, 1.0);
  EXPECT_NEAR(look.startWidth(scene.segments[0]), extent / 75.0, 1e-12);
  EXPECT_NEAR(look.startWidth(scene.segments[1]), extent / 75.0 / std::sqrt(2.0), 1e-12) << "a branch is thinner";
  // the same plant a thousand times as large looks the same
  const Scene large = drawn("F(5000)[+(90)F(1000)]F(5000)");
  EXPECT_NEAR(lineLookOf(large, {}).startWidth(large.segments[0]), 1000.0 * extent / 75.0, 1e-9);
}

TEST(LineLook, ShortLinesAreThinSoThatDenseDrawingsStayClear) {
  std::string curve;
  for (int i = 0; i < 200; ++i) {
    curve += i % 2 == 0 ? "F(1)+(90)" : "F(1)-(90)";
  }
  const Scene scene = drawn(curve);
  const LineLook look = lineLookOf(scene, {});
  EXPECT_NEAR(look.startWidth(scene.segments[0]), 0.35, 1e-12) << "a part of the mean length, which is 1";
  EXPECT_EQ(look.startWidth(scene.segments[0]), look.endWidth(scene.segments[100]));
}

TEST(LineLook, WidthsOfTheModelKeepTheirProportions) {
  const Scene scene = drawn("!(0.4)F(5)[+(60)!(0.1)F(3)]");
  const LineLook look = lineLookOf(scene, {});
  EXPECT_EQ(look.style, files::LineStyle::Cylinder);
  EXPECT_NEAR(look.endWidth(scene.segments[1]) / look.startWidth(scene.segments[0]), 0.25, 1e-12);
}

TEST(LineLook, AViewFileDecides) {
  files::ViewSettings view;
  view.isLineStyleGiven = true;
  const Scene pixels = drawn("F(5)", view);
  EXPECT_EQ(lineLookOf(pixels, view).style, files::LineStyle::Pixel);
  EXPECT_EQ(lineLookOf(pixels, view).startWidth(pixels.segments[0]), 1.0);
  EXPECT_NEAR(meshLineLookOf(pixels, view).startWidth(pixels.segments[0]), 5.0 / 800.0, 1e-12);
  view.lineStyle = files::LineStyle::Polygon;
  const Scene strips = drawn("!(0.3)F(5)", view);
  EXPECT_EQ(lineLookOf(strips, view).style, files::LineStyle::Polygon);
  EXPECT_EQ(lineLookOf(strips, view).startWidth(strips.segments[0]), 0.3);
}

TEST(LineLook, TablesHaveTheWidthsOfTheModel) {
  TurtleRun run("F(5)[+(60)F(3)]");
  run.draw();
  EXPECT_EQ(run.scene.segments[1].startWidth, 1.0);
  EXPECT_EQ(run.scene.lineStyle, files::LineStyle::Pixel);
  EXPECT_EQ(run.records.back().width, 1.0);
}

TEST(Palette, APlantWithoutColoursIsBrownBesideOneThatHasColours) {
  Scene scene = drawn("F[+F];(40)F");
  const std::size_t count = scene.segments.size();
  for (Segment& segment : scene.segments) {
    segment.plant = 3;
  }
  const Scene plain = drawn("F[+F]");
  scene.segments.append(plain.segments.view());
  const Palette palette(scene, {});
  const auto isDefault = [&](const Segment& segment) {
    const Colour colour = palette.ofSegment(segment);
    const Colour green = defaultColour(128);
    return colour.red == green.red && colour.green == green.green && colour.blue == green.blue;
  };
  EXPECT_TRUE(isDefault(scene.segments[0])) << "the plant uses the ramp of colours";
  EXPECT_FALSE(isDefault(scene.segments[count]));
  EXPECT_GT(palette.ofSegment(scene.segments[count]).red, palette.ofSegment(scene.segments[count]).green);
}

TEST(Palette, WoodOfAPlantWithLeavesIsBrownAndTheLeavesAreGreen) {
  const Scene scene = drawn("F[+F[+F[+F{.f+f+f}]]]");
  const Palette palette(scene, {});
  for (const Segment& segment : scene.segments) {
    EXPECT_GT(palette.ofSegment(segment).red, palette.ofSegment(segment).green) << segment.branchOrder;
  }
  EXPECT_GT(palette.ofIndex(scene.polygons[0].colour).green, palette.ofIndex(scene.polygons[0].colour).red);
}

TEST(Palette, AColourMapEntryChangesThatColourOnly) {
  files::ViewSettings view;
  view.colourEntries[0] = {1, 2, 3};
  view.colourEntries[7] = {200, 0, 0};
  const Scene scene = drawn("F[+F[+F]]");
  const Palette palette(scene, view);
  const Palette without(scene, {});
  EXPECT_EQ(palette.background().blue, 3);
  EXPECT_EQ(palette.ofIndex(7).red, 200);
  EXPECT_EQ(palette.ofIndex(100).red, without.ofIndex(100).red);
  EXPECT_EQ(palette.ofSegment(scene.segments[2]).green, without.ofSegment(scene.segments[2]).green);
  // the colour of the lines themselves counts
  view.colourEntries[128] = {9, 9, 9};
  EXPECT_EQ(Palette(scene, view).ofSegment(scene.segments[2]).green, 9);
}

TEST(Palette, TheFoldersColoursWinOverEntries) {
  files::ViewSettings view;
  view.colourEntries[7] = {200, 0, 0};
  files::Palette folder;
  folder.maps[1][7] = {0, 100, 0};
  EXPECT_EQ(Palette({}, view, &folder).ofIndex(7).green, 100);
  EXPECT_EQ(paletteOf(view, folder).colour(7).green, 100);
  EXPECT_TRUE(paletteOf({}, {}).empty());
}

TEST(Palette, ModelsOfAForestHaveTheirOwnBlocks) {
  files::Palette folder;
  folder.maps[1][7] = {0, 100, 0};
  folder.maps[17][7] = {90, 0, 0};  // of the second model
  const Palette palette({}, {}, &folder);
  EXPECT_EQ(palette.ofIndex(7).green, 100);
  EXPECT_EQ(palette.ofIndex(7 + 16 * 256).red, 90);
  EXPECT_EQ(palette.ofIndex(7 + 256).green, 100) << "a block that nobody has is the first one";
  EXPECT_EQ(palette.ofIndex(7 - 256).green, 100);
  Segment segment;
  segment.colour = 7 + 16 * 256;
  EXPECT_EQ(palette.ofSegment(segment).red, 90);
  EXPECT_NE(palette.materialOf(segment), palette.numberOf(7));
}

TEST(GroundContact, APlantThatStandsHasOneAtItsFoot) {
  const auto contacts = groundContactsOf(drawn("F(2)[+(45)F(1)][-(45)F(1)]"));
  ASSERT_EQ(contacts.size(), 1U);
  EXPECT_EQ(contacts[0].place, (core::Vec3{0, 0, 0}));
  EXPECT_NEAR(contacts[0].radius, 0.55 * std::sqrt(0.5), 1e-12);
}

TEST(GroundContact, EveryStemOfAStandHasItsOwn) {
  // one string with two plants, the second with an organ only, and a twig behind a gap high in the first
  const auto contacts = groundContactsOf(drawn("[F(2)[+(45)F(1)][-(45)F(1)]][@M(5,0,1)F(2)@O(1)]"));
  ASSERT_EQ(contacts.size(), 2U);
  EXPECT_EQ(contacts[1].place, (core::Vec3{5, 0, 1}));
  EXPECT_NEAR(contacts[1].radius, 0.2, 1e-12) << "a tenth of its height";
  EXPECT_EQ(groundContactsOf(drawn("F(2)[+(45)F(1)][@M(0,1.5,0)F(1)[+F(1)]]")).size(), 1U);
}

TEST(GroundContact, CurvesRootsAndCreepersHaveNone) {
  EXPECT_TRUE(groundContactsOf(drawn("F+(60)F-(120)F+(60)F")).empty()) << "a curve";
  EXPECT_TRUE(groundContactsOf(drawn("F(1)[+(180)F(3)]")).empty()) << "more than half is below the foot";
  EXPECT_TRUE(groundContactsOf(drawn("+(90)F(5)[+(20)F(1)]")).empty()) << "it lies";
  EXPECT_TRUE(groundContactsOf({}).empty());
}

TEST(GroundContact, IsAShadeOnThePageOfTheModelOnly) {
  const Scene scene = drawn("F(2)[+(45)F(1)][-(45)F(1)]");
  const auto darkest = [&scene](PictureOptions options) {
    options.widthPixels = 120;
    options.heightPixels = 120;
    const PictureImage image = renderPicture(scene, {}, options);
    // beside the foot of the stem, at the bottom
    int least = 255;
    for (int y = 108; y < 119; ++y) {
      const std::size_t at = (static_cast<std::size_t>(y) * 120 + 68) * 4;
      least = std::min<int>(least, image.pixels[at]);
    }
    return least;
  };
  EXPECT_LT(darkest({}), 240);
  EXPECT_EQ(darkest({.hasGround = false}), 250);
  EXPECT_EQ(darkest({.background = PictureBackground::White}), 255);
}

TEST(MeshMaterials, AnObjNamesTheHolesOfItsPictures) {
  files::ViewSettings view;
  files::Surface surface;
  surface.id = 'p';
  files::SurfacePatch patch;
  for (std::size_t i = 0; i < 16; ++i) {
    patch.points[i] = {static_cast<double>(i % 4), static_cast<double>(i / 4), 0.0};
  }
  surface.patches.push_back(patch);
  view.surfaces.push_back(surface);
  files::Texture texture;
  texture.bytes = std::make_shared<const std::string>("P6");
  texture.image = std::make_shared<const files::Image>(files::Image{2, 1, {255, 255, 255, 255, 255, 255, 255, 0}});
  view.textures.push_back(texture);
  TurtleRun run("@Tx(1)~p", view);
  run.draw();
  core::StringSink obj;
  core::StringSink materials;
  core::StringSink picture;
  const ExportTarget target{.fileName = "a.obj",
                            .sink = obj,
                            .openCompanion = [&](const std::string& name) -> core::ByteSink& {
                              return name.ends_with(".mtl") ? static_cast<core::ByteSink&>(materials) : picture;
                            },
                            .progress = {}};
  ASSERT_EQ(findExportFormat("obj")->write({.scene = run.scene, .view = run.program.view}, target), std::nullopt);
  EXPECT_NE(materials.text().find("newmtl leaf\n"), std::string::npos);
  EXPECT_NE(materials.text().find("map_Kd a_texture_1.png\nmap_d a_texture_1.png\n"), std::string::npos)
      << materials.text();
}

}  // namespace
}  // namespace espalier::turtle::looks_test
