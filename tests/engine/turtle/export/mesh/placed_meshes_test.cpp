#include "engine/turtle/export/mesh/placed_meshes.h"

#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "engine/turtle/export/picture/picture.h"
#include "tests/engine/turtle/textured_view.h"
#include "tests/engine/turtle/turtle_fixture.h"
#include "tests/support/mesh_measures.h"

namespace espalier::turtle::placed_meshes_test {
namespace {

using core::Vec3;
using nlohmann::json;

constexpr double kQuarter = std::numbers::pi / 2.0;

/// Two plants: a bent branch with a sphere, and a textured one.
class PlacedScenesTest : public ::testing::Test {
 protected:
  PlacedScenesTest()
      : first(";(3)!(0.4)F(2)+(30)F(1)@O(0.5)", texturedView()), second(";(9)@Tx(1)F(1)~p", texturedView()) {
    first.draw();
    second.draw();
    inputs.push_back({.scene = first.scene, .view = first.program.view});
    inputs.push_back({.scene = second.scene, .view = second.program.view});
  }

  [[nodiscard]] std::string written(const std::string& format, const std::vector<ScenePlacement>& placements) {
    core::StringSink sink;
    core::StringSink companion;
    const ExportTarget target{.fileName = "wood",
                              .sink = sink,
                              .openCompanion = [&](const std::string&) -> core::ByteSink& { return companion; },
                              .progress = {}};
    EXPECT_EQ(findExportFormat(format)->writePlaced({inputs, placements}, target), std::nullopt);
    return sink.take();
  }

  static json textOf(const std::string& glb) {
    const auto word = [&glb](std::size_t at) {
      return static_cast<std::size_t>(static_cast<unsigned char>(glb[at])) |
             static_cast<std::size_t>(static_cast<unsigned char>(glb[at + 1])) << 8U |
             static_cast<std::size_t>(static_cast<unsigned char>(glb[at + 2])) << 16U;
    };
    return json::parse(glb.substr(20, word(12)));
  }

  TurtleRun first, second;
  std::vector<ExportInput> inputs;
};

using PlacedMeshesOfScenes = PlacedScenesTest;

TEST_F(PlacedMeshesOfScenes, ACopyIsTurnedScaledAndMoved) {
  // from z toward x, seen from above against the clock
  const ScenePlacement placement{.position = {1, 2, 3}, .turnRadians = kQuarter, .scale = 2.0};
  expectVector(placedPoint(placement, {0, 1, 1}), 3, 4, 3, 1e-12);
  expectVector(placedPoint(placement, {1, 0, 0}), 1, 2, 1, 1e-12);
  expectVector(placedDirection(placement, {0, 0, 1}), 1, 0, 0, 1e-12);
}

TEST_F(PlacedMeshesOfScenes, EveryCopyHasTheScenesAreaAndItsOwnPlants) {
  const std::vector<ScenePlacement> placements{{.scene = 0},
                                               {.scene = 1, .position = {5, 0, 0}},
                                               {.scene = 0, .position = {0, 0, 7}, .turnRadians = 1.0, .scale = 3.0}};
  PlacedMeshes meshes({inputs, placements});
  std::array<Mesh, 3> copies;
  ASSERT_EQ(meshes.forEach([&](const PlacedMeshes::Item& item, const Mesh& mesh) -> std::optional<std::string> {
    append(copies[item.plant()], mesh);
    return std::nullopt;
  }),
            std::nullopt);
  const test::MeshMeasures alone = test::measure(copies[0]);
  const test::MeshMeasures larger = test::measure(copies[2]);
  EXPECT_NEAR(larger.area, 9.0 * alone.area, 1e-9);
  EXPECT_NEAR(larger.signedVolume, 27.0 * alone.signedVolume, 1e-9);
  EXPECT_LT(larger.largestNormalError, 1e-9);
  EXPECT_GT(larger.smallestFacing, 0.0);
  EXPECT_GT(copies[1].positions.size(), 0U);
}

TEST_F(PlacedMeshesOfScenes, MaterialsAreColoursWithTexturesEachOnce) {
  const std::vector<ScenePlacement> placements{{.scene = 0}, {.scene = 1}, {.scene = 1}};
  PlacedMeshes meshes({inputs, placements});
  std::vector<std::string> names;
  for (const MeshMaterial& material : meshes.materials()) {
    names.push_back(material.name);
  }
  EXPECT_EQ(names, (std::vector<std::string>{"bark", "fruit", "bark_9", "leaf"}));
  ASSERT_EQ(meshes.textures().size(), 1U);
  EXPECT_EQ(meshes.textures()[0].suffix(), ".png");
  EXPECT_FALSE(meshes.textures()[0].hasHoles());
}

TEST_F(PlacedMeshesOfScenes, FilesAreTheSameForAnyNumberOfThreads) {
  TurtleRun tree(
      ";(3)!(0.3)F" +
          [] {
            std::string text;
            for (int i = 0; i < 5000; ++i) {
              text += "[+(" + std::to_string(i % 90) + ")F(2)]/(7)F";
            }
            return text;
          }(),
      texturedView());
  tree.draw();
  const ScenePlacement here;
  for (const char* format : {"glb", "obj", "ply", "stl", "usda"}) {
    std::array<std::string, 2> files;
    for (unsigned threads = 1; threads <= 2; ++threads) {
      core::StringSink sink;
      const ExportInput input{.scene = tree.scene, .view = tree.program.view, .threads = threads};
      ASSERT_EQ(findExportFormat(format)->writePlaced(
                    {{&input, 1}, {&here, 1}}, {.fileName = "a", .sink = sink, .openCompanion = {}, .progress = {}}),
                std::nullopt);
      files[threads - 1] = sink.take();
    }
    EXPECT_TRUE(files[0] == files[1]) << format;
  }
}

TEST_F(PlacedMeshesOfScenes, InGlbASceneThatIsPlacedSeveralTimesIsOneMesh) {
  std::vector<ScenePlacement> placements{{.scene = 1, .position = {-4, 0, 0}}};
  const std::string two = written("glb", {{.scene = 0}, {.scene = 0, .position = {4, 0, 0}}});
  for (int i = 0; i < 100; ++i) {
    placements.push_back(
        {.scene = 0, .position = {static_cast<double>(i), 0, 0}, .turnRadians = 0.1 * i, .scale = 1.5});
  }
  const std::string many = written("glb", placements);
  const json text = textOf(many);
  // one plant with its meshes and organs below, a hundred nodes of one mesh
  EXPECT_EQ(text["scenes"][0]["nodes"].size(), 101U);
  std::map<int, int> uses;
  for (const json& node : text["nodes"]) {
    uses[node.value("mesh", -1)] += 1;
  }
  EXPECT_TRUE(std::ranges::any_of(uses, [](const auto& use) { return use.first >= 0 && use.second == 100; }));
  const json& last = text["nodes"][100];
  EXPECT_EQ(last["name"], "plant_100");
  EXPECT_NEAR(last["rotation"][1].get<double>(), std::sin(0.5 * 9.9), 1e-6);
  EXPECT_EQ(last["scale"], (json{1.5, 1.5, 1.5}));
  EXPECT_LT(many.size(), 2 * two.size() + 100 * 160) << "the copies cost a node each";
}

TEST_F(PlacedMeshesOfScenes, InstancingPutsAllCopiesIntoOneNode) {
  std::vector<ScenePlacement> placements;
  for (int i = 0; i < 50; ++i) {
    placements.push_back({.scene = 0, .position = {static_cast<double>(i), 0, 0}});
  }
  inputs[0].usesInstancing = true;
  const json text = textOf(written("glb", placements));
  ASSERT_EQ(text["nodes"].size(), 1U);
  const json& attributes = text["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
  EXPECT_EQ(text["accessors"][attributes["TRANSLATION"].get<std::size_t>()]["count"], 50);
  EXPECT_EQ(text["accessors"][attributes["ROTATION"].get<std::size_t>()]["type"], "VEC4");
  EXPECT_EQ(text["extensionsUsed"], (json{"EXT_mesh_gpu_instancing"}));
}

TEST_F(PlacedMeshesOfScenes, APictureShowsAllCopies) {
  PictureOptions options{.widthPixels = 300, .heightPixels = 100, .marginFraction = 0.0};
  options.background = PictureBackground::Transparent;
  const auto columnsOf = [&](const std::vector<ScenePlacement>& placements) {
    const PictureImage image = renderPlaced({inputs, placements}, options);
    std::size_t columns = 0;
    for (int x = 0; x < image.width; ++x) {
      bool isDrawn = false;
      for (int y = 0; y < image.height; ++y) {
        isDrawn = isDrawn || image.pixels[static_cast<std::size_t>(y * image.width + x) * 4 + 3] > 0;
      }
      columns += isDrawn ? 1 : 0;
    }
    return columns;
  };
  const std::size_t three =
      columnsOf({{.scene = 0}, {.scene = 0, .position = {3, 0, 0}}, {.scene = 0, .position = {6, 0, 0}}});
  const std::size_t one = columnsOf({{.scene = 0}});
  // the page's height decides, so each copy is as wide as one alone
  EXPECT_NEAR(static_cast<double>(three), 3.0 * static_cast<double>(one), 6.0);
  // a copy of half the size is as wide as the whole when it fills the page
  EXPECT_NEAR(static_cast<double>(columnsOf({{.scene = 0, .position = {9, 0, 0}, .scale = 0.5}})),
              static_cast<double>(one), 2.0);
}

TEST_F(PlacedMeshesOfScenes, AProblemNamesStepModuleAndSymbol) {
  const double far = 1e39;
  const ScenePlacement here{.position = {far, 0, 0}};
  const derivation::ModuleString* const string = &first.state.string;
  const ExportInput input{
      .scene = first.scene, .view = first.program.view, .step = 7, .program = &first.program, .strings = {&string, 1}};
  core::StringSink sink;
  EXPECT_EQ(
      findExportFormat("stl")->writePlaced({{&input, 1}, {&here, 1}},
                                           {.fileName = "a", .sink = sink, .openCompanion = {}, .progress = {}}),
      "step 7, plant 0, module 2 ('F'): its geometry is not finite in 32-bit numbers. Bound the lengths, widths and "
      "scales of the model");
}

}  // namespace
}  // namespace espalier::turtle::placed_meshes_test
