#include "environment/light/voxels/turbid_memory.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "engine/core/work_meter.h"

namespace espalier::environment {

using core::Vec3;

namespace {

constexpr std::size_t kMostParts = std::size_t{1} << 25U;
constexpr std::size_t kMostStepsOfLine = 1U << 14U;
/// A ray that starts in a voxel, or one voxel aside for a gradient, and meets another voxel: the line from middle to
/// middle is at most 2 voxels beside it. Points of a line are half a voxel apart.
constexpr std::int64_t kReach = 2;
constexpr double kStep = 0.5;

}  // namespace

void TurbidMemory::clear() {
  *this = TurbidMemory();
}

bool TurbidMemory::isBefore(const Entry& a, const Entry& b) {
  // of several entries of a place the one with most rays comes first
  return std::tuple(a.place.x, a.place.y, a.place.z, b.rayCount) <
         std::tuple(b.place.x, b.place.y, b.place.z, a.rayCount);
}

void TurbidMemory::begin(const VoxelField& field, const VoxelField::Shape& shape, std::span<const Vec3> directions) {
  std::swap(before_, now_);
  now_.entries.clear();
  now_.parts.clear();
  touched_.clear();
  shape_ = shape;
  std::vector<std::size_t> changed;
  const bool isComparable = field_.values().size() == field.values().size() && directionCount_ == directions.size();
  for (std::size_t voxel = 0; isComparable && voxel < field.values().size(); ++voxel) {
    if (field.values()[voxel] != field_.values()[voxel]) {
      changed.push_back(voxel);
    }
  }
  field_ = field;
  directionCount_ = directions.size();
  // finding the rays that many changes touch costs more than tracing all
  if (!isComparable || 4 * changed.size() > before_.entries.size()) {
    before_ = {};
    return;
  }
  std::sort(before_.entries.begin(), before_.entries.end(), isBefore);
  if (!changed.empty()) {
    touched_.assign(field.values().size(), 0);
  }
  for (const std::size_t voxel : changed) {
    for (std::size_t d = 0; d < directions.size(); ++d) {
      core::pollWork();
      touch(voxel, d, directions[d]);
    }
  }
}

void TurbidMemory::touch(std::size_t voxel, std::size_t direction, const Vec3& towards) {
  // back along the line, from the voxel away from the light
  const std::uint64_t bit = std::uint64_t{1} << direction % 64;
  const Vec3 middle = field_.middleOf(voxel);
  for (std::size_t step = 0; step < kMostStepsOfLine; ++step) {
    const Vec3 point = middle - towards * (kStep * static_cast<double>(step) * shape_.voxelSize);
    const VoxelField::Voxel at = field_.voxelOf(point);
    if (field_.isBeyond(at, kReach)) {
      return;
    }
    for (std::int64_t a = -kReach; a <= kReach; ++a) {
      for (std::int64_t b = -kReach; b <= kReach; ++b) {
        for (std::int64_t layer = -kReach; layer <= kReach; ++layer) {
          if (const auto index = field_.indexBeside(at, a, b, layer)) {
            touched_[*index] |= bit;
          }
        }
      }
    }
  }
  // nearly level light in a stand that repeats itself goes everywhere
  for (std::uint64_t& bits : touched_) {
    bits |= bit;
  }
}

TurbidMemory::Place TurbidMemory::lookAt(const Vec3& place, std::size_t rayCount) {
  Place result;
  const std::size_t count = rayCount * directionCount_;
  // places that are no numbers have no order
  const bool isKept = isFinite(place) && now_.parts.size() + count <= kMostParts;
  std::vector<double>& parts = isKept ? now_.parts : unkept_;
  if (isKept) {
    // in this order: without memory for the entry its parts are not referenced
    parts.resize(parts.size() + count);
    now_.entries.push_back({place, rayCount, parts.size() - count});
  } else {
    parts.resize(std::max(parts.size(), count));
  }
  result.parts = std::span(parts).last(count);
  if (!isFinite(place)) {
    return result;
  }
  const auto found =
      std::lower_bound(before_.entries.begin(), before_.entries.end(), Entry{place, kMostRays, 0}, isBefore);
  const auto voxel = field_.indexOf(field_.voxelOf(place));
  // changes that touch places beside the box are not known
  if (found != before_.entries.end() && found->place == place && found->rayCount >= rayCount &&
      (voxel || touched_.empty())) {
    result.before = std::span<const double>(before_.parts).subspan(found->first, count);
    result.touched = touched_.empty() ? 0 : touched_[*voxel];
  }
  return result;
}

}  // namespace espalier::environment
