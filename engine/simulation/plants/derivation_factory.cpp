#include "engine/simulation/plants/derivation_factory.h"

#include <algorithm>
#include <utility>

namespace espalier::simulation {

std::uint64_t DerivationFactory::seed() const {
  return options_->hasSeed ? options_->seed : models_->modelSeed().value_or(options_->seed);
}

std::uint64_t DerivationFactory::runLength() const {
  return options_->derivationLength.value_or(models_->longestDerivation());
}

std::optional<std::uint64_t> DerivationFactory::lengthOf(const Plant& member) const {
  // alone a model knows its own length; in company all end with the run
  if (models_->size() == 1 && member.birthStep == 0) {
    return options_->derivationLength;
  }
  return std::max(runLength(), member.birthStep) - member.birthStep;
}

derivation::DerivationOptions DerivationFactory::options(std::uint32_t plant, const Plant& member) const {
  derivation::DerivationOptions options;
  options.seed = seed();
  // of several models one names the seed of all
  options.hasSeed = options_->hasSeed || models_->size() > 1;
  options.plant = plant;
  options.derivationLength = lengthOf(member);
  options.threads = options_->threads;
  options.limits = options_->limits;
  options.cancelled = isCancelled_;
  options.messages = options_->messages;
  options.canWriteFiles = options_->fileWriter != nullptr;
  return options;
}

std::unique_ptr<derivation::Derivation> DerivationFactory::forSteps(std::uint32_t plant, const Plant& member) const {
  derivation::DerivationOptions options = this->options(plant, member);
  if (messages_->isWanted()) {
    options.messages = [messages = messages_, plant](core::MessageKind kind, std::string_view text) {
      messages->deliver(plant, kind, text);
    };
  }
  return std::make_unique<derivation::Derivation>(*models_->programs()[member.origin.model], std::move(options));
}

std::unique_ptr<derivation::Derivation> DerivationFactory::forDrawing(std::uint32_t plant, const Plant& member) const {
  derivation::DerivationOptions options = this->options(plant, member);
  options.cancelled = nullptr;
  if (options_->messages) {
    options.messages = [messages = options_->messages](core::MessageKind kind, std::string_view text) {
      if (kind == core::MessageKind::Warning) {
        messages(kind, text);
      }
    };
  }
  return std::make_unique<derivation::Derivation>(*models_->programs()[member.origin.model], std::move(options));
}

}  // namespace espalier::simulation
