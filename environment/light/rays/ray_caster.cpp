#include "environment/light/rays/ray_caster.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>

#include "engine/core/elementary.h"
#include "engine/core/work_meter.h"
#include "environment/geometry/embree_memory.h"

namespace espalier::environment {

using core::Vec3;

namespace {

/// How much further than its ends Embree follows a ray, relative to the distance: more than its reciprocals are off.
/// How far they are off depends on the processor, so distances are computed and compared here.
constexpr float kWider = 1e-5F;

RTCRay rayAlong(const Vec3& direction) {
  RTCRay ray{};
  ray.dir_x = static_cast<float>(direction.x);
  ray.dir_y = static_cast<float>(direction.y);
  ray.dir_z = static_cast<float>(direction.z);
  ray.mask = 0xFFFFFFFFU;
  return ray;
}

/// The data of a ray besides Embree's part: its ends, the triangles, and the nearest hit so far.
struct HitContext {
  RTCIntersectContext embree;
  const float* vertices = nullptr;            // three a vertex
  const std::uint32_t* corners = nullptr;     // three a triangle
  const std::uint32_t* originalOf = nullptr;  // of the scene's triangles; nullptr: the same
  double from = 0.0;
  double to = HUGE_VAL;
  double nearest = HUGE_VAL;
  std::uint32_t triangle = RayCaster::kMiss;
  bool isFront = false;
};
static_assert(std::is_standard_layout_v<HitContext>);

/// Whether Embree may be asked for a ray from there: it ends the program for places beyond 1.8·10¹⁸.
bool isNear(const Vec3& origin) {
  constexpr double kFar = 1e18;
  return std::abs(origin.x) <= kFar && std::abs(origin.y) <= kFar && std::abs(origin.z) <= kFar;
}

/// Lets a ray begin at another place; it has met nothing so far.
void start(RTCRay& ray, HitContext& context, const Vec3& origin, double from, double to) {
  ray.org_x = static_cast<float>(origin.x);
  ray.org_y = static_cast<float>(origin.y);
  ray.org_z = static_cast<float>(origin.z);
  ray.tnear = static_cast<float>(from) * (1.0F - kWider);
  ray.tfar = static_cast<float>(to) * (1.0F + kWider);
  context.from = from;
  context.to = to;
}

/// On which side of an edge a ray along `way` from the origin passes. The same number with the other sign for the
/// edge in the other direction, so that of two triangles at an edge at least one is met.
double sideOf(const Vec3& way, const Vec3& from, const Vec3& to) {
  return core::dot(way, core::cross(from, to));
}

/// The distance along the ray to a triangle that Embree has met; negative when the ray does not meet it between its
/// ends. Embree also takes rays that pass a triangle closely, but whether it looks at that triangle then depends on its
/// tree, which differs between vector instructions.
double distanceOf(const HitContext& context, const RTCRay& ray, const RTCHit& hit) {
  const Vec3 origin{ray.org_x, ray.org_y, ray.org_z};
  const Vec3 way{ray.dir_x, ray.dir_y, ray.dir_z};
  const auto corner = [&](std::size_t k) {
    const float* vertex = context.vertices + std::size_t{3} * context.corners[std::size_t{3} * hit.primID + k];
    return Vec3{vertex[0], vertex[1], vertex[2]} - origin;
  };
  const Vec3 a = corner(0);
  const Vec3 b = corner(1);
  const Vec3 c = corner(2);
  const double ab = sideOf(way, a, b);
  const double bc = sideOf(way, b, c);
  const double ca = sideOf(way, c, a);
  const bool isInside = (ab >= 0.0 && bc >= 0.0 && ca >= 0.0) || (ab <= 0.0 && bc <= 0.0 && ca <= 0.0);
  const Vec3 normal{hit.Ng_x, hit.Ng_y, hit.Ng_z};
  const double distance = core::dot(a, normal) / core::dot(way, normal);
  return isInside && distance >= context.from && distance <= context.to ? distance : -1.0;
}

/// Keeps the nearest triangle; of triangles at the same distance the one with the smallest number. Embree looks on for
/// others that are hardly further.
void keepNearest(const RTCFilterFunctionNArguments* arguments) {
  if (arguments->valid[0] == 0) {
    return;
  }
  // rays are cast one by one, so these are a context, a ray and a hit
  auto& context = *reinterpret_cast<HitContext*>(arguments->context);
  auto& ray = *reinterpret_cast<RTCRay*>(arguments->ray);
  const auto& hit = *reinterpret_cast<const RTCHit*>(arguments->hit);
  const double distance = distanceOf(context, ray, hit);
  const std::uint32_t triangle = context.originalOf == nullptr ? hit.primID : context.originalOf[hit.primID];
  if (distance < 0.0 || distance > context.nearest || (distance == context.nearest && triangle > context.triangle)) {
    arguments->valid[0] = 0;
    return;
  }
  context.nearest = distance;
  context.triangle = triangle;
  // Embree's normal is cross(b - a, c - a)
  context.isFront = hit.Ng_x * ray.dir_x + hit.Ng_y * ray.dir_y + hit.Ng_z * ray.dir_z < 0.0F;
  ray.tfar = static_cast<float>(distance) * (1.0F + kWider);
}

/// Any triangle between the ends of the ray will do.
void keepAny(const RTCFilterFunctionNArguments* arguments) {
  const auto& context = *reinterpret_cast<const HitContext*>(arguments->context);
  if (arguments->valid[0] != 0 && distanceOf(context, *reinterpret_cast<const RTCRay*>(arguments->ray),
                                             *reinterpret_cast<const RTCHit*>(arguments->hit)) < 0.0) {
    arguments->valid[0] = 0;
  }
}

/// A length that single precision resolves at places up to so far from its zero.
double resolvedAt(double largest) {
  return core::exp2(std::ceil(core::log2(2e-6 * std::max(largest, 1e-20))));
}

double largestOf(const Vec3& place) {
  return std::max({std::abs(place.x), std::abs(place.y), std::abs(place.z)});
}

}  // namespace

struct RayCaster::Tree {
  EmbreeDevice device;
  RTCScene scene = nullptr;
  std::vector<std::uint32_t> originalOf;   // triangle by triangle of the scene; empty: the same
  const float* vertices = nullptr;         // of the scene, three a vertex
  const std::uint32_t* corners = nullptr;  // of the scene, three a triangle
  std::optional<Repetition> repetition;
  double lowest = 0.0;  // along the third axis
  double highest = 0.0;
  double margin = 1e-6;
  Vec3 middle;

  [[nodiscard]] HitContext context() const {
    HitContext made;
    rtcInitIntersectContext(&made.embree);
    made.vertices = vertices;
    made.corners = corners;
    made.originalOf = originalOf.empty() ? nullptr : originalOf.data();
    return made;
  }

  ~Tree() {
    if (scene != nullptr) {
      device.beginRelease();
      rtcReleaseScene(scene);
    }
  }
};

Vec3 RayCaster::middleOf(std::span<const Vec3> vertices) {
  constexpr double kFar = 16.0;  // sizes of the scene from 0: four of the 24 binary digits are then lost
  std::array<double, 3> low{HUGE_VAL, HUGE_VAL, HUGE_VAL};
  std::array<double, 3> high{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
  for (const Vec3& vertex : vertices) {
    const auto place = componentsOf(vertex);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], place[axis]);
      high[axis] = std::max(high[axis], place[axis]);
    }
  }
  const double size = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
  std::array<double, 3> middle{};
  for (std::size_t axis = 0; axis < 3 && size > 0.0; ++axis) {
    if (std::max(-low[axis], high[axis]) > kFar * size) {
      // multiples of a power of two, which a growing scene seldom leaves
      const double step = 4.0 * core::exp2(std::ceil(core::log2(size)));
      middle[axis] = step * std::floor(low[axis] / step + 0.5);
    }
  }
  return {middle[0], middle[1], middle[2]};
}

RayCaster::RayCaster(std::span<const Vec3> vertices, std::span<const std::array<std::uint32_t, 3>> triangles,
                     const std::optional<Repetition>& givenRepetition, const Vec3& middle, unsigned threads,
                     const std::string& widestInstructions)
    : tree_(std::make_unique<Tree>()) {
  Tree& tree = *tree_;
  tree.middle = middle;
  std::optional<Repetition>& repetition = tree.repetition;
  repetition = givenRepetition;
  std::vector<Vec3> places(vertices.begin(), vertices.end());
  for (Vec3& place : places) {
    place = place - middle;
  }
  for (std::size_t k = 0; repetition && k < 2; ++k) {
    const double own = componentsOf(middle)[static_cast<std::size_t>(repetition->axes[k])];
    repetition->low[k] -= own;
    repetition->high[k] -= own;
  }
  std::vector<std::array<std::uint32_t, 3>> corners(triangles.begin(), triangles.end());
  if (repetition) {
    // triangles beyond the plot come in on the other side: copies of the triangles that reach into the plot
    tree.originalOf.resize(triangles.size());
    for (std::uint32_t i = 0; i < triangles.size(); ++i) {
      tree.originalOf[i] = i;
    }
    for (std::uint32_t i = 0; i < triangles.size(); ++i) {
      std::array<std::array<int, 2>, 2> shifts{};
      for (std::size_t k = 0; k < 2; ++k) {
        const auto axis = static_cast<std::size_t>(repetition->axes[k]);
        double low = HUGE_VAL;
        double high = -HUGE_VAL;
        for (const std::uint32_t corner : triangles[i]) {
          low = std::min(low, componentsOf(places[corner])[axis]);
          high = std::max(high, componentsOf(places[corner])[axis]);
        }
        const double width = repetition->high[k] - repetition->low[k];
        shifts[k] = {static_cast<int>(std::ceil((repetition->low[k] - high) / width)),
                     static_cast<int>(std::floor((repetition->high[k] - low) / width))};
      }
      bool isFirst = true;
      for (int a = shifts[0][0]; a <= shifts[0][1]; ++a) {
        for (int b = shifts[1][0]; b <= shifts[1][1]; ++b) {
          std::array<double, 3> shift{};
          shift[static_cast<std::size_t>(repetition->axes[0])] = a * (repetition->high[0] - repetition->low[0]);
          shift[static_cast<std::size_t>(repetition->axes[1])] = b * (repetition->high[1] - repetition->low[1]);
          std::array<std::uint32_t, 3> copy{};
          for (std::size_t corner = 0; corner < 3; ++corner) {
            copy[corner] = static_cast<std::uint32_t>(places.size());
            const Vec3 place = places[triangles[i][corner]];
            places.push_back(place + Vec3{shift[0], shift[1], shift[2]});
          }
          if (isFirst) {
            corners[i] = copy;
          } else {
            corners.push_back(copy);
            tree.originalOf.push_back(i);
          }
          isFirst = false;
        }
      }
    }
  }
  double largest = 0.0;
  const std::size_t upright = repetition ? static_cast<std::size_t>(3 - repetition->axes[0] - repetition->axes[1]) : 1;
  tree.lowest = HUGE_VAL;
  tree.highest = -HUGE_VAL;
  for (const Vec3& place : places) {
    largest = std::max(largest, largestOf(place));
    tree.lowest = std::min(tree.lowest, componentsOf(place)[upright]);
    tree.highest = std::max(tree.highest, componentsOf(place)[upright]);
  }
  tree.margin = resolvedAt(largest);
  if (corners.empty()) {
    return;
  }
  // no fused multiply-add: without it Embree meets the same triangles on every processor
  tree.device.open(
      ("ignore_config_files=1,threads=" + std::to_string(std::max(threads, 1U)) + ",max_isa=" + widestInstructions)
          .c_str());
  tree.scene = rtcNewScene(tree.device.get());
  throwWithoutMemory(tree.device.get());
  RTCGeometry geometry = rtcNewGeometry(tree.device.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
  throwWithoutMemory(tree.device.get());
  rtcAttachGeometry(tree.scene, geometry);
  rtcReleaseGeometry(geometry);  // the scene keeps it
  auto* position = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                               3 * sizeof(float), places.size()));
  throwWithoutMemory(tree.device.get());
  tree.vertices = position;
  for (const Vec3& place : places) {
    *position++ = static_cast<float>(place.x);
    *position++ = static_cast<float>(place.y);
    *position++ = static_cast<float>(place.z);
  }
  auto* index = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), corners.size()));
  throwWithoutMemory(tree.device.get());
  tree.corners = index;
  for (const auto& corner : corners) {
    index = std::copy(corner.begin(), corner.end(), index);
  }
  rtcSetGeometryIntersectFilterFunction(geometry, keepNearest);
  rtcSetGeometryOccludedFilterFunction(geometry, keepAny);
  rtcCommitGeometry(geometry);
  rtcSetSceneFlags(tree.scene, RTC_SCENE_FLAG_ROBUST);
  rtcCommitScene(tree.scene);
  throwWithoutMemory(tree.device.get());
  tree.device.endBuild();
}

RayCaster::~RayCaster() = default;
RayCaster::RayCaster(RayCaster&&) noexcept = default;
RayCaster& RayCaster::operator=(RayCaster&&) noexcept = default;

double RayCaster::margin() const {
  return tree_->margin;
}

const Vec3& RayCaster::middle() const {
  return tree_->middle;
}

double RayCaster::marginOf(std::uint32_t triangle) const {
  if (tree_->repetition || tree_->scene == nullptr) {
    return tree_->margin;
  }
  double largest = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const float* place = tree_->vertices + std::size_t{3} * tree_->corners[std::size_t{3} * triangle + k];
    largest = std::max(largest, largestOf({place[0], place[1], place[2]}));
  }
  return resolvedAt(largest);
}

template <typename Cast>
RayCaster::Hit RayCaster::alongPlots(const Vec3& origin, const Vec3& direction, double margin, const Cast& cast) const {
  const Repetition& repetition = *tree_->repetition;
  auto place = componentsOf(origin);
  const auto way = componentsOf(direction);
  const auto upright = static_cast<std::size_t>(3 - repetition.axes[0] - repetition.axes[1]);
  // into the plot
  for (std::size_t k = 0; k < 2; ++k) {
    const double width = repetition.high[k] - repetition.low[k];
    double& p = place[static_cast<std::size_t>(repetition.axes[k])];
    const double plots = (p - repetition.low[k]) / width;
    // most rays start in the plot, and without SSE4.1 floor is a call
    p -= plots > 0.0 && plots < 1.0 ? 0.0 : width * std::floor(plots);
  }
  // from border to border, until above or below everything
  const double end = way[upright] == 0.0
                         ? 0.0
                         : ((way[upright] > 0.0 ? tree_->highest : tree_->lowest) - place[upright]) / way[upright];
  constexpr int kMostBorders = 10'000'000;  // a ray that is nearly level passes more of a narrow plot than are computed
  double from = margin;
  double passed = 0.0;
  for (int plots = 0; passed <= end && plots < kMostBorders; ++plots) {
    if (plots % 1024 == 1023) {
      core::pollWork();
    }
    double nearest = HUGE_VAL;
    std::size_t crossed = 0;
    for (std::size_t k = 0; k < 2; ++k) {
      const auto axis = static_cast<std::size_t>(repetition.axes[k]);
      if (way[axis] != 0.0) {
        const double border = way[axis] > 0.0 ? repetition.high[k] : repetition.low[k];
        const double distance = std::max((border - place[axis]) / way[axis], 0.0);
        if (distance < nearest) {
          nearest = distance;
          crossed = k;
        }
      }
    }
    const double length = std::min(nearest, end - passed + 2.0 * margin);
    const Hit hit = cast(Vec3{place[0], place[1], place[2]}, from, length);
    if (hit.triangle != kMiss || nearest == HUGE_VAL) {
      return hit;
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      place[axis] += way[axis] * nearest;
    }
    const auto axis = static_cast<std::size_t>(repetition.axes[crossed]);
    place[axis] = way[axis] > 0.0 ? repetition.low[crossed] : repetition.high[crossed];
    passed += nearest;
    from = 0.0;
  }
  return {};
}

RayCaster::Hit RayCaster::firstHit(const Vec3& from, const Vec3& direction, double margin) const {
  const Vec3 origin = from - tree_->middle;
  if (tree_->scene == nullptr || !isNear(origin)) {
    return {};
  }
  RTCRayHit ray;
  ray.ray = rayAlong(direction);
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  HitContext context = tree_->context();
  const auto cast = [&](const Vec3& place, double begin, double end) {
    start(ray.ray, context, place, begin, end);
    rtcIntersect1(tree_->scene, &context.embree, &ray);
    return Hit{context.triangle, context.isFront};
  };
  return tree_->repetition ? alongPlots(origin, direction, margin, cast) : cast(origin, margin, HUGE_VAL);
}

bool RayCaster::isFree(const Vec3& from, const Vec3& direction, double margin) const {
  const Vec3 origin = from - tree_->middle;
  if (tree_->scene == nullptr || !isNear(origin)) {
    return true;
  }
  RTCRay ray = rayAlong(direction);
  HitContext context = tree_->context();
  const auto cast = [&](const Vec3& place, double begin, double end) {
    start(ray, context, place, begin, end);
    rtcOccluded1(tree_->scene, &context.embree, &ray);
    return ray.tfar < 0.0F ? Hit{0, false} : Hit{};
  };
  return (tree_->repetition ? alongPlots(origin, direction, margin, cast) : cast(origin, margin, HUGE_VAL)).triangle ==
         kMiss;
}

}  // namespace espalier::environment
