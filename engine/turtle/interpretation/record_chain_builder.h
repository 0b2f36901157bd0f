#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "engine/turtle/interpretation/interpretation.h"
#include "engine/turtle/interpretation/record_chain.h"
#include "engine/turtle/interpretation/record_group_maker.h"

namespace espalier::turtle {

/// Makes the links of one plant (Interpreter::appendRecords).
///
/// The builder goes through the string from left to right, from group to group, and from stretch to stretch where a
/// group does not follow. It takes the next part of the base when the changes kept its modules and the turtle, with the
/// branches that the part closes, is the same. Bits are compared, so the part taken equals the part that interpretation
/// would make. Otherwise it interprets modules until it comes to the next kept stretch of the base with the same
/// turtle, or until there are enough modules for a new stretch.
class RecordChainBuilder {
 public:
  /// Modules of a stretch, about. With fewer, states cost more; with more, one change costs more.
  static constexpr std::uint64_t kStretchModules = 128;

  /// Everything must outlive the object. `base` may be null; `changes` are from its string to this one.
  RecordChainBuilder(const Interpretation::Subject& subject, const RecordChain* base,
                     const derivation::StepChanges& changes, const std::function<void(std::span<TurtleRecord>)>& rename,
                     RecordChain& chain, std::uint64_t stretchModules = kStretchModules);

  void appendPlant();

 private:
  /// A stretch of the base.
  struct Place {
    std::size_t link = 0;     // its group
    std::size_t stretch = 0;  // within the group
  };

  static constexpr std::uint64_t kNever = ~std::uint64_t{0};

  /// Moves next_ to the first kept stretch of the base that is not behind the present module.
  void findNext();
  void skipStretch();
  /// Where these modules of the base are now; kNever: not all of them were kept.
  [[nodiscard]] std::uint64_t placeOf(std::uint64_t baseModule, std::uint64_t modules) const;
  [[nodiscard]] bool groupFollows() const;
  [[nodiscard]] bool stretchFollows() const;
  /// Whether a part may be taken here, whose modules follow.
  [[nodiscard]] bool isReached(const TurtlePassage& passage) const;
  void takeGroup();
  void takeStretch();
  void pass(const TurtlePassage& passage);
  void interpret();
  void append(std::shared_ptr<const RecordStretch> stretch);
  [[nodiscard]] std::uint32_t resolved(std::uint32_t number) const;

  const derivation::ModuleString& string_;
  const RecordChain* base_;
  const std::function<void(std::span<TurtleRecord>)>& rename_;
  RecordChain& chain_;
  std::uint64_t stretchModules_;
  RecordGroupMaker groups_;
  std::vector<TurtleRecord> records_;  // of the stretch being interpreted
  InterpretationOutput output_;
  Interpretation interpretation_;
  Interpretation::StretchNotes notes_;  // its outer records are numbered as in the whole
  std::uint64_t module_ = 0;            // the next
  std::uint64_t offset_ = 0;            // of its parameters
  std::uint32_t recordCount_ = 0;       // so far, of the whole

  std::span<const derivation::KeptModules> kept_;  // from the base's string; those behind are passed
  Place next_;                                     // of the base that is expected next
  std::uint64_t nextModule_ = kNever;              // where it is now; kNever: nothing of the base is left
  std::size_t end_ = 0;                            // behind the plant's last link
};

}  // namespace espalier::turtle
