#include "clients/espalier/output/plant_rows.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "clients/espalier/messages.h"
#include "engine/core/hash.h"
#include "engine/turtle/scene/scene_bounds.h"

namespace espalier::command {
namespace {

constexpr double kRoom = 1.1;  // between plants, of the larger side of the largest

std::uint64_t hashOf(const simulation::Simulation& simulation) {
  core::Hasher hasher;
  // the drawing of a string may have random numbers of its own
  for (const language::LSystem& system : simulation.program().systems) {
    const auto& images = system.homomorphism.productions;
    if (!std::ranges::all_of(images, [](const language::Production& image) { return image.isPure; })) {
      hasher.integer(simulation.options().seed);
    }
  }
  for (std::size_t plant = 0; plant < simulation.plantCount(); ++plant) {
    const derivation::ModuleString& string = simulation.string(plant);
    hasher.integer(string.size());
    for (const core::ModuleTypeId type : string.types()) {
      hasher.integer(type);
    }
    for (const double parameter : string.parameters()) {
      hasher.number(parameter);
    }
  }
  return hasher.value();
}

}  // namespace

bool PlantRows::add(const simulation::Simulation& simulation) {
  std::shared_ptr<const language::Program> program = simulation.programs().front();
  const std::uint64_t hash = hashOf(simulation);
  const auto known = std::ranges::find_if(
      grown_, [&](const auto& plant) { return plant->hash == hash && plant->program->hash == program->hash; });
  if (known == grown_.end()) {
    auto scene = simulation.scene();
    if (!scene) {
      printError(formatSimulationError(scene.error()));
      return false;
    }
    grown_.push_back(std::make_unique<Grown>(
        Grown{std::move(program), simulation.view(), simulation.options().palette, std::move(*scene), hash}));
    kinds_.push_back(static_cast<std::uint32_t>(grown_.size() - 1));
    return true;
  }
  kinds_.push_back(static_cast<std::uint32_t>(known - grown_.begin()));
  return true;
}

PlantRows::Room PlantRows::room() const {
  Room largest;
  for (const auto& plant : grown_) {
    if (const std::optional<files::Box> box = turtle::boundsOf(plant->scene, plant->view)) {
      largest.width = std::max({largest.width, box->maximum.x - box->minimum.x, box->maximum.z - box->minimum.z});
      largest.height = std::max(largest.height, box->maximum.y - box->minimum.y);
    }
  }
  return largest;
}

bool PlantRows::write(const OutputOptions& options, double spacing, bool isQuiet) const {
  std::vector<turtle::ExportInput> scenes;
  for (const auto& plant : grown_) {
    scenes.push_back(
        {.scene = plant->scene, .view = plant->view, .palette = &plant->palette, .program = plant->program.get()});
  }
  const Room largest = room();
  const double own = largest.width > 0.0 ? kRoom * largest.width : 1.0;
  const double apart = spacing > 0.0 ? spacing : own;
  const double above = std::max(kRoom * largest.height, std::numeric_limits<double>::min());
  const auto columns = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(kinds_.size()))));
  std::vector<turtle::ScenePlacement> behind;
  std::vector<turtle::ScenePlacement> below;
  for (std::size_t i = 0; i < kinds_.size(); ++i) {
    const double x = static_cast<double>(i % columns) * apart;
    const auto row = static_cast<double>(i / columns);
    behind.push_back({.scene = kinds_[i], .position = {x, 0.0, -row * apart}});
    below.push_back({.scene = kinds_[i], .position = {x, -row * above, 0.0}});
  }
  OutputOptions pictures = options;
  OutputOptions meshes = options;
  const auto isPicture = [&](const std::string& file) { return formatOf(options, file)->name == "png"; };
  std::erase_if(pictures.files, [&](const std::string& file) { return !isPicture(file); });
  std::erase_if(meshes.files, isPicture);
  const std::string what = std::to_string(plantCount()) + " plants, " + std::to_string(kindCount()) + " different";
  return writePlacedFiles(meshes, scenes, behind, what, isQuiet) &&
         writePlacedFiles(pictures, scenes, below, what, isQuiet);
}

}  // namespace espalier::command
