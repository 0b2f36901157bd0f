#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "engine/turtle/interpretation/interpretation.h"
#include "engine/turtle/interpretation/record_chain.h"
#include "engine/turtle/interpretation/record_group_maker.h"

namespace espalier::turtle {

/// Makes the links of one plant (Interpreter::appendRecords).
///
/// The builder goes through the string from left to right, from group to group, and from stretch to stretch where a
/// group does not follow. It takes the next part of the base when the same modules follow and the turtle, with the
/// branches that the part closes, is the same. Bits are compared, so the part taken equals the part that interpretation
/// would make. Otherwise it interprets modules until the turtle is in the state before a later stretch of the base
/// whose modules follow, or until there are enough modules for a new stretch. It needs no difference of the strings.
class RecordChainBuilder {
 public:
  /// Modules of a stretch, about. With fewer, states cost more; with more, one change costs more.
  static constexpr std::uint64_t kStretchModules = 128;

  /// Everything must outlive the object. `base` may be null.
  RecordChainBuilder(const Interpretation::Subject& subject, const RecordChain* base,
                     const std::function<void(std::span<TurtleRecord>)>& rename, RecordChain& chain,
                     std::uint64_t stretchModules = kStretchModules);

  void appendPlant();

 private:
  /// A stretch of the base.
  struct Place {
    std::size_t link = 0;     // its group
    std::size_t stretch = 0;  // within the group
  };

  [[nodiscard]] bool isKnown() const { return next_.link < end_; }
  [[nodiscard]] bool groupFollows();
  [[nodiscard]] bool stretchFollows(const Place& place);
  [[nodiscard]] bool follows(const TurtlePassage& passage, std::uint64_t baseModule, const core::ModuleTypeId* types,
                             const double* parameters);
  [[nodiscard]] bool areKept(std::uint64_t baseModule, std::uint64_t modules);
  [[nodiscard]] bool findNext();
  void buildTable(std::size_t end);
  [[nodiscard]] Place placeOf(std::uint32_t entry) const;
  void takeGroup();
  void takeStretch();
  void pass(const TurtlePassage& passage);
  void interpret();
  void append(std::shared_ptr<const RecordStretch> stretch, std::uint32_t entryHash);
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

  // runs of modules that the derivation kept from the base's string, and the next of them
  std::vector<derivation::KeptModules> kept_;
  std::size_t nextKept_ = 0;

  Place next_;                  // of the base that is expected next
  std::size_t end_ = 0;         // behind the plant's last link
  std::uint64_t takenEnd_ = 0;  // behind the last module that was not interpreted
  // where to find stretches of links [tableBegin_, tableEnd_) by the turtle that they begin with: heads of lists (a
  // power of two), the list's next; an entry is kMostStretches times the link, counted from tableBegin_, and the
  // stretch
  std::vector<std::uint32_t> heads_;
  std::vector<std::uint32_t> following_;
  std::size_t tableBegin_ = 0;
  std::size_t tableEnd_ = 0;
};

}  // namespace espalier::turtle
