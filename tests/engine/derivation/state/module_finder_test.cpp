#include "engine/derivation/state/module_finder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace espalier::module_finder_test {
namespace {

using derivation::ModuleFinder;

constexpr std::uint8_t kAll = 0xFF;

struct Found {
  std::vector<std::uint32_t> modules;
  std::vector<std::uint32_t> offsets;
  std::vector<std::uint8_t> bits;
  std::uint32_t parameters = 0;
  bool operator==(const Found&) const = default;
};

/// The result that the header promises, module by module.
Found expected(const std::vector<core::ModuleTypeId>& types, std::size_t first, std::size_t count, bool hasBefore,
               bool hasBehind, const std::vector<std::uint16_t>& arity, const ModuleFinder::Marks& marks) {
  Found found;
  for (std::size_t i = first; i < first + count; ++i) {
    std::uint8_t bits = marks.own[types[i]];
    if (!marks.before.empty()) {
      bits &= i > first || hasBefore ? marks.before[types[i - 1]] : kAll;
      bits &= i + 1 < first + count || hasBehind ? marks.behind[types[i + 1]] : kAll;
    }
    if (bits != 0) {
      found.modules.push_back(static_cast<std::uint32_t>(i - first));
      found.offsets.push_back(found.parameters);
      found.bits.push_back(bits);
    }
    found.parameters += arity[types[i]];
  }
  return found;
}

template <typename Find>
Found run(Find find) {
  Found found;
  found.modules.resize(1000 + ModuleFinder::kSlack);
  found.offsets.resize(1000 + ModuleFinder::kSlack);
  found.bits.resize(1000 + ModuleFinder::kSlack);
  const ModuleFinder::Count count =
      find(ModuleFinder::Target{found.modules.data(), found.offsets.data(), found.bits.data()});
  found.modules.resize(count.found);
  found.offsets.resize(count.found);
  found.bits.resize(count.found);
  found.parameters = count.parameters;
  return found;
}

TEST(ModuleFinder, FindsTheSameWithAndWithoutVectorInstructionsAndModuleByModule) {
  std::mt19937 random(7);
  const auto below = [&random](std::uint32_t bound) { return static_cast<std::uint32_t>(random() % bound); };
  for (int round = 0; round < 3000; ++round) {
    // one, two and four registers a table, and more types or parameters than the vectors take
    const std::size_t typeCount = std::vector<std::size_t>{3, 16, 17, 32, 50, 64, 65, 300}[below(8)];
    const std::uint32_t largestArity = below(8) == 0 ? 40 : 15;
    std::vector<std::uint16_t> arity(typeCount);
    std::generate(arity.begin(), arity.end(), [&] { return static_cast<std::uint16_t>(below(largestArity + 1)); });
    // from hardly any module to all of them
    const std::uint32_t share = 1 + below(8);
    const auto makeMarks = [&](std::uint32_t chance) {
      std::vector<std::uint8_t> marks(typeCount);
      std::generate(marks.begin(), marks.end(),
                    [&] { return static_cast<std::uint8_t>(below(8) < chance ? 1 + below(255) : 0); });
      return marks;
    };
    ModuleFinder::Marks marks{makeMarks(share), {}, {}};
    if (below(2) == 0) {
      marks.before = makeMarks(6);
      marks.behind = makeMarks(6);
    }
    std::vector<core::ModuleTypeId> types(1 + below(200));
    std::generate(types.begin(), types.end(),
                  [&] { return static_cast<core::ModuleTypeId>(below(static_cast<std::uint32_t>(typeCount))); });
    const std::size_t first = below(2) == 0 ? 0 : below(static_cast<std::uint32_t>(types.size()));
    const std::size_t count = below(static_cast<std::uint32_t>(types.size() - first + 1));
    const bool hasBefore = first > 0;
    const bool hasBehind = first + count < types.size();

    const ModuleFinder finder(arity, marks);
    const Found wanted = expected(types, first, count, hasBefore, hasBehind, arity, marks);
    EXPECT_EQ(run([&](const ModuleFinder::Target& target) {
                return finder.find(types.data() + first, static_cast<std::uint32_t>(count), hasBefore, hasBehind,
                                   target);
              }),
              wanted)
        << "round " << round;
    EXPECT_EQ(run([&](const ModuleFinder::Target& target) {
                return finder.findSlowly(types.data() + first, static_cast<std::uint32_t>(count), hasBefore, hasBehind,
                                         target);
              }),
              wanted)
        << "round " << round;
  }
}

TEST(ModuleFinder, CountsParametersBeforeWhatItFinds) {
  // types 0, 1, 2 with 1, 2 and 0 parameters; type 2 is looked for
  const std::vector<std::uint16_t> arity{1, 2, 0};
  const ModuleFinder finder(arity, {{0, 0, 4}, {}, {}});
  const std::vector<core::ModuleTypeId> types{0, 2, 1, 1, 2, 0};
  const Found found = run([&](const ModuleFinder::Target& target) {
    return finder.find(types.data(), static_cast<std::uint32_t>(types.size()), false, false, target);
  });
  EXPECT_EQ(found, (Found{{1, 4}, {1, 5}, {4, 4}, 6}));
}

TEST(ModuleFinder, NeighboursMustAgreeAndWhatIsMissingAgreesWithAll) {
  const std::vector<std::uint16_t> arity{0, 0};
  const ModuleFinder finder(arity, {{3, 0}, {1, 2}, {1, 3}});
  const std::vector<core::ModuleTypeId> types{0, 1, 0, 0};
  const Found found = run([&](const ModuleFinder::Target& target) {
    return finder.find(types.data(), static_cast<std::uint32_t>(types.size()), false, false, target);
  });
  // 0 at the start: all & 3; 0 behind 1 and before 0: 2 & 1; 0 behind 0 at the end: 1
  EXPECT_EQ(found, (Found{{0, 3}, {0, 0}, {3, 1}, 0}));
}

}  // namespace
}  // namespace espalier::module_finder_test
