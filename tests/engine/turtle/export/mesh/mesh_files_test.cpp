// The mesh formats as another library reads them (assimp), and USD by a reader of its own: counts, bounds, sides.

#include <gtest/gtest.h>

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "engine/turtle/export/exporters.h"
#include "engine/turtle/export/mesh/scene_meshes.h"
#include "tests/engine/turtle/turtle_fixture.h"
#include "tests/support/mesh_measures.h"

namespace espalier::turtle::mesh_files_test {
namespace {

using core::Vec3;

constexpr const char* kMeshPlant =
    "!(0.4)F(2)[+(40)!(0.2)F(1)@O(0.5)];(3)-(20)!(0.3)F(1)&(30)/(20)F(1)[{.+(30)f.+(60)f.-(150)f.-(40)f(3).}]"
    "@c(0.6){(1)f+(20)f}(1)~p+(30)~p(2)/(50)@D(0.5)~p(1,-2,3)";

files::ViewSettings meshView() {
  files::ViewSettings view;
  view.lineStyle = files::LineStyle::Cylinder;
  files::Surface surface;
  surface.id = 'p';
  files::SurfacePatch patch;
  for (std::size_t i = 0; i < 16; ++i) {
    const double x = static_cast<double>(i % 4) / 3.0;
    patch.points[i] = {x, static_cast<double>(i / 4) / 3.0, 0.2 * x * x};
  }
  surface.patches.push_back(patch);
  view.surfaces.push_back(surface);
  return view;
}

class MeshFiles : public ::testing::Test {
 protected:
  MeshFiles() : run(kMeshPlant, meshView()) {
    run.draw({.position = {1, 2, 3}, .frame = {}});
    const ExportInput input{.scene = run.scene, .view = run.program.view};
    MaterialTable materials;
    core::WorkerTeam team(2);
    const SceneMeshes meshes(input, materials, team);
    Mesh mesh;
    for (const MeshPart& part : meshes.parts()) {
      meshes.make(part, mesh);
      append(expected, mesh);
    }
  }

  [[nodiscard]] std::string written(const std::string& format) const {
    core::StringSink sink;
    const ExportTarget target{.fileName = "plant", .sink = sink, .openCompanion = {}, .progress = {}};
    const derivation::ModuleString* const string = &run.state.string;
    const ExportInput input{
        .scene = run.scene, .view = run.program.view, .program = &run.program, .strings = {&string, 1}};
    EXPECT_EQ(findExportFormat(format)->write(input, target), std::nullopt);
    return sink.take();
  }

  // the mesh that assimp sees, in world coordinates
  [[nodiscard]] Mesh read(const std::string& format, const std::string& bytes) const {
    Assimp::Importer importer;
    const aiScene* scene = importer.ReadFileFromMemory(
        bytes.data(), bytes.size(), aiProcess_Triangulate | aiProcess_PreTransformVertices, format.c_str());
    Mesh mesh;
    if (scene == nullptr) {
      ADD_FAILURE() << format << ": " << importer.GetErrorString();
      return mesh;
    }
    for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
      const aiMesh& from = *scene->mMeshes[m];
      const auto first = static_cast<std::uint32_t>(mesh.positions.size());
      EXPECT_TRUE(from.HasNormals()) << format;
      for (unsigned i = 0; i < from.mNumVertices; ++i) {
        mesh.positions.push_back({from.mVertices[i].x, from.mVertices[i].y, from.mVertices[i].z});
        mesh.normals.push_back({from.mNormals[i].x, from.mNormals[i].y, from.mNormals[i].z});
        const bool hasCoordinates = from.HasTextureCoords(0);
        mesh.coordinates.push_back(
            {hasCoordinates ? from.mTextureCoords[0][i].x : -1.0, hasCoordinates ? from.mTextureCoords[0][i].y : -1.0});
      }
      for (unsigned i = 0; i < from.mNumFaces; ++i) {
        const aiFace& face = from.mFaces[i];
        if (face.mNumIndices == 3) {
          mesh.faces.push_back(
              {first + face.mIndices[0], first + face.mIndices[1], first + face.mIndices[2], Mesh::kNoVertex});
        }
      }
    }
    return mesh;
  }

  void expectSame(const Mesh& mesh, const std::string& format) const {
    const test::MeshMeasures a = test::measure(mesh);
    const test::MeshMeasures b = test::measure(expected);
    EXPECT_EQ(mesh.faces.size(), expected.triangleCount()) << format;
    EXPECT_NEAR(a.area, b.area, 1e-4 * b.area) << format;
    EXPECT_NEAR(a.signedVolume, b.signedVolume, 1e-3) << format;
    EXPECT_LT(core::length(a.low - b.low), 1e-5) << format;
    EXPECT_LT(core::length(a.high - b.high), 1e-5) << format;
    EXPECT_GT(a.smallestFacing, 0.0) << format << ": normals are on the side from which corners are counter-clockwise";
    EXPECT_LT(a.largestNormalError, 1e-3) << format;
  }

  TurtleRun run;
  Mesh expected;
};

TEST_F(MeshFiles, GlbObjAndPlyAreReadAsTheSameMesh) {
  for (const std::string format : {"glb", "obj", "ply"}) {
    const Mesh mesh = read(format, written(format));
    expectSame(mesh, format);
    double alongMost = 0.0;
    for (const auto& uv : mesh.coordinates) {
      EXPECT_NE(uv[0], -1.0) << format << " has texture coordinates";
      alongMost = std::max(alongMost, uv[1]);
    }
    EXPECT_NEAR(alongMost, 4.0, 1e-5) << format << ": along the axis by its length";
  }
}

TEST_F(MeshFiles, StlIsReadAsTheSameSurface) {
  const std::string bytes = written("stl");
  const Mesh mesh = read("stl", bytes);
  const test::MeshMeasures a = test::measure(mesh);
  const test::MeshMeasures b = test::measure(expected);
  EXPECT_NEAR(a.area, b.area, 1e-4 * b.area);
  EXPECT_NEAR(a.signedVolume, b.signedVolume, 1e-3);
  EXPECT_LT(core::length(a.low - b.low), 1e-5);
  EXPECT_LT(core::length(a.high - b.high), 1e-5);
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, 4);
  EXPECT_EQ(bytes.size(), 84U + 50U * count);
  EXPECT_FALSE(bytes.starts_with("solid")) << "readers take that for the text format";
}

TEST_F(MeshFiles, PlyVerticesKnowWhereTheyComeFrom) {
  const std::string bytes = written("ply");
  const std::size_t begin = bytes.find("end_header\n") + 11;
  ASSERT_NE(bytes.find("comment organs: 0 branches 1 cylinders 2 polygons 3 surfaces 4 patches 5 balls\n"),
            std::string::npos);
  // position, normal, st: 32 bytes; three of colour, organ, order, symbol, plant, module
  constexpr std::size_t kStride = 32 + 3 + 1 + 2 + 2 + 4 + 4;
  const std::size_t count = expected.positions.size();
  ASSERT_NE(bytes.find("element vertex " + std::to_string(count) + "\n"), std::string::npos);
  ASSERT_GT(bytes.size(), begin + count * kStride);
  std::vector<std::uint32_t> modules;
  for (std::size_t i = 0; i < count; ++i) {
    const char* vertex = bytes.data() + begin + i * kStride;
    std::uint32_t module = 0;
    std::uint16_t order = 0;
    std::memcpy(&order, vertex + 36, 2);
    std::memcpy(&module, vertex + 44, 4);
    std::uint16_t symbol = 0;
    std::memcpy(&symbol, vertex + 38, 2);
    EXPECT_EQ(symbol, run.program.symbolOf[run.state.string.types()[module]]);
    const auto organ = static_cast<OrganKind>(vertex[35]);
    if (organ == OrganKind::Ball && order == 1) {
      EXPECT_EQ(module, run.scene.balls[0].module);
    }
    EXPECT_LE(static_cast<int>(vertex[35]), 5);
    modules.push_back(module);
  }
  // the first tube is of the first F and of those after the branch
  EXPECT_EQ(modules.front(), run.scene.segments[0].module);
  std::ranges::sort(modules);
  modules.erase(std::unique(modules.begin(), modules.end()), modules.end());
  EXPECT_EQ(modules.size(), 4U + 2U + 1U + 1U + 3U) << "segments, balls, polygon, cylinder, surfaces";
}

// numbers between the brackets of an attribute, everywhere in the file
std::vector<double> numbersOf(const std::string& text, const std::string& attribute) {
  std::vector<double> numbers;
  for (std::size_t at = text.find(attribute + " = ["); at != std::string::npos;
       at = text.find(attribute + " = [", at + 1)) {
    const std::size_t end = text.find(']', at + attribute.size() + 4);
    for (const char* from = text.data() + at + attribute.size() + 4; from < text.data() + end;) {
      char* next = nullptr;
      const double number = std::strtod(from, &next);
      if (next == from) {
        ++from;
        continue;
      }
      numbers.push_back(number);
      from = next;
    }
  }
  return numbers;
}

// all prims of type Mesh, their faces cut into triangles
Mesh usdMesh(const std::string& text) {
  Mesh mesh;
  for (std::size_t at = text.find("def Mesh "); at != std::string::npos;) {
    const std::size_t next = text.find("def Mesh ", at + 1);
    const std::string prim = text.substr(at, next == std::string::npos ? next : next - at);
    at = next;
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    const auto vectors = [&prim](const std::string& attribute, std::vector<Vec3>& into) {
      const std::vector<double> numbers = numbersOf(prim, attribute);
      for (std::size_t i = 0; i + 2 < numbers.size(); i += 3) {
        into.push_back({numbers[i], numbers[i + 1], numbers[i + 2]});
      }
    };
    vectors("point3f[] points", mesh.positions);
    vectors("normal3f[] normals", mesh.normals);
    const std::vector<double> coordinates = numbersOf(prim, "texCoord2f[] primvars:st");
    for (std::size_t i = 0; i + 1 < coordinates.size(); i += 2) {
      mesh.coordinates.push_back({coordinates[i], coordinates[i + 1]});
    }
    const std::vector<double> indices = numbersOf(prim, "int[] faceVertexIndices");
    std::size_t corner = 0;
    for (const double count : numbersOf(prim, "int[] faceVertexCounts")) {
      const auto vertex = [&](std::size_t k) { return first + static_cast<std::uint32_t>(indices.at(corner + k)); };
      for (std::size_t k = 1; k + 1 < static_cast<std::size_t>(count); ++k) {
        mesh.faces.push_back({vertex(0), vertex(k), vertex(k + 1), Mesh::kNoVertex});
      }
      corner += static_cast<std::size_t>(count);
    }
    EXPECT_EQ(corner, indices.size());
  }
  return mesh;
}

TEST_F(MeshFiles, UsdHasTheSameMesh) {
  const std::string text = written("usda");
  EXPECT_TRUE(text.starts_with("#usda 1.0\n"));
  EXPECT_EQ(std::ranges::count(text, '{'), std::ranges::count(text, '}'));
  EXPECT_EQ(std::ranges::count(text, '['), std::ranges::count(text, ']'));
  EXPECT_EQ(std::ranges::count(text, '('), std::ranges::count(text, ')'));
  const Mesh mesh = usdMesh(text);
  EXPECT_EQ(mesh.positions.size(), expected.positions.size());
  EXPECT_EQ(mesh.normals.size(), expected.positions.size());
  EXPECT_EQ(mesh.coordinates.size(), expected.positions.size());
  expectSame(mesh, "usda");
}

// each prim of type Mesh refers to all of its own points and to no others, and says their extent
void expectOwnPoints(const std::string& text, std::size_t leastPrims) {
  std::size_t prims = 0;
  for (std::size_t at = text.find("def Mesh "); at != std::string::npos; ++prims) {
    const std::size_t next = text.find("def Mesh ", at + 1);
    const std::string prim = text.substr(at, next == std::string::npos ? next : next - at);
    at = next;
    const std::vector<double> points = numbersOf(prim, "point3f[] points");
    const std::vector<double> indices = numbersOf(prim, "int[] faceVertexIndices");
    ASSERT_FALSE(indices.empty());
    EXPECT_EQ(*std::ranges::min_element(indices), 0.0);
    EXPECT_EQ(*std::ranges::max_element(indices), static_cast<double>(points.size() / 3 - 1));
    const std::vector<double> extent = numbersOf(prim, "float3[] extent");
    ASSERT_EQ(extent.size(), 6U);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double low = points[axis];
      double high = points[axis];
      for (std::size_t i = axis; i < points.size(); i += 3) {
        low = std::min(low, points[i]);
        high = std::max(high, points[i]);
      }
      EXPECT_EQ(extent[axis], low);
      EXPECT_EQ(extent[axis + 3], high);
    }
  }
  EXPECT_GE(prims, leastPrims);
}

TEST_F(MeshFiles, UsdMeshesHaveTheirOwnPoints) {
  // a polygon without area before another of another colour
  TurtleRun flat("[;(3){.f(1).f(1).}]f(3)[;(4){.f(1).+(60)f(1).}][;(5)!(0.2)F(1)]", meshView());
  // more vertices than one prim holds
  std::string text = "!(0.1)";
  for (int i = 0; i < 600; ++i) {
    text += "[+(" + std::to_string(i % 90) + ")F(2)]/(7)F";
  }
  TurtleRun large(text, meshView());
  large.program.view.contourSides = 64;
  for (TurtleRun* each : {&flat, &large}) {
    each->draw();
    for (const unsigned threads : {1U, 2U}) {
      core::StringSink sink;
      const ExportInput input{.scene = each->scene, .view = each->program.view, .threads = threads};
      EXPECT_EQ(findExportFormat("usda")->write(
                    input, {.fileName = "plant", .sink = sink, .openCompanion = {}, .progress = {}}),
                std::nullopt);
      expectOwnPoints(sink.text(), 2);
    }
  }
}

TEST_F(MeshFiles, UsdOfAGrowingPlantShowsOneStepAtATime) {
  core::StringSink sink;
  const ExportTarget target{.fileName = "plant", .sink = sink, .openCompanion = {}, .progress = {}};
  const std::unique_ptr<GrowthExport> growth =
      findExportFormat("usda")->beginGrowth(target, {.firstStep = 0, .lastStep = 4, .every = 2});
  for (const std::uint64_t step : {0U, 2U, 4U}) {
    EXPECT_EQ(growth->addFrame({.scene = run.scene, .view = run.program.view}, step), std::nullopt);
  }
  growth->finish();
  const std::string& text = sink.text();
  EXPECT_NE(text.find("startTimeCode = 0\n    endTimeCode = 4\n"), std::string::npos);
  EXPECT_NE(text.find("def Xform \"step_0\"\n{\n    token visibility.timeSamples = {\n        0: \"inherited\",\n"
                      "        2: \"invisible\",\n    }\n"),
            std::string::npos);
  EXPECT_NE(text.find("def Xform \"step_4\"\n{\n    token visibility.timeSamples = {\n        0: \"invisible\",\n"
                      "        4: \"inherited\",\n    }\n"),
            std::string::npos);
  EXPECT_EQ(std::ranges::count(text, '{'), std::ranges::count(text, '}'));
  EXPECT_EQ(numbersOf(text, "point3f[] points").size(), 3 * 3 * expected.positions.size());
}

TEST_F(MeshFiles, TheSameSceneGivesTheSameBytes) {
  for (const ExportFormat& format : exportFormats()) {
    if (format.source != ExportSource::Scene) {
      continue;  // written from the string
    }
    EXPECT_EQ(written(std::string(format.name)), written(std::string(format.name))) << format.name;
  }
}

TEST(MeshFilesBadInput, GeometryThatDoesNotFit32BitsNamesItsModule) {
  TurtleRun far("F@M(0,1e39)F");
  far.draw();
  for (const std::string format : {"obj", "ply", "stl", "usda", "vtp", "glb"}) {
    core::StringSink sink;
    const ExportTarget target{.fileName = "plant", .sink = sink, .openCompanion = {}, .progress = {}};
    EXPECT_EQ(findExportFormat(format)->write({.scene = far.scene, .view = {}}, target),
              "plant 0, module 3: its geometry is not finite in 32-bit numbers. Bound the lengths, widths and scales "
              "of the model")
        << format;
  }
}

TEST(MeshFilesBadInput, OnAnAxisTheLineThatIsNotFiniteIsNamed) {
  // four lines of one tube; the third ends beyond 32-bit numbers
  TurtleRun far("F(1)F(1.0e20)F(1.0e39)F(1)");
  far.draw();
  const derivation::ModuleString* const string = &far.state.string;
  for (const std::string format : {"obj", "ply", "stl", "usda", "vtp", "glb"}) {
    core::StringSink sink;
    const ExportTarget target{.fileName = "plant", .sink = sink, .openCompanion = {}, .progress = {}};
    const ExportInput input{
        .scene = far.scene, .view = {}, .step = 3, .program = &far.program, .strings = {&string, 1}};
    const std::optional<std::string> problem = findExportFormat(format)->write(input, target);
    ASSERT_TRUE(problem) << format;
    EXPECT_TRUE(problem->starts_with("step 3, plant 0, module 2 ('F'): its geometry is not finite")) << *problem;
  }
}

TEST(MeshFilesBadInput, AnEmptySceneIsAFileWithoutTriangles) {
  for (const ExportFormat& format : exportFormats()) {
    if (format.source != ExportSource::Scene) {
      continue;  // written from the string
    }
    core::StringSink sink;
    const ExportTarget target{.fileName = "plant", .sink = sink, .openCompanion = {}, .progress = {}};
    EXPECT_EQ(format.write({.scene = Scene{}, .view = {}}, target), std::nullopt) << format.name;
    EXPECT_FALSE(sink.text().empty()) << format.name;
  }
}

}  // namespace
}  // namespace espalier::turtle::mesh_files_test
