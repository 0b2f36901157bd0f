#include "environment/plugin_process.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/turtle/scene/geometry.h"
#include "tests/environment/query_builder.h"

namespace espalier::environment::plugin_process_test {
namespace {

// answers p1: the length of all segments; p2: triangles of the organ behind the query, −1 without geometry
int measure(void*, const espalier_queries* queries, espalier_replies* replies, char*, size_t) {
  const espalier_geometry* geometry = queries->geometry;
  for (size_t query = 0; query < queries->count; ++query) {
    double* values = replies->values + queries->parameter_offset[query];
    uint8_t* set = replies->is_set + queries->parameter_offset[query];
    values[0] = 0.0;
    values[1] = -1.0;
    set[0] = set[1] = 1;
    for (size_t i = 0; geometry != nullptr && i < geometry->segments.count; ++i) {
      const double* a = geometry->start + 3 * i;
      const double* b = geometry->end + 3 * i;
      values[0] += std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
    }
    for (size_t i = 0; geometry != nullptr && i < geometry->organs.count; ++i) {
      if (geometry->organs.plant[i] == queries->plant[query] &&
          geometry->organs.module[i] == queries->module[query] + 1) {
        values[1] = static_cast<double>(geometry->triangle_offset[i + 1] - geometry->triangle_offset[i]);
      }
    }
  }
  return 0;
}

void* makeNothing(const char*, char*, size_t) {
  static int instance = 0;
  return &instance;
}

espalier_plugin surveyor(std::uint32_t needs) {
  espalier_plugin plugin{};
  plugin.version = ESPALIER_PLUGIN_VERSION;
  plugin.size = sizeof(espalier_plugin);
  plugin.name = "surveyor";
  plugin.summary = "Measures what plants draw.";
  plugin.needs = needs;
  plugin.create = makeNothing;
  plugin.destroy = [](void*) {};
  plugin.step = measure;
  return plugin;
}

turtle::QueryBatch batchWithGeometry() {
  QueryBuilder builder;
  builder.add({0, 0, 0}, {0, 0}).add({1, 0, 0}, {0, 0});
  auto geometry = std::make_shared<turtle::Geometry>();
  geometry->segments = {{0, 0}, {4, 5}, {1, 1}, {0, 0}, {0, 0}};
  geometry->start = {{0, 0, 0}, {0, 2, 0}};
  geometry->end = {{0, 2, 0}, {3, 6, 0}};
  geometry->startWidth = geometry->endWidth = {0.1, 0.1};
  // behind the second query: two triangles
  geometry->organs = {{0}, {2}, {1}, {7}, {0}};
  geometry->kind = {turtle::GeometryKind::Polygon};
  geometry->vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  geometry->triangles = {{0, 1, 2}, {0, 2, 3}};
  geometry->vertexOffset = {0, 4};
  geometry->triangleOffset = {0, 2};
  builder.batch().geometry = std::move(geometry);
  return builder.batch();
}

std::unique_ptr<turtle::EnvironmentProcess> made(const espalier_plugin& plugin) {
  auto process = makePluginProcess(plugin, nullptr, "");
  return std::move(process.value());
}

TEST(PluginProcess, SeesWhatAllPlantsDrawWhenItNeedsIt) {
  const espalier_plugin plugin = surveyor(ESPALIER_NEEDS_GEOMETRY);
  const auto process = made(plugin);
  EXPECT_TRUE(process->describe().needs.geometry);
  const ReplyTable table = answersOf(*process, batchWithGeometry());
  // 2, and √(3² + 4²)
  EXPECT_EQ(table[0][0], 7.0);
  EXPECT_EQ(table[0][1], -1.0);
  EXPECT_EQ(table[1][1], 2.0);
}

TEST(PluginProcess, SeesNoGeometryWhenItDoesNotAskForIt) {
  const espalier_plugin plugin = surveyor(ESPALIER_NEEDS_POSITION);
  const auto process = made(plugin);
  EXPECT_FALSE(process->describe().needs.geometry);
  EXPECT_EQ(answersOf(*process, batchWithGeometry())[0][0], 0.0);
}

TEST(PluginProcess, AnIncompleteTableIsRefused) {
  const auto problemOf = [](const espalier_plugin& plugin) {
    const auto process = makePluginProcess(plugin, nullptr, "");
    return process ? std::string() : process.error();
  };
  espalier_plugin plugin = surveyor(0);
  plugin.step = nullptr;
  EXPECT_EQ(problemOf(plugin), "its table lacks create, destroy and step");
  plugin = surveyor(0);
  plugin.name = "";
  EXPECT_EQ(problemOf(plugin), "its table lacks a name");
  plugin = surveyor(0);
  plugin.is_stateful = 1;
  EXPECT_EQ(problemOf(plugin), "its table lacks save and restore, which it needs because it has a state");
  // one without the other is not enough
  plugin.save = [](void*, void*, std::size_t) -> std::size_t { return 0; };
  EXPECT_EQ(problemOf(plugin), "its table lacks save and restore, which it needs because it has a state");
  plugin.save = nullptr;
  plugin.restore = [](void*, const void*, std::size_t, char*, std::size_t) { return 0; };
  EXPECT_EQ(problemOf(plugin), "its table lacks save and restore, which it needs because it has a state");
  plugin = surveyor(0);
  plugin.version = 9;
  EXPECT_NE(problemOf(plugin).find("it has version 9 of the plug-in interface"), std::string::npos);
}

}  // namespace
}  // namespace espalier::environment::plugin_process_test
