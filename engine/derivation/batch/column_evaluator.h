#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/core/random.h"
#include "engine/derivation/batch/column_plan.h"
#include "engine/language/program.h"

namespace espalier::derivation {

/// The place of a formal parameter's value, for a lane of a batch.
struct SlotSource {
  enum class Kind : std::uint8_t {
    Own,       // parameter `position` of the module itself
    Left,      // of its nearest left neighbour
    Right,     // of its nearest right neighbour
    Searched,  // element `position` of the row that the context search filled
  };
  Kind kind = Kind::Own;
  std::uint32_t position = 0;
};

/// The modules of one evaluation, at most ColumnEvaluator::kLanes. A view.
struct Lanes {
  std::size_t count = 0;
  const SlotSource* slots = nullptr;       // by formal parameter
  const double* ownParameters = nullptr;   // `own` counts from here
  const double* parameters = nullptr;      // of the whole string
  const double* rows = nullptr;            // filled by context searches
  const std::uint32_t* own = nullptr;      // (count) offset of the module's parameters
  const std::uint64_t* left = nullptr;     // (count) offset of the left neighbour's parameters, or of the row
  const std::uint64_t* right = nullptr;    // (count)
  const std::uint64_t* modules = nullptr;  // (count) positions in the string; for expressions that draw
};

/// One value for each lane, or the same for all.
struct ColumnValue {
  const double* values = nullptr;  // (Lanes::count), valid until the next call; null: `constant` for all
  double constant = 0.0;
};

/// Evaluates pure expressions for many modules at once, operation by operation, with the same bits as the Evaluator. It
/// gives no warnings: it notes that the Evaluator would warn, and the caller repeats the work there. Each thread has
/// its own object.
class ColumnEvaluator {
 public:
  static constexpr std::size_t kLanes = 256;

  /// `program` must outlive the object. `slotCount` and `columnCount` bound the expressions of later calls.
  ColumnEvaluator(const language::Program& program, std::size_t slotCount, std::size_t columnCount);

  /// Gives Q and Z, and the places that have warned already (by instruction; the caller keeps them until the next
  /// begin). ran draws from `draws`.
  void begin(double step, double length, const std::uint8_t* hasWarned, const core::CounterRandom& draws = {});
  /// The lanes of the following expressions.
  void setLanes(const Lanes& lanes);
  [[nodiscard]] ColumnValue value(const ColumnExpression& expression);
  /// Whether the Evaluator would have warned since begin or clearUnusual.
  [[nodiscard]] bool isUnusual() const { return isUnusual_; }
  void clearUnusual() { isUnusual_ = false; }

 private:
  [[nodiscard]] const double* slot(std::uint32_t index);
  [[nodiscard]] ColumnValue operand(const ColumnOperand& operand);
  void run(const ColumnInstruction& instruction);
  void runPerLane(const ColumnExpression& expression, double* target);
  [[nodiscard]] double runLane(language::CodeRange code);
  void noteDivision(std::uint32_t instruction) { isUnusual_ = isUnusual_ || hasWarned_[instruction] == 0; }

  const language::Program* program_;
  Lanes lanes_;
  double step_ = 0.0;
  double length_ = 0.0;
  const std::uint8_t* hasWarned_ = nullptr;
  core::CounterRandom draws_;
  bool isUnusual_ = false;
  std::vector<double> slots_;            // gathered parameters, kLanes for each slot
  std::vector<std::uint64_t> gathered_;  // by slot: the call of setLanes for which it was gathered
  std::uint64_t generation_ = 0;
  std::vector<double> columns_;  // intermediate results, kLanes each
  std::vector<double> frame_;    // formal parameters of one lane
  std::vector<double> stack_;    // of one lane
};

}  // namespace espalier::derivation
