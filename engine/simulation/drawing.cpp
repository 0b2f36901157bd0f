#include <span>
#include <utility>

#include "engine/simulation/simulation_implementation.h"
#include "engine/turtle/interpretation/record_chain.h"

namespace espalier::simulation {

using Outcome = std::optional<core::SimulationError>;

derivation::Derivation& Simulation::Implementation::displayDerivation(std::size_t plant) {
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
  return *derivation;
}

void Simulation::Implementation::drawPlant(std::size_t plant, const turtle::InterpretationOutput& output) {
  const PlantOrigin& origin = members_[plant].origin;
  models_.interpreter(origin.model)
      .interpret(displayDerivation(plant), plants_[plant], static_cast<std::uint32_t>(plant), origin.placement, output);
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
    const files::LineStyle lineStyle = scene.lineStyle;
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
    models_.toCommonNumbers(origin.model, origin.colourShift + block * files::Palette::kBlockSize, mark, scene);
  }
  return std::nullopt;
}

Outcome Simulation::Implementation::chainRecords(const turtle::RecordChain* base, turtle::RecordChain& chain) {
  chain.programs = models_.programs();
  // other Programs mean other modules
  if (base != nullptr && base->programs != chain.programs) {
    base = nullptr;
  }
  for (std::size_t plant = 0; plant < plants_.size(); ++plant) {
    const PlantOrigin& origin = members_[plant].origin;
    chain.origins.push_back({origin.model, origin.placement});
    if (members_[plant].isAlive()) {
      const bool isKnown =
          base != nullptr && plant < base->origins.size() && base->origins[plant] == chain.origins.back();
      const auto rename = [&](std::span<turtle::TurtleRecord> records) {
        models_.toCommonSymbols(origin.model, records);
      };
      try {
        models_.interpreter(origin.model)
            .appendRecords(displayDerivation(plant), plants_[plant], static_cast<std::uint32_t>(plant),
                           origin.placement, isKnown ? base : nullptr, rename, chain);
      } catch (const core::SimulationFailure& failure) {
        return failed(failure.error());
      }
    }
    chain.firstLink.push_back(chain.links.size());
  }
  return std::nullopt;
}

}  // namespace espalier::simulation
