#include "engine/simulation/plants/plant_drawing.h"

#include <span>
#include <utility>

#include "engine/simulation/plants/plant_variables.h"
#include "engine/turtle/interpretation/record_chain.h"

namespace espalier::simulation {

derivation::Derivation* PlantDrawing::derivationOf(const std::vector<Plant>& members, std::size_t plant) {
  derivations_.resize(members.size());
  Expansion& expansion = derivations_[plant];
  if (!members[plant].isAlive()) {
    expansion.derivation = nullptr;
  } else if (expansion.derivation == nullptr || expansion.birthStep != members[plant].birthStep) {
    expansion = {members[plant].birthStep, factory_->forDrawing(static_cast<std::uint32_t>(plant), members[plant])};
  }
  return expansion.derivation.get();
}

void PlantDrawing::drawPlant(std::size_t plant, const PlantOrigin& origin, derivation::Derivation& derivation,
                             derivation::PlantState& state, const turtle::InterpretationOutput& output) {
  PlantVariables before;
  before.copyFrom(state);
  try {
    models_->interpreter(origin.model)
        .interpret(derivation, state, static_cast<std::uint32_t>(plant), origin.placement, output);
  } catch (...) {
    before.copyTo(state);
    throw;
  }
  before.copyTo(state);
}

void PlantDrawing::draw(const std::vector<Plant>& members, std::vector<derivation::PlantState>& states,
                        turtle::InterpretationOutput output) {
  output.fillsQueries = false;
  const bool hasPalette = models_->size() > 1 && !options_->palette.empty();
  turtle::Scene none;
  turtle::Scene& scene = output.scene == nullptr ? none : *output.scene;
  for (std::size_t plant = 0; plant < states.size(); ++plant) {
    derivation::Derivation* const derivation = derivationOf(members, plant);
    if (derivation == nullptr) {
      continue;
    }
    const PlantOrigin& origin = members[plant].origin;
    const turtle::SceneMark mark(scene);
    const files::LineStyle lineStyle = scene.lineStyle;
    const std::size_t firstRecord = output.records == nullptr ? 0 : output.records->size();
    drawPlant(plant, origin, *derivation, states[plant], output);
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

void PlantDrawing::chainRecords(const std::vector<Plant>& members, std::vector<derivation::PlantState>& states,
                                const turtle::RecordChain* base, const std::vector<derivation::StepChanges>& changes,
                                turtle::RecordChain& chain) {
  const derivation::StepChanges unknown;
  chain.programs = models_->programs();
  // other Programs mean other modules
  if (base != nullptr && base->programs != chain.programs) {
    base = nullptr;
  }
  for (std::size_t plant = 0; plant < states.size(); ++plant) {
    const PlantOrigin& origin = members[plant].origin;
    chain.origins.push_back({origin.model, origin.placement});
    if (derivation::Derivation* const derivation = derivationOf(members, plant)) {
      const bool isKnown =
          base != nullptr && plant < base->origins.size() && base->origins[plant] == chain.origins.back();
      const auto rename = [&](std::span<turtle::TurtleRecord> records) {
        models_->toCommonSymbols(origin.model, records);
      };
      models_->interpreter(origin.model)
          .appendRecords(*derivation, states[plant], static_cast<std::uint32_t>(plant), origin.placement,
                         isKnown ? base : nullptr, plant < changes.size() ? changes[plant] : unknown, rename, chain);
    }
    chain.firstLink.push_back(chain.links.size());
  }
}

}  // namespace espalier::simulation
