#include "engine/turtle/export/mesh/glb.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>

#include "engine/turtle/export/mesh/scene_meshes.h"
#include "tests/engine/turtle/turtle_fixture.h"
#include "tests/support/mesh_measures.h"

namespace espalier::turtle::glb_test {
namespace {

using core::Vec3;
using nlohmann::json;

constexpr const char* kGlbPlant =
    "!(0.4)F(2)[+(40)!(0.2)F(1)@O(0.5)];(3)-(20)!(0.3)F(1)&(30)/(20)F(1){.+(30)f.+(60)f.+(60)f.}@c(0.6){(1)f+(20)f}(1)"
    "~p+(30)~p(2)/(50)@D(0.5)~p(1,2,3)";

files::ViewSettings glbView() {
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

std::string glbOf(const Scene& scene, const files::ViewSettings& view, const files::Palette* palette = nullptr,
                  bool usesInstancing = false) {
  core::StringSink sink;
  const ExportInput input{.scene = scene, .view = view, .palette = palette, .usesInstancing = usesInstancing};
  EXPECT_EQ(
      findExportFormat("glb")->write(input, {.fileName = "a.glb", .sink = sink, .openCompanion = {}, .progress = {}}),
      std::nullopt);
  return sink.take();
}

std::uint32_t wordAt(const std::string& bytes, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, 4);
  return word;
}

/// A .glb as another program reads it: written from the specification of the format, with another JSON library.
struct GlbContent {
  json text;
  std::string binary;

  explicit GlbContent(const std::string& bytes) {
    EXPECT_EQ(bytes.substr(0, 4), "glTF");
    EXPECT_EQ(wordAt(bytes, 4), 2U);
    EXPECT_EQ(wordAt(bytes, 8), bytes.size());
    const std::size_t length = wordAt(bytes, 12);
    EXPECT_EQ(length % 4, 0U);
    EXPECT_EQ(bytes.substr(16, 4), "JSON");
    text = json::parse(bytes.substr(20, length));
    if (bytes.size() > 20 + length) {
      EXPECT_EQ(wordAt(bytes, 20 + length), bytes.size() - length - 28);
      EXPECT_EQ(bytes.substr(24 + length, 4), std::string("BIN\0", 4));
      binary = bytes.substr(28 + length);
      EXPECT_EQ(text["buffers"][0]["byteLength"], binary.size());
    }
  }

  [[nodiscard]] std::vector<double> numbers(const json& index, std::size_t components) const {
    const json& accessor = text["accessors"][index.get<std::size_t>()];
    const json& view = text["bufferViews"][accessor["bufferView"].get<std::size_t>()];
    const bool isIndex = accessor["componentType"] == 5125;
    const std::size_t stride = view.value("byteStride", components * 4);
    const std::size_t begin = view["byteOffset"].get<std::size_t>() + accessor.value("byteOffset", std::size_t{0});
    const std::size_t end = view["byteOffset"].get<std::size_t>() + view["byteLength"].get<std::size_t>();
    std::vector<double> values;
    for (std::size_t i = 0; i < accessor["count"].get<std::size_t>(); ++i) {
      for (std::size_t k = 0; k < components; ++k) {
        const std::size_t at = begin + i * stride + 4 * k;
        EXPECT_LE(at + 4, end);
        float single = 0.0F;
        std::memcpy(&single, binary.data() + at, 4);
        values.push_back(isIndex ? wordAt(binary, at) : static_cast<double>(single));
      }
    }
    return values;
  }

  // all triangles of the default scene in world coordinates
  [[nodiscard]] Mesh world() const {
    Mesh mesh;
    for (const json& root : text["scenes"][text["scene"].get<std::size_t>()]["nodes"]) {
      for (const json& child : text["nodes"][root.get<std::size_t>()]["children"]) {
        addNode(text["nodes"][child.get<std::size_t>()], mesh);
      }
    }
    return mesh;
  }

 private:
  static Vec3 vector(const json& v) { return {v[0].get<double>(), v[1].get<double>(), v[2].get<double>()}; }
  // v turned by a quaternion: v + 2 q x (q x v + w v)
  static Vec3 rotated(const Vec3& v, const json& q) {
    const Vec3 axis{q[0].get<double>(), q[1].get<double>(), q[2].get<double>()};
    return v + 2.0 * core::cross(axis, core::cross(axis, v) + q[3].get<double>() * v);
  }

  void addNode(const json& node, Mesh& mesh) const {
    const json q = node.value("rotation", json{0, 0, 0, 1});
    const Vec3 t = vector(node.value("translation", json{0, 0, 0}));
    const Vec3 s = vector(node.value("scale", json{1, 1, 1}));
    for (const json& primitive : text["meshes"][node["mesh"].get<std::size_t>()]["primitives"]) {
      const auto first = static_cast<std::uint32_t>(mesh.positions.size());
      const std::vector<double> p = numbers(primitive["attributes"]["POSITION"], 3);
      const std::vector<double> n = numbers(primitive["attributes"]["NORMAL"], 3);
      const std::vector<double> uv = numbers(primitive["attributes"]["TEXCOORD_0"], 2);
      for (std::size_t i = 0; i < p.size() / 3; ++i) {
        mesh.positions.push_back(t + rotated({s.x * p[3 * i], s.y * p[3 * i + 1], s.z * p[3 * i + 2]}, q));
        mesh.normals.push_back(core::normalised(rotated({n[3 * i] / s.x, n[3 * i + 1] / s.y, n[3 * i + 2] / s.z}, q)));
        mesh.coordinates.push_back({uv[2 * i], 1.0 - uv[2 * i + 1]});
      }
      const std::vector<double> indices = numbers(primitive["indices"], 1);
      const auto at = [&](std::size_t k) { return first + static_cast<std::uint32_t>(indices[k]); };
      for (std::size_t i = 0; i < indices.size(); i += 3) {
        mesh.faces.push_back({at(i), at(i + 1), at(i + 2), Mesh::kNoVertex});
      }
    }
  }
};

// the same scene without a file between
Mesh expectedMesh(const Scene& scene, const files::ViewSettings& view) {
  const ExportInput input{.scene = scene, .view = view};
  MaterialTable materials;
  core::WorkerTeam team(2);
  const SceneMeshes meshes(input, materials, team);
  Mesh all;
  Mesh mesh;
  for (const MeshPart& part : meshes.parts()) {
    meshes.make(part, mesh);
    appendPlaced(all, mesh, {.position = {}, .frame = {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}}});
  }
  return all;
}

TEST(Glb, AnotherReaderSeesTheSceneWhereTheTurtleDrewIt) {
  TurtleRun run(kGlbPlant, glbView());
  run.draw({.position = {3, 1, -2}, .frame = {}});
  const Mesh read = GlbContent(glbOf(run.scene, run.program.view)).world();
  const Mesh expected = expectedMesh(run.scene, run.program.view);
  EXPECT_EQ(read.positions.size(), expected.positions.size());
  const test::MeshMeasures a = test::measure(read);
  const test::MeshMeasures b = test::measure(expected);
  EXPECT_EQ(read.faces.size(), expected.triangleCount());
  EXPECT_NEAR(a.area, b.area, 1e-5 * b.area);
  // not mirrored, and every side looks outward
  EXPECT_NEAR(a.signedVolume, b.signedVolume, 1e-4);
  EXPECT_GT(a.smallestFacing, 0.0);
  EXPECT_LT(core::length(a.low - b.low), 1e-5);
  EXPECT_LT(core::length(a.high - b.high), 1e-5);
  // every vertex has one of the same place, normal and texture coordinates
  for (std::size_t i = 0; i < expected.positions.size(); ++i) {
    bool isFound = false;
    for (std::size_t k = 0; k < read.positions.size() && !isFound; ++k) {
      isFound = core::length(read.positions[k] - expected.positions[i]) < 1e-5 &&
                core::length(read.normals[k] - expected.normals[i]) < 1e-4 &&
                std::abs(read.coordinates[k][0] - expected.coordinates[i][0]) +
                        std::abs(read.coordinates[k][1] - expected.coordinates[i][1]) <
                    1e-5;
    }
    ASSERT_TRUE(isFound) << "vertex " << i;
  }
}

TEST(Glb, BoundsOfPositionsAreExact) {
  TurtleRun run(kGlbPlant, glbView());
  run.draw();
  const GlbContent content(glbOf(run.scene, run.program.view));
  for (const json& mesh : content.text["meshes"]) {
    for (const json& primitive : mesh["primitives"]) {
      const json& index = primitive["attributes"]["POSITION"];
      const json& accessor = content.text["accessors"][index.get<std::size_t>()];
      const std::vector<double> p = content.numbers(index, 3);
      for (std::size_t k = 0; k < 3; ++k) {
        double low = p[k];
        double high = p[k];
        for (std::size_t i = k; i < p.size(); i += 3) {
          low = std::min(low, p[i]);
          high = std::max(high, p[i]);
        }
        EXPECT_EQ(static_cast<float>(accessor["min"][k].get<double>()), static_cast<float>(low));
        EXPECT_EQ(static_cast<float>(accessor["max"][k].get<double>()), static_cast<float>(high));
      }
    }
  }
}

TEST(Glb, APlantHasOneNodeForEachKindOfOrgans) {
  TurtleRun run("F[+F]~p f~p f(2)@O(1);(9)~p @O(2)", glbView());
  run.draw();
  const GlbContent content(glbOf(run.scene, run.program.view));
  std::vector<std::string> names;
  for (const json& node : content.text["nodes"]) {
    names.push_back(node["name"]);
  }
  EXPECT_EQ(names, (std::vector<std::string>{"plant_0", "plant_0 branches", "plant_0 leaves", "plant_0 fruits"}));
  // leaves in two colours are two primitives of one mesh
  EXPECT_EQ(content.text["meshes"][1]["primitives"].size(), 2U);
  std::vector<std::string> materials;
  for (const json& material : content.text["materials"]) {
    materials.push_back(material["name"]);
  }
  EXPECT_EQ(materials, (std::vector<std::string>{"leaf", "fruit", "leaf_128", "fruit_128", "bark", "bark_1"}));
  EXPECT_FALSE(content.text.contains("extensionsRequired"));
}

TEST(Glb, WithInstancingEqualOrgansOfAPlantAreOneNode) {
  TurtleRun run("~p f~p f(2)@O(1);(9)~p @O(2)", glbView());
  run.draw();
  const std::string bytes = glbOf(run.scene, run.program.view, nullptr, true);
  const GlbContent content(bytes);
  // surface and sphere in two colours each, of one shape each
  EXPECT_EQ(content.text["meshes"].size(), 4U);
  ASSERT_EQ(content.text["nodes"].size(), 1U + 4U);
  EXPECT_EQ(content.text["meshes"][0]["name"], "surface p leaf_128");
  std::vector<std::size_t> counts;
  for (std::size_t i = 1; i < content.text["nodes"].size(); ++i) {
    const json& attributes = content.text["nodes"][i]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
    const json& accessor = content.text["accessors"][attributes["TRANSLATION"].get<std::size_t>()];
    counts.push_back(accessor["count"]);
  }
  EXPECT_EQ(counts, (std::vector<std::size_t>{2, 1, 1, 1}));
  EXPECT_EQ(content.text["extensionsRequired"], json{"EXT_mesh_gpu_instancing"});
}

TEST(Glb, HasNoTrianglesWithoutArea) {
  // a patch whose first row of points is one point, as at the tip of a leaf
  files::ViewSettings view = glbView();
  for (std::size_t i = 0; i < 4; ++i) {
    view.surfaces[0].patches[0].points[i] = view.surfaces[0].patches[0].points[0];
  }
  TurtleRun run("~p", view);
  run.draw();
  for (const bool usesInstancing : {false, true}) {
    const GlbContent content(glbOf(run.scene, run.program.view, nullptr, usesInstancing));
    const json& primitive = content.text["meshes"][0]["primitives"][0];
    const std::vector<double> p = content.numbers(primitive["attributes"]["POSITION"], 3);
    const std::vector<double> indices = content.numbers(primitive["indices"], 1);
    const auto at = [&](double index) {
      const auto i = 3 * static_cast<std::size_t>(index);
      return core::Vec3{p[i], p[i + 1], p[i + 2]};
    };
    EXPECT_GT(indices.size(), 0U);
    for (std::size_t i = 0; i < indices.size(); i += 3) {
      const core::Vec3 a = at(indices[i]);
      EXPECT_GT(core::length(core::cross(at(indices[i + 1]) - a, at(indices[i + 2]) - a)), 0.0);
    }
  }
}

TEST(Glb, EachPrimitiveOfAGreatMeshRefersToItsOwnVertices) {
  // a primitive ends behind a million vertices; a tube of 64 sides has 258 and more
  std::string text = "!(0.1)";
  for (int i = 0; i < 4500; ++i) {
    text += "[+(" + std::to_string(i % 90) + ")F(2)]/(7)F";
  }
  files::ViewSettings view = glbView();
  view.contourSides = 64;
  TurtleRun run(text, view);
  run.draw();
  const GlbContent content(glbOf(run.scene, run.program.view));
  const json& primitives = content.text["meshes"][0]["primitives"];
  std::map<json, int> primitivesOf;  // by material
  for (const json& primitive : primitives) {
    ++primitivesOf[primitive["material"]];
  }
  EXPECT_TRUE(std::ranges::any_of(primitivesOf, [](const auto& entry) { return entry.second > 1; }));
  double vertices = 0;
  for (const json& primitive : primitives) {
    const std::vector<double> indices = content.numbers(primitive["indices"], 1);
    const auto count =
        content.text["accessors"][primitive["attributes"]["POSITION"].get<std::size_t>()]["count"].get<double>();
    EXPECT_EQ(*std::ranges::min_element(indices), 0.0);
    EXPECT_EQ(*std::ranges::max_element(indices), count - 1.0);
    vertices += count;
  }
  EXPECT_GT(vertices, 1e6);
}

TEST(Glb, OrgansOfAFrameThatIsNoRotationArePartOfTheMesh) {
  TurtleRun run("~p", glbView());
  run.draw();
  run.scene.surfaces[0].frame.heading = {0.5, 1.0, 0.0};
  const GlbContent content(glbOf(run.scene, run.program.view));
  EXPECT_EQ(content.text["meshes"][0]["name"], "plant_0 leaves");
  EXPECT_LT(
      core::length(test::measure(content.world()).high - test::measure(expectedMesh(run.scene, run.program.view)).high),
      1e-6);
}

TEST(Glb, EachPlantIsANode) {
  TurtleRun run("F@O(1)");
  run.draw();
  Scene two = run.scene;
  two.segments.push_back(two.segments[0]);
  two.segments[1].plant = 1;
  const GlbContent content(glbOf(two, {}));
  EXPECT_EQ(content.text["scenes"][0]["nodes"], json({0, 1}));
  EXPECT_EQ(content.text["nodes"][0]["name"], "plant_0");
  EXPECT_EQ(content.text["nodes"][0]["children"].size(), 2U);
  EXPECT_EQ(content.text["nodes"][1]["name"], "plant_1");
  EXPECT_EQ(content.text["nodes"][1]["children"].size(), 1U);
}

TEST(Glb, MaterialsHaveTheLinearColoursOfThePalette) {
  TurtleRun run(";(7)F@O(1)");
  run.draw();
  files::Palette palette;
  palette.maps[1][7] = {255, 0, 188};
  const GlbContent mapped(glbOf(run.scene, {}, &palette));
  // bark and fruit
  ASSERT_EQ(mapped.text["materials"].size(), 2U);
  EXPECT_EQ(mapped.text["materials"][1]["pbrMetallicRoughness"], mapped.text["materials"][0]["pbrMetallicRoughness"]);
  const json& colour = mapped.text["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"];
  EXPECT_EQ(colour[0], 1);
  EXPECT_EQ(colour[1], 0);
  // 188 of 255 is half the light
  EXPECT_NEAR(colour[2].get<double>(), 0.503, 1e-3);
  EXPECT_EQ(colour[3], 1);

  EXPECT_FALSE(mapped.text.contains("extensionsUsed"));
  palette.materials[1][7] = {
      .diffuse = {0, 1, 0}, .emission = {1, 0, 0}, .specular = {0.5, 0, 1}, .opacity = 0.5, .shininess = 30.0};
  palette.usesMaterials = true;
  const GlbContent material(glbOf(run.scene, {}, &palette));
  EXPECT_EQ(material.text["materials"][0]["alphaMode"], "BLEND");
  EXPECT_EQ(material.text["materials"][0]["emissiveFactor"], json({1, 0, 0}));
  EXPECT_EQ(material.text["materials"][0]["pbrMetallicRoughness"]["roughnessFactor"], 0.25);
  // highlights of grey 0.5 are as glTF has them without the extension
  const json& highlights = material.text["materials"][0]["extensions"]["KHR_materials_specular"];
  EXPECT_NEAR(highlights["specularColorFactor"][0].get<double>(), 1.0, 1e-5);
  EXPECT_EQ(highlights["specularColorFactor"][1], 0);
  EXPECT_EQ(material.text["extensionsUsed"], json({"KHR_materials_specular"}));
  EXPECT_EQ(material.text["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"][3], 0.5);
}

TEST(Glb, AnEmptySceneIsAValidFile) {
  const GlbContent content(glbOf(Scene{}, {}));
  EXPECT_EQ(content.text["scenes"].size(), 1U);
  EXPECT_FALSE(content.text.contains("meshes"));
}

TEST(Glb, IsDeterministic) {
  TurtleRun run(kGlbPlant, glbView());
  run.draw();
  EXPECT_EQ(glbOf(run.scene, run.program.view), glbOf(run.scene, run.program.view));
}

TEST(Glb, GeometryBeyond32BitsNamesItsModule) {
  TurtleRun run("F@M(0,1e39)F");
  run.draw();
  core::StringSink sink;
  EXPECT_EQ(findExportFormat("glb")->write({.scene = run.scene, .view = {}},
                                           {.fileName = "a.glb", .sink = sink, .openCompanion = {}, .progress = {}}),
            "plant 0, module 3: its geometry is not finite in 32-bit numbers. Bound the lengths, widths and scales of "
            "the model");
  EXPECT_TRUE(sink.text().empty()) << "found before anything is written";
}

TEST(Glb, ProgressEndsWithAllParts) {
  TurtleRun run("F[+F][-F]F");
  run.draw();
  core::StringSink sink;
  std::uint64_t lastDone = 0;
  std::uint64_t lastTotal = 0;
  const auto progress = [&](std::uint64_t done, std::uint64_t total) {
    EXPECT_GE(done, lastDone);
    lastDone = done;
    lastTotal = total;
  };
  EXPECT_EQ(
      findExportFormat("glb")->write({.scene = run.scene, .view = {}},
                                     {.fileName = "a.glb", .sink = sink, .openCompanion = {}, .progress = progress}),
      std::nullopt);
  EXPECT_EQ(lastDone, lastTotal);
  EXPECT_GT(lastTotal, 0U);
}

}  // namespace
}  // namespace espalier::turtle::glb_test
