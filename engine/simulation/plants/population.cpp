#include "engine/simulation/plants/population.h"

#include <algorithm>
#include <utility>

#include "engine/derivation/state/string_text.h"

namespace espalier::simulation {

Population::Population(const ModelSet& models, const DerivationFactory& factory, std::vector<Plant> members)
    : models_(&models), factory_(&factory), members_(std::move(members)) {
  for (std::uint32_t plant = 0; plant < members_.size(); ++plant) {
    derivations_.push_back(members_[plant].isAlive() ? factory.forSteps(plant, members_[plant]) : nullptr);
  }
}

std::uint64_t Population::livingCount() const {
  return static_cast<std::uint64_t>(
      std::count_if(members_.begin(), members_.end(), [](const Plant& member) { return member.isAlive(); }));
}

const std::shared_ptr<const std::vector<Plant>>& Population::sharedMembers() {
  if (sharedMembers_ == nullptr) {
    sharedMembers_ = std::make_shared<const std::vector<Plant>>(members_);
  }
  return sharedMembers_;
}

void Population::reseed() {
  for (const auto& derivation : derivations_) {
    if (derivation != nullptr) {
      derivation->setSeed(factory_->seed());
    }
  }
}

std::vector<Plant> Population::founders() const {
  std::vector<Plant> founders;
  for (const Plant& member : members_) {
    if (member.birthStep == 0) {
      founders.push_back({.origin = member.origin});
    }
  }
  return founders;
}

std::vector<core::Vec3> Population::places() const {
  std::vector<core::Vec3> places;
  for (const Plant& member : members_) {
    if (member.isAlive()) {
      places.push_back(member.origin.placement.position);
    }
  }
  return places;
}

void Population::add(Plant member, derivation::PlantState state, std::unique_ptr<derivation::Derivation> derivation) {
  members_.push_back(std::move(member));
  states_.push_back(std::move(state));
  derivations_.push_back(std::move(derivation));
  sharedMembers_ = nullptr;
}

void Population::end(std::size_t plant, std::uint64_t deathStep) {
  members_[plant].deathStep = deathStep;
  derivation::PlantState rest;
  rest.step = states_[plant].step;
  rest.derivationLength = states_[plant].derivationLength;
  states_[plant] = std::move(rest);
  derivations_[plant].reset();
  sharedMembers_ = nullptr;
}

Population::Totals Population::totals() const {
  Totals totals;
  for (const derivation::PlantState& plant : states_) {
    totals.modules += plant.string.size();
    totals.parameters += plant.string.parameterCount();
    totals.bytes += plant.string.bytes();
  }
  return totals;
}

std::uint64_t Population::derivationLength() const {
  if (states_.empty()) {
    return factory_->runLength();
  }
  std::uint64_t length = 0;
  for (std::size_t plant = 0; plant < states_.size(); ++plant) {
    length = std::max(length, members_[plant].birthStep + states_[plant].derivationLength);
  }
  return length;
}

bool Population::isFinished(std::uint64_t completedSteps) const {
  for (std::size_t plant = 0; plant < states_.size(); ++plant) {
    const derivation::PlantState& state = states_[plant];
    if (members_[plant].isAlive() && !state.isStopped &&
        completedSteps < members_[plant].birthStep + state.derivationLength) {
      return false;
    }
  }
  return true;
}

namespace {

void hashFiles(core::Hasher& hasher, const derivation::FileState& files) {
  for (const derivation::OpenFile& file : files.open) {
    hasher.integer(file.file);
    hasher.integer(file.mode.bits());
    hasher.integer(file.position);
    hasher.integer(file.isOpen ? 1 : 0);
  }
  for (const derivation::KeptFile& file : files.kept) {
    hasher.integer(file.file);
    hasher.integer(file.text.size());
    hasher.bytes(file.text);
  }
}

void hashPlant(core::Hasher& hasher, const language::Program& program, const derivation::PlantState& plant) {
  hasher.integer(derivation::hashOf(program, plant.string));
  hasher.integer(plant.step);
  hasher.integer(plant.derivationLength);
  hasher.integer(plant.isStopped ? 1 : 0);
  for (const double value : plant.statics) {
    hasher.number(value);
  }
  for (const derivation::InstanceState& instance : plant.instances) {
    hasher.integer(instance.system);
    hasher.integer(instance.hasStarted ? 1 : 0);
    for (const double value : instance.variables) {
      hasher.number(value);
    }
    for (const double value : instance.elements) {
      hasher.number(value);
    }
  }
  hasher.integer(plant.random.seed);
  hasher.integer(plant.random.mainSeed);
  hasher.integer(plant.random.selection.state());
  hasher.integer(plant.random.main.state());
  hasher.number(plant.random.normalCache);
  hasher.number(plant.random.normalCacheFlag);
  hashFiles(hasher, plant.files);
}

}  // namespace

void Population::hash(core::Hasher& hasher) const {
  for (std::size_t plant = 0; plant < states_.size(); ++plant) {
    const Plant& member = members_[plant];
    if (member.birthStep != 0 || !member.isAlive()) {
      hasher.integer(member.birthStep);
      hasher.integer(member.deathStep);
      hasher.number(member.origin.placement.position.x);
      hasher.number(member.origin.placement.position.y);
      hasher.number(member.origin.placement.position.z);
    }
    hashPlant(hasher, program(plant), states_[plant]);
  }
}

}  // namespace espalier::simulation
