#include <span>
#include <utility>

#include "engine/simulation/simulation_implementation.h"

namespace espalier::simulation {

using Outcome = std::optional<core::SimulationError>;

void Simulation::Implementation::drawPlant(std::size_t plant, const turtle::InterpretationOutput& output) {
  const PlantOrigin& origin = members_[plant].origin;
  // its own derivation: a picture prints nothing and cannot be cancelled with a step
  displayDerivations_.resize(plants_.size());
  std::unique_ptr<derivation::Derivation>& derivation = displayDerivations_[plant];
  if (derivation == nullptr) {
    derivation::DerivationOptions options = derivationOptions(static_cast<std::uint32_t>(plant), members_[plant]);
    options.cancelled = nullptr;
    if (options_.messages) {
      options.messages = [messages = options_.messages](core::MessageKind kind, std::string_view text) {
        if (kind == core::MessageKind::Warning) {
          messages(kind, text);
        }
      };
    }
    derivation = std::make_unique<derivation::Derivation>(programOf(plant), std::move(options));
  }
  models_.interpreter(origin.model)
      .interpret(*derivation, plants_[plant], static_cast<std::uint32_t>(plant), origin.placement, output);
}

Outcome Simulation::Implementation::draw(turtle::InterpretationOutput output) {
  output.fillsQueries = false;
  const bool hasPalette = models_.size() > 1 && !options_.palette.empty();
  turtle::Scene none;
  turtle::Scene& scene = output.scene == nullptr ? none : *output.scene;
  for (std::size_t plant = 0; plant < plants_.size(); ++plant) {
    if (!members_[plant].isAlive()) {
      continue;
    }
    const PlantOrigin& origin = members_[plant].origin;
    const ModelSet::SceneMark mark(scene);
    const language::LineStyle lineStyle = scene.lineStyle;
    const std::size_t firstRecord = output.records == nullptr ? 0 : output.records->size();
    PlantVariables before;
    before.copyFrom(plants_[plant]);
    Outcome outcome;
    try {
      drawPlant(plant, output);
    } catch (const core::SimulationFailure& failure) {
      outcome = failed(failure.error());
    }
    // whatever the homomorphism's blocks did is taken back
    before.copyTo(plants_[plant]);
    if (outcome) {
      return outcome;
    }
    if (origin.model != 0) {
      scene.lineStyle = mark.isEmpty() ? scene.lineStyle : lineStyle;
    }
    if (output.records != nullptr) {
      models_.toCommonSymbols(origin.model, std::span(*output.records).subspan(firstRecord));
    }
    const int block = hasPalette ? kBlocksPerModel * static_cast<int>(origin.model) : 0;
    models_.toCommonNumbers(origin.model, origin.colourShift + block * language::Palette::kBlockSize, mark, scene);
  }
  return std::nullopt;
}

}  // namespace espalier::simulation
