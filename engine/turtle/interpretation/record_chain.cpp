#include "engine/turtle/interpretation/record_chain.h"

#include <algorithm>

namespace espalier::turtle {
namespace {

bool dependsOnStep(const language::Program& program, const language::Expression& expression) {
  for (std::uint32_t i = expression.code.begin; i < expression.code.end; ++i) {
    const language::Operation operation = program.code[i].operation;
    if (operation == language::Operation::LoadStep || operation == language::Operation::LoadLength) {
      return true;
    }
  }
  return false;
}

/// Whether the image of a module is the same whenever and wherever it is.
bool hasOneImage(const language::Program& program, const language::Production& production) {
  const bool isAlone = production.predecessor.size() == 1 && production.leftContext.empty() &&
                       production.rightContext.empty() && production.newLeftContext.empty() &&
                       production.newRightContext.empty();
  return isAlone && production.isPure && !production.drawsRandom && !production.probability &&
         !(production.condition && dependsOnStep(program, *production.condition)) &&
         std::none_of(production.expressions.begin(), production.expressions.end(),
                      [&](const language::Expression& expression) { return dependsOnStep(program, expression); });
}

}  // namespace

bool isRepeatable(const language::Program& program) {
  if (program.hasSubSystems) {
    return false;
  }
  // `?(id,k)` and its `$`
  for (std::size_t i = 0; i < program.moduleTypeCount(); ++i) {
    const auto type = static_cast<core::ModuleTypeId>(i);
    const char character = program.symbols[program.symbolOf[type]].character();
    if (type == program.subSystemEnd || (character == '?' && program.arity[type] > 0)) {
      return false;
    }
  }
  for (const language::LSystem& system : program.systems) {
    const auto& productions = system.homomorphism.productions;
    if (!std::all_of(productions.begin(), productions.end(),
                     [&](const language::Production& production) { return hasOneImage(program, production); })) {
      return false;
    }
  }
  return true;
}

std::vector<RecordChain::Place> RecordChain::places(std::size_t begin, std::size_t end) const {
  std::vector<Place> result;
  for (std::size_t i = begin; i < end; ++i) {
    const RecordGroup& group = *links[i].group;
    for (const RecordGroup::Link& link : group.links) {
      result.push_back({link.stretch.get(), &group, i, links[i].firstModule + link.firstModule,
                        links[i].firstRecord + link.firstRecord, link.firstOuter});
    }
  }
  return result;
}

std::uint32_t RecordChain::recordOf(const Place& place, std::uint32_t number) const {
  if (number == kNoParent) {
    return kNoParent;
  }
  return number >= kOuterRecord ? outerRecordOf(place, number - kOuterRecord) : place.firstRecord + number;
}

std::uint32_t RecordChain::outerRecordOf(const Place& place, std::size_t k) const {
  const Link& link = links[place.link];
  const std::uint32_t number = place.group->outer[place.firstOuter + k];
  if (number == kNoParent) {
    return kNoParent;
  }
  return number >= kOuterRecord ? outer[link.firstOuter + (number - kOuterRecord)] : link.firstRecord + number;
}

}  // namespace espalier::turtle
