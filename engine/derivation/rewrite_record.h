#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/derivation/matching/context_matcher.h"
#include "engine/derivation/state/module_string.h"
#include "engine/language/program.h"

namespace espalier::derivation {

/// The result of one candidate production at one place. The Rewriter writes it while it decides.
struct CandidateRecord {
  enum class Result : std::uint8_t { Predecessor, RightContext, LeftContext, ProducedContext, Condition, Matched };
  const language::Production* production = nullptr;
  Result result = Result::Matched;      // the part that failed first; Matched: none
  std::size_t predecessorModule = 0;    // Predecessor: index of its module that the string does not have
  std::vector<ContextLook> rightLooks;  // nearest element first, up to the failed element
  std::vector<ContextLook> leftLooks;
  std::vector<double> formals;      // by slot, after the pre-block; empty when a context or the predecessor failed
  std::optional<double> condition;  // its value; nothing: no condition, or not reached
  std::vector<std::pair<std::string, double>> variables;  // that the condition reads, with their values
  std::optional<double> weight;                           // stochastic choice: of a candidate that matches
};

/// One search for a production at one module of the string, or of a successor that is being decomposed.
struct SearchRecord {
  const language::ProductionList* list = nullptr;
  core::ModuleTypeId type = core::kNoModuleType;
  std::vector<double> parameters;
  std::uint32_t depth = 0;                  // decomposition: rewritings that made the module
  bool isAtMaximumDepth = false;            // nothing was tried
  std::vector<CandidateRecord> candidates;  // the tried candidates, in the order of the file
  bool isStochastic = false;
  std::optional<double> draw;  // the number in [0, 1] that made the choice; nothing: at most one match
  const language::Production* chosen = nullptr;
  ModuleString made;  // the successor of `chosen`, before it is decomposed
};

/// Everything that a step does with one module of the old string.
struct ModuleRecord {
  enum class Fate : std::uint8_t {
    NotReached,  // the step ended before the module
    Unfinished,  // the step failed at the module
    Rewritten,   // by a production or a decomposition
    Copied,
    Cut,      // it is a `%` that cuts
    CutAway,  // a `%` before it removed it
  };
  std::uint64_t module = 0;  // the module asked for; set by the caller
  Fate fate = Fate::NotReached;
  std::uint64_t first = 0;                    // first module of the predecessor that contains the module
  std::uint64_t consumed = 1;                 // its modules
  std::uint64_t cutBy = 0;                    // CutAway: the `%`
  const language::LSystem* system = nullptr;  // whose productions were tried
  std::vector<SearchRecord> searches;         // in the order they were made
  ModuleString result;                        // the new modules, after decomposition
};

}  // namespace espalier::derivation
