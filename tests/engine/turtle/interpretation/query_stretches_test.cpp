#include "engine/turtle/interpretation/query_stretches.h"

#include <bit>
#include <random>

#include "tests/engine/turtle/turtle_fixture.h"

namespace espalier::turtle::query_stretches_test {
namespace {

// everything that the passage of a turtle depends on, queries of both kinds, cuts, a bracket too many
const char* const kPart =
    "F(1)!(0.5)?E(1,2)[+(25)F(1)?E(3)@A(0.9)]/(137)?P(0,0,0)[-(31)[&(10)f(1)A(2)]F(0.5)?E(7)~s(1)]F(0)F(0)F(0)%F(2)]"
    ";(3)F(0)F(0)F(0)F(0)[^(20)@X+(4)?H(0,0,0)F(1)@X]@A(1.1)F+F-F?E(4)F(0)F(0)";

std::string repeated(const std::string& text, int times) {
  std::string result;
  for (int i = 0; i < times; ++i) {
    result += text;
  }
  return result;
}

/// The passes over a string that changes, by one that takes over and by one that interprets the whole.
class TwoPasses {
 public:
  explicit TwoPasses(const std::string& text)
      : run_(text), derivation_(run_.program, derivation::DerivationOptions{}), interpreter_(run_.program) {}

  [[nodiscard]] derivation::ModuleString& string() { return run_.state.string; }
  [[nodiscard]] const language::Program& program() const { return run_.program; }
  [[nodiscard]] const std::vector<ParameterChange>& changes() const { return run_.changes; }
  [[nodiscard]] const QueryBatch& queries() const { return run_.queries; }
  [[nodiscard]] const QueryStretches& known() const { return known_; }

  /// Interprets the string, in which everything but `kept` has changed since the call before.
  void takeOver(const derivation::StepChanges& kept) {
    run_.queries.clear();
    run_.offsets.clear();
    run_.changes.clear();
    InterpretationOutput output;
    output.queries = &run_.queries;
    output.needs = kAllButGeometry;
    output.queryParameterOffsets = &run_.offsets;
    output.changes = &run_.changes;
    ASSERT_TRUE(interpreter_.mayTakeOver());
    interpreter_.takeOver(derivation_, run_.state, 0, {}, output, kept, known_);
  }

  void expectSameAsWhole() {
    const QueryBatch taken = run_.queries;
    const std::vector<std::uint64_t> offsets = run_.offsets;
    const std::vector<double> parameters(string().parameters().begin(), string().parameters().end());
    run_.pass(kAllButGeometry);
    ASSERT_EQ(taken.module, run_.queries.module);
    EXPECT_EQ(taken.symbol, run_.queries.symbol);
    EXPECT_TRUE(taken.position == run_.queries.position);
    EXPECT_TRUE(taken.heading == run_.queries.heading);
    EXPECT_TRUE(taken.left == run_.queries.left);
    EXPECT_TRUE(taken.up == run_.queries.up);
    EXPECT_EQ(taken.width, run_.queries.width);
    EXPECT_EQ(taken.scale, run_.queries.scale);
    EXPECT_EQ(taken.parameterOffset, run_.queries.parameterOffset);
    EXPECT_EQ(taken.parameters, run_.queries.parameters);
    EXPECT_EQ(taken.following, run_.queries.following);
    EXPECT_EQ(taken.followingPair, run_.queries.followingPair);
    EXPECT_EQ(taken.followingOffset, run_.queries.followingOffset);
    EXPECT_EQ(taken.followingParameters, run_.queries.followingParameters);
    EXPECT_EQ(offsets, run_.offsets);
    EXPECT_TRUE(std::equal(parameters.begin(), parameters.end(), string().parameters().begin()));
  }

 private:
  TurtleRun run_;
  derivation::Derivation derivation_;
  Interpreter interpreter_;
  QueryStretches known_;
};

/// Deletes, doubles and changes a few modules; tells what it kept.
derivation::StepChanges change(std::mt19937& dice, const language::Program& program, derivation::ModuleString& string) {
  derivation::StepChanges changes;
  derivation::ModuleString result;
  std::uint64_t offset = 0;
  std::uint64_t kept = 0;
  for (std::uint64_t i = 0; i < string.size(); ++i) {
    const core::ModuleTypeId type = string.types()[i];
    const auto span = string.parameters().subspan(offset, program.arity[type]);
    std::vector<double> values(span.begin(), span.end());
    offset += values.size();
    if (dice() % 400 != 0) {
      result.append(type, values);
      ++kept;
      continue;
    }
    if (kept > 0) {
      changes.keep(i - kept, result.size() - kept, kept);
      kept = 0;
    }
    const std::size_t kind = dice() % 3;
    if (kind == 0 && !values.empty()) {
      values[0] += 0.125;
    }
    for (std::size_t copies = kind; copies != 1; copies = copies == 0 ? 1 : copies - 1) {
      result.append(type, values);
    }
  }
  if (kept > 0) {
    changes.keep(string.size() - kept, result.size() - kept, kept);
  }
  string = std::move(result);
  return changes;
}

TEST(QueryStretches, GiveWhatAWholePassGivesWhateverChanged) {
  std::size_t queries = 0;
  for (unsigned round = 0; round < 12; ++round) {
    std::mt19937 dice(round);
    TwoPasses passes(repeated(kPart, 60));
    passes.takeOver({});
    passes.expectSameAsWhole();
    for (int i = 0; i < 12; ++i) {
      // modules that the turtle wrote into have changed too
      std::vector<std::uint64_t> written;
      for (const ParameterChange& it : passes.changes()) {
        written.push_back(it.module);
      }
      const auto answered = derivation::StepChanges::ofParameters(written, passes.string().size());
      passes.takeOver(answered.then(change(dice, passes.program(), passes.string())));
      passes.expectSameAsWhole();
      ASSERT_FALSE(testing::Test::HasFailure()) << "round " << round << ", change " << i;
      queries += passes.queries().size();
    }
  }
  EXPECT_GT(queries, 10'000U);
}

TEST(QueryStretches, AreNotInterpretedAgain) {
  // a stretch that is walked through fills its ?P again
  TwoPasses passes(repeated("F(1)?P(0,0,0)", 1000) + "?E(1)");
  passes.takeOver({});
  EXPECT_EQ(passes.changes().size(), 3000U);
  passes.takeOver(derivation::StepChanges::nothing(passes.string().size()));
  EXPECT_EQ(passes.changes().size(), 0U);
  passes.expectSameAsWhole();
  // one module of 3001 is new
  const std::vector<std::uint64_t> changed{1500};
  passes.takeOver(derivation::StepChanges::ofParameters(changed, passes.string().size()));
  EXPECT_GT(passes.changes().size(), 0U);
  EXPECT_LT(passes.changes().size(), 600U);
  passes.expectSameAsWhole();
}

TEST(QueryStretches, AreNewBehindABranchThatBeganOtherwise) {
  // the branch itself is the same, and hides the width that comes back behind it
  const std::string text = "!(2)F(0)[!(1)" + repeated("F(0)", 700) + "]?E(1)" + repeated("F(0)", 700) + "?E(2)";
  TwoPasses passes(text);
  passes.takeOver({});
  passes.string().setParameter(0, 3.0);
  const std::vector<std::uint64_t> changed{0};
  passes.takeOver(derivation::StepChanges::ofParameters(changed, passes.string().size()));
  EXPECT_EQ(passes.queries().width, (std::vector<double>{3.0, 3.0}));
  passes.expectSameAsWhole();
}

TEST(QueryStretches, AreNewBehindModulesThatHaveGone) {
  // pieces of every length: of some, what was kept comes directly behind what was kept
  for (std::uint64_t gone = 1; gone < 600; ++gone) {
    TwoPasses passes(repeated("F(1)", 1200) + "?E(1)");
    passes.takeOver({});
    derivation::ModuleString& string = passes.string();
    derivation::ModuleString shorter;
    shorter.appendAll(string.types().subspan(gone), string.parameters().subspan(gone));
    derivation::StepChanges changes;
    changes.keep(0, 0, 256);
    changes.keep(256 + gone, 256, string.size() - gone - 256);
    string = std::move(shorter);
    passes.takeOver(changes);
    passes.expectSameAsWhole();
    ASSERT_FALSE(testing::Test::HasFailure()) << gone;
  }
}

TEST(QueryStretches, DoNotEndBetweenTheSymbolsOfOneCommand) {
  // `@` and `D` alone are no command; then the third symbol comes and scales, at the end of stretches of every length
  for (int before = 240; before < 270; ++before) {
    const std::string text = repeated("F(1)", before) + "@D";
    TwoPasses passes(text + repeated("F(1)", 600) + "?E(1)i(4)");
    passes.takeOver({});
    derivation::ModuleString& string = passes.string();
    const std::uint64_t place = static_cast<std::uint64_t>(before) + 2;
    derivation::ModuleString longer;
    longer.appendAll(string.types().first(place), string.parameters().first(place - 2));
    longer.append(string.types()[string.size() - 1], string.parameters().last(1));
    longer.appendAll(string.types().subspan(place), string.parameters().subspan(place - 2));
    derivation::StepChanges changes;
    changes.keep(0, 0, place);
    changes.keep(place, place + 1, string.size() - place);
    string = std::move(longer);
    passes.takeOver(changes);
    passes.expectSameAsWhole();
    ASSERT_FALSE(testing::Test::HasFailure()) << before;
  }
}

TEST(QueryStretches, TakeBoundedMemory) {
  for (const std::string& text : {repeated("[", 300) + repeated("]", 300), repeated("?E(1)", 300)}) {
    TwoPasses passes(repeated(text, 20));
    passes.takeOver({});
    EXPECT_FALSE(passes.known().isWhole());
    EXPECT_LE(passes.known().bytes(), 32 * passes.string().size());
    passes.takeOver(derivation::StepChanges::nothing(passes.string().size()));
    passes.expectSameAsWhole();
  }
  TwoPasses passes(repeated(kPart, 60));
  passes.takeOver({});
  EXPECT_TRUE(passes.known().isWhole());
  EXPECT_GT(passes.known().bytes(), 0U);
}

TEST(QueryStretches, AreForgottenWhenAPassFails) {
  TwoPasses passes(repeated("F(1)?E(1)", 1000));
  passes.takeOver({});
  const double before = passes.string().parameters()[0];
  passes.string().setParameter(0, std::numeric_limits<double>::infinity());
  const std::vector<std::uint64_t> changed{0};
  const auto changes = derivation::StepChanges::ofParameters(changed, passes.string().size());
  EXPECT_THROW(passes.takeOver(changes), core::SimulationFailure);
  passes.string().setParameter(0, before);
  passes.takeOver(changes);
  passes.expectSameAsWhole();
}

}  // namespace
}  // namespace espalier::turtle::query_stretches_test
