#include "engine/language/checks/model_queries.h"

#include <algorithm>
#include <cctype>
#include <string_view>

namespace espalier::language {
namespace {

void addQueries(const Program& program, const std::vector<SuccessorModule>& modules, std::vector<ModelQuery>& queries) {
  for (std::size_t i = 1; i < modules.size(); ++i) {
    const Symbol& symbol = program.symbols[program.symbolOf[modules[i].type]];
    if (modules[i - 1].type != program.bareQuery || (!symbol.isQuery && symbol.name != "E")) {
      continue;
    }
    const bool isKnown =
        std::any_of(queries.begin(), queries.end(), [&](const ModelQuery& query) { return query.name == symbol.name; });
    if (!isKnown) {
      queries.push_back({symbol.name, modules[i].range});
    }
  }
}

bool equalIgnoringCase(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) {
    return std::tolower(static_cast<unsigned char>(x)) == std::tolower(static_cast<unsigned char>(y));
  });
}

}  // namespace

std::vector<ModelQuery> queriesOf(const Program& program) {
  std::vector<ModelQuery> queries;
  if (program.bareQuery == core::kNoModuleType) {
    return queries;
  }
  for (const LSystem& system : program.systems) {
    addQueries(program, system.axiom, queries);
    for (const ProductionList* list : {&system.productions, &system.decomposition, &system.homomorphism}) {
      for (const Production& production : list->productions) {
        addQueries(program, production.successor, queries);
      }
    }
  }
  return queries;
}

std::vector<core::Diagnostic> unansweredQueries(const Program& program, const std::vector<std::string>& processNames) {
  std::vector<core::Diagnostic> warnings;
  const std::vector<std::string_view> names(processNames.begin(), processNames.end());
  for (const ModelQuery& query : queriesOf(program)) {
    const bool isAnswered = query.name == kSeedName || query.name == kDeathName ||
                            (query.name == "E" && !names.empty()) ||
                            std::any_of(names.begin(), names.end(),
                                        [&](std::string_view name) { return equalIgnoringCase(name, query.name); });
    if (isAnswered) {
      continue;
    }
    core::Diagnostic& warning = warnings.emplace_back();
    warning.severity = core::Severity::Warning;
    warning.location = program.sourceMap.locate(query.range);
    warning.message = names.empty() ? "?" + query.name + " gets no answer: no environment is given"
                                    : "no environment process is named '" + query.name + "'";
    warning.hint = names.empty() ? "give the model an environment; without one the parameters keep their values"
                                 : core::suggestName(query.name, names);
  }
  return warnings;
}

std::optional<core::Diagnostic> unaskedEnvironment(const Program& program) {
  if (program.hasQueries) {
    return std::nullopt;
  }
  core::Diagnostic warning;
  warning.severity = core::Severity::Warning;
  warning.location.file = program.modelFile;
  warning.message = "the environment has no effect: the model has no communication module ?E(x) that asks it";
  warning.hint = "write ?E(x) where the plant asks, as in 'A?E(x) : x > 0 --> F A?E(0)'; or give no environment";
  return warning;
}

std::vector<core::Diagnostic> unwrittenFiles(const Program& program) {
  std::vector<core::Diagnostic> warnings;
  for (std::size_t i = 0; i < program.code.size(); ++i) {
    const Instruction& instruction = program.code[i];
    if (instruction.operation != Operation::FileOpen || !FileMode::fromBits(instruction.count).canWrite ||
        program.files[instruction.operand].isRefused) {
      continue;
    }
    core::Diagnostic& warning = warnings.emplace_back();
    warning.severity = core::Severity::Warning;
    warning.location = program.sourceMap.locate(program.codeRanges[i]);
    warning.message =
        "models cannot write files here: fopen(\"" + program.files[instruction.operand].name + "\") returns 0";
    warning.hint = "run the model with the program 'espalier' to write the file beside it";
  }
  return warnings;
}

}  // namespace espalier::language
