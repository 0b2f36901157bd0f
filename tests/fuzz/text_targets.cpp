#include <string>
#include <variant>
#include <vector>

#include "clients/espalier/roots/root_system.h"
#include "engine/core/check.h"
#include "engine/files/points/point_cloud.h"
#include "engine/language/compiler.h"
#include "engine/simulation/simulation.h"
#include "engine/turtle/export/text/mtg.h"
#include "engine/turtle/export/text/rsml.h"
#include "environment/output/field_output.h"
#include "server/remote/terrain/geotiff.h"
#include "tests/fuzz/bundle.h"
#include "tests/fuzz/small_limits.h"
#include "tests/fuzz/targets.h"

namespace espalier::fuzz {

void fuzzString(std::string_view text) {
  constexpr const char* kString = "string.txt";
  core::MemoryFileProvider files = unbundle(text, kString);
  language::CompileInput input;
  input.modelFile = kModel;
  input.limits = smallLimits();
  const language::CompileResult compiled = language::compile(input, files);
  if (compiled.program == nullptr) {
    return;
  }
  simulation::SimulationOptions options;
  options.limits = smallLimits();
  options.startString = files.read(kString).value_or("");
  simulation::Simulation simulation(compiled.program, std::vector<turtle::PlantPlacement>(1), nullptr, options);
  if (const auto error = simulation.rewind()) {
    ESPALIER_CHECK(!error->message.empty());
    return;
  }
  (void)simulation.scene();
  (void)simulation.step();
  (void)simulation.stringText();
}

void fuzzMtg(std::string_view text) {
  const auto read = turtle::readMtg(text);
  if (const auto* strings = std::get_if<turtle::MtgStrings>(&read)) {
    ESPALIER_CHECK(!strings->strings.empty());
  }
}

void fuzzPoints(std::string_view bytes) {
  const auto cloud = files::readPoints(bytes);
  if (!cloud) {
    ESPALIER_CHECK(!cloud.error().empty());
    return;
  }
  // a point takes at least six bytes of a file: "0 0 0\n"
  ESPALIER_CHECK(cloud->points.size() <= bytes.size() / 5);
  ESPALIER_CHECK(cloud->classes.empty() || cloud->classes.size() == cloud->points.size());
  ESPALIER_CHECK(cloud->returns.empty() || cloud->returns.size() == cloud->points.size());
}

void fuzzTerrain(std::string_view bytes) {
  const auto terrain = server::readGeoTiff(bytes);
  if (!terrain) {
    ESPALIER_CHECK(!terrain.error().empty());
    return;
  }
  ESPALIER_CHECK(terrain->heights.size() == terrain->rows * terrain->columns);
  ESPALIER_CHECK(terrain->heights.size() <= server::kMostHeights);
}

void fuzzRoots(std::string_view text) {
  const auto roots = text.starts_with("node") ? roots::readRootTable(text) : roots::readRsml(text);
  if (!roots) {
    ESPALIER_CHECK(!roots.error().empty());
    return;
  }
  for (std::uint32_t i = 0; i < roots->nodes.size(); ++i) {
    ESPALIER_CHECK(roots->nodes[i].parent == roots::RootSystem::kNone || roots->nodes[i].parent < i);
  }
  ESPALIER_CHECK(roots::modelOf(*roots).starts_with("Lsystem"));
  const turtle::RsmlLabels labels = roots::labelsOf(*roots);
  for (const turtle::RsmlLabels::Piece& piece : labels.pieces) {
    ESPALIER_CHECK(piece.root < labels.roots.size() && labels.roots[piece.root].plant < labels.plants.size());
  }
}

void fuzzVti(std::string_view text) {
  const auto fields = environment::readVti(text);
  if (!fields) {
    ESPALIER_CHECK(!fields.error().empty());
    return;
  }
  for (const turtle::Field& field : *fields) {
    ESPALIER_CHECK(field.values.size() == field.cells[0] * field.cells[1] * field.cells[2]);
  }
}

}  // namespace espalier::fuzz
