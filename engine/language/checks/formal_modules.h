#pragma once

#include "engine/language/parse/syntax.h"

namespace espalier::language {

/// Calls `action(FormalModuleSyntax)` for the modules of the predecessor and of all contexts, in this order.
template <typename Action>
void forFormals(const ProductionSyntax& production, const Action& action) {
  for (const FormalModuleSyntax& module : production.predecessor) {
    action(module);
  }
  for (const auto* context :
       {&production.leftContext, &production.rightContext, &production.newLeftContext, &production.newRightContext}) {
    for (const ContextElementSyntax& element : *context) {
      if (element.kind == ContextElement::Kind::Module) {
        action(element.module);
      }
    }
  }
}

}  // namespace espalier::language
