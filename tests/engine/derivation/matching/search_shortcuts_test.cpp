#include "engine/derivation/matching/search_shortcuts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "engine/derivation/matching/context_matcher.h"
#include "engine/derivation/matching/produced_pieces.h"
#include "tests/support/derived_model.h"

namespace espalier::search_shortcuts_test {
namespace {

using core::ModuleTypeId;
using derivation::ContextRules;
using derivation::ModuleString;
using language::ContextElement;
using language::Production;
using language::Program;

/// The values that a context binds, nearest module first; nothing where it does not match.
using Bound = std::optional<std::vector<double>>;

/// The modules of a string with one parameter each, whose brackets may lack partners.
struct Module {
  ModuleTypeId type = core::kNoModuleType;
  double value = 0.0;  // unless a bracket
};

/// Finds contexts one module after the other, without links between brackets and without memory.
class PlainSearch {
 public:
  PlainSearch(const Program& program, const ContextRules& rules, const std::vector<Module>& modules)
      : program_(program), rules_(rules), modules_(modules) {}

  [[nodiscard]] Bound left(std::span<const ContextElement> context, std::size_t module) const {
    std::vector<double> values;
    for (const ContextElement& element : context) {
      std::size_t steps = 0;
      while (true) {
        if (module == 0 && rules_.isRing()) {
          module = modules_.size();
        }
        if (module == 0 || ++steps > modules_.size() * 2) {
          return {};
        }
        --module;
        const ModuleTypeId type = modules_[module].type;
        if (type == program_.closeBranch) {
          for (int depth = 1; depth > 0;) {
            if (module == 0) {
              return {};
            }
            --module;
            depth += modules_[module].type == program_.closeBranch ? 1 : 0;
            depth -= modules_[module].type == program_.openBranch ? 1 : 0;
          }
        } else if (type != program_.openBranch && !rules_.isIgnored(type)) {
          if (type != element.module.type) {
            return {};
          }
          values.push_back(modules_[module].value);
          break;
        }
      }
    }
    return values;
  }

  [[nodiscard]] Bound right(std::span<const ContextElement> context, std::size_t module) const {
    std::vector<double> values;
    for (const ContextElement& element : context) {
      const bool isBranchEnd = element.kind == ContextElement::Kind::SkipToBranchEnd;
      const bool isOpen = element.kind == ContextElement::Kind::OpenBranch;
      for (std::size_t steps = 0;; ++steps) {
        if (module >= modules_.size() && rules_.isRing()) {
          module = 0;
        }
        if (module >= modules_.size() || steps > modules_.size() * 2) {
          return {};
        }
        const ModuleTypeId type = modules_[module].type;
        if (isBranchEnd && type == program_.closeBranch) {
          break;
        }
        if (type == program_.openBranch && (isBranchEnd || (!isOpen && !rules_.isIgnored(type)))) {
          int depth = 1;
          for (++module; depth > 0; ++module) {
            if (module == modules_.size()) {
              return {};
            }
            depth += modules_[module].type == program_.openBranch ? 1 : 0;
            depth -= modules_[module].type == program_.closeBranch ? 1 : 0;
          }
        } else if (isBranchEnd || rules_.isIgnored(type)) {
          ++module;
        } else {
          if (type != element.module.type) {
            return {};
          }
          if (program_.arity[type] > 0) {
            values.push_back(modules_[module].value);
          }
          ++module;
          break;
        }
      }
    }
    return values;
  }

 private:
  const Program& program_;
  const ContextRules& rules_;
  const std::vector<Module>& modules_;
};

/// The values of a context in a frame.
std::vector<double> bound(const Program& program, std::span<const ContextElement> context,
                          const std::vector<double>& frame) {
  std::vector<double> values;
  for (const ContextElement& element : context) {
    if (element.kind == ContextElement::Kind::Module && program.arity[element.module.type] > 0) {
      values.push_back(frame[element.module.firstSlot]);
    }
  }
  return values;
}

/// A model whose productions have the contexts of these tests.
test::DerivedModel contexts(const std::string& items, const std::string& productions) {
  return test::DerivedModel(test::modelText(items, "A(1)B(1)C(1)i(1)[]", productions));
}

constexpr const char* kContexts =
    "A(p) < B(x) > A(q) --> C(p)\nA(p)C(q) < B(x) > C(r)A(s) --> C(p)\nB(p)B(q) < B(x) > [A(r)]C(s) --> C(p)\n"
    "C(p)A(q)A(r) < B(x) > [A(s)=]C(t) --> C(p)\nC(p) < B(x) > [[A(q)]=]A(r) --> C(p)\n"
    "i(p) < B(x) > =]A(q) --> C(p)\ni(p)A(q) < B(x) > A(r)=]A(s) --> C(p)\n";

/// A string of mostly ignored modules, so that searches are long. Each module has its place as value.
std::vector<Module> longRows(const Program& program, std::size_t size, int branches, std::mt19937& random) {
  const auto typeOf = [&](const std::string& symbol) { return program.findType(symbol, 1); };
  std::vector<Module> modules;
  for (std::size_t i = 0; i < size; ++i) {
    const auto number = static_cast<unsigned>(random() % 1000);
    const auto branch = static_cast<unsigned>(branches);
    const ModuleTypeId type = number < branch            ? program.openBranch
                              : number < 2 * branch      ? program.closeBranch
                              : number < 2 * branch + 8  ? typeOf("A")
                              : number < 2 * branch + 12 ? typeOf("C")
                              : number < 2 * branch + 40 ? typeOf("B")
                                                         : typeOf("i");
    modules.push_back({type, static_cast<double>(i)});
  }
  return modules;
}

ModuleString stringOf(const Program& program, std::span<const Module> modules) {
  ModuleString string;
  for (const Module& module : modules) {
    string.append(module.type, {&module.value, program.arity[module.type]});
  }
  return string;
}

TEST(SearchShortcuts, LongSearchesFindWhatSearchesModuleByModuleFind) {
  std::mt19937 random(1);
  std::size_t matches = 0;
  for (const char* items : {"ignore: i\n", "ignore: iB\n", "ignore: i[]\n", "consider: AC\n", "ignore: iBC\n",
                            "Ring Lsystem\nignore: iB\n", "Ring Lsystem\nignore: iABC\n"}) {
    const test::DerivedModel model = contexts(items, kContexts);
    const Program& program = model.program();
    const ContextRules rules(program, program.systems[0]);
    for (const int branches : {0, 4, 60, 300}) {
      const std::vector<Module> modules = longRows(program, 1500, branches, random);
      const ModuleString string = stringOf(program, modules);
      derivation::StringIndex index(program);
      index.extend(string);
      derivation::SearchShortcuts shortcuts;
      const derivation::ContextString searched{string.types().data(),
                                               string.parameters().data(),
                                               string.size(),
                                               string.parameterCount(),
                                               &index,
                                               true,
                                               &shortcuts};
      const PlainSearch plain(program, rules, modules);
      std::vector<double> frame(program.maximumSlots + std::size_t{1});
      std::uint64_t offset = 0;
      for (std::size_t i = 0; i < modules.size(); ++i) {
        for (const Production& production : program.systems[0].productions.productions) {
          Bound found;
          if (matchesLeft(program, rules, searched, production.leftContext, i, offset, frame.data())) {
            found = bound(program, production.leftContext, frame);
          }
          ASSERT_EQ(found, plain.left(production.leftContext, i)) << items << branches << " left of " << i;
          matches += found ? 1 : 0;
          found.reset();
          if (matchesRight(program, rules, searched, production.rightContext, i, offset, frame.data())) {
            found = bound(program, production.rightContext, frame);
          }
          ASSERT_EQ(found, plain.right(production.rightContext, i)) << items << branches << " right from " << i;
          matches += found ? 1 : 0;
        }
        offset += program.arity[modules[i].type];
      }
    }
  }
  EXPECT_GT(matches, 20000U);
}

TEST(SearchShortcuts, SearchesInAStringThatIsProducedFindWhatSearchesModuleByModuleFind) {
  const char* productions =
      "B(x) >> A(q) --> C(x)\nB(x) >> C(r)A(s) --> C(x)\nB(x) >> [A(r)]C(s) --> C(x)\nB(x) >> [A(s)=]C(t) --> C(x)\n"
      "B(x) >> =]A(q) --> C(x)\nB(x) >> A(r)=]A(s) --> C(x)\n";
  std::mt19937 random(2);
  std::size_t matches = 0;
  for (const char* items : {"ignore: i\n", "ignore: iB\n", "ignore: i[]\n", "consider: AC\n", "ignore: iBC\n"}) {
    const test::DerivedModel model = contexts(items, productions);
    const Program& program = model.program();
    const ContextRules rules(program, program.systems[0]);
    for (const int branches : {0, 4, 60, 300}) {
      const std::vector<Module> modules = longRows(program, 1500, branches, random);
      derivation::ProducedPieces pieces(program);
      std::vector<std::vector<Module>> made;  // from the right
      std::vector<std::uint64_t> oldModules;  // of each; more than one: dropped together
      std::vector<double> frame(program.maximumSlots + std::size_t{1});
      for (std::size_t end = modules.size(); end > 0;) {
        // pieces without modules, and cuts, which empty earlier ones
        const std::size_t size = random() % 3 == 0 ? 0 : std::min<std::size_t>(end, random() % 5 == 0 ? 40 : 1);
        const std::span<const Module> piece{modules.data() + end - size, size};
        pieces.begin();
        std::vector<Module> behind;
        for (std::size_t i = made.size(); i-- > 0;) {
          behind.insert(behind.end(), made[i].begin(), made[i].end());
        }
        const PlainSearch plain(program, rules, behind);
        for (const Production& production : program.systems[0].productions.productions) {
          Bound found;
          if (pieces.matchesRight(rules, production.newRightContext, frame.data())) {
            found = bound(program, production.newRightContext, frame);
          }
          ASSERT_EQ(found, plain.right(production.newRightContext, 0)) << items << branches << " before " << end;
          matches += found ? 1 : 0;
        }
        if (size == 0 && random() % 8 == 0) {
          std::uint64_t dropped = 0;
          for (std::size_t k = random() % std::min<std::size_t>(made.size() + 1, 12); k > 0; --k) {
            dropped += oldModules.back();
            made.pop_back();
            oldModules.pop_back();
          }
          pieces.dropBefore(dropped);
          if (dropped > 0) {
            made.emplace_back();
            oldModules.push_back(dropped);
          }
        }
        made.emplace_back();
        oldModules.push_back(1);
        made.back().assign(piece.begin(), piece.end());
        pieces.modules().appendAll(stringOf(program, piece).types(), stringOf(program, piece).parameters());
        end -= size;
      }
      ModuleString whole;
      pieces.appendTo(whole);
      std::size_t count = 0;
      for (const std::vector<Module>& piece : made) {
        count += piece.size();
      }
      EXPECT_EQ(whole.size(), count);
      ASSERT_EQ(pieces.count(), made.size());
      for (std::size_t i = 0; i < made.size(); ++i) {
        EXPECT_EQ(pieces.sizeOf(i), made[i].size());
        EXPECT_EQ(pieces.oldModulesOf(i), oldModules[i]);
      }
    }
  }
  EXPECT_GT(matches, 2000U);
}

}  // namespace
}  // namespace espalier::search_shortcuts_test
