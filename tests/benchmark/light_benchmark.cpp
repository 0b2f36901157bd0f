// Light by rays beside a bare loop of Embree over as many rays of the same scene, and voxel light.

#include <benchmark/benchmark.h>
#include <embree3/rtcore.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <random>
#include <thread>
#include <vector>

#include "engine/turtle/scene/geometry.h"
#include "environment/light/rays/leaf_light.h"
#include "environment/light/rays/plant_surfaces.h"
#include "environment/light/voxels/voxel_field.h"
#include "tests/benchmark/workload.h"

namespace espalier::benchmarking {
namespace {

using benchmark::Counter;
using core::Vec3;

constexpr int kDirections = 64;

double millisecondsOf(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

// a canopy of leaves, each of two triangles, in a cube of side 1 with a leaf area index of 3
environment::LightSurfaces canopy(int triangleCount) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> place(0.0, 1.0);
  std::normal_distribution<double> component;
  const double side = std::sqrt(3.0 / (triangleCount / 2.0));
  environment::LightSurfaces surfaces;
  for (int leaf = 0; leaf < triangleCount / 2; ++leaf) {
    const Vec3 u = core::normalised({component(random), component(random), component(random)});
    const Vec3 w = core::normalised({component(random), component(random), component(random)});
    const Vec3 v = core::normalised(w - u * core::dot(u, w));
    const Vec3 corner{place(random), place(random), place(random)};
    const auto base = static_cast<std::uint32_t>(surfaces.vertices.size());
    surfaces.vertices.insert(surfaces.vertices.end(),
                             {corner, corner + u * side, corner + (u + v) * side, corner + v * side});
    surfaces.triangles.push_back({base, base + 1, base + 2});
    surfaces.triangles.push_back({base, base + 2, base + 3});
    surfaces.material.insert(surfaces.material.end(), 2, 0U);
  }
  return surfaces;
}

// one bounce in one band, of rays that have been traced
void bounce(benchmark::State& state) {
  const auto surfaces = canopy(static_cast<int>(state.range(0)));
  const environment::LeafLight traced(surfaces, {}, {}, {.directions = kDirections});
  const std::vector<double> sky(traced.directions().all().size(), 1.0);
  for (auto _ : state) {
    benchmark::DoNotOptimize(traced.irradiances(0, sky, {{0.1, 0.1}}, {}, 1));
  }
  state.counters["rays/s"] = Counter(2.0 * static_cast<double>(traced.rayCount()), Counter::kIsIterationInvariantRate);
}

// the same with the triangles in the order of space, as `light` visits them: a bare loop over it meets in turn what
// lies together
environment::LightSurfaces inOrderOfSpace(const environment::LightSurfaces& surfaces) {
  const auto cellOf = [&](std::uint32_t triangle) {
    const Vec3& place = surfaces.vertices[surfaces.triangles[triangle][0]];
    std::uint64_t cell = 0;
    for (int bit = 9; bit >= 0; --bit) {
      for (const double along : {place.z, place.y, place.x}) {
        cell = 2 * cell + (static_cast<std::uint64_t>(along * 1024.0) >> bit & 1U);
      }
    }
    return cell;
  };
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order;
  for (std::uint32_t triangle = 0; triangle < surfaces.triangles.size(); ++triangle) {
    order.emplace_back(cellOf(triangle), triangle);
  }
  std::sort(order.begin(), order.end());
  environment::LightSurfaces sorted = surfaces;
  for (std::size_t i = 0; i < order.size(); ++i) {
    sorted.triangles[i] = surfaces.triangles[order[i].second];
  }
  return sorted;
}

// a scene and as many rays as `light` has, with nothing around: building the tree and rtcIntersect1 from the middles of
// the triangles, one after the other
void castBareRays(const environment::LightSurfaces& surfaces, unsigned threads) {
  const environment::RayDirections lattice(kDirections);
  const std::vector<Vec3>& directions = lattice.all();
  std::vector<std::uint32_t> hits(surfaces.triangles.size() * kDirections);
  RTCDevice device = rtcNewDevice(threads == 1 ? "threads=1" : "threads=2");
  RTCScene scene = rtcNewScene(device);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* position = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                               3 * sizeof(float), surfaces.vertices.size()));
  for (const Vec3& vertex : surfaces.vertices) {
    *position++ = static_cast<float>(vertex.x);
    *position++ = static_cast<float>(vertex.y);
    *position++ = static_cast<float>(vertex.z);
  }
  auto* index = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), surfaces.triangles.size()));
  for (const auto& corners : surfaces.triangles) {
    index = std::copy(corners.begin(), corners.end(), index);
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  rtcCommitScene(scene);
  const auto part = [&](std::size_t from, std::size_t to) {
    for (std::size_t triangle = from; triangle < to; ++triangle) {
      const auto& corners = surfaces.triangles[triangle];
      const Vec3 middle =
          (surfaces.vertices[corners[0]] + surfaces.vertices[corners[1]] + surfaces.vertices[corners[2]]) * (1.0 / 3.0);
      for (std::size_t i = 0; i < kDirections; ++i) {
        RTCRayHit ray{};
        ray.ray.org_x = static_cast<float>(middle.x);
        ray.ray.org_y = static_cast<float>(middle.y);
        ray.ray.org_z = static_cast<float>(middle.z);
        ray.ray.dir_x = static_cast<float>(directions[i].x);
        ray.ray.dir_y = static_cast<float>(directions[i].y);
        ray.ray.dir_z = static_cast<float>(directions[i].z);
        ray.ray.tnear = 1e-5F;
        ray.ray.tfar = INFINITY;
        ray.ray.mask = 0xFFFFFFFFU;
        ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcIntersect1(scene, &context, &ray);
        hits[triangle * kDirections + i] = ray.hit.primID;
      }
    }
  };
  const std::size_t half = threads == 1 ? 0 : surfaces.triangles.size() / 2;
  std::jthread second(part, 0, half);
  part(half, surfaces.triangles.size());
  second.join();
  rtcReleaseScene(scene);
  rtcReleaseDevice(device);
  benchmark::DoNotOptimize(hits.data());
}

// the rays of `light` through a canopy of range(0) triangles, tree included, and in turn with it as many rays of a bare
// loop over the same triangles, as they stand in memory and in the order of space
void rays(benchmark::State& state, unsigned threads) {
  const auto surfaces = canopy(static_cast<int>(state.range(0)));
  const auto sorted = inOrderOfSpace(surfaces);
  double best = 1e30;
  double bare = 1e30;
  double bareSorted = 1e30;
  double count = 0.0;
  for (auto _ : state) {
    const double milliseconds = millisecondsOf([&] {
      const environment::LeafLight traced(surfaces, {}, {}, {.directions = kDirections, .threads = threads});
      count = static_cast<double>(traced.rayCount());
    });
    state.SetIterationTime(1e-3 * milliseconds);
    best = std::min(best, milliseconds);
    bare = std::min(bare, millisecondsOf([&] { castBareRays(surfaces, threads); }));
    bareSorted = std::min(bareSorted, millisecondsOf([&] { castBareRays(sorted, threads); }));
  }
  state.counters["rays/s"] = Counter(1e3 * count / best);
  state.counters["embree rays/s"] = Counter(1e3 * count / bare);
  state.counters["of embree"] = Counter(bare / best);
  state.counters["of embree sorted"] = Counter(bareSorted / best);
}

// a canopy of leaves, each a disc of ten triangles behind a query, in a cube with a leaf area index of 3
turtle::QueryBatch leavesBehindQueries(std::size_t count) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> place(0.0, 1.0);
  std::normal_distribution<double> component;
  const double radius = std::sqrt(3.0 / (3.14159 * static_cast<double>(count)));
  auto geometry = std::make_shared<turtle::Geometry>();
  turtle::QueryBatch queries;
  queries.parameterOffset.push_back(0);
  for (std::size_t leaf = 0; leaf < count; ++leaf) {
    const Vec3 u = core::normalised({component(random), component(random), component(random)});
    const Vec3 w = core::normalised({component(random), component(random), component(random)});
    const Vec3 v = core::normalised(w - u * core::dot(u, w));
    const Vec3 middle{place(random), place(random), place(random)};
    const auto base = static_cast<std::uint32_t>(geometry->vertices.size());
    geometry->vertices.push_back(middle);
    for (std::uint32_t k = 0; k < 10; ++k) {
      const double angle = 0.6283185307 * k;
      geometry->vertices.push_back(middle + u * (radius * std::cos(angle)) + v * (radius * std::sin(angle)));
      geometry->triangles.push_back({base, base + 1 + k, base + 1 + (k + 1) % 10});
    }
    geometry->vertexOffset.push_back(geometry->vertices.size());
    geometry->triangleOffset.push_back(geometry->triangles.size());
    geometry->kind.push_back(turtle::GeometryKind::Polygon);
    geometry->organs.plant.push_back(0);
    geometry->organs.module.push_back(2 * leaf + 1);
    geometry->organs.symbol.push_back(1);
    geometry->organs.colour.push_back(0);
    geometry->organs.branchOrder.push_back(0);
    queries.plant.push_back(0);
    queries.module.push_back(2 * leaf);
    queries.symbol.push_back(0);
    queries.isTransient.push_back(0);
    queries.position.push_back(middle);
    queries.parameters.insert(queries.parameters.end(), 4, 0.0);
    queries.parameterOffset.push_back(queries.parameters.size());
  }
  queries.geometry = std::move(geometry);
  return queries;
}

// the same with every thousandth leaf a little higher
turtle::QueryBatch withSomeHigher(const turtle::QueryBatch& queries) {
  auto moved = std::make_shared<turtle::Geometry>(*queries.geometry);
  for (std::size_t leaf = 0; leaf < moved->kind.size(); leaf += 1000) {
    for (std::uint64_t vertex = moved->vertexOffset[leaf]; vertex < moved->vertexOffset[leaf + 1]; ++vertex) {
      moved->vertices[vertex].y += 0.01;
    }
  }
  turtle::QueryBatch next = queries;
  next.geometry = std::move(moved);
  return next;
}

// one step of the process `light` by two threads with range(0) queries before leaves of ten triangles: two bounces,
// overcast sky, sun in one direction. Its parts are timed apart, beside a step in which nothing, or little, changed
void lightStep(benchmark::State& state) {
  const turtle::QueryBatch queries = leavesBehindQueries(static_cast<std::size_t>(state.range(0)));
  const turtle::QueryBatch moved = withSomeHigher(queries);
  const auto process = makeProcess("light", R"({"sun":"direction","threads":2})");
  turtle::ReplyBatch replies;
  const auto step = [&](const turtle::QueryBatch& batch) {
    replies.prepare(batch);
    if (const auto error = process->step(batch, replies)) {
      state.SkipWithError(error->message.c_str());
    }
  };
  for (auto _ : state) {
    state.PauseTiming();
    if (const auto error = process->open({})) {
      state.SkipWithError(error->message.c_str());
      return;
    }
    state.ResumeTiming();
    step(queries);
  }
  state.counters["unchanged ms"] = Counter(millisecondsOf([&] { step(queries); }));
  state.counters["1/1000 moved ms"] = Counter(millisecondsOf([&] { step(moved); }));
  environment::PlantSurfaces plants;
  state.counters["surfaces ms"] =
      Counter(millisecondsOf([&] { plants = environment::surfacesOf(*queries.geometry, 5); }));
  const environment::LightSurfaces& surfaces = plants.surfaces;
  const double tree = millisecondsOf(
      [&] { benchmark::DoNotOptimize(environment::RayCaster(surfaces.vertices, surfaces.triangles, {}, {}, 2).margin()); });
  state.counters["tree ms"] = Counter(tree);
  environment::LeafLight light({.threads = 2});
  const double traced = millisecondsOf([&] { light.setScene(surfaces, {}, {{{0, 1, 0}, {800.0}}}); });
  state.counters["rays ms"] = Counter(traced - tree);
  const std::vector<double> sky(light.directions().all().size(), 1.0);
  const std::vector<environment::LightMaterial> materials(256, environment::LightMaterial{0.08, 0.05});
  state.counters["bounces ms"] =
      Counter(millisecondsOf([&] { benchmark::DoNotOptimize(light.irradiances(0, sky, materials, {}, 2)); }));
  state.counters["rays"] = Counter(static_cast<double>(light.rayCount()));
  state.counters["queries/s"] = Counter(static_cast<double>(queries.size()), Counter::kIsIterationInvariantRate);
}

// sums over the rectangles of all layers of a field of range(0)³ voxels
void voxels(benchmark::State& state) {
  const std::int64_t side = state.range(0);
  environment::VoxelField field({{0, 0, 0}, {side, side, side}, 1.0, false}, environment::GridAxes{});
  field.values()[0] = 1.0;
  for (auto _ : state) {
    field.sumLayers();
    benchmark::DoNotOptimize(field.boxSum({side / 2, side / 2, side / 2}, 8));
  }
  // each pass reads a number and writes one
  const double bytes = static_cast<double>(side * side * side) * sizeof(double);
  state.counters["bytes/s"] = Counter(2.0 * bytes, Counter::kIsIterationInvariantRate);
  state.counters["copied bytes/s"] = Counter(copiedBytesPerSecond(static_cast<std::size_t>(bytes)));
}

// a step of `light-voxels` after one in which the leaves were the same but for ten neighbours, and beside it the same
// by a new process: range(0) leaves in a cube, that ask for light and gradient
void fewLeavesChange(benchmark::State& state) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> place(0.0, 100.0);
  turtle::QueryBatch queries;
  queries.parameterOffset.push_back(0);
  for (std::int64_t leaf = 0; leaf < state.range(0); ++leaf) {
    queries.plant.push_back(0);
    queries.module.push_back(static_cast<std::uint64_t>(leaf));
    queries.symbol.push_back(0);
    queries.isTransient.push_back(0);
    queries.position.push_back({place(random), place(random), place(random)});
    queries.parameters.insert(queries.parameters.end(), {20.0, 0.0, 0.0, 0.0});
    queries.parameterOffset.push_back(queries.parameters.size());
  }
  turtle::QueryBatch changed = queries;
  for (std::size_t leaf = 0; leaf < 10; ++leaf) {
    changed.position[leaf] = {50.0 + 0.1 * static_cast<double>(leaf), 90.0, 50.0};
    queries.position[leaf] = changed.position[leaf] - Vec3{0, 1, 0};
  }
  const auto process = makeProcess("light-voxels", R"({"gridSize":[50,50,50],"voxelSize":2,"position":[0,0,0]})");
  turtle::ReplyBatch replies;
  const auto stepOf = [&](const turtle::QueryBatch& batch) {
    replies.prepare(batch);
    return millisecondsOf([&] { static_cast<void>(process->step(batch, replies)); });
  };
  double kept = 1e30;
  double anew = 1e30;
  for (auto _ : state) {
    static_cast<void>(process->open({}));
    anew = std::min(anew, stepOf(queries));
    const double milliseconds = stepOf(changed);
    state.SetIterationTime(milliseconds * 1e-3);
    kept = std::min(kept, milliseconds);
  }
  state.counters["anew ms"] = Counter(anew);
  state.counters["gain"] = Counter(anew / kept);
}

const bool kIsRegistered = [] {
  for (const unsigned threads : {1U, 2U}) {
    // a million triangles take minutes: once
    for (const bool isLarge : {false, true}) {
      benchmark::RegisterBenchmark(("rays/light/" + std::to_string(threads)).c_str(),
                                   [threads](benchmark::State& state) { rays(state, threads); })
          ->Unit(benchmark::kMillisecond)
          ->UseManualTime()
          ->Iterations(isLarge ? 1 : 3)
          ->Arg(isLarge ? 1'000'000 : 100'000);
    }
  }
  benchmark::RegisterBenchmark("process/light", lightStep)
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime()
      ->RangeMultiplier(10)
      ->Range(100, 100'000);
  benchmark::RegisterBenchmark("bounce/light", bounce)->Unit(benchmark::kMillisecond)->UseRealTime()->Arg(100'000);
  benchmark::RegisterBenchmark("change/light-voxels", fewLeavesChange)
      ->Unit(benchmark::kMillisecond)
      ->UseManualTime()
      ->Arg(10'000)
      ->Arg(100'000);
  benchmark::RegisterBenchmark("voxels/light-voxels", voxels)->Unit(benchmark::kMillisecond)->UseRealTime()->Arg(256);
  return true;
}();

}  // namespace
}  // namespace espalier::benchmarking
