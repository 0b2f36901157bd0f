#include "environment/light/turbid_memory.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

namespace espalier::environment {

using core::Vec3;

namespace {

constexpr std::int64_t kBlock = 8;  // voxels along a side of a block, at most

bool isBefore(const TurbidMemory::Answer& a, const TurbidMemory::Answer& b) {
  // of several answers at a place the one that knows most comes first
  return std::tuple(a.place.x, a.place.y, a.place.z, b.count) < std::tuple(b.place.x, b.place.y, b.place.z, a.count);
}

/// The width of blocks: a box that repeats itself consists of whole ones. 0: there are none.
std::int64_t blockWidth(const VoxelField::Shape& shape, const GridAxes& axes) {
  if (!shape.isPeriodic) {
    return kBlock;
  }
  for (std::int64_t width = kBlock; width > 1; --width) {
    bool fits = true;
    for (int axis = 0; axis < 3; ++axis) {
      fits = fits && (axis == axes.up || shape.cells[static_cast<std::size_t>(axis)] % width == 0);
    }
    if (fits) {
      return width;
    }
  }
  return 0;
}

}  // namespace

void TurbidMemory::clear() {
  known_.clear();
  next_.clear();
  contents_.clear();
  touched_.reset();
}

void TurbidMemory::begin(const VoxelField& field, const VoxelField::Shape& shape, const GridAxes& axes) {
  known_ = std::move(next_);
  next_.clear();
  touched_.reset();
  const std::vector<double>& contents = field.values();
  std::vector<std::size_t> changed;
  for (std::size_t voxel = 0; voxel < contents_.size(); ++voxel) {
    if (contents[voxel] != contents_[voxel]) {
      changed.push_back(voxel);
    }
  }
  const std::int64_t width = blockWidth(shape, axes);
  // where much changed, looking for what did not is no gain
  if (contents_.size() != contents.size() || 8 * changed.size() > contents.size() || (width == 0 && !changed.empty())) {
    known_.clear();
  }
  contents_ = contents;
  if (known_.empty()) {
    return;
  }
  std::sort(known_.begin(), known_.end(), isBefore);
  if (changed.empty()) {
    return;
  }
  // where the box ends there is one more block: a gradient beside the box sees into it
  VoxelField::Shape blocks = shape;
  blocks.voxelSize = shape.voxelSize * static_cast<double>(width);
  std::array<double, 3> corner{shape.position.x, shape.position.y, shape.position.z};
  for (int axis = 0; axis < 3; ++axis) {
    const auto k = static_cast<std::size_t>(axis);
    const bool ends = !shape.isPeriodic || axis == axes.up;
    blocks.cells[k] = (shape.cells[k] + width - 1) / width + (ends ? 2 : 0);
    corner[k] -= ends ? blocks.voxelSize : 0.0;
  }
  blocks.position = {corner[0], corner[1], corner[2]};
  touched_.emplace(blocks, axes);
  for (const std::size_t voxel : changed) {
    const Vec3 middle = field.middleOf(voxel);
    for (int x = -2; x <= 2; ++x) {
      for (int y = -2; y <= 2; ++y) {
        for (int z = -2; z <= 2; ++z) {
          const Vec3 point =
              middle + Vec3{static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)} * shape.voxelSize;
          if (const auto block = touched_->indexOf(touched_->voxelOf(point))) {
            touched_->values()[*block] = 1.0;
          }
        }
      }
    }
  }
}

void TurbidMemory::keep(const Answer& answer) {
  // places that are no numbers have no order
  if (std::isfinite(answer.place.x) && std::isfinite(answer.place.y) && std::isfinite(answer.place.z)) {
    next_.push_back(answer);
  }
}

const TurbidMemory::Answer* TurbidMemory::find(const Vec3& place, std::size_t count,
                                               std::span<const Vec3> directions) const {
  const auto found = std::lower_bound(known_.begin(), known_.end(), Answer{place, 5, {}}, isBefore);
  if (found == known_.end() || !(found->place == place) || found->count < count) {
    return nullptr;
  }
  const bool isTouched = touched_ && std::any_of(directions.begin(), directions.end(), [&](const Vec3& direction) {
                           return touched_->integralAlong(place, direction) > 0.0;
                         });
  return isTouched ? nullptr : &*found;
}

}  // namespace espalier::environment
