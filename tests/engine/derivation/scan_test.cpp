// The scan against an independent specification: the plain derivation of tests/support, on models made at random.
#include <gtest/gtest.h>

#include <random>
#include <string>

#include "engine/derivation/string_text.h"
#include "tests/support/derived_model.h"
#include "tests/support/plain_derivation.h"

namespace espalier {
namespace {

using test::DerivedModel;
using test::PlainDerivation;
using test::PlainModule;
using test::PlainString;

/// Makes models of pure productions: letters A to E with up to two parameters, brackets, contexts, conditions, weights.
class ModelMaker {
 public:
  explicit ModelMaker(unsigned seed) : random_(seed) {}

  std::string model() {
    std::string text = "Lsystem: 1\nderivation length: 50\n";
    isStochastic_ = chance(40);
    hasContexts_ = chance(60);
    if (isStochastic_) {
      text += "Seed: " + std::to_string(number(1, 60000)) + "\n";
    }
    if (hasContexts_ && chance(30)) {
      text += chance(50) ? "ignore: +E\n" : "consider: ABC[]\n";
    } else if (hasContexts_ && chance(20)) {
      text += "ignore: []+\n";
    }
    text += "Axiom: " + modules(number(8, 16), "", 2) + "\n";
    const int count = number(2, 9);
    for (int i = 0; i < count; ++i) {
      text += production();
    }
    return text + "endlsystem\n";
  }

 private:
  int number(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }
  bool chance(int percent) { return number(1, 100) <= percent; }
  std::string oneOf(const std::string& set) {
    return set.substr(static_cast<std::size_t>(number(0, static_cast<int>(set.size()) - 1)), 1);
  }

  /// A letter always has the same choice of arities: A and B none or one, C one, D none or two, others none.
  int arityOf(char letter) {
    switch (letter) {
      case 'A':
      case 'B':
        return chance(70) ? 1 : 0;
      case 'C':
        return 1;
      case 'D':
        return chance(50) ? 2 : 0;
      default:
        return 0;
    }
  }

  std::string formal(std::string& names) {
    static const std::string kLetters = "abcdefghij";
    const std::string letter = oneOf("AABBCDE+");
    const int arity = arityOf(letter[0]);
    std::string text = letter;
    for (int i = 0; i < arity; ++i) {
      const std::string name(1, kLetters.at(names.size()));
      text += (i == 0 ? "(" : ",") + name;
      names += name;
    }
    return arity > 0 ? text + ")" : text;
  }

  std::string expression(const std::string& names) {
    static const std::string kConstants[] = {"0.5", "2", "1", "0.25", "3"};
    const std::string constant = kConstants[number(0, 4)];
    if (names.empty() || chance(15)) {
      return constant;
    }
    // the last names are those of the right context
    const std::string x = chance(50) ? oneOf(names) : names.substr(names.size() - 1);
    switch (number(0, 7)) {
      case 0:
        return x;
      case 1:
        return x + "+" + constant;
      case 2:
        return x + "*0.5";
      case 3:
        return constant + "-" + x;
      case 4:
        return x + "/3";
      case 5:
        return "(" + x + "+" + oneOf(names) + ")/2";
      case 6:
        return x + "-" + oneOf(names);
      default:
        return x + "*0.9+Q";
    }
  }

  std::string condition(const std::string& names) {
    if (names.empty()) {
      return chance(50) ? "Q<3" : "*";
    }
    static const std::string kOperators[] = {"<", ">", "<=", ">=", "!=", "=="};
    std::string text = oneOf(names) + kOperators[number(0, 5)] + expression(names);
    if (chance(30)) {
      text += (chance(50) ? " && " : " || ") + oneOf(names) + "<2";
    }
    return text;
  }

  std::string modules(int count, const std::string& names, int depth) {
    std::string text;
    for (int i = 0; i < count; ++i) {
      if (depth > 0 && chance(15)) {
        text += "[" + modules(number(1, 3), names, depth - 1) + "]";
        continue;
      }
      if (chance(2)) {
        text += "%";
        continue;
      }
      const std::string letter = oneOf("AABBCDE+F");
      text += letter;
      const int arity = arityOf(letter[0]);
      for (int k = 0; k < arity; ++k) {
        text += (k == 0 ? "(" : ",") + expression(names);
      }
      text += arity > 0 ? ")" : "";
    }
    return text;
  }

  std::string rightContext(std::string& names) {
    switch (number(0, 5)) {
      case 0:
        return "[" + formal(names);
      case 1:
        return "[" + formal(names) + "=]" + formal(names);
      case 2:
        return formal(names) + "]";
      case 3:
        return formal(names) + formal(names);
      default:
        return formal(names);
    }
  }

  std::string production() {
    std::string names;
    std::string left;
    if (hasContexts_ && chance(40)) {
      left = formal(names) + (chance(25) ? formal(names) : "") + " < ";
    }
    std::string predecessor = formal(names);
    if (chance(15)) {
      predecessor += formal(names);
    }
    std::string right;
    if (hasContexts_ && chance(40)) {
      right = " > " + rightContext(names);
    }
    std::string text = left + predecessor + right;
    if (chance(40)) {
      text += " : " + condition(names);
    }
    // branches and what follows them are what contexts look over
    if (chance(5)) {
      text += " --> *";
    } else {
      text += " --> " + modules(number(1, 4), names, 1);
      text += chance(60) ? "[" + modules(2, names, 0) + "]" + modules(1, names, 0) : std::string();
    }
    if (isStochastic_ && chance(70)) {
      text += " : " + (chance(20) && !names.empty() ? oneOf(names) + "*" + oneOf(names) : std::to_string(number(0, 4)));
    }
    return text + "\n";
  }

  std::mt19937 random_;
  bool isStochastic_ = false;
  bool hasContexts_ = false;
};

PlainString plainOf(const language::Program& program, const derivation::ModuleString& string) {
  PlainString plain;
  std::size_t offset = 0;
  for (const core::ModuleTypeId type : string.types()) {
    const std::span<const double> parameters = string.parameters().subspan(offset, program.arity[type]);
    plain.push_back(PlainModule{type, {parameters.begin(), parameters.end()}});
    offset += parameters.size();
  }
  return plain;
}

TEST(Scan, AgreesWithThePlainDerivationOnRandomModels) {
  constexpr unsigned kModels = 2000;
  constexpr std::size_t kMaximumModules = 5000;
  std::size_t stepCount = 0;
  std::size_t changedCount = 0;
  for (unsigned seed = 0; seed < kModels; ++seed) {
    const std::string text = ModelMaker(seed).model();
    SCOPED_TRACE("model " + std::to_string(seed) + ":\n" + text);
    derivation::DerivationOptions options;
    options.seed = seed;
    options.hasSeed = true;
    DerivedModel model(text, options);
    const PlainDerivation plain(model.program(), seed);
    PlainString expected = plain.axiom();
    ASSERT_TRUE(plainOf(model.program(), model.state().string) == expected);
    for (std::uint64_t step = 1; step <= 8 && expected.size() < kMaximumModules; ++step) {
      const PlainString before = expected;
      expected = plain.derive(before, step);
      model.steps(1);
      ++stepCount;
      changedCount += before == expected ? 0U : 1U;
      ASSERT_TRUE(plainOf(model.program(), model.state().string) == expected)
          << "step " << step << " from " << before.size() << " modules made " << model.text().substr(0, 400);
    }
  }
  // the models must be worth comparing
  EXPECT_GT(stepCount, 10000U);
  EXPECT_GT(changedCount, 4000U);
}

TEST(Scan, LongSuccessorsAreWrittenWhole) {
  std::string successor;
  for (int i = 0; i < 40; ++i) {
    successor += "abcdefghij";
  }
  EXPECT_EQ(test::derive(test::modelText("", "xAx", "A --> " + successor + "\n"), 1), "x" + successor + "x");
}

TEST(Scan, CopiesManyParametersAndFewAlike) {
  // the last module's parameters end where the string's do
  EXPECT_EQ(test::derive(test::modelText("", "p(1)q(1,2,3,4,5,6,7,8,9)r(1,2,3,4)s(5)", "A --> A\n"), 2),
            "p(1)q(1,2,3,4,5,6,7,8,9)r(1,2,3,4)s(5)");
}

TEST(Scan, GrowsOverManyChunks) {
  DerivedModel model(test::modelText("", "A(1)", "A(x) --> A(x)B(x)A(x)[c]\n"));
  model.steps(14);
  // a(k+1) = 2 a(k) modules A; b and the brackets add 4 for every A rewritten
  EXPECT_EQ(model.state().string.size(), (1U << 14U) + 4U * ((1U << 14U) - 1U));
  EXPECT_EQ(model.state().string.parameterCount(), (1U << 14U) + (1U << 14U) - 1U);
}

}  // namespace
}  // namespace espalier
