#include "engine/simulation/snapshot_check.h"

#include <limits>
#include <random>

#include "tests/engine/simulation/crafted_snapshot.h"
#include "tests/engine/simulation/simulation_fixture.h"

namespace espalier::simulation::snapshot_check_test {
namespace {

// variables, an array, a production-local variable, sub-L-systems and a query
const char* const kEverything =
    "Lsystem: 1\n"
    "derivation length: 9\n"
    "Define: { array a[3]; }\n"
    "Start: {n=100; m=1;}\n"
    "Axiom: J?(2)JJ$A(0)?E(0)\n"
    "J : {n=n+1;} * --> J(n)J\n"
    "A(x) > ?E(y) : {k=x+1;} * {a[1]=k;} --> A(k)\n"
    "endlsystem\n"
    "Lsystem: 2\n"
    "Start: {w=10;}\n"
    "EndEach: {w=w*2;}\n"
    "Axiom: X\n"
    "J : {w=w+1;} * --> J(w)J\n"
    "endlsystem\n";

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

using Change = std::function<void(SnapshotContent&)>;

struct Case {
  const char* name;
  Change change;
  const char* message;  // without what every refusal begins and ends with
};

const char* const kUnfit = "The snapshot does not fit its model: plant 1: ";
const char* const kUnfitEnd = ". Use an intact copy, or the Espalier that made it. The simulation stays at step 2.";
const char* const kDamaged = "The snapshot is damaged: ";
const char* const kDamagedEnd = ". Use an intact copy. The simulation stays at step 2.";

/// A snapshot after two steps of two plants, and a simulation that is to refuse whatever is made of it.
class CraftedSnapshot : public testing::Test {
 protected:
  CraftedSnapshot() : program_(compileText(kEverything)), run_(program_, 2) {
    expectSuccess(run_.simulation.rewind());
    expectSuccess(run_.simulation.step());
    expectSuccess(run_.simulation.step());
    snapshot_ = snapshotOf(run_.simulation);
  }

  void expectRefused(const Case& example, const std::string& begin, const std::string& end) {
    SCOPED_TRACE(example.name);
    const std::uint64_t hash = run_.simulation.stateHash();
    const auto error = run_.simulation.restore(crafted(snapshot_, example.change));
    ASSERT_TRUE(error.has_value());
    EXPECT_EQ(error->code, core::SimulationErrorCode::Snapshot);
    EXPECT_EQ(error->message, begin + example.message + end);
    EXPECT_EQ(run_.simulation.stateHash(), hash);
  }

  std::shared_ptr<const language::Program> program_;
  TestRun run_;
  std::string snapshot_;
};

TEST_F(CraftedSnapshot, ThatFitsRunsOn) {
  expectSuccess(run_.simulation.restore(crafted(snapshot_, [](SnapshotContent&) {})));
  expectSuccess(run_.simulation.step());
}

TEST_F(CraftedSnapshot, ThatDoesNotFitItsModelIsRefusedWithItsReason) {
  const Case cases[] = {
      {"fewer variables of the main L-system", [](auto& c) { c.plants[1].instances[0].variables.clear(); },
       "its set of variables 0 has 0 variables, and its L-system has 2"},
      {"no variables and no elements",
       [](auto& c) {
         c.plants[1].instances[0].variables.clear();
         c.plants[1].instances[0].elements.clear();
       },
       "its set of variables 0 has 0 variables, and its L-system has 2"},
      {"more elements", [](auto& c) { c.plants[1].instances[0].elements.resize(4); },
       "its set of variables 0 has 4 array elements, and its L-system has 3"},
      {"a main L-system that is not there", [](auto& c) { c.plants[1].instances[0].system = 7; },
       "its set of variables 0 is of L-system 7, and the model has 2"},
      {"another L-system as the main one", [](auto& c) { c.plants[1].instances[0] = c.plants[1].instances[1]; },
       "its set of variables 0 is not of the L-system that the string calls"},
      {"no variables of a call", [](auto& c) { c.plants[1].instances.pop_back(); },
       "its string calls 1 sub-L-system and the snapshot holds 1 set of variables, one of them the main L-system's"},
      {"variables of too many calls", [](auto& c) { c.plants[1].instances.push_back(c.plants[1].instances.back()); },
       "its string calls 1 sub-L-system and the snapshot holds 3 sets of variables, one of them the main L-system's"},
      {"no variables at all", [](auto& c) { c.plants[1].instances.clear(); },
       "its string calls 1 sub-L-system and the snapshot holds 0 sets of variables, one of them the main L-system's"},
      {"local variables", [](auto& c) { c.plants[1].statics.push_back(1.0); },
       "it has 2 production-local variables and the model has 1"},
      {"a type that is not there", [](auto& c) { c.plants[1].string.typeBuffer().span()[3] = 999; },
       "module 3 is of a type that the model does not have"},
      {"too few parameters",
       [](auto& c) { c.plants[1].string.parameterBuffer().resize(c.plants[1].string.parameterCount() - 1); },
       "its modules have 9 parameters and the snapshot holds 8"},
      {"a parameter that is NaN", [](auto& c) { c.plants[1].string.parameterBuffer().span()[0] = kNaN; },
       "a parameter is not a finite number"},
      {"too many steps", [](auto& c) { c.plants[1].step = 3; }, "it has made more steps than the simulation"},
      {"an open file", [](auto& c) { c.plants[1].files.open.emplace_back(); },
       "it has opened a file that the model does not name"},
      {"a kept file", [](auto& c) { c.plants[1].files.kept.emplace_back(); },
       "it keeps the content of a file that the model does not both write and read"},
      {"a dead plant with a string", [](auto& c) { c.members[1].deathStep = 2; },
       "it is dead and has a string or variables"},
  };
  for (const Case& example : cases) {
    expectRefused(example, kUnfit, kUnfitEnd);
  }
}

TEST_F(CraftedSnapshot, ThatIsWrongByItselfIsRefusedWithItsReason) {
  const Case cases[] = {
      {"a place", [](auto& c) { c.members[0].origin.placement.position.x = kNaN; }, "plant 0: its place is not finite"},
      {"a frame", [](auto& c) { c.members[0].origin.placement.frame.up.z = kInfinity; },
       "plant 0: its place is not finite"},
      {"a colour", [](auto& c) { c.members[0].origin.colourShift = std::numeric_limits<std::int32_t>::max(); },
       "plant 0: its colour shift is beyond 2000000"},
      {"a birth to come", [](auto& c) { c.members[1].birthStep = 3; },
       "plant 1: it is born after the last completed step"},
      {"a death to come", [](auto& c) { c.members[1].deathStep = 3; },
       "plant 1: it dies before its birth or after the last completed step"},
      {"steps", [](auto& c) { c.completedSteps = std::numeric_limits<std::uint64_t>::max(); },
       "no run has 18446744073709551615 steps"},
      {"spacing", [](auto& c) { c.seeds.spacing = -1.0; },
       "the rules for seeds are not finite, or their spacing is below 0"},
      {"iterations", [](auto& c) { c.coupling.iterations = 4'000'000'000; },
       "the coupling needs 1 to 10000 iterations and a tolerance of at least 0"},
      {"a colour block", [](auto& c) { c.palette.maps[2'000'000] = {}; },
       "a colour is not finite, or its block does not exist"},
      {"replies without marks",
       [](auto& c) {
         c.hasReplies = true;
         c.replies.values = {1.0, 2.0};
       },
       "there are 2 reply values and 0 marks of which are set"},
      {"a reply that is NaN",
       [](auto& c) {
         c.hasReplies = true;
         c.replies.values = {kNaN, kNaN};
         c.replies.isSet = {0, 1};
       },
       "reply value 1 is not a finite number"},
  };
  for (const Case& example : cases) {
    expectRefused(example, kDamaged, kDamagedEnd);
  }
}

TEST_F(CraftedSnapshot, WithAnyChangedByteIsRefusedOrRuns) {
  std::mt19937 random(1);
  int runs = 0;
  for (int round = 0; round < 3000; ++round) {
    std::string changed = snapshot_;
    changed[random() % (changed.size() - 8)] ^= static_cast<char>(1U << (random() % 8U));
    SimulationOptions options;
    options.limits.maximumModules = 1000;
    TestRun other(program_, 2, options);
    expectSuccess(other.simulation.rewind());
    if (!other.simulation.restore(withChecksum(changed))) {
      ++runs;
      static_cast<void>(other.simulation.step());
      static_cast<void>(other.simulation.scene());
      static_cast<void>(other.simulation.stateHash());
    }
  }
  // most bytes are of numbers that any value fits, or of texts
  EXPECT_GT(runs, 300);
}

TEST_F(CraftedSnapshot, WithAPlantTooFewOrTooManyIsRefused) {
  const char* const message = "sections are missing, or bytes follow the last one";
  expectRefused({"too few", [](auto& c) { c.plants.pop_back(); }, message}, kDamaged, kDamagedEnd);
  expectRefused({"too many", [](auto& c) { c.plants.push_back(c.plants.back()); }, message}, kDamaged, kDamagedEnd);
}

TEST_F(CraftedSnapshot, WithASectionTwiceIsRefused) {
  // magic and version, then the section of the model: tag, length, bytes
  std::uint64_t length = 0;
  for (int i = 7; i >= 0; --i) {
    length = (length << 8U) | static_cast<std::uint8_t>(snapshot_[16 + static_cast<std::size_t>(i)]);
  }
  const std::string model = snapshot_.substr(12, 12 + length);
  const auto error = run_.simulation.restore(withChecksum(snapshot_.substr(0, 12) + model + snapshot_.substr(12)));
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->message,
            "The snapshot is damaged: its section 1 is too short, comes twice or does not fit those before it. Use an "
            "intact copy. The simulation stays at step 2.");
}

// models that a server runs may write no files; a snapshot from elsewhere can hold one that is open for writing
TEST(RestoredFiles, AreNotWrittenWhereModelsMayNotWrite) {
  const auto program = compileText(
      "Lsystem: 1\n"
      "derivation length: 5\n"
      "Start: {f=fopen(\"out.txt\",\"w\");}\n"
      "StartEach: {fprintf(f,\"%g\",1);}\n"
      "Axiom: A\n"
      "A --> A\n"
      "endlsystem\n");
  struct Writer final : core::FileWriter {
    std::optional<std::string> write(const std::string&, bool, std::string_view) override { return std::nullopt; }
  };
  SimulationOptions options;
  options.fileWriter = std::make_shared<Writer>();
  TestRun run(program, 1, options, false);
  expectSuccess(run.simulation.rewind());
  expectSuccess(run.simulation.step());
  TestRun other(program, 1, {}, false);
  expectSuccess(other.simulation.restore(snapshotOf(run.simulation)));
  expectSuccess(other.simulation.step());
}

}  // namespace
}  // namespace espalier::simulation::snapshot_check_test
