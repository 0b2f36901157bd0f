#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/elementary.h"
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
    Searched,  // of the module that a context search found for element `element`
  };
  Kind kind = Kind::Own;
  std::uint32_t position = 0;
  std::uint32_t element = 0;  // Searched: of the left context, then of the right context
};

/// The draws of the code of one module.
struct ModuleDraws {
  static constexpr std::uint32_t kNoPair = ~std::uint32_t{0};
  std::uint32_t count = 0;          // that it has made
  std::uint32_t pair = kNoPair;     // known draws: 2 * pair and the next
  std::array<double, 2> numbers{};  // these draws
};

/// The modules of one evaluation, at most ColumnEvaluator::kLanes. A view.
struct Lanes {
  std::size_t count = 0;
  const SlotSource* slots = nullptr;           // by formal parameter
  const double* ownParameters = nullptr;       // siteOffsets count from here
  const double* parameters = nullptr;          // of the whole string
  const std::uint64_t* rows = nullptr;         // of context searches: offsets of the parameters, one for each element
  const std::uint32_t* sites = nullptr;        // (count) number of the module in siteOffsets
  const std::uint32_t* siteOffsets = nullptr;  // offset of a module's parameters
  const std::uint64_t* left = nullptr;         // (count) offset of the left neighbour's parameters, or of the row
  const std::uint64_t* right = nullptr;        // (count)
  const std::uint64_t* modules = nullptr;      // (count) positions in the string; null: nothing draws
  ModuleDraws* draws = nullptr;                // by number of the module; code counts on
};

/// One value for each lane, or the same for all.
struct ColumnValue {
  const double* values = nullptr;  // (Lanes::count), valid until the next call; null: `constant` for all
  double constant = 0.0;
};

/// The inputs of code beside the lanes. Views; the caller keeps all of it until the next begin.
struct ColumnInputs {
  double step = 0.0;                        // Q
  double length = 0.0;                      // Z
  const std::uint8_t* hasWarned = nullptr;  // by instruction: not 0 where the place has warned already
  const double* variables = nullptr;        // of the main L-system (LSystem::variables)
  const double* elements = nullptr;         // its array elements
  core::CounterRandom draws;                // of ran, nran and bran
};

/// Runs expressions and blocks for many modules at once, operation by operation, with the same bits as the Evaluator.
/// Where lanes jump to different places, it runs the first stretch that some lane waits for, with a mask. It gives no
/// warnings: it notes that the Evaluator would warn, and the caller repeats the work there. Each thread has its own
/// object.
class ColumnEvaluator {
 public:
  static constexpr std::size_t kLanes = 256;

  /// `program` must outlive the object. `slotCount` and `columnCount` bound the code of later calls.
  ColumnEvaluator(const language::Program& program, std::size_t slotCount, std::size_t columnCount);

  void begin(const ColumnInputs& inputs);
  /// The lanes of the following code. Nothing is assigned yet.
  void setLanes(const Lanes& lanes);
  /// Runs a block, which assigns local variables and formal parameters.
  void run(const ColumnCode& code);
  [[nodiscard]] ColumnValue value(const ColumnCode& expression);

  /// The values of a local variable or an assigned formal parameter (Lanes::count). They can be set, too.
  [[nodiscard]] double* column(std::uint32_t index) { return columns_.data() + index * kLanes; }
  /// Whether each lane has assigned the local variable in the last run, as a mask: 0 or all bits. Null: all lanes have.
  [[nodiscard]] const std::uint64_t* storing(const ColumnCode& code, std::uint32_t local) const;

  /// Whether the Evaluator would have warned or failed since begin or clearUnusual.
  [[nodiscard]] bool isUnusual() const { return isUnusual_; }
  void clearUnusual() { isUnusual_ = false; }

 private:
  using Mask = std::uint64_t;  // of a lane: 0 or all bits
  struct Power {
    std::uint64_t base;  // bits of the number
    std::uint64_t exponent;
    double value;
  };
  static constexpr unsigned kPowerBits = 8;
  [[nodiscard]] static std::size_t placeOfPower(std::uint64_t base, std::uint64_t exponent) {
    // multiplication mixes all bits into the highest ones
    return ((base ^ std::rotl(exponent, 23)) * 0x9E3779B97F4A7C15ULL) >> (64U - kPowerBits);
  }

  [[nodiscard]] const double* slot(std::uint32_t index);
  [[nodiscard]] ColumnValue operand(const ColumnOperand& operand);
  void runStretches(const ColumnCode& code);
  void leaveStretch(const ColumnCode& code, std::size_t stretch);
  void wait(std::size_t stretch, const Mask* lanes);
  void run(const ColumnInstruction& instruction);
  void runOneByOne(const ColumnInstruction& instruction, double* target, const ColumnValue& a, const ColumnValue& b);
  void divide(const ColumnInstruction& instruction, double* target, const ColumnValue& a, const ColumnValue& b);
  void takeRemainders(const ColumnInstruction& instruction, double* target, const ColumnValue& a, const ColumnValue& b);
  void move(const ColumnInstruction& instruction, double* target, const ColumnValue& from);
  [[nodiscard]] double power(double x, double y);
  void raise(double* target, const ColumnValue& a, const ColumnValue& b);
  void prepareDraws();
  [[nodiscard]] double draw(language::Function function, std::span<const double> arguments, std::size_t lane);
  [[nodiscard]] bool loadElements(const ColumnInstruction& instruction, double* target);
  [[nodiscard]] double element(const ColumnInstruction& instruction, std::span<const double> subscripts);
  void noteWarning(std::uint32_t instruction) { isUnusual_ = isUnusual_ || inputs_.hasWarned[instruction] == 0; }
  [[nodiscard]] bool isActive(std::size_t lane) const { return mask_ == nullptr || mask_[lane] != 0; }

  const language::Program* program_;
  core::Elementary elementary_;
  Lanes lanes_;
  ColumnInputs inputs_;
  bool isUnusual_ = false;
  std::vector<double> slots_;            // gathered parameters, kLanes for each slot
  std::vector<std::uint64_t> gathered_;  // by slot: the call of setLanes for which it was gathered
  std::uint64_t generation_ = 0;
  std::vector<double> columns_;  // what blocks assign, and intermediate results, kLanes each

  // of code with jumps
  const Mask* mask_ = nullptr;           // lanes that run the present stretch; null: all
  std::vector<Mask> active_;             // (kLanes) the same
  std::vector<Mask> waiting_;            // by stretch: lanes that wait for it, kLanes each
  std::vector<std::size_t> waitCounts_;  // by stretch: their number
  std::vector<Mask> taken_;              // (kLanes) lanes that jump
  std::vector<Mask> stored_;             // by local variable: lanes that have assigned it, kLanes each
  std::uint32_t turns_ = 0;              // of loops

  // draws that a column needs first
  std::vector<std::uint64_t> drawModules_;  // (kLanes)
  std::vector<std::uint32_t> drawPairs_;    // (kLanes)
  std::vector<double> drawNumbers_;         // (2 * kLanes)

  std::vector<Power> powers_;  // computed last, by a hash of base and exponent (1 << kPowerBits)
};

}  // namespace espalier::derivation
