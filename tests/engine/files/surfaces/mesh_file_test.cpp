#include "engine/files/surfaces/mesh_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

#include "engine/core/streams.h"
#include "engine/language/view/view_file.h"
#include "tests/support/places.h"

namespace espalier::files::mesh_file_test {
namespace {

using core::Vec3;

std::string fileText(const std::string& name) {
  std::ifstream file(sourceFolder() + "/tests/engine/files/surfaces/meshes/" + name, std::ios::binary);
  EXPECT_TRUE(file.good()) << name;
  return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<SurfaceTriangle> trianglesOf(const std::string& name) {
  auto read = readMeshFile(name, fileText(name));
  EXPECT_TRUE(read) << name << ": " << read.error();
  return read.value_or(std::vector<SurfaceTriangle>{});
}

std::string problemOf(const std::string& name, const std::string& bytes) {
  const auto read = readMeshFile(name, bytes);
  return read ? "" : read.error();
}

struct Measures {
  double area = 0.0;
  double signedVolume = 0.0;
  Vec3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
  double largestNormalError = 0.0;
};

Measures measure(const std::vector<SurfaceTriangle>& triangles) {
  Measures measures;
  for (const SurfaceTriangle& t : triangles) {
    measures.area += 0.5 * core::length(core::cross(t.points[1] - t.points[0], t.points[2] - t.points[0]));
    measures.signedVolume += core::dot(t.points[0], core::cross(t.points[1], t.points[2])) / 6.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& p = t.points[k];
      measures.low = {std::min(measures.low.x, p.x), std::min(measures.low.y, p.y), std::min(measures.low.z, p.z)};
      measures.high = {std::max(measures.high.x, p.x), std::max(measures.high.y, p.y), std::max(measures.high.z, p.z)};
      measures.largestNormalError = std::max(measures.largestNormalError, std::abs(core::length(t.normals[k]) - 1.0));
    }
  }
  return measures;
}

void expectUnitBox(const std::string& name) {
  const std::vector<SurfaceTriangle> triangles = trianglesOf(name);
  const Measures measures = measure(triangles);
  EXPECT_EQ(triangles.size(), 12U) << name;
  EXPECT_NEAR(measures.area, 6.0, 1e-6) << name;
  EXPECT_NEAR(measures.signedVolume, 1.0, 1e-6) << name << ": its sides look outward";
  EXPECT_LT(core::length(measures.low - Vec3{-0.5, -0.5, -0.5}), 1e-6) << name;
  EXPECT_LT(core::length(measures.high - Vec3{0.5, 0.5, 0.5}), 1e-6) << name;
  EXPECT_LT(measures.largestNormalError, 1e-6) << name;
  for (const SurfaceTriangle& t : triangles) {
    const Vec3 side = core::cross(t.points[1] - t.points[0], t.points[2] - t.points[0]);
    EXPECT_GT(core::dot(side, t.normals[0] + t.normals[1] + t.normals[2]), 0.0) << name;
  }
}

TEST(MeshFile, BoxesOfOtherProgramsAreBoxes) {
  expectUnitBox("box.obj");
  expectUnitBox("BoxTextured.glb");
  expectUnitBox("BoxTextured.gltf");
}

TEST(MeshFile, AMaterialLibraryThatIsNotThereDoesNotMatter) {
  const std::vector<SurfaceTriangle> triangles = trianglesOf("cube_usemtl.obj");
  EXPECT_EQ(triangles.size(), 12U);
  EXPECT_GT(measure(triangles).signedVolume, 0.0);
}

TEST(MeshFile, NormalsAreMadeUnit) {
  const std::vector<SurfaceTriangle> triangles = trianglesOf("BoxBadNormals.glb");
  EXPECT_EQ(triangles.size(), 12U);
  EXPECT_LT(measure(triangles).largestNormalError, 1e-6);
}

TEST(MeshFile, ABandOfAnotherProgramIsReadAsItStandsWithoutItsBones) {
  // four squares of 1 by 0.5 above each other, each of two triangles; the file has no normals
  const std::vector<SurfaceTriangle> triangles = trianglesOf("simple_skin.gltf");
  const Measures measures = measure(triangles);
  EXPECT_EQ(triangles.size(), 8U);
  EXPECT_NEAR(measures.area, 2.0, 1e-6);
  EXPECT_EQ(measures.low, (Vec3{0, 0, 0}));
  EXPECT_EQ(measures.high, (Vec3{1, 2, 0}));
  for (const SurfaceTriangle& t : triangles) {
    EXPECT_EQ(t.normals[1], (Vec3{0, 0, 1}));
  }
}

TEST(MeshFile, ConcaveFacesAreCutIntoTrianglesOfTheirArea) {
  // it lies in a plane x = constant
  const std::vector<SurfaceTriangle> triangles = trianglesOf("concave_polygon.obj");
  ASSERT_EQ(triangles.size(), 64U) << "of one face of 66 corners, a ring with a slit";
  double signedArea = 0.0;
  double area = 0.0;
  for (const SurfaceTriangle& t : triangles) {
    const Vec3 side = core::cross(t.points[1] - t.points[0], t.points[2] - t.points[0]);
    signedArea += 0.5 * side.x;
    area += 0.5 * core::length(side);
  }
  EXPECT_NEAR(std::abs(signedArea), area, 1e-6) << "no triangle is turned over";
}

TEST(MeshFile, TextureCoordinatesHaveVUpwardInBothFormats) {
  // the corner that glTF calls (0, 0) is the upper left of the picture, that of OBJ the lower left
  const auto object = readObjMesh("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.25 0.75\nf 1/1 2/1 3/1\n");
  EXPECT_EQ(object.value()[0].coordinates[0], (std::array<double, 2>{0.25, 0.75}));
  for (const SurfaceTriangle& t : trianglesOf("BoxTextured.glb")) {
    for (const auto& uv : t.coordinates) {
      EXPECT_GE(uv[0], -1e-6);
    }
  }
}

TEST(MeshFile, NegativeIndicesAndPolygonsOfObjAreRead) {
  const auto read = readObjMesh("v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nf -4 -3 -2 -1\n");
  ASSERT_EQ(read.value().size(), 2U);
  EXPECT_NEAR(measure(read.value()).area, 4.0, 1e-6);
  EXPECT_EQ(read.value()[0].normals[0], (Vec3{0, 0, 1})) << "the side's, where the file has none";
}

TEST(MeshFile, AnUnusableFileIsRefusedWithAReason) {
  EXPECT_EQ(problemOf("a.obj", ""), "it has no triangles");
  EXPECT_EQ(problemOf("a.obj", "v 1 2 3\n"), "it has no triangles");
  EXPECT_EQ(problemOf("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"), "a face has the vertex 9 of 3");
  EXPECT_NE(problemOf("a.glb", "no mesh").find("it is not a glTF 2.0 file: "), std::string::npos);
  EXPECT_NE(problemOf("malformed.obj", fileText("malformed.obj")), "");
  EXPECT_EQ(problemOf("BoxWithInfinites.glb", fileText("BoxWithInfinites.glb")).find("vertex "), 0U);
  EXPECT_EQ(problemOf("RecursiveNodes.gltf", fileText("RecursiveNodes.gltf")),
            "its scene has too many nodes, or nodes at too deep a level");
  EXPECT_NE(
      problemOf("IndexOutOfRange.gltf", fileText("IndexOutOfRange.gltf"))
          .find("it needs the file 'IndexOutOfRange.bin', but only data inside the file is read; export it as .glb"),
      std::string::npos);
}

TEST(MeshFile, ACoordinateOfObjThatIsNotFiniteIsRefused) {
  for (const std::string number : {"nan", "inf"}) {
    EXPECT_EQ(problemOf("a.obj", "v 0 0 0\nv 1 0 0\nv 0 " + number + " 0\nf 1 2 3\n"),
              "line 3: a vertex has the coordinate '" + number + "', which is not a finite number");
  }
  EXPECT_TRUE(readObjMesh("v 0 0 0\nv 1 0 0\nv 0 1e-999 1\nf 1 2 3\n").has_value()) << "too small is 0";
}

TEST(MeshFile, AFileThatIsCutOffAnywhereIsRefused) {
  const std::string whole = fileText("BoxTextured.glb");
  for (std::size_t length = 0; length < whole.size(); length += 97) {
    EXPECT_NE(problemOf("a.glb", whole.substr(0, length)), "") << length;
  }
}

TEST(MeshFile, ChangedBytesNeverReadOutsideTheFile) {
  // with the address sanitizer; here: nothing is thrown
  const std::string whole = fileText("BoxTextured.glb");
  for (std::size_t at = 12; at < whole.size(); at += 13) {
    std::string changed = whole;
    changed[at] = static_cast<char>(changed[at] ^ 0x15);
    EXPECT_NO_THROW(static_cast<void>(readMeshFile("a.glb", changed))) << at;
  }
}

TEST(MeshFile, TheSuffixTellsAMesh) {
  EXPECT_TRUE(isMeshFile("leaf.obj"));
  EXPECT_TRUE(isMeshFile("organs/Leaf.GLB"));
  EXPECT_TRUE(isMeshFile("leaf.gltf"));
  EXPECT_FALSE(isMeshFile("leaf.s"));
  EXPECT_FALSE(isMeshFile(".obj"));
}

TEST(MeshFile, SurfacesOfAViewFileCanBeMeshes) {
  core::MemoryFileProvider files;
  files.add("m/box.obj", fileText("box.obj"));
  files.add("m/box.glb", fileText("BoxTextured.glb"));
  files.add("m/broken.glb", "?");
  files.add("m/plant.v",
            "surface: l box.obj 2\ntsurface: m box.glb 1\nsurface: b broken.glb 1\nsurface: n none.obj 1\n");
  const language::ViewFileResult read = language::readViewFile("m/plant.v", files, core::Compatibility::Espalier, {});
  ASSERT_EQ(read.settings.triangleSurfaces.size(), 2U);
  EXPECT_EQ(read.settings.triangleSurfaces[0].id, 'l');
  EXPECT_NEAR(measure(read.settings.triangleSurfaces[0].triangles).signedVolume, 8.0, 1e-6);
  EXPECT_NEAR(measure(read.settings.triangleSurfaces[1].triangles).signedVolume, 1.0, 1e-6);
  std::string messages;
  for (const core::Diagnostic& diagnostic : read.diagnostics.entries()) {
    messages += core::formatDiagnostic(diagnostic) + "\n";
  }
  EXPECT_NE(messages.find("m/plant.v:3:"), std::string::npos) << messages;
  EXPECT_NE(messages.find("the mesh 'm/broken.glb' cannot be used: it is not a glTF 2.0 file: "), std::string::npos)
      << messages;
  EXPECT_NE(messages.find("~b draws nothing"), std::string::npos) << messages;
  EXPECT_NE(messages.find("the file 'm/none.obj' cannot be read; ~n draws nothing"), std::string::npos) << messages;
}

}  // namespace
}  // namespace espalier::files::mesh_file_test
