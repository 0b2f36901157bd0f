#include "environment/geometry/box_note.h"

#include <gtest/gtest.h>

#include "tests/environment/query_builder.h"

namespace espalier::environment::box_note_test {
namespace {

using Notes = std::vector<std::string>;

Notes notesOf(const Bounds& box, QueryBuilder& queries) {
  turtle::ReplyBatch replies;
  replies.prepare(queries.batch());
  noteIfAllAreOutside("soil", box, "cm", queries.batch(), replies);
  return replies.notes;
}

Notes notesOfProcess(const std::string& type, const std::string& configuration, const core::Vec3& place) {
  auto made = makeProcess(type, configuration);
  EXPECT_EQ(errorsOf(made), "");
  EXPECT_FALSE(made.value()->open({}).has_value());
  QueryBuilder queries;
  queries.add(place, {0.1, 0.0});
  turtle::ReplyBatch replies;
  replies.prepare(queries.batch());
  EXPECT_FALSE(made.value()->step(queries.batch(), replies).has_value());
  return replies.notes;
}

TEST(BoxNote, IsWrittenWhenNoQueryLiesInTheBoxOrCloseToIt) {
  const Bounds box{{0.0, -10.0, 0.0}, {1.0, 0.0, 2.0}};
  EXPECT_EQ(
      notesOf(box, QueryBuilder().add({0.5, 5.0, 0.5}, {1.0}).add({0.5, -20.0, 0.5}, {1.0})),
      Notes{"environment 'soil': no query of the step lies in its box (x from 0 to 1, y from -10 to 0, z from 0 to "
            "2 cm), so all are answered as outside of it. Move or enlarge the box, or move the plants"});
  EXPECT_EQ(notesOf(box, QueryBuilder().add({0.5, 5.0, 0.5}, {1.0}).add({0.5, -2.0, 0.5}, {1.0})), Notes{});
  // a plant that begins on the ground
  EXPECT_EQ(notesOf(box, QueryBuilder().add({0.5, 0.5, 0.5}, {1.0})), Notes{});
  QueryBuilder none;
  EXPECT_EQ(notesOf(box, none), Notes{});
}

TEST(BoxNote, LeavesAxesOutAlongWhichTheBoxIsInfinite) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const Bounds box{{-kInfinity, 0.0, -kInfinity}, {kInfinity, 1.0, kInfinity}};
  EXPECT_EQ(notesOf(box, QueryBuilder().add({99.0, 1.0, -99.0}, {1.0})), Notes{});
  EXPECT_EQ(notesOf(box, QueryBuilder().add({99.0, 2.0, -99.0}, {1.0})).at(0).substr(0, 77),
            "environment 'soil': no query of the step lies in its box (y from 0 to 1 cm), ");
}

TEST(BoxNote, ProcessesWithABoxWriteIt) {
  for (const char* type : {"soil", "soil-water", "emission", "light-voxels", "clover", "ornament"}) {
    EXPECT_EQ(notesOfProcess(type, "{}", {-100.0, -100.0, -100.0}).size(), 1U) << type;
    EXPECT_EQ(notesOfProcess(type, "{}", {0.1, 0.1, 0.1}).size(), 0U) << type;
  }
  // a periodic box has no end to the sides
  EXPECT_EQ(notesOfProcess("light-voxels", R"({"periodic": true})", {-100.0, 0.1, -100.0}).size(), 0U);
  EXPECT_EQ(notesOfProcess("light-voxels", R"({"periodic": true})", {0.1, -100.0, 0.1}).size(), 1U);
}

}  // namespace
}  // namespace espalier::environment::box_note_test
