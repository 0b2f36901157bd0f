#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "engine/turtle/interpretation.h"
#include "engine/turtle/record_chain.h"

namespace espalier::turtle {

/// Makes the links of one plant (Interpreter::appendRecords).
///
/// The string is gone through from left to right, from stretch to stretch. The next stretch of the base is taken when
/// its modules are those that follow and the turtle, with the branches that it closes, is the one that it began with:
/// bits are compared, so what is taken is what would have been made. Otherwise modules are interpreted until the turtle
/// is again where a later stretch of the base began and its modules follow, or until there are enough for a stretch of
/// their own. No difference of the strings is needed, and a string without brackets is no special case.
class RecordChainBuilder {
 public:
  /// Everything must outlive the object. `base` may be null.
  RecordChainBuilder(const Interpretation::Subject& subject, const RecordChain* base,
                     const std::function<void(std::span<TurtleRecord>)>& rename, RecordChain& chain);

  void appendPlant();

 private:
  [[nodiscard]] bool follows(std::size_t link);
  [[nodiscard]] bool findNext();
  void buildTable();
  void take(const std::shared_ptr<const RecordStretch>& stretch);
  void interpret();
  void append(std::shared_ptr<const RecordStretch> stretch, std::uint64_t firstModule);
  [[nodiscard]] std::uint32_t resolved(std::uint32_t number) const;

  const derivation::ModuleString& string_;
  const std::vector<std::uint16_t>& arity_;
  const RecordChain* base_;
  const std::function<void(std::span<TurtleRecord>)>& rename_;
  RecordChain& chain_;
  std::vector<TurtleRecord> records_;  // of the stretch being interpreted
  InterpretationOutput output_;
  Interpretation interpretation_;
  Interpretation::StretchNotes notes_;
  std::uint64_t module_ = 0;  // the next
  std::uint64_t offset_ = 0;  // of its parameters

  std::size_t next_ = 0;  // link of the base that is expected next
  std::size_t end_ = 0;   // behind the plant's last link
  // where to find links by the turtle that they begin with: heads of lists (a power of two), the list's next link
  std::vector<std::uint32_t> heads_;
  std::vector<std::uint32_t> following_;  // by link, from tableBegin_ on
  std::size_t tableBegin_ = 0;
};

}  // namespace espalier::turtle
