#include "server/stream/turtle_frame.h"

#include <gtest/gtest.h>

#include <random>

#include "protocol/json_writer.h"
#include "tests/server/frame_viewer.h"

namespace espalier::server::turtle_frame_test {
namespace {

const std::shared_ptr<const std::vector<std::string>> kSymbols =
    std::make_shared<const std::vector<std::string>>(std::vector<std::string>{"F", "E", "A"});

/// A record whose place tells it from others.
turtle::TurtleRecord recordAt(double place, std::uint64_t module, std::uint32_t parent) {
  turtle::TurtleRecord record;
  record.module = module;
  record.position = {place, 2.0 * place, -place};
  record.symbol = static_cast<std::uint16_t>(static_cast<int>(place) % 3);
  record.parent = parent;
  record.parameters.assign(static_cast<std::size_t>(place) % 3, place);
  return record;
}

std::vector<turtle::TurtleRecord> chain(std::size_t count) {
  std::vector<turtle::TurtleRecord> records;
  for (std::size_t i = 0; i < count; ++i) {
    records.push_back(
        recordAt(static_cast<double>(i), 2 * i, i == 0 ? turtle::kNoParent : static_cast<std::uint32_t>(i - 1)));
  }
  return records;
}

TurtleFrame frameOf(const std::vector<turtle::TurtleRecord>& records, const protocol::StreamSelection& select = {}) {
  return makeTurtleFrame(records, kSymbols, select);
}

/// The frame of a viewer that had `base` and is told the difference.
TurtleFrame applied(const TurtleFrame& base, const TurtleFrame& fresh, const TurtleDifference& difference,
                    std::size_t rows) {
  return viewedAfter(base, {rows, difference.kept, std::make_shared<const TurtleFrame>(fresh)});
}

TEST(TurtleFrame, ARowAtTheEndCostsOneRow) {
  const TurtleFrame base = frameOf(chain(1000));
  const TurtleFrame frame = frameOf(chain(1001));
  const TurtleDifference difference = differenceOf(base, frame);
  EXPECT_EQ(difference.fresh, std::vector<std::uint32_t>{1000});
  ASSERT_EQ(difference.kept.size(), 1U);
  EXPECT_EQ(difference.kept[0].rows, 1000U);
}

TEST(TurtleFrame, AnInsertionMovesModulesAndParentsOfWhatFollows) {
  auto records = chain(100);
  const TurtleFrame base = frameOf(records);
  records.insert(records.begin() + 40, {recordAt(1000, 80, 39), recordAt(1001, 82, 40)});
  for (std::size_t i = 42; i < records.size(); ++i) {
    records[i].module += 6;
    records[i].parent += i == 42 ? 0 : 2;
  }
  const TurtleFrame frame = frameOf(records);
  const TurtleDifference difference = differenceOf(base, frame);
  EXPECT_EQ(difference.fresh, (std::vector<std::uint32_t>{40, 41}));
  // before it, the row that grows from before it, and the rest
  ASSERT_EQ(difference.kept.size(), 3U);
  EXPECT_EQ(difference.kept[1].module, 6U);
  EXPECT_EQ(difference.kept[1].parent, 0U);
  EXPECT_EQ(difference.kept[2].parent, 2U);
  expectSameRows(applied(base, rowsOf(frame, difference.fresh), difference, frame.rows()), frame);
}

TEST(TurtleFrame, MinusZeroIsNotZero) {
  auto records = chain(3);
  const TurtleFrame base = frameOf(records);
  records[0].position.x = -0.0;
  EXPECT_EQ(differenceOf(base, frameOf(records)).fresh, std::vector<std::uint32_t>{0});
}

TEST(TurtleFrame, ManyRowsThatWereAddedOrTakenAwayAreFound) {
  auto records = chain(5000);
  const TurtleFrame base = frameOf(records);
  records.erase(records.begin() + 1000, records.begin() + 3000);
  std::vector<turtle::TurtleRecord> added;
  for (int i = 0; i < 900; ++i) {
    added.push_back(recordAt(10'000 + i, 7, turtle::kNoParent));
  }
  records.insert(records.begin() + 2000, added.begin(), added.end());
  const TurtleFrame frame = frameOf(records);
  const TurtleDifference difference = differenceOf(base, frame);
  EXPECT_EQ(difference.fresh.size(), 900U);
  expectSameRows(applied(base, rowsOf(frame, difference.fresh), difference, frame.rows()), frame);
}

TEST(TurtleFrame, AnyChangeIsToldCompletely) {
  std::mt19937 dice(7);
  const auto draw = [&dice](std::size_t bound) { return static_cast<std::size_t>(dice()) % bound; };
  for (int round = 0; round < 200; ++round) {
    auto records = chain(1 + draw(60));
    const protocol::StreamSelection select =
        round % 2 == 0 ? protocol::StreamSelection{} : protocol::StreamSelection{.symbols = {"F", "A"}, .plants = {}};
    const TurtleFrame base = frameOf(records, select);
    for (std::size_t change = draw(6); change > 0; --change) {
      const std::size_t at = draw(records.size());
      switch (draw(5)) {
        case 0:
          records.insert(records.begin() + static_cast<std::ptrdiff_t>(at),
                         recordAt(static_cast<double>(100 + draw(9)), draw(99), static_cast<std::uint32_t>(draw(50))));
          break;
        case 1:
          if (records.size() > 1) {
            records.erase(records.begin() + static_cast<std::ptrdiff_t>(at));
          }
          break;
        case 2:
          records[at].parent = draw(2) == 0 ? turtle::kNoParent : static_cast<std::uint32_t>(draw(50));
          break;
        case 3:
          records[at].parameters.push_back(static_cast<double>(draw(3)));
          break;
        default:
          std::swap(records[at], records[draw(records.size())]);
      }
    }
    const TurtleFrame frame = frameOf(records, select);
    const TurtleDifference difference = differenceOf(base, frame);
    expectSameRows(applied(base, rowsOf(frame, difference.fresh), difference, frame.rows()), frame);
  }
}

TEST(TurtleFrame, NumbersThatAreNotFiniteAreRefused) {
  auto records = chain(3);
  records[1].position.y = std::numeric_limits<double>::infinity();
  EXPECT_THROW((void)frameOf(records), protocol::NonFiniteNumber);
}

}  // namespace
}  // namespace espalier::server::turtle_frame_test
