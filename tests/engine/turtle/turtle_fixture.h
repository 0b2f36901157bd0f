#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/core/number_text.h"
#include "engine/derivation/derivation.h"
#include "engine/derivation/state/string_text.h"
#include "engine/language/program.h"
#include "engine/turtle/interpretation/interpreter.h"

namespace espalier::turtle {

/// Of a query, everything that a process can need.
constexpr EnvironmentNeeds kAllButGeometry{.position = true,
                                           .heading = true,
                                           .left = true,
                                           .up = true,
                                           .width = true,
                                           .scale = true,
                                           .parameters = true,
                                           .following = true,
                                           .geometry = false};

/// A string and a Program that knows its modules, made without the compiler: a symbol is one character, or a declared
/// name as given; parameters are numbers.
class TurtleRun {
 public:
  explicit TurtleRun(std::string_view text, files::ViewSettings view = {},
                     core::Compatibility compatibility = core::Compatibility::Espalier,
                     std::vector<std::string> declaredQueries = {}) {
    program.compatibility = compatibility;
    program.view = std::move(view);
    program.systems.emplace_back();
    program.hasQueries = text.find('?') != std::string_view::npos;
    for (const std::string& name : declaredQueries) {
      program.symbols.push_back({.name = name, .isDeclared = true, .isQuery = true, .parameterNames = {}});
    }
    program.openBranch = typeOf("[", 0);
    program.closeBranch = typeOf("]", 0);
    readString(text);
    program.cut = program.findType("%", 0);
    program.bareQuery = program.findType("?", 0);
    program.subSystemEnd = program.findType("$", 0);
    language::LSystem& system = program.systems.front();
    system.isIgnored.assign(program.symbols.size(), false);
    for (language::ProductionList* list : {&system.productions, &system.decomposition, &system.homomorphism}) {
      list->index.begin.assign(program.types.size() + 1, 0);
    }
    state.instances.push_back({});
  }

  /// Interprets for the scene and the records.
  void draw(const PlantPlacement& placement = {}) {
    interpret(placement, {.scene = &scene, .records = &records, .queryParameterOffsets = nullptr});
  }

  /// An environment pass.
  void pass(const EnvironmentNeeds& needs = {}, const PlantPlacement& placement = {}) {
    queries.clear();
    offsets.clear();
    changes.clear();
    interpret(placement, {.queries = &queries, .needs = needs, .queryParameterOffsets = &offsets, .changes = &changes});
  }

  void interpret(const PlantPlacement& placement, const InterpretationOutput& output) {
    derivation::DerivationOptions options;
    options.limits = limits;
    options.threads = threads;
    options.cancelled = cancelled;
    options.messages = [this](core::MessageKind, std::string_view message) { messages.emplace_back(message); };
    derivation::Derivation derivation(program, options);
    Interpreter interpreter(program);
    interpreter.interpret(derivation, state, 0, placement, output);
  }

  /// The parameters of the module with the given index in the string.
  [[nodiscard]] std::vector<double> parametersOf(std::uint64_t module) const {
    std::uint64_t offset = 0;
    for (std::uint64_t i = 0; i < module; ++i) {
      offset += program.arity[state.string.types()[i]];
    }
    const auto values = state.string.parameters().subspan(offset, program.arity[state.string.types()[module]]);
    return {values.begin(), values.end()};
  }
  [[nodiscard]] std::vector<double> lastParameters() const { return parametersOf(state.string.size() - 1); }
  [[nodiscard]] std::string text() const {
    return derivation::toText(program, state.string, core::NumberStyle::PercentG);
  }

  language::Program program;
  derivation::PlantState state;
  core::Limits limits;
  unsigned threads = 1;
  const std::atomic<bool>* cancelled = nullptr;
  Scene scene;
  std::vector<TurtleRecord> records;
  QueryBatch queries;
  std::vector<std::uint64_t> offsets;
  std::vector<ParameterChange> changes;
  std::vector<std::string> messages;

 private:
  core::ModuleTypeId typeOf(std::string_view name, std::uint16_t arity) {
    for (std::size_t i = 0; i < program.types.size(); ++i) {
      if (program.symbols[program.types[i].symbol].name == name && program.types[i].arity == arity) {
        return static_cast<core::ModuleTypeId>(i);
      }
    }
    std::size_t symbol = 0;
    while (symbol < program.symbols.size() && program.symbols[symbol].name != name) {
      ++symbol;
    }
    if (symbol == program.symbols.size()) {
      language::Symbol fresh;
      fresh.name = name;
      program.symbols.push_back(fresh);
    }
    program.types.push_back({static_cast<core::SymbolId>(symbol), arity});
    program.arity.push_back(arity);
    program.symbolOf.push_back(static_cast<core::SymbolId>(symbol));
    return static_cast<core::ModuleTypeId>(program.types.size() - 1);
  }

  void readString(std::string_view text) {
    for (std::size_t i = 0; i < text.size();) {
      if (text[i] == ' ') {
        ++i;
        continue;
      }
      std::string_view name = text.substr(i, 1);
      for (const language::Symbol& symbol : program.symbols) {
        if (symbol.isDeclared && text.substr(i).starts_with(symbol.name)) {
          name = text.substr(i, symbol.name.size());
        }
      }
      i += name.size();
      std::vector<double> parameters;
      if (i < text.size() && text[i] == '(') {
        const std::size_t end = text.find(')', i);
        const std::string list(text.substr(i + 1, end - i - 1));
        const char* at = list.c_str();
        char* next = nullptr;
        while (*at != '\0') {
          parameters.push_back(std::strtod(at, &next));
          at = *next == ',' ? next + 1 : next;
        }
        i = end + 1;
      }
      state.string.append(typeOf(name, static_cast<std::uint16_t>(parameters.size())), parameters);
    }
  }
};

/// A vector agrees with x, y, z within 1e-5, the precision of recorded values.
inline void expectVector(const core::Vec3& v, double x, double y, double z, double tolerance = 1e-5) {
  EXPECT_NEAR(v.x, x, tolerance);
  EXPECT_NEAR(v.y, y, tolerance);
  EXPECT_NEAR(v.z, z, tolerance);
}

/// A query's parameters agree with the expected ones within 1e-5.
inline void expectParameters(const std::vector<double>& values, const std::vector<double>& expected) {
  ASSERT_EQ(values.size(), expected.size());
  for (std::size_t k = 0; k < values.size(); ++k) {
    EXPECT_NEAR(values[k], expected[k], 1e-5) << "parameter " << k;
  }
}

}  // namespace espalier::turtle
