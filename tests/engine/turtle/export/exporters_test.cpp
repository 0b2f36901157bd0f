#include "engine/turtle/export/exporters.h"

#include <array>
#include <cmath>
#include <cstdlib>
#include <set>
#include <sstream>

#include "engine/turtle/export/mesh/obj.h"
#include "engine/turtle/export/palette.h"
#include "engine/turtle/export/picture/projection.h"
#include "engine/turtle/export/picture/svg.h"
#include "tests/engine/turtle/turtle_fixture.h"

namespace espalier::turtle::exporters_test {
namespace {

constexpr const char* kExportedPlant =
    "!(0.4)F(2)[+(40)!(0.2)F(1)@O(0.5)]-(20)!(0.3)F(1)&(30)F(1){.+(30)f.+(60)f.+(60)f.}@c(0.6)@o(0.3){(1)f+(20)f}(1)~p";

files::ViewSettings exportedView() {
  files::ViewSettings view;
  view.lineStyle = files::LineStyle::Cylinder;
  files::Surface surface;
  surface.id = 'p';
  surface.subdivisionS = 2;
  surface.subdivisionT = 3;
  files::SurfacePatch patch;
  for (std::size_t i = 0; i < 16; ++i) {
    patch.points[i] = {static_cast<double>(i % 4) / 3.0, static_cast<double>(i / 4) / 3.0, 0.0};
  }
  surface.patches.push_back(patch);
  view.surfaces.push_back(surface);
  return view;
}

std::string svgOf(const Scene& scene, const files::ViewSettings& view, const SvgOptions& options = {}) {
  core::StringSink sink;
  writeSvg(scene, view, options, sink);
  return sink.take();
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
    ++found;
  }
  return found;
}

struct WrittenObj {
  core::StringSink object;
  core::StringSink materials;
};

// an OBJ without a name has no companion
void writeObj(const Scene& scene, const files::ViewSettings& view, const std::string& fileName, WrittenObj& written) {
  ExportTarget target{.fileName = fileName, .sink = written.object, .openCompanion = {}, .progress = {}};
  if (!fileName.empty()) {
    target.openCompanion = [&written](const std::string&) -> core::ByteSink& { return written.materials; };
  }
  EXPECT_EQ(findExportFormat("obj")->write({.scene = scene, .view = view}, target), std::nullopt);
}

// the content of an OBJ file for its reader
struct ObjContent {
  std::vector<core::Vec3> vertices, normals;
  std::size_t coordinateCount = 0;
  std::vector<std::vector<std::array<long, 3>>> faces;
  std::set<std::string> objects, materials;
  std::string library;
};

ObjContent parseObj(const std::string& text) {
  ObjContent content;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string keyword;
    words >> keyword;
    core::Vec3 v;
    if (keyword == "v" || keyword == "vn") {
      words >> v.x >> v.y >> v.z;
      EXPECT_FALSE(words.fail()) << line;
      (keyword == "v" ? content.vertices : content.normals).push_back(v);
    } else if (keyword == "vt") {
      ++content.coordinateCount;
    } else if (keyword == "f") {
      content.faces.emplace_back();
      for (std::string corner; words >> corner;) {
        std::array<long, 3> indices{};
        EXPECT_EQ(std::sscanf(corner.c_str(), "%ld/%ld/%ld", &indices[0], &indices[1], &indices[2]), 3) << line;
        content.faces.back().push_back(indices);
      }
    } else if (keyword == "o") {
      std::string name;
      words >> name;
      content.objects.insert(name);
    } else if (keyword == "usemtl") {
      std::string name;
      words >> name;
      content.materials.insert(name);
    } else if (keyword == "mtllib") {
      words >> content.library;
    }
  }
  return content;
}

TEST(Exporters, FormatsAreFoundByNameAndBySuffixInAnyCase) {
  for (const ExportFormat& format : exportFormats()) {
    EXPECT_EQ(findExportFormat(format.name), &format);
    EXPECT_EQ(findExportFormatOfFile("a.b" + std::string(format.suffix)), &format);
    EXPECT_TRUE(format.suffix.starts_with('.'));
    EXPECT_FALSE(format.summary.empty());
  }
  EXPECT_EQ(findExportFormatOfFile("TREE.OBJ"), findExportFormat("obj"));
  EXPECT_EQ(findExportFormatOfFile("tree"), nullptr);
  EXPECT_EQ(findExportFormat("OBJ"), nullptr);
}

TEST(Exporters, ASuffixIsReplacedOrAdded) {
  EXPECT_EQ(withSuffix("tree.obj", ".mtl"), "tree.mtl");
  EXPECT_EQ(withSuffix("a.tree.obj", ".mtl"), "a.tree.mtl");
  EXPECT_EQ(withSuffix("tree", ".mtl"), "tree.mtl");
  EXPECT_EQ(withSuffix(".tree", ".mtl"), ".tree.mtl");
}

TEST(Svg, EveryOrganIsPainted) {
  TurtleRun run(kExportedPlant, exportedView());
  run.draw();
  const std::string svg = svgOf(run.scene, run.program.view);
  EXPECT_TRUE(svg.starts_with("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg "));
  EXPECT_TRUE(svg.ends_with("</svg>\n"));
  EXPECT_EQ(count(svg, "<radialGradient"), 1U);
  EXPECT_EQ(count(svg, "<circle"), 2U);                              // a sphere and a disc on the screen
  EXPECT_GE(count(svg, "stroke-width=\"0.4\""), 1U + 1U + 6U + 8U);  // polygon, disc, 2x3 quads, cylinder
  EXPECT_EQ(count(svg, "nan"), 0U);
  EXPECT_EQ(count(svg, "inf"), 0U);
}

TEST(Svg, TheViewBoxIsTheDrawingWithItsMargin) {
  // a line of length 10 upward: the height of 100 less margins of a tenth of the larger side, 20 each
  files::ViewSettings view;
  view.isLineStyleGiven = true;
  TurtleRun run("F(4)F(6)", view);
  run.draw();
  const std::string svg = svgOf(run.scene, view, {.widthPixels = 200, .heightPixels = 100, .marginFraction = 0.1});
  EXPECT_NE(svg.find("width=\"40\" height=\"100\" viewBox=\"0 0 40 100\""), std::string::npos) << svg;
  // one stroke of width 1 through the joint at 4/10 of the length
  EXPECT_NE(svg.find("stroke-width=\"1\" stroke-linecap=\"round\" stroke-linejoin=\"round\" "
                     "d=\"M20 80L20 56L20 20\"/>"),
            std::string::npos)
      << svg;
}

TEST(Svg, EveryBranchOrderIsOnePath) {
  files::ViewSettings view;
  TurtleRun run("F[+F[+F]F]F[-F[-F]]F", view);
  run.draw();
  const std::string svg = svgOf(run.scene, view);
  for (const char* const order : {"order-0", "order-1", "order-2"}) {
    EXPECT_EQ(count(svg, std::string("class=\"") + order + "\""), 1U);
  }
  EXPECT_EQ(count(svg, "<path"), 3U);
  // three axes of order 0 to 2: F F F; F F, F; F, F begin 1, 2 and 2 strokes
  EXPECT_EQ(count(svg, "M"), 5U);
  EXPECT_EQ(count(svg, "L"), 8U);
}

TEST(Svg, LinesThatTaperAreOutlines) {
  files::ViewSettings view;
  view.lineStyle = files::LineStyle::Cylinder;
  TurtleRun run("!(2)F(10)!(1)F(10)", view);
  run.draw();
  const std::string svg = svgOf(run.scene, view);
  EXPECT_EQ(count(svg, "<path"), 1U);
  EXPECT_EQ(count(svg, "fill=\"none\""), 0U);
  // two outlines of two arcs each
  EXPECT_EQ(count(svg, "A"), 4U);
  EXPECT_EQ(count(svg, "Z"), 2U);
}

TEST(Svg, TheBackgroundCanBeLeftOut) {
  TurtleRun run("F");
  run.draw();
  EXPECT_EQ(count(svgOf(run.scene, {}), "<rect"), 1U);
  EXPECT_EQ(count(svgOf(run.scene, {}, {.hasBackground = false}), "<rect"), 0U);
}

TEST(Svg, AnEmptySceneIsAnEmptyPage) {
  const std::string svg = svgOf(Scene{}, {});
  EXPECT_TRUE(svg.ends_with("</svg>\n"));
  EXPECT_EQ(count(svg, "<path"), 0U);
}

TEST(Svg, FartherOrgansArePaintedFirst) {
  // the default view looks along -z: the second disc is nearer and comes last although it was drawn first
  TurtleRun run("@M(0,0,5);(0)@o(1)@M(1,0,-5);(255)@o(1)");
  run.draw();
  const std::string svg = svgOf(run.scene, {}, {.hasBackground = false});
  const std::size_t first = svg.find("<circle cx=\"");
  const std::size_t second = svg.find("<circle cx=\"", first + 1);
  ASSERT_NE(second, std::string::npos);
  // x = 1 is on the right
  EXPECT_GT(std::strtod(svg.c_str() + first + 12, nullptr), std::strtod(svg.c_str() + second + 12, nullptr));
}

TEST(Svg, LabelsAreEscaped) {
  TurtleRun run("@L(0)F");
  run.program.strings.push_back("a<b & \"c\">");
  run.draw();
  EXPECT_NE(svgOf(run.scene, {}).find(">a&lt;b &amp; \"c\"&gt;</text>"), std::string::npos);
}

TEST(Svg, IsDeterministic) {
  TurtleRun run(kExportedPlant, exportedView());
  run.draw();
  EXPECT_EQ(svgOf(run.scene, run.program.view), svgOf(run.scene, run.program.view));
}

TEST(Projection, LooksAlongMinusZByDefault) {
  const ProjectedPoint p = Projection({}).project({2, 3, 0.25});
  EXPECT_DOUBLE_EQ(p.x, 2.0);
  EXPECT_DOUBLE_EQ(p.y, 3.0);
  EXPECT_DOUBLE_EQ(p.depth, 0.75);
}

TEST(Projection, PerspectiveMakesNearThingsLarger) {
  files::ViewSettings view;
  view.isPerspective = true;
  view.viewpoint = {10, 0, 0};
  const Projection projection(view);
  // seen from +x the z axis points left; half way to the viewer everything is twice as large
  EXPECT_NEAR(projection.project({0, 1, 1}).x, -1.0, 1e-12);
  EXPECT_NEAR(projection.project({5, 1, 0}).y, 2.0, 1e-12);
  EXPECT_FALSE(projection.isVisible({11, 0, 0}));
}

TEST(Projection, LookingDownHasMinusZUp) {
  files::ViewSettings view;
  view.viewpoint = {0, 7, 0};
  const ProjectedPoint p = Projection(view).project({1, 0, -2});
  EXPECT_NEAR(p.x, 1.0, 1e-12);
  EXPECT_NEAR(p.y, 2.0, 1e-12);
}

TEST(Obj, IndicesAreValidNormalsUnitAndOrgansNamed) {
  TurtleRun run(kExportedPlant, exportedView());
  run.draw();
  WrittenObj written;
  writeObj(run.scene, run.program.view, "plant.obj", written);
  const ObjContent content = parseObj(written.object.text());
  EXPECT_EQ(content.library, "plant.mtl");
  EXPECT_EQ(content.objects, (std::set<std::string>{"plant_0_balls", "plant_0_branches", "plant_0_cylinders",
                                                    "plant_0_polygons", "plant_0_surfaces"}));
  ASSERT_FALSE(content.faces.empty());
  EXPECT_EQ(content.coordinateCount, content.vertices.size());
  EXPECT_EQ(content.normals.size(), content.vertices.size());
  for (const auto& face : content.faces) {
    EXPECT_GE(face.size(), 3U);
    for (const auto& corner : face) {
      for (const long index : corner) {
        ASSERT_GE(index, 1);
        ASSERT_LE(index, static_cast<long>(content.vertices.size()));
      }
    }
  }
  for (const core::Vec3& normal : content.normals) {
    EXPECT_NEAR(core::length(normal), 1.0, 1e-4);
  }
  for (const std::string& material : content.materials) {
    EXPECT_NE(written.materials.text().find("newmtl " + material + "\n"), std::string::npos);
  }
}

TEST(Obj, AStraightTubeHasItsRadiusAndSharesTheRingAtTheJoint) {
  files::ViewSettings view;
  view.lineStyle = files::LineStyle::Cylinder;
  view.contourSides = 6;
  TurtleRun run("!(2)F(3)F(4)", view);
  run.draw();
  WrittenObj written;
  writeObj(run.scene, view, "", written);
  const ObjContent content = parseObj(written.object.text());
  // three rings of 7 vertices, two ends of 6
  EXPECT_EQ(content.vertices.size(), 3U * 7U + 2U * 6U);
  EXPECT_EQ(content.faces.size(), 2U * 6U + 2U * 4U);
  for (std::size_t i = 0; i < 21; ++i) {
    EXPECT_NEAR(std::hypot(content.vertices[i].x, content.vertices[i].z), 1.0, 1e-5);
    EXPECT_NEAR(content.vertices[i].y, (i < 7 ? 0.0 : i < 14 ? 3.0 : 7.0), 1e-6);
  }
  EXPECT_EQ(content.library, "");
}

TEST(Obj, FacesLookOutward) {
  files::ViewSettings view;
  view.lineStyle = files::LineStyle::Cylinder;
  TurtleRun run("!(1)F(2)@M(5,0)@O(2)", view);
  run.draw();
  WrittenObj written;
  writeObj(run.scene, view, "x.obj", written);
  const ObjContent content = parseObj(written.object.text());
  for (const auto& face : content.faces) {
    const auto at = [&](std::size_t k) { return content.vertices[static_cast<std::size_t>(face[k][0] - 1)]; };
    const core::Vec3 normal = core::cross(at(1) - at(0), at(2) - at(0)) +
                              (face.size() > 3 ? core::cross(at(2) - at(0), at(3) - at(0)) : core::Vec3{});
    const core::Vec3 stored = content.normals[static_cast<std::size_t>(face[0][2] - 1)];
    if (core::length(normal) > 1e-9) {
      EXPECT_GT(core::dot(normal, stored), 0.0);
    }
  }
}

TEST(Palette, ColourIndicesWrapAndNeighboursAreClose) {
  const Colour a = defaultColour(7);
  const Colour b = defaultColour(7 + 256);
  EXPECT_EQ(a.red, b.red);
  EXPECT_EQ(a.green, b.green);
  EXPECT_EQ(defaultColour(-1).blue, defaultColour(255).blue);
}

TEST(Palette, ASceneThatSaysNothingAboutColourGoesFromBrownToGreen) {
  TurtleRun plain("F[+F[+F]]");
  plain.draw();
  const Palette palette(plain.scene, {});
  const Colour trunk = palette.ofSegment(plain.scene.segments[0]);
  const Colour twig = palette.ofSegment(plain.scene.segments[2]);
  EXPECT_GT(trunk.red, trunk.green);
  EXPECT_GT(twig.green, twig.red);
  TurtleRun coloured("F;(200)F");
  coloured.draw();
  EXPECT_EQ(Palette(coloured.scene, {}).ofSegment(coloured.scene.segments[1]).red, defaultColour(200).red);
}

TEST(Palette, AFoldersColoursReplaceTheRamp) {
  Scene scene;
  scene.segments.push_back({});
  files::Palette colours;
  EXPECT_FALSE(Palette(scene, {}, &colours).folderMaterial(128));
  EXPECT_EQ(Palette(scene, {}, &colours).materialOf(scene.segments[0]),
            Palette(scene, {}).materialOf(scene.segments[0]))
      << "an empty palette is none";

  colours.maps[1][128] = {10, 20, 30};
  colours.maps[1][0] = {1, 2, 3};
  const Palette mapped(scene, {}, &colours);
  EXPECT_EQ(mapped.materialOf(scene.segments[0]), 128);
  const Colour colour = mapped.ofSegment(scene.segments[0]);
  EXPECT_EQ((std::array{colour.red, colour.green, colour.blue}), (std::array<unsigned char, 3>{10, 20, 30}));
  EXPECT_EQ(mapped.background().blue, 3);
  EXPECT_EQ(mapped.opacityOfIndex(128), 1.0);

  colours.materials[1][128].opacity = 0.25;
  colours.usesMaterials = true;
  const Palette material(scene, {}, &colours);
  EXPECT_EQ(material.opacityOfIndex(128), 0.25);
  EXPECT_EQ(material.ofIndex(128).red, 255) << "a material's diffuse colour is white unless the file says otherwise";
}

}  // namespace
}  // namespace espalier::turtle::exporters_test
