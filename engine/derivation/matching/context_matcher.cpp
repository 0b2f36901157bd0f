#include "engine/derivation/matching/context_matcher.h"

namespace espalier::derivation {
namespace {

using language::ContextElement;

/// Binds the parameters of a module that matches to a frame.
void bind(const language::Program& program, const ContextString& string, const language::FormalModule& formal,
          std::uint64_t offset, double* frame) {
  const std::size_t arity = program.arity[formal.type];
  for (std::size_t i = 0; i < arity; ++i) {
    frame[formal.firstSlot + i] = string.parameters[offset + i];
  }
}

/// Adds an entry to `looks`, when searches are recorded, and returns whether the element matched.
template <bool kIsRecorded>
bool look(std::vector<ContextLook>* looks, ContextLook::Result result, const language::Program& program,
          const ContextString& string, std::uint64_t module, std::uint64_t offset) {
  if constexpr (kIsRecorded) {
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

template <bool kIsRing, bool kIsRecorded>
bool searchLeft(const language::Program& program, const ContextRules& rules, const ContextString& string,
                std::span<const ContextElement> context, std::uint64_t module, std::uint64_t offset, double* frame,
                std::vector<ContextLook>* looks) {
  using Result = ContextLook::Result;
  const core::ModuleTypeId* const types = string.types;
  const std::uint16_t* const arity = program.arity.data();
  const std::uint8_t* const traits = rules.traits();
  for (std::size_t i = 0; i < context.size(); ++i) {
    const ContextElement& element = context[i];
    if (element.kind != ContextElement::Kind::Module) {
      return false;
    }
    // without a bound, the search would never end in a ring of ignored modules
    [[maybe_unused]] std::uint64_t remaining = string.size + 1;
    std::uint32_t passed = 0;
    while (true) {
      if (module == 0) {
        if (!kIsRing || !string.canWrap) {
          return look<kIsRecorded>(looks, Result::StringEnd, program, string, 0, 0);
        }
        module = string.size;
        offset = string.parameterCount;
      }
      if (kIsRing && --remaining == 0) {
        return look<kIsRecorded>(looks, Result::StringEnd, program, string, 0, 0);
      }
      --module;
      const core::ModuleTypeId type = types[module];
      const std::uint8_t trait = traits[type];
      offset -= arity[type];
      if (trait == 0) [[likely]] {
        if (type != element.module.type) {
          return look<kIsRecorded>(looks, Result::OtherModule, program, string, module, offset);
        }
        look<kIsRecorded>(looks, Result::Matched, program, string, module, offset);
        bind(program, string, element.module, offset, frame);
        break;
      }
      if ((trait & ContextRules::kCloseBranch) != 0) {
        const StringIndex::Link link = string.index->link(module);
        if (link.partner == StringIndex::kNone) {
          return look<kIsRecorded>(looks, Result::LoneBracket, program, string, 0, 0);
        }
        module = link.partner;
        offset -= link.parameterCount;
      }
      // a search that has passed many modules goes on where an earlier search has ended
      if (++passed > LeftShortcuts::kNearModules && string.shortcuts != nullptr &&
          types[module] == program.openBranch) {
        const LeftShortcuts::Place end = string.shortcuts->follow(program, rules, string, {module, offset});
        module = end.module;
        offset = end.offset;
        passed = 0;
      }
    }
  }
  return true;
}

template <bool kIsRing, bool kIsRecorded>
bool searchRight(const language::Program& program, const ContextRules& rules, const ContextString& string,
                 std::span<const ContextElement> context, std::uint64_t module, std::uint64_t offset, double* frame,
                 std::vector<ContextLook>* looks) {
  using Result = ContextLook::Result;
  const core::ModuleTypeId* const types = string.types;
  const std::uint16_t* const arity = program.arity.data();
  const std::uint8_t* const traits = rules.traits();
  // the branch that the context has entered last, when brackets alone end it
  const bool areBracketsSeen =
      !kIsRing && !rules.isIgnored(program.openBranch) && !rules.isIgnored(program.closeBranch);
  std::uint64_t entered = string.size;  // its `[`; the size of the string: none
  std::uint64_t enteredOffset = 0;      // behind the `[`
  for (std::size_t i = 0; i < context.size(); ++i) {
    const ContextElement& element = context[i];
    const bool isBranchEnd = element.kind == ContextElement::Kind::SkipToBranchEnd;
    const bool entersBranch = element.kind == ContextElement::Kind::OpenBranch;
    if (isBranchEnd && entered != string.size) {
      const StringIndex::Link link = string.index->link(entered);
      if (link.partner != StringIndex::kNone) {
        module = link.partner;
        offset = enteredOffset + link.parameterCount;
      }
    }
    [[maybe_unused]] std::uint64_t remaining = string.size + 1;
    while (true) {
      if (module >= string.size) {
        if (!kIsRing || string.size == 0) {
          return look<kIsRecorded>(looks, Result::StringEnd, program, string, 0, 0);
        }
        module = 0;
        offset = 0;
      }
      if (kIsRing && --remaining == 0) {
        return look<kIsRecorded>(looks, Result::StringEnd, program, string, 0, 0);
      }
      const core::ModuleTypeId type = types[module];
      const std::uint8_t trait = traits[type];
      if (isBranchEnd) {
        // brackets alone decide where the branch ends
        if ((trait & ContextRules::kCloseBranch) != 0) {
          look<kIsRecorded>(looks, Result::Matched, program, string, module, offset);
          break;
        }
      } else if ((trait & ContextRules::kIgnored) == 0 && ((trait & ContextRules::kOpenBranch) == 0 || entersBranch)) {
        if (type != element.module.type) {
          return look<kIsRecorded>(looks, Result::OtherModule, program, string, module, offset);
        }
        look<kIsRecorded>(looks, Result::Matched, program, string, module, offset);
        bind(program, string, element.module, offset, frame);
        offset += arity[type];
        if ((trait & (ContextRules::kOpenBranch | ContextRules::kCloseBranch)) != 0) {
          entered = entersBranch && areBracketsSeen ? module : string.size;
          enteredOffset = offset;
        }
        ++module;
        break;
      }
      // a branch is passed as a whole, unless its bracket is ignored
      if ((trait & ContextRules::kOpenBranch) != 0 && (isBranchEnd || (trait & ContextRules::kIgnored) == 0)) {
        const StringIndex::Link link = string.index->link(module);
        if (link.partner == StringIndex::kNone) {
          return look<kIsRecorded>(looks, Result::LoneBracket, program, string, 0, 0);
        }
        module = link.partner + 1;
        offset += link.parameterCount;
        continue;
      }
      offset += arity[type];
      ++module;
    }
  }
  return true;
}

}  // namespace

ContextRules::ContextRules(const language::Program& program, const language::LSystem& system)
    : traits_(program.moduleTypeCount(), 0), isRing_(system.isRing) {
  for (std::size_t type = 0; type < program.moduleTypeCount(); ++type) {
    const core::SymbolId symbol = program.symbolOf[type];
    traits_[type] = symbol < system.isIgnored.size() && system.isIgnored[symbol] ? kIgnored : 0;
  }
  traits_[program.openBranch] |= kOpenBranch;
  traits_[program.closeBranch] |= kCloseBranch;
}

bool matchesLeft(const language::Program& program, const ContextRules& rules, const ContextString& string,
                 std::span<const ContextElement> context, std::uint64_t module, std::uint64_t offset, double* frame,
                 std::vector<ContextLook>* looks) {
  if (looks != nullptr) {
    return rules.isRing() ? searchLeft<true, true>(program, rules, string, context, module, offset, frame, looks)
                          : searchLeft<false, true>(program, rules, string, context, module, offset, frame, looks);
  }
  return rules.isRing() ? searchLeft<true, false>(program, rules, string, context, module, offset, frame, looks)
                        : searchLeft<false, false>(program, rules, string, context, module, offset, frame, looks);
}

bool matchesRight(const language::Program& program, const ContextRules& rules, const ContextString& string,
                  std::span<const ContextElement> context, std::uint64_t module, std::uint64_t offset, double* frame,
                  std::vector<ContextLook>* looks) {
  if (looks != nullptr) {
    return rules.isRing() ? searchRight<true, true>(program, rules, string, context, module, offset, frame, looks)
                          : searchRight<false, true>(program, rules, string, context, module, offset, frame, looks);
  }
  return rules.isRing() ? searchRight<true, false>(program, rules, string, context, module, offset, frame, looks)
                        : searchRight<false, false>(program, rules, string, context, module, offset, frame, looks);
}

}  // namespace espalier::derivation
