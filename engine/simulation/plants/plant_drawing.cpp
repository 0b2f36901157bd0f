#include "engine/simulation/plants/plant_drawing.h"

#include <span>
#include <utility>

#include "engine/simulation/plants/plant_variables.h"
#include "engine/turtle/interpretation/record_chain.h"

namespace espalier::simulation {

void PlantDrawing::drawPlant(std::size_t plant, const turtle::InterpretationOutput& output) {
  derivation::PlantState& state = population_->states()[plant];
  PlantVariables before;
  before.copyFrom(state);
  try {
    population_->interpreter(plant).interpret(population_->displayDerivation(plant), state,
                                              static_cast<std::uint32_t>(plant),
                                              population_->member(plant).origin.placement, output);
  } catch (...) {
    before.copyTo(state);
    throw;
  }
  before.copyTo(state);
}

void PlantDrawing::draw(turtle::InterpretationOutput output) {
  output.fillsQueries = false;
  const bool hasPalette = models_->size() > 1 && !options_->palette.empty();
  turtle::Scene none;
  turtle::Scene& scene = output.scene == nullptr ? none : *output.scene;
  for (std::size_t plant = 0; plant < population_->states().size(); ++plant) {
    if (!population_->member(plant).isAlive()) {
      continue;
    }
    const PlantOrigin& origin = population_->member(plant).origin;
    const ModelSet::SceneMark mark(scene);
    const files::LineStyle lineStyle = scene.lineStyle;
    const std::size_t firstRecord = output.records == nullptr ? 0 : output.records->size();
    drawPlant(plant, output);
    // the first model's line style is everybody's, unless nothing was drawn with it
    if (origin.model != 0) {
      scene.lineStyle = mark.isEmpty() ? scene.lineStyle : lineStyle;
    }
    if (output.records != nullptr) {
      models_->toCommonSymbols(origin.model, std::span(*output.records).subspan(firstRecord));
    }
    const int block = hasPalette ? kBlocksPerModel * static_cast<int>(origin.model) : 0;
    models_->toCommonNumbers(origin.model, origin.colourShift + block * files::Palette::kBlockSize, mark, scene);
  }
}

void PlantDrawing::chainRecords(const turtle::RecordChain* base, turtle::RecordChain& chain) {
  chain.programs = models_->programs();
  // other Programs mean other modules
  if (base != nullptr && base->programs != chain.programs) {
    base = nullptr;
  }
  for (std::size_t plant = 0; plant < population_->states().size(); ++plant) {
    const PlantOrigin& origin = population_->member(plant).origin;
    chain.origins.push_back({origin.model, origin.placement});
    if (population_->member(plant).isAlive()) {
      const bool isKnown =
          base != nullptr && plant < base->origins.size() && base->origins[plant] == chain.origins.back();
      const auto rename = [&](std::span<turtle::TurtleRecord> records) {
        models_->toCommonSymbols(origin.model, records);
      };
      population_->interpreter(plant).appendRecords(population_->displayDerivation(plant), population_->states()[plant],
                                                    static_cast<std::uint32_t>(plant), origin.placement,
                                                    isKnown ? base : nullptr, rename, chain);
    }
    chain.firstLink.push_back(chain.links.size());
  }
}

}  // namespace espalier::simulation
