#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/core/identifiers.h"
#include "engine/language/program.h"
#include "engine/simulation/forest.h"
#include "engine/turtle/environment_process.h"
#include "engine/turtle/interpretation/interpreter.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::simulation {

/// The Programs of a simulation, their Interpreters, and one numbering of symbols, surfaces and contours for all of
/// them. Environments and pictures use that numbering. With one Program every number is that Program's own.
class ModelSet {
 public:
  /// At least one Program; all of one compatibility mode.
  explicit ModelSet(Programs programs);

  [[nodiscard]] const Programs& programs() const { return programs_; }
  [[nodiscard]] const language::Program& first() const { return *programs_.front(); }
  [[nodiscard]] std::size_t size() const { return programs_.size(); }
  [[nodiscard]] core::Compatibility compatibility() const { return first().compatibility; }
  [[nodiscard]] turtle::Interpreter& interpreter(std::uint32_t model) const { return *interpreters_[model]; }

  /// Names by common SymbolId.
  [[nodiscard]] const std::vector<std::string>& symbolNames() const { return symbolNames_; }
  [[nodiscard]] core::SymbolId commonSymbol(std::uint32_t model, core::SymbolId symbol) const {
    return commonSymbol_[model][symbol];
  }
  /// Whether a common SymbolId is that of a communication module that the simulation answers itself.
  [[nodiscard]] bool isSeed(core::SymbolId symbol) const { return symbol == seed_; }
  [[nodiscard]] bool isDeath(core::SymbolId symbol) const { return symbol == death_; }
  /// Whether a Program has such modules.
  [[nodiscard]] bool hasLifeQueries() const { return seed_ != core::kNoSymbol || death_ != core::kNoSymbol; }
  [[nodiscard]] bool hasQueries() const;
  [[nodiscard]] bool writesFiles() const;
  /// The `seed:` of the first Program that has one.
  [[nodiscard]] std::optional<std::uint64_t> modelSeed() const;
  [[nodiscard]] std::uint64_t longestDerivation() const;
  /// The first Program's view settings, with the surfaces and contours of all.
  [[nodiscard]] const files::ViewSettings& view() const { return programs_.size() == 1 ? first().view : view_; }

  /// Turns the symbols of queries from `firstQuery` on, which a plant of `model` made, into the common ones.
  void toCommonSymbols(std::uint32_t model, std::size_t firstQuery, turtle::QueryBatch& queries) const;
  /// The same for records of the turtle.
  void toCommonSymbols(std::uint32_t model, std::span<turtle::TurtleRecord> records) const;
  /// Gives the elements behind `mark`, which a plant of `model` drew, the common numbers of surfaces and contours, and
  /// adds `colourShift` to their colours.
  void toCommonNumbers(std::uint32_t model, std::int32_t colourShift, const turtle::SceneMark& mark,
                       turtle::Scene& scene) const;

 private:
  struct Offsets {
    std::uint32_t surface = 0;
    std::uint32_t triangleSurface = 0;
    std::int32_t contour = 0;
  };

  void numberSymbols();
  void mergeViews();

  Programs programs_;
  std::vector<std::unique_ptr<turtle::Interpreter>> interpreters_;  // by model
  std::vector<std::string> symbolNames_;
  std::vector<std::vector<core::SymbolId>> commonSymbol_;  // by model, by its SymbolId
  std::vector<Offsets> offsets_;                           // by model
  files::ViewSettings view_;                               // of several Programs
  core::SymbolId seed_ = core::kNoSymbol;
  core::SymbolId death_ = core::kNoSymbol;
};

}  // namespace espalier::simulation
