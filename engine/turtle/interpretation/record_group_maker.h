#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "engine/turtle/interpretation/record_chain.h"

namespace espalier::turtle {

/// Collects stretches that follow each other in a string and makes groups of them, at the end of a chain.
class RecordGroupMaker {
 public:
  /// `chain` must outlive the object.
  explicit RecordGroupMaker(RecordChain& chain) : chain_(chain) {}

  /// The next stretch. `outer`: its outer records as they are in the whole.
  void add(std::shared_ptr<const RecordStretch> stretch, std::span<const std::uint32_t> outer);
  [[nodiscard]] std::size_t waiting() const { return waiting_.size(); }
  /// The stretches that wait become a group; nothing when none do.
  void finish() { makeGroup(waiting_.size()); }
  /// The next part of the string is an existing group.
  void pass(const TurtlePassage& passage) { module_ += passage.modules; }

 private:
  struct Waiting {
    std::shared_ptr<const RecordStretch> stretch;
    std::size_t firstOuter = 0;  // in `outer_`
  };

  void makeGroup(std::size_t stretches);

  RecordChain& chain_;
  std::vector<Waiting> waiting_;
  std::vector<std::uint32_t> outer_;  // of all that wait, records as they are in the whole
  std::uint64_t module_ = 0;          // where those that wait begin in the string
};

}  // namespace espalier::turtle
