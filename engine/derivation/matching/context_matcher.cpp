#include "engine/derivation/matching/context_matcher.h"

namespace espalier::derivation {
namespace {

using language::ContextElement;

void bind(const language::Program& program, const language::FormalModule& formal, const double* parameters,
          double* frame) {
  const std::size_t arity = program.arity[formal.type];
  for (std::size_t i = 0; i < arity; ++i) {
    frame[formal.firstSlot + i] = parameters[i];
  }
}

/// Adds an entry to `looks`, unless it is null, and returns whether the element matched.
bool look(std::vector<ContextLook>* looks, ContextLook::Result result, const language::Program& program,
          const ContextString& string, std::uint64_t module, std::uint64_t offset) {
  if (looks != nullptr) {
    ContextLook& entry = looks->emplace_back();
    entry.result = result;
    if (result == ContextLook::Result::Matched || result == ContextLook::Result::OtherModule) {
      entry.module = module;
      entry.type = string.types[module];
      entry.parameters.assign(string.parameters + offset, string.parameters + offset + program.arity[entry.type]);
    }
  }
  return result == ContextLook::Result::Matched;
}

}  // namespace

ContextRules::ContextRules(const language::Program& program, const language::LSystem& system)
    : isIgnored_(program.moduleTypeCount(), 0), isRing_(system.isRing) {
  for (std::size_t type = 0; type < program.moduleTypeCount(); ++type) {
    const core::SymbolId symbol = program.symbolOf[type];
    isIgnored_[type] = symbol < system.isIgnored.size() && system.isIgnored[symbol] ? 1 : 0;
  }
}

bool matchesLeft(const language::Program& program, const ContextRules& rules, const ContextString& string,
                 std::span<const ContextElement> context, std::uint64_t module, std::uint64_t offset, double* frame,
                 std::vector<ContextLook>* looks) {
  for (const ContextElement& element : context) {
    if (element.kind != ContextElement::Kind::Module) {
      return false;
    }
    // without a bound, the search would never end in a ring of ignored modules
    std::uint64_t remaining = string.size + 1;
    std::uint32_t passed = 0;
    while (true) {
      if (++passed > LeftShortcuts::kNearModules && string.shortcuts != nullptr && module < string.size &&
          string.types[module] == program.openBranch) {
        const LeftShortcuts::Place end = string.shortcuts->follow(program, rules, string, {module, offset});
        module = end.module;
        offset = end.offset;
        passed = 0;
      }
      if (module == 0) {
        if (!rules.isRing() || !string.canWrap) {
          return look(looks, ContextLook::Result::StringEnd, program, string, 0, 0);
        }
        module = string.size;
        offset = string.parameterCount;
      }
      if (--remaining == 0) {
        return look(looks, ContextLook::Result::StringEnd, program, string, 0, 0);
      }
      --module;
      const core::ModuleTypeId type = string.types[module];
      offset -= program.arity[type];
      if (type == program.closeBranch) {
        const StringIndex::Link link = string.index->link(module);
        if (link.partner == StringIndex::kNone) {
          return look(looks, ContextLook::Result::LoneBracket, program, string, 0, 0);
        }
        module = link.partner;
        offset -= link.parameterCount;
        continue;
      }
      if (type == program.openBranch || rules.isIgnored(type)) {
        continue;
      }
      if (type != element.module.type) {
        return look(looks, ContextLook::Result::OtherModule, program, string, module, offset);
      }
      look(looks, ContextLook::Result::Matched, program, string, module, offset);
      bind(program, element.module, string.parameters + offset, frame);
      break;
    }
  }
  return true;
}

bool matchesRight(const language::Program& program, const ContextRules& rules, const ContextString& string,
                  std::span<const ContextElement> context, std::uint64_t module, std::uint64_t offset, double* frame,
                  std::vector<ContextLook>* looks) {
  for (const ContextElement& element : context) {
    const bool isBranchEnd = element.kind == ContextElement::Kind::SkipToBranchEnd;
    std::uint64_t remaining = string.size + 1;
    while (true) {
      if (module >= string.size) {
        if (!rules.isRing() || string.size == 0) {
          return look(looks, ContextLook::Result::StringEnd, program, string, 0, 0);
        }
        module = 0;
        offset = 0;
      }
      if (--remaining == 0) {
        return look(looks, ContextLook::Result::StringEnd, program, string, 0, 0);
      }
      const core::ModuleTypeId type = string.types[module];
      // brackets alone decide where the branch ends
      if (isBranchEnd && type == program.closeBranch) {
        look(looks, ContextLook::Result::Matched, program, string, module, offset);
        break;
      }
      const bool isSkippedBranch =
          type == program.openBranch &&
          (isBranchEnd || (!rules.isIgnored(type) && element.kind != ContextElement::Kind::OpenBranch));
      if (isSkippedBranch) {
        const StringIndex::Link link = string.index->link(module);
        if (link.partner == StringIndex::kNone) {
          return look(looks, ContextLook::Result::LoneBracket, program, string, 0, 0);
        }
        module = link.partner + 1;
        offset += link.parameterCount;
        continue;
      }
      if (isBranchEnd || rules.isIgnored(type)) {
        offset += program.arity[type];
        ++module;
        continue;
      }
      if (type != element.module.type) {
        return look(looks, ContextLook::Result::OtherModule, program, string, module, offset);
      }
      look(looks, ContextLook::Result::Matched, program, string, module, offset);
      bind(program, element.module, string.parameters + offset, frame);
      offset += program.arity[type];
      ++module;
      break;
    }
  }
  return true;
}

}  // namespace espalier::derivation
