#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "engine/turtle/interpretation/interpretation.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::turtle {

/// Puts a scene together in the order of the string while threads draw its branches: each branch as soon as it and all
/// before it are drawn. Its lines are copied while they are still in the processor's cache, so that the memory of the
/// scene is touched once.
class SceneAssembly {
 public:
  /// `around` is drawn already: everything but the branches, which begin at `starts`. It is used up. `whole` gets the
  /// plant behind what it has. All must outlive the object.
  SceneAssembly(Scene& whole, Scene& around, std::span<const Interpretation::BranchStart> starts);

  /// An empty scene to draw a branch into. For any thread, as is add().
  [[nodiscard]] Scene take();
  /// What Interpretation::runBranch drew.
  void add(std::size_t branch, Scene&& drawn);
  /// All branches that were reached are there: adds the rest. Returns false when that is not possible: there are more
  /// lines than can be numbered, or there is not enough memory. The caller takes the plant back then.
  [[nodiscard]] bool finish();
  void takeBack() { first_.restore(*whole_); }

 private:
  void placeAround(const SceneMark& end);
  void placeBranch(std::size_t branch, Scene& drawn);

  Scene* whole_;
  Scene* around_;
  std::span<const Interpretation::BranchStart> starts_;
  SceneMark first_;  // of `whole`, before

  std::mutex mutex_;                         // of everything below
  std::vector<std::optional<Scene>> drawn_;  // by branch, until it is placed
  std::size_t next_ = 0;                     // branch to be placed
  SceneMark done_;                           // of `around`
  std::vector<std::uint32_t> lineOf_;        // of `around`: the line in `whole` (those that are placed)
  std::vector<Scene> spare_;                 // with memory to draw into
  bool isBroken_ = false;
};

}  // namespace espalier::turtle
