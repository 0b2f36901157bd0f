#include <algorithm>
#include <array>

#include "engine/turtle/interpretation/interpretation.h"
#include "engine/turtle/turtle_motion.h"

namespace espalier::turtle {

using core::Vec3;

std::uint64_t Interpretation::executeQuery(const Sequence& sequence, std::uint64_t i, std::uint64_t offset) {
  const std::uint64_t next = i + 1;
  if (next >= sequence.count) {
    return 1;
  }
  const core::ModuleTypeId type = sequence.types[next];
  const language::Symbol& symbol = program_.symbols[program_.symbolOf[type]];
  const char character = symbol.character();
  if (symbol.isQuery || character == 'E') {
    communicate(sequence, next, offset);
    return 2;
  }
  // any other symbol after `?` is interpreted on its own
  return fillQuery(character, sequence, offset, program_.arity[type]) ? 2 : 1;
}

void Interpretation::askAgain(std::uint64_t module, std::uint64_t offset, const QueryPlace& place) {
  state_.position = place.position;
  state_.frame = place.frame;
  state_.width = place.width;
  state_.scale = place.scale;
  module_ = module - 1;
  communicate(
      {plantState_.string.types().data(), plantState_.string.parameters().data(), plantState_.string.size(), false},
      module, offset);
}

bool Interpretation::fillQuery(char character, const Sequence& sequence, std::uint64_t offset, std::uint16_t arity) {
  const auto fillVector = [&](const Vec3& v) { fill(sequence, offset, arity, std::array{v.x, v.y, v.z}); };
  switch (character) {
    case 'P':
      fillVector(coordinates_.toPlantPoint(state_.position));
      return true;
    case 'H':
      fillVector(coordinates_.toPlantDirection(state_.frame.heading));
      return true;
    case 'L':
      fillVector(coordinates_.toPlantDirection(state_.frame.left));
      return true;
    case 'U':
      fillVector(coordinates_.toPlantDirection(state_.frame.up));
      return true;
    case 'Q': {
      const core::Frame frame{coordinates_.toPlantDirection(state_.frame.heading),
                              coordinates_.toPlantDirection(state_.frame.left),
                              coordinates_.toPlantDirection(state_.frame.up)};
      fill(sequence, offset, arity, quaternionOf(frame));
      return true;
    }
    case 'F': {
      if (isCompatible()) {
        return false;
      }
      const Vec3 p = coordinates_.toPlantPoint(state_.position);
      const Vec3 h = coordinates_.toPlantDirection(state_.frame.heading);
      const Vec3 l = coordinates_.toPlantDirection(state_.frame.left);
      const Vec3 u = coordinates_.toPlantDirection(state_.frame.up);
      fill(sequence, offset, arity, std::array{p.x, p.y, p.z, h.x, h.y, h.z, l.x, l.y, l.z, u.x, u.y, u.z});
      return true;
    }
    default:
      return false;
  }
}

void Interpretation::fill(const Sequence& sequence, std::uint64_t offset, std::uint16_t arity,
                          std::span<const double> values) {
  isTouched_ = true;
  if (sequence.isImage || !output_.fillsQueries) {
    return;
  }
  const std::size_t count = std::min<std::size_t>(arity, values.size());
  for (std::size_t k = 0; k < count; ++k) {
    const double before = sequence.parameters[offset + k];
    const double value = isCompatible() ? static_cast<double>(static_cast<float>(values[k])) : values[k];
    if (!isCompatible() && !std::isfinite(value)) [[unlikely]] {
      // in the plant's own coordinates; the turtle's are checked as it moves
      fail(core::SimulationErrorCode::NonFinite,
           "the answer to this query is not a finite number. Bound the place and the directions of the plant");
    }
    if (output_.changes != nullptr) {
      output_.changes->push_back({offset + k, before, module_});
    }
    plantState_.string.setParameter(offset + k, value);
  }
}

void Interpretation::fillLegacyPosition(const Sequence& sequence, std::uint64_t offset, std::uint16_t arity) {
  if (isCompatible() && isEnvironmentPass_) {
    static_cast<void>(fillQuery('P', sequence, offset, arity));
  }
}

void Interpretation::communicate(const Sequence& sequence, std::uint64_t i, std::uint64_t offset) {
  isTouched_ = true;
  if (output_.queries == nullptr) {
    return;
  }
  QueryBatch& batch = *output_.queries;
  if (batch.size() >= derivation_.options().limits.maximumQueries) {
    fail(core::SimulationErrorCode::LimitExceeded,
         "more than " + std::to_string(derivation_.options().limits.maximumQueries) +
             " communication modules in one step, the limit queries. Raise the limit if the model is meant to "
             "do this");
  }
  const core::ModuleTypeId type = sequence.types[i];
  const std::uint16_t arity = program_.arity[type];
  // the module, its turtle state as far as it is needed, its parameters
  batch.plant.push_back(plant_);
  batch.module.push_back(sequence.isImage ? module_ : i);
  batch.symbol.push_back(program_.symbolOf[type]);
  batch.isTransient.push_back(sequence.isImage ? 1 : 0);
  if (output_.needs.position) {
    batch.position.push_back(state_.position);
  }
  if (output_.needs.heading) {
    batch.heading.push_back(state_.frame.heading);
  }
  if (output_.needs.left) {
    batch.left.push_back(state_.frame.left);
  }
  if (output_.needs.up) {
    batch.up.push_back(state_.frame.up);
  }
  if (output_.needs.width) {
    batch.width.push_back(state_.width);
  }
  if (output_.needs.scale) {
    batch.scale.push_back(state_.scale);
  }
  if (batch.parameterOffset.empty()) {
    batch.parameterOffset.push_back(0);
  }
  batch.parameters.insert(batch.parameters.end(), sequence.parameters + offset, sequence.parameters + offset + arity);
  batch.parameterOffset.push_back(batch.parameters.size());
  if (output_.queryParameterOffsets != nullptr) {
    output_.queryParameterOffsets->push_back(sequence.isImage ? kTransientQuery : offset);
  }
  if (!output_.needs.following) {
    return;
  }
  // the next module as written; of a pair (~x, @x) the second, which carries the parameters
  std::uint64_t next = i + 1;
  std::uint64_t nextOffset = offset + arity;
  char pair = '\0';
  if (next + 1 < sequence.count && program_.arity[sequence.types[next]] == 0) {
    const char character = characterOf(sequence.types[next]);
    const bool isPair = character == '~' || character == '@';
    next += isPair ? 1U : 0U;
    pair = isPair ? character : '\0';
  }
  batch.followingPair.push_back(pair);
  if (batch.followingOffset.empty()) {
    batch.followingOffset.push_back(0);
  }
  if (next < sequence.count) {
    const core::ModuleTypeId followingType = sequence.types[next];
    batch.following.push_back(program_.symbolOf[followingType]);
    batch.followingParameters.insert(batch.followingParameters.end(), sequence.parameters + nextOffset,
                                     sequence.parameters + nextOffset + program_.arity[followingType]);
  } else {
    batch.following.push_back(core::kNoSymbol);
  }
  batch.followingOffset.push_back(batch.followingParameters.size());
}

}  // namespace espalier::turtle
