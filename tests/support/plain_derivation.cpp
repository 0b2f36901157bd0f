#include "tests/support/plain_derivation.h"

#include <optional>
#include <stdexcept>

#include "engine/core/random.h"
#include "engine/language/arithmetic.h"

namespace espalier::test {

using language::ContextElement;
using language::Operation;

PlainDerivation::PlainDerivation(const language::Program& program, std::uint64_t seed)
    : program_(&program), seed_(seed) {}

double PlainDerivation::value(const language::Expression& expression, const Frame& frame, double step,
                              Draws& draws) const {
  if (expression.kind == language::Expression::Kind::Constant) {
    return expression.constant;
  }
  if (expression.kind == language::Expression::Kind::Slot) {
    return frame.at(expression.slot);
  }
  std::vector<double> stack;
  const auto pop = [&stack] {
    const double top = stack.back();
    stack.pop_back();
    return top;
  };
  bool dividedByZero = false;
  for (std::size_t at = expression.code.begin; at < expression.code.end;) {
    const language::Instruction& instruction = program_->code.at(at++);
    switch (instruction.operation) {
      case Operation::Constant:
        stack.push_back(program_->constants.at(instruction.operand));
        break;
      case Operation::LoadSlot:
        stack.push_back(frame.at(instruction.operand));
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
        std::vector<double> arguments(instruction.count);
        for (std::size_t i = arguments.size(); i-- > 0;) {
          arguments[i] = pop();
        }
        if (static_cast<language::Function>(instruction.operand) == language::Function::Ran) {
          stack.push_back(arguments[0] * core::CounterRandom(seed_, 0).uniform(core::DrawDomain::Production,
                                                                               static_cast<std::uint32_t>(step),
                                                                               draws.module, draws.count++));
          break;
        }
        stack.push_back(
            language::callPure(static_cast<language::Function>(instruction.operand), arguments, dividedByZero));
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
  return stack.back();
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

PlainString PlainDerivation::axiom() const {
  PlainString string;
  Draws draws;
  for (const language::SuccessorModule& module : program_->systems[0].axiom) {
    PlainModule made{module.type, {}};
    for (std::size_t i = 0; i < program_->arity[module.type]; ++i) {
      made.parameters.push_back(
          value(program_->systems[0].axiomExpressions.at(module.firstExpression + i), Frame{}, 0.0, draws));
    }
    string.push_back(std::move(made));
  }
  return string;
}

PlainString PlainDerivation::derive(const PlainString& old, std::uint64_t step) const {
  struct Match {
    const language::Production* production;
    Frame frame;
    double weight;
  };
  const language::LSystem& system = program_->systems[0];
  const core::CounterRandom random(seed_, 0);
  const auto q = static_cast<double>(step);
  PlainString made;
  for (std::size_t at = 0; at < old.size();) {
    // all productions that apply here, in the order of the file
    std::vector<Match> matches;
    Draws draws{at, 0};
    for (const language::Production& production : system.productions.productions) {
      Frame frame(production.slotCount, 0.0);
      if (matchesPredecessor(old, at, production, frame) &&
          matchesRight(old, at + production.predecessor.size(), production, frame) &&
          matchesLeft(old, at, production, frame) &&
          (!production.condition || value(*production.condition, frame, q, draws) != 0.0)) {
        const double weight = production.probability ? value(*production.probability, frame, q, draws) : 1.0;
        matches.push_back({&production, std::move(frame), weight});
      }
    }
    if (matches.empty() && old[at].type == program_->cut) {
      // the rest of the branch goes
      int depth = 0;
      while (at < old.size() && (depth > 0 || old[at].type != program_->closeBranch)) {
        depth += old[at].type == program_->openBranch ? 1 : 0;
        depth -= old[at].type == program_->closeBranch ? 1 : 0;
        ++at;
      }
      continue;
    }
    if (matches.empty()) {
      made.push_back(old[at++]);
      continue;
    }
    std::size_t chosen = 0;
    if (system.isStochastic) {
      double remainder = 0.0;
      for (const Match& match : matches) {
        remainder += match.weight;
      }
      remainder *= 1.0 - random.selection(static_cast<std::uint32_t>(step), at);
      for (chosen = 0; chosen + 1 < matches.size(); ++chosen) {
        remainder -= matches[chosen].weight;
        if (remainder <= 0.0) {
          break;
        }
      }
    }
    const Match& match = matches[chosen];
    for (const language::SuccessorModule& module : match.production->successor) {
      PlainModule next{module.type, {}};
      for (std::size_t i = 0; i < program_->arity[module.type]; ++i) {
        next.parameters.push_back(
            value(match.production->expressions.at(module.firstExpression + i), match.frame, q, draws));
      }
      made.push_back(std::move(next));
    }
    at += match.production->predecessor.size();
  }
  return made;
}

}  // namespace espalier::test
