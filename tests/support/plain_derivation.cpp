#include "tests/support/plain_derivation.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "engine/core/random.h"
#include "engine/language/arithmetic.h"

namespace espalier::test {

using language::ContextElement;
using language::Operation;

PlainDerivation::PlainDerivation(const language::Program& program, std::uint64_t seed)
    : program_(&program),
      seed_(seed),
      statics_(program.staticCount, 0.0),
      variables_(program.systems[0].variables.size(), 0.0),
      elements_(program.systems[0].arrayElementCount, 0.0) {
  for (const language::ArrayVariable& array : program.systems[0].arrays) {
    for (std::size_t i = 0; i < array.initial.size(); ++i) {
      elements_.at(array.firstElement + i) = array.initial[i];
    }
  }
}

double PlainDerivation::value(const language::Expression& expression, Frame& frame, double step, Draws& draws) {
  if (expression.kind == language::Expression::Kind::Constant) {
    return expression.constant;
  }
  if (expression.kind == language::Expression::Kind::Slot) {
    return frame.at(expression.slot);
  }
  return run(expression.code, frame, step, draws);
}

double& PlainDerivation::element(const language::Instruction& instruction, const std::vector<double>& subscripts) {
  const language::ArrayVariable& array = program_->systems[0].arrays.at(instruction.operand);
  std::size_t index = 0;
  for (std::size_t i = 0; i < array.dimensions.size(); ++i) {
    const double last = array.dimensions[i] - 1.0;
    const double subscript = std::isnan(subscripts.at(i)) ? 0.0 : std::trunc(subscripts[i]);
    index = index * array.dimensions[i] + static_cast<std::size_t>(subscript < 0.0    ? 0.0
                                                                   : subscript > last ? last
                                                                                      : subscript);
  }
  return elements_.at(array.firstElement + index);
}

double PlainDerivation::run(language::CodeRange code, Frame& frame, double step, Draws& draws) {
  std::vector<double> stack;
  const auto pop = [&stack] {
    const double top = stack.back();
    stack.pop_back();
    return top;
  };
  const auto popAll = [&](std::size_t count) {
    std::vector<double> arguments(count);
    for (std::size_t i = count; i-- > 0;) {
      arguments[i] = pop();
    }
    return arguments;
  };
  bool dividedByZero = false;
  for (std::size_t at = code.begin; at < code.end;) {
    const language::Instruction& instruction = program_->code.at(at++);
    switch (instruction.operation) {
      case Operation::Constant:
        stack.push_back(program_->constants.at(instruction.operand));
        break;
      case Operation::LoadSlot:
        stack.push_back(frame.at(instruction.operand));
        break;
      case Operation::LoadStatic:
        stack.push_back(statics_.at(instruction.operand));
        break;
      case Operation::LoadVariable:
        stack.push_back(variables_.at(instruction.operand));
        break;
      case Operation::LoadElement:
        stack.push_back(element(instruction, popAll(instruction.count)));
        break;
      case Operation::StoreSlot:
        frame.at(instruction.operand) = pop();
        break;
      case Operation::StoreStatic:
        statics_.at(instruction.operand) = pop();
        break;
      case Operation::StoreVariable:
        variables_.at(instruction.operand) = pop();
        break;
      case Operation::StoreElement: {
        const double stored = pop();
        element(instruction, popAll(instruction.count)) = stored;
        break;
      }
      case Operation::Pop:
        static_cast<void>(pop());
        break;
      case Operation::LoadStep:
        stack.push_back(step);
        break;
      case Operation::LoadLength:
        stack.push_back(static_cast<double>(program_->derivationLength));
        break;
      case Operation::Negate:
      case Operation::Not:
      case Operation::ToBoolean:
        stack.push_back(language::applyUnary(instruction.operation, pop()));
        break;
      case Operation::Select: {
        const double second = pop();
        const double first = pop();
        stack.push_back(pop() != 0.0 ? first : second);
        break;
      }
      case Operation::Call: {
        const std::vector<double> arguments = popAll(instruction.count);
        const auto function = static_cast<language::Function>(instruction.operand);
        const auto uniform = [&] {
          return core::CounterRandom(seed_, 0).uniform(core::DrawDomain::Production, static_cast<std::uint32_t>(step),
                                                       draws.module, draws.count++);
        };
        if (function == language::Function::Ran) {
          stack.push_back(arguments[0] * uniform());
          break;
        }
        if (function == language::Function::Nran) {
          // a point inside the unit circle
          double x = 0.0;
          double y = 0.0;
          do {
            x = 2.0 * uniform() - 1.0;
            y = 2.0 * uniform() - 1.0;
          } while (x * x + y * y >= 1.0 || x * x + y * y == 0.0);
          const double square = x * x + y * y;
          stack.push_back(arguments[0] + arguments[1] * y * std::sqrt(-2.0 * core::log(square) / square));
          break;
        }
        stack.push_back(language::callPure(function, arguments, dividedByZero));
        break;
      }
      case Operation::Jump:
        at = instruction.operand;
        break;
      case Operation::JumpIfZero:
        at = pop() == 0.0 ? instruction.operand : at;
        break;
      case Operation::JumpIfNonZero:
        at = pop() != 0.0 ? instruction.operand : at;
        break;
      default: {
        if (instruction.operation < Operation::Add || instruction.operation > Operation::LogicalOr) {
          throw std::logic_error("an instruction that the plain derivation does not know");
        }
        const double b = pop();
        const double a = pop();
        stack.push_back(language::applyBinary(instruction.operation, a, b, dividedByZero));
      }
    }
  }
  return stack.empty() ? 0.0 : stack.back();
}

bool PlainDerivation::isIgnored(core::ModuleTypeId type) const {
  return program_->systems[0].isIgnored.at(program_->symbolOf[type]);
}

namespace {

void bind(const PlainModule& module, const language::FormalModule& formal, std::vector<double>& frame) {
  for (std::size_t i = 0; i < module.parameters.size(); ++i) {
    frame.at(formal.firstSlot + i) = module.parameters[i];
  }
}

}  // namespace

bool PlainDerivation::matchesPredecessor(const PlainString& old, std::size_t at, const language::Production& production,
                                         Frame& frame) const {
  for (std::size_t i = 0; i < production.predecessor.size(); ++i) {
    if (at + i >= old.size() || old[at + i].type != production.predecessor[i].type) {
      return false;
    }
    bind(old[at + i], production.predecessor[i], frame);
  }
  return true;
}

bool PlainDerivation::matchesLeft(const PlainString& old, std::size_t at, const language::Production& production,
                                  Frame& frame) const {
  for (const ContextElement& element : production.leftContext) {
    while (true) {
      if (at == 0) {
        return false;
      }
      --at;
      const core::ModuleTypeId type = old[at].type;
      if (type == program_->closeBranch) {
        // a finished branch: go to its beginning
        int depth = 1;
        while (depth > 0) {
          if (at == 0) {
            return false;
          }
          --at;
          depth += old[at].type == program_->closeBranch ? 1 : 0;
          depth -= old[at].type == program_->openBranch ? 1 : 0;
        }
        continue;
      }
      if (type == program_->openBranch || isIgnored(type)) {
        continue;
      }
      if (type != element.module.type) {
        return false;
      }
      bind(old[at], element.module, frame);
      break;
    }
  }
  return true;
}

bool PlainDerivation::matchesRight(const PlainString& old, std::size_t behind, const language::Production& production,
                                   Frame& frame) const {
  std::size_t at = behind;
  const auto skipBranch = [&] {
    int depth = 1;
    while (depth > 0) {
      if (++at >= old.size()) {
        return false;
      }
      depth += old[at].type == program_->openBranch ? 1 : 0;
      depth -= old[at].type == program_->closeBranch ? 1 : 0;
    }
    ++at;
    return true;
  };
  for (const ContextElement& element : production.rightContext) {
    if (element.kind == ContextElement::Kind::SkipToBranchEnd) {
      while (at < old.size() && old[at].type != program_->closeBranch) {
        if (old[at].type != program_->openBranch) {
          ++at;
        } else if (!skipBranch()) {
          return false;
        }
      }
      if (at >= old.size()) {
        return false;
      }
      continue;
    }
    while (true) {
      if (at >= old.size()) {
        return false;
      }
      const core::ModuleTypeId type = old[at].type;
      if (isIgnored(type)) {
        ++at;
      } else if (type == program_->openBranch && element.kind != ContextElement::Kind::OpenBranch) {
        if (!skipBranch()) {
          return false;
        }
      } else if (type != element.module.type) {
        return false;
      } else {
        bind(old[at], element.module, frame);
        ++at;
        break;
      }
    }
  }
  return true;
}

PlainString PlainDerivation::axiom() {
  PlainString string;
  Draws draws;
  Frame none;
  run(program_->systems[0].start, none, 0.0, draws);
  for (const language::SuccessorModule& module : program_->systems[0].axiom) {
    PlainModule made{module.type, {}};
    for (std::size_t i = 0; i < program_->arity[module.type]; ++i) {
      made.parameters.push_back(
          value(program_->systems[0].axiomExpressions.at(module.firstExpression + i), none, 0.0, draws));
    }
    string.push_back(std::move(made));
  }
  return string;
}

std::vector<PlainDerivation::Match> PlainDerivation::matches(const PlainString& old, std::size_t at, double step,
                                                             Draws& draws) {
  const language::LSystem& system = program_->systems[0];
  std::vector<Match> found;
  for (const language::Production& production : system.productions.productions) {
    Frame frame(production.slotCount, 0.0);
    if (!matchesPredecessor(old, at, production, frame) ||
        !matchesRight(old, at + production.predecessor.size(), production, frame) ||
        !matchesLeft(old, at, production, frame)) {
      continue;
    }
    run(production.preBlock, frame, step, draws);
    if (production.condition && value(*production.condition, frame, step, draws) == 0.0) {
      continue;
    }
    found.push_back({&production, std::move(frame), 1.0});
    if (!system.isStochastic) {
      break;
    }
    found.back().weight =
        production.probability ? value(*production.probability, found.back().frame, step, draws) : 1.0;
  }
  return found;
}

PlainString PlainDerivation::successor(Match& match, double step, Draws& draws) {
  PlainString made;
  run(match.production->postBlock, match.frame, step, draws);
  for (const language::SuccessorModule& module : match.production->successor) {
    PlainModule next{module.type, {}};
    for (std::size_t i = 0; i < program_->arity[module.type]; ++i) {
      next.parameters.push_back(
          value(match.production->expressions.at(module.firstExpression + i), match.frame, step, draws));
    }
    made.push_back(std::move(next));
  }
  return made;
}

void PlainDerivation::decompose(const PlainModule& module, std::uint32_t depth, double step, Draws& draws,
                                PlainString& made) {
  const language::ProductionList& list = program_->systems[0].decomposition;
  for (const language::Production& production : list.productions) {
    Match match{&production, Frame(production.slotCount, 0.0), 1.0};
    if (depth >= list.maximumDepth || !matchesPredecessor({module}, 0, production, match.frame)) {
      continue;
    }
    run(production.preBlock, match.frame, step, draws);
    if (production.condition && value(*production.condition, match.frame, step, draws) == 0.0) {
      continue;
    }
    for (const PlainModule& part : successor(match, step, draws)) {
      decompose(part, depth + 1, step, draws, made);
    }
    return;
  }
  made.push_back(module);
}

PlainString PlainDerivation::derive(const PlainString& old, std::uint64_t step) {
  const language::LSystem& system = program_->systems[0];
  const core::CounterRandom random(seed_, 0);
  const auto q = static_cast<double>(step);
  Draws ofBlocks;
  Frame none;
  run(system.startEach, none, q, ofBlocks);
  PlainString made;
  for (std::size_t at = 0; at < old.size();) {
    // all productions that apply here, in the order of the file
    Draws draws{at, 0};
    std::vector<Match> found = matches(old, at, q, draws);
    const bool isDecomposed = std::any_of(
        system.decomposition.productions.begin(), system.decomposition.productions.end(),
        [&](const language::Production& production) { return production.predecessor[0].type == old[at].type; });
    if (found.empty() && old[at].type == program_->cut && !isDecomposed) {
      // the rest of the branch goes
      int depth = 0;
      while (at < old.size() && (depth > 0 || old[at].type != program_->closeBranch)) {
        depth += old[at].type == program_->openBranch ? 1 : 0;
        depth -= old[at].type == program_->closeBranch ? 1 : 0;
        ++at;
      }
      continue;
    }
    if (found.empty()) {
      decompose(old[at++], 0, q, draws, made);
      continue;
    }
    std::size_t chosen = 0;
    if (system.isStochastic) {
      double remainder = 0.0;
      for (const Match& match : found) {
        remainder += match.weight;
      }
      remainder *= 1.0 - random.selection(static_cast<std::uint32_t>(step), at);
      for (chosen = 0; chosen + 1 < found.size(); ++chosen) {
        remainder -= found[chosen].weight;
        if (remainder <= 0.0) {
          break;
        }
      }
    }
    for (const PlainModule& module : successor(found[chosen], q, draws)) {
      decompose(module, 0, q, draws, made);
    }
    at += found[chosen].production->predecessor.size();
  }
  return made;
}

}  // namespace espalier::test
