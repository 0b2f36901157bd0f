#include "environment/geometry/box_tree.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "environment/geometry/embree_memory.h"

namespace espalier::environment {

namespace {

/// Far more than single precision rounds, relative to the coordinates involved.
constexpr double kWidening = 4e-6;

float below(double value, double margin) {
  return std::nextafter(static_cast<float>(value - margin), -std::numeric_limits<float>::infinity());
}
float above(double value, double margin) {
  return std::nextafter(static_cast<float>(value + margin), std::numeric_limits<float>::infinity());
}

double largest(const core::Vec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

/// The data that a ray carries to its visitor.
struct RayContext {
  RTCIntersectContext context;
  double (*call)(const void* data, unsigned index);
  const void* data;
  double from;    // the ray's origin as Embree sees it, along the ray
  double margin;  // by which a reach is widened
};

void boundsOf(const RTCBoundsFunctionArguments* arguments) {
  const auto& box = static_cast<const RTCBounds*>(arguments->geometryUserPtr)[arguments->primID];
  *arguments->bounds_o = box;
}

void intersect(const RTCIntersectFunctionNArguments* arguments) {
  if (arguments->valid[0] == 0) {
    return;
  }
  const auto* context = reinterpret_cast<const RayContext*>(arguments->context);
  auto* ray = reinterpret_cast<RTCRayHit*>(arguments->rayhit);
  const double reach = context->call(context->data, arguments->primID) - context->from;
  const float limit = above(reach, context->margin);
  ray->ray.tfar = std::min(ray->ray.tfar, limit);
}

}  // namespace

struct BoxTree::Tree {
  std::vector<RTCBounds> boxes;
  core::Vec3 low;
  core::Vec3 high;
  double margin = 0.0;
  EmbreeDevice device;
  RTCScene scene = nullptr;

  ~Tree() {
    if (scene != nullptr) {
      device.beginRelease();
      rtcReleaseScene(scene);
    }
  }
};

BoxTree::BoxTree(std::span<const Bounds> boxes) : tree_(std::make_unique<Tree>()) {
  if (boxes.empty()) {
    return;
  }
  Tree& tree = *tree_;
  tree.low = boxes.front().low;
  tree.high = boxes.front().high;
  for (const Bounds& box : boxes) {
    tree.low = {std::min(tree.low.x, box.low.x), std::min(tree.low.y, box.low.y), std::min(tree.low.z, box.low.z)};
    tree.high = {std::max(tree.high.x, box.high.x), std::max(tree.high.y, box.high.y),
                 std::max(tree.high.z, box.high.z)};
  }
  tree.margin = kWidening * std::max({largest(tree.low), largest(tree.high), 1e-20});
  tree.boxes.reserve(boxes.size());
  for (const Bounds& box : boxes) {
    RTCBounds wide{};
    wide.lower_x = below(box.low.x, tree.margin);
    wide.lower_y = below(box.low.y, tree.margin);
    wide.lower_z = below(box.low.z, tree.margin);
    wide.upper_x = above(box.high.x, tree.margin);
    wide.upper_y = above(box.high.y, tree.margin);
    wide.upper_z = above(box.high.z, tree.margin);
    tree.boxes.push_back(wide);
  }
  // one thread: a simulation belongs to one worker
  tree.device.open("threads=1,user_threads=1");
  tree.scene = rtcNewScene(tree.device.get());
  throwWithoutMemory(tree.device.get());
  RTCGeometry geometry = rtcNewGeometry(tree.device.get(), RTC_GEOMETRY_TYPE_USER);
  throwWithoutMemory(tree.device.get());
  rtcAttachGeometry(tree.scene, geometry);
  rtcReleaseGeometry(geometry);  // the scene keeps it
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(tree.boxes.size()));
  rtcSetGeometryUserData(geometry, tree.boxes.data());
  rtcSetGeometryBoundsFunction(geometry, boundsOf, nullptr);
  rtcSetGeometryIntersectFunction(geometry, intersect);
  rtcCommitGeometry(geometry);
  rtcSetSceneFlags(tree.scene, RTC_SCENE_FLAG_ROBUST);
  rtcCommitScene(tree.scene);
  throwWithoutMemory(tree.device.get());
  tree.device.endBuild();
}

BoxTree::~BoxTree() = default;
BoxTree::BoxTree(BoxTree&&) noexcept = default;
BoxTree& BoxTree::operator=(BoxTree&&) noexcept = default;

void BoxTree::near(const core::Vec3& point, double radius, Visitor visitor) const {
  if (tree_->scene == nullptr) {
    return;
  }
  struct Search {
    Visitor visitor;
    double margin;
  };
  Search search{visitor, kWidening * std::max(largest(point), 1e-20) + tree_->margin};
  RTCPointQuery query{};
  query.x = static_cast<float>(point.x);
  query.y = static_cast<float>(point.y);
  query.z = static_cast<float>(point.z);
  query.radius = above(radius, search.margin);
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  const auto visit = [](RTCPointQueryFunctionArguments* arguments) {
    const auto& searching = *static_cast<const Search*>(arguments->userPtr);
    const double left = searching.visitor.call(searching.visitor.data, arguments->primID);
    const float limit = above(left * (1.0 + kWidening), searching.margin);
    if (limit < arguments->query->radius) {
      arguments->query->radius = limit;
      return true;
    }
    return false;
  };
  rtcPointQuery(tree_->scene, &query, &context, visit, &search);
}

void BoxTree::along(const core::Vec3& origin, const core::Vec3& direction, double reach, Visitor visitor) const {
  if (tree_->scene == nullptr) {
    return;
  }
  // an origin far away is moved to where the ray enters the box of all boxes, so that rounding stays small
  const std::array<double, 3> start{origin.x, origin.y, origin.z};
  const std::array<double, 3> way{direction.x, direction.y, direction.z};
  const std::array<double, 3> low{tree_->low.x, tree_->low.y, tree_->low.z};
  const std::array<double, 3> high{tree_->high.x, tree_->high.y, tree_->high.z};
  const double wide = 4.0 * tree_->margin;
  double from = 0.0;
  double to = reach;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (way[axis] == 0.0) {
      if (start[axis] < low[axis] - wide || start[axis] > high[axis] + wide) {
        return;
      }
      continue;
    }
    const double a = (low[axis] - wide - start[axis]) / way[axis];
    const double b = (high[axis] + wide - start[axis]) / way[axis];
    from = std::max(from, std::min(a, b));
    to = std::min(to, std::max(a, b));
  }
  if (!(from <= to)) {
    return;
  }
  const core::Vec3 entry = origin + direction * from;
  RTCRayHit ray{};
  ray.ray.org_x = static_cast<float>(entry.x);
  ray.ray.org_y = static_cast<float>(entry.y);
  ray.ray.org_z = static_cast<float>(entry.z);
  ray.ray.dir_x = static_cast<float>(direction.x);
  ray.ray.dir_y = static_cast<float>(direction.y);
  ray.ray.dir_z = static_cast<float>(direction.z);
  ray.ray.tnear = 0.0F;
  ray.ray.tfar = above(to - from, wide);
  ray.ray.mask = 0xFFFFFFFFU;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  RayContext context{};
  rtcInitIntersectContext(&context.context);
  context.call = visitor.call;
  context.data = visitor.data;
  context.from = from;
  context.margin = wide;
  rtcIntersect1(tree_->scene, &context.context, &ray);
}

}  // namespace espalier::environment
