#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "engine/derivation/derivation.h"
#include "engine/language/program.h"
#include "engine/turtle/environment_process.h"
#include "engine/turtle/interpretation/interpretation_tables.h"
#include "engine/turtle/scene/scene.h"
#include "engine/turtle/turtle_state.h"

namespace espalier::turtle {

class PartedInterpretation;
class QueryStretches;
struct RecordChain;

/// Where a plant stands: the turtle starts here.
struct PlantPlacement {
  core::Vec3 position;
  core::Frame frame;

  bool operator==(const PlantPlacement&) const = default;
};

/// A parameter of the string that an interpretation overwrote, for undoing it.
struct ParameterChange {
  std::uint64_t offset = 0;  // into the string's parameters
  double before = 0.0;
  std::uint64_t module = 0;  // that has the parameter, or the module before it (`?` of `?P(x,y)`)
};

/// The parameter offset of a query that a homomorphism made: its parameters are not in the string.
inline constexpr std::uint64_t kTransientQuery = std::numeric_limits<std::uint64_t>::max();

/// The outputs of one interpretation. A null output is not produced.
struct InterpretationOutput {
  Scene* scene = nullptr;
  QueryBatch* queries = nullptr;  // communication modules are appended
  EnvironmentNeeds needs{};       // of the environment that reads `queries`
  std::vector<TurtleRecord>* records = nullptr;
  /// Called after each module of the string, or after the modules that belong together, with the turtle's state then
  /// and the first of them; the record's module is the last, its parent is not set.
  std::function<void(const TurtleRecord&, std::uint64_t first)> onModule{};
  /// Per appended query: where its parameters are in the string; kTransientQuery when a homomorphism made it.
  std::vector<std::uint64_t>* queryParameterOffsets = nullptr;
  std::vector<ParameterChange>* changes = nullptr;  // every parameter that was filled is appended
  bool fillsQueries = true;                         // ?P ?H ?L ?U ?Q ?F are written into the string
};

/// Interprets the string of one plant from left to right, with homomorphism, filling ?P ?H ?L ?U ?Q (and ?F) in place.
/// An interpretation with `queries` is an environment pass: in the compatible modes it does not execute width and
/// colour symbols, and it overwrites the legacy `s`. turtle_symbols.def specifies the symbols. Throws
/// core::SimulationFailure: a position that is not finite, a limit, cancelled; the string may then be partly filled
/// (`changes` tells how to undo it). O(modules). Warnings go to the Derivation's message sink, each text once per
/// Interpreter. An environment pass with several threads (DerivationOptions::threads) interprets branches of a long
/// string at the same time; the output is the same.
class Interpreter {
 public:
  /// `program` must outlive the object.
  explicit Interpreter(const language::Program& program);
  ~Interpreter();

  void interpret(derivation::Derivation& derivation, derivation::PlantState& state, std::uint32_t plant,
                 const PlantPlacement& placement, const InterpretationOutput& output);

  /// Whether takeOver may be used: the Program is repeatable (record_chain.h) and has no homomorphism.
  [[nodiscard]] bool mayTakeOver() const { return mayTakeOver_; }
  /// The same as interpret() in an environment pass, but it does not interpret what is known already. `changes` says
  /// what happened to the string since the previous pass over this plant; the unchanged parts are taken over. `known`
  /// belongs to the previous pass before the call, and to this one after it. `output` has `queries`, and nothing that
  /// is drawn.
  void takeOver(derivation::Derivation& derivation, derivation::PlantState& state, std::uint32_t plant,
                const PlantPlacement& placement, const InterpretationOutput& output,
                const derivation::StepChanges& changes, QueryStretches& known);

  /// Appends the next plant's records to `chain` (record_chain.h), bit for bit those that interpret() makes. It takes a
  /// stretch of `base` (null: nothing is known) when `changes`, from the base's string to this one, kept its modules
  /// and the turtle before it is the same. It interprets the rest, and calls `rename` with the records of each stretch
  /// that it interpreted. `base` must have the plant with the same Program and placement. The Program must be
  /// repeatable. O(groups of stretches) and O(modules) of what is new.
  void appendRecords(derivation::Derivation& derivation, derivation::PlantState& state, std::uint32_t plant,
                     const PlantPlacement& placement, const RecordChain* base, const derivation::StepChanges& changes,
                     const std::function<void(std::span<TurtleRecord>)>& rename, RecordChain& chain);

 private:
  const language::Program* program_;
  InterpretationTables tables_;
  bool mayTakeOver_;
  std::set<std::string> reported_;  // warnings already given
  std::unique_ptr<PartedInterpretation> parted_;
};

}  // namespace espalier::turtle
