#include "engine/turtle/interpretation/scene_assembly.h"

#include <new>
#include <utility>

namespace espalier::turtle {
namespace {

/// Moves elements to the end of another list. `lineOf` gives the lines that they grow on.
template <typename Element, typename LineOf>
void moveElements(std::vector<Element>& from, std::size_t begin, std::size_t end, const LineOf& lineOf,
                  std::vector<Element>& to) {
  for (std::size_t i = begin; i < end; ++i) {
    to.push_back(std::move(from[i]));
    to.back().parent = lineOf(to.back().parent);
  }
}

template <typename LineOf>
void moveOrgans(Scene& from, const SceneMark& begin, const SceneMark& end, const LineOf& lineOf, Scene& to) {
  moveElements(from.polygons, begin.polygons, end.polygons, lineOf, to.polygons);
  moveElements(from.balls, begin.balls, end.balls, lineOf, to.balls);
  moveElements(from.surfaces, begin.surfaces, end.surfaces, lineOf, to.surfaces);
  moveElements(from.cylinders, begin.cylinders, end.cylinders, lineOf, to.cylinders);
  moveElements(from.labels, begin.labels, end.labels, lineOf, to.labels);
}

}  // namespace

SceneAssembly::SceneAssembly(Scene& whole, Scene& around, std::span<const Interpretation::BranchStart> starts)
    : whole_(&whole), around_(&around), starts_(starts), first_(whole), drawn_(starts.size()) {}

Scene SceneAssembly::take() {
  const std::lock_guard lock(mutex_);
  if (spare_.empty()) {
    return {};
  }
  Scene scene = std::move(spare_.back());
  spare_.pop_back();
  return scene;
}

void SceneAssembly::add(std::size_t branch, Scene&& drawn) {
  const std::lock_guard lock(mutex_);
  if (isBroken_) {
    return;
  }
  // stays true when the code below throws
  isBroken_ = true;
  drawn_[branch] = std::move(drawn);
  for (; next_ < starts_.size(); ++next_) {
    if (!starts_[next_].isReached) {
      continue;
    }
    std::optional<Scene>& scene = drawn_[next_];
    if (!scene) {
      break;
    }
    if (whole_->segments.size() + around_->segments.size() + scene->segments.size() >= kNoParent) {
      return;
    }
    placeAround(starts_[next_].drawn);
    placeBranch(next_, *scene);
    scene->clear();
    spare_.push_back(std::move(*scene));
    scene.reset();
  }
  isBroken_ = false;
}

bool SceneAssembly::finish() {
  if (isBroken_) {
    return false;
  }
  try {
    placeAround(SceneMark(*around_));
  } catch (const std::bad_alloc&) {
    return false;
  }
  return true;
}

// the elements of the walk around the branches, up to a mark
void SceneAssembly::placeAround(const SceneMark& end) {
  const auto lineOf = [this](std::uint32_t line) { return line == kNoParent ? kNoParent : lineOf_[line]; };
  for (std::size_t i = done_.segments; i < end.segments; ++i) {
    Segment line = std::as_const(around_->segments)[i];
    line.parent = lineOf(line.parent);
    lineOf_.push_back(static_cast<std::uint32_t>(whole_->segments.size()));
    whole_->segments.push_back(line);
  }
  moveOrgans(*around_, done_, end, lineOf, *whole_);
  done_ = end;
}

void SceneAssembly::placeBranch(std::size_t branch, Scene& drawn) {
  // the first line and the first cylinder belong to the walk around the branches
  SceneMark begin;
  begin.segments = 1;
  begin.cylinders = 1;
  const std::uint32_t start = starts_[branch].state.segment;
  const std::uint32_t parent = start == kNoParent ? kNoParent : lineOf_[start];
  const std::size_t before = whole_->segments.size();
  const auto lineOf = [&](std::uint32_t line) {
    if (line == kNoParent || line == 0) {
      return line == 0 ? parent : kNoParent;
    }
    return static_cast<std::uint32_t>(before + line - 1);
  };
  const std::span<const Segment> lines = std::as_const(drawn.segments).view().subspan(begin.segments);
  whole_->segments.resize(before + lines.size());
  Segment* const to = whole_->segments.data() + before;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    to[i] = lines[i];
    to[i].parent = lineOf(lines[i].parent);
  }
  moveOrgans(drawn, begin, SceneMark(drawn), lineOf, *whole_);
}

}  // namespace espalier::turtle
