// Record chains of strings that are edited at random, in small stretches so that groups begin and end everywhere: every
// chain must have the records of the whole, and differences applied to the base must give them, bit by bit.

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "engine/turtle/interpretation/record_chain_builder.h"
#include "server/stream/chain_difference.h"
#include "tests/engine/turtle/turtle_fixture.h"
#include "tests/server/frame_viewer.h"

namespace espalier::server::chain_edits_test {
namespace {

using turtle::RecordChain;

struct Token {
  core::ModuleTypeId type = 0;
  std::vector<double> parameters;
};
using Tokens = std::vector<Token>;

constexpr const char* kAlphabet = "[]F f F(1) f(1) +(1) -(1) &(1) /(1) !(1) ;(1) @O(1) @v {.} ~l(1) X(1) X % ?E(1)";

/// A plant whose string can be edited.
struct Plant {
  turtle::TurtleRun run{kAlphabet};
  turtle::InterpretationTables tables{run.program};
  std::set<std::string> reported;
  turtle::PlantPlacement placement;
  Tokens tokens;
  derivation::StepChanges changes;  // of the string since the last chain

  [[nodiscard]] core::ModuleTypeId typeOf(const std::string& name, std::uint16_t arity) const {
    return run.program.findType(name, arity);
  }
  void write() {
    const derivation::ModuleString before = run.state.string;
    run.state.string.clear();
    for (const Token& token : tokens) {
      run.state.string.append(token.type, token.parameters);
    }
    changes = changes.then(derivation::StepChanges::between(before, run.state.string, run.program.arity));
  }
};

class Editor {
 public:
  explicit Editor(unsigned seed) : dice_(seed) {}

  std::size_t draw(std::size_t bound) { return static_cast<std::size_t>(dice_()) % bound; }

  /// Modules with branches that are closed, `length` parts of them.
  Tokens piece(const Plant& plant, std::size_t length, int depth = 0) {
    static const std::vector<std::pair<const char*, int>> kSingle{{"F", 0}, {"F", 1}, {"f", 1}, {"+", 1}, {"-", 1},
                                                                  {"&", 1}, {"/", 1}, {"!", 1}, {";", 1}, {"X", 1},
                                                                  {"X", 0}, {"X", 0}, {"F", 0}, {"F", 1}, {"+", 1}};
    Tokens tokens;
    const auto add = [&](const char* name, int arity, double value) {
      tokens.push_back({plant.typeOf(name, static_cast<std::uint16_t>(arity)),
                        std::vector<double>(static_cast<std::size_t>(arity), value)});
    };
    for (; length > 0; --length) {
      const std::size_t kind = draw(20);
      if (kind < 3 && depth < 6) {
        add("[", 0, 0);
        const Tokens inner = piece(plant, draw(6), depth + 1);
        tokens.insert(tokens.end(), inner.begin(), inner.end());
        add("]", 0, 0);
      } else if (kind == 3) {
        add("@", 0, 0);
        add("O", 1, 0.5);
      } else if (kind == 4) {
        add("?", 0, 0);
        add("E", 1, static_cast<double>(draw(3)));
      } else if (kind == 5) {
        add("~", 0, 0);
        add("l", 1, 0.5);
      } else if (kind == 6 && draw(20) == 0) {
        add("%", 0, 0);
      } else {
        const auto& [name, arity] = kSingle[draw(kSingle.size())];
        add(name, arity, static_cast<double>(draw(4)) * 0.25);
      }
    }
    return tokens;
  }

  /// One edit somewhere.
  void edit(Plant& plant) {
    Tokens& tokens = plant.tokens;
    const auto at = [&](std::size_t place) { return tokens.begin() + static_cast<std::ptrdiff_t>(place); };
    const std::size_t place = draw(tokens.size() + 1);
    const std::size_t end = std::min(tokens.size(), place + draw(draw(4) == 0 ? 600 : 12));
    switch (draw(6)) {
      case 0: {
        const Tokens fresh = piece(plant, 1 + draw(draw(4) == 0 ? 200 : 4));
        tokens.insert(at(place), fresh.begin(), fresh.end());
        break;
      }
      case 1:  // whole branches or halves of them
        tokens.erase(at(place), at(end));
        break;
      case 2: {
        // elsewhere: cut out there, put in here
        Tokens moved(at(place), at(end));
        tokens.erase(at(place), at(end));
        tokens.insert(at(draw(tokens.size() + 1)), moved.begin(), moved.end());
        break;
      }
      case 3: {
        // a second time
        const Tokens copied(at(place), at(end));
        tokens.insert(at(draw(tokens.size() + 1)), copied.begin(), copied.end());
        break;
      }
      case 4:
        tokens.insert(at(place), Token{plant.typeOf(draw(2) == 0 ? "[" : "]", 0), {}});
        break;
      default:
        for (std::size_t i = place; i < tokens.size(); ++i) {
          if (!tokens[i].parameters.empty()) {
            tokens[i].parameters[0] = static_cast<double>(draw(5)) * 0.25;
            break;
          }
        }
    }
  }

 private:
  std::mt19937 dice_;
};

class ChainEdits : public testing::Test {
 protected:
  ChainEdits() : plants_(2) {
    plants_[1].placement.position = {7.0, 0.0, 0.0};
    const auto& symbols = plants_[0].run.program.symbols;
    std::vector<std::string> names;
    for (const language::Symbol& symbol : symbols) {
      names.push_back(symbol.name);
    }
    symbols_ = std::make_shared<const std::vector<std::string>>(std::move(names));
  }

  /// The chain of the plants' strings as they are, with stretches of so many modules.
  std::shared_ptr<const RecordChain> chain(const RecordChain* base, std::uint64_t stretchModules) {
    const auto result = std::make_shared<RecordChain>();
    result->generation = ++chainCount_;
    for (std::uint32_t i = 0; i < plants_.size(); ++i) {
      Plant& plant = plants_[i];
      plant.write();
      derivation::Derivation derivation(plant.run.program, {});
      const std::function<void(std::span<turtle::TurtleRecord>)> rename = [](std::span<turtle::TurtleRecord>) {};
      turtle::RecordChainBuilder(
          {plant.run.program, plant.tables, plant.reported, derivation, plant.run.state, i, plant.placement}, base,
          plant.changes, rename, *result, stretchModules)
          .appendPlant();
      plant.changes = derivation::StepChanges::nothing(plant.tokens.size());
      result->firstLink.push_back(result->links.size());
    }
    return result;
  }

  TurtleFrame whole() {
    std::vector<turtle::TurtleRecord> records;
    for (std::uint32_t i = 0; i < plants_.size(); ++i) {
      Plant& plant = plants_[i];
      plant.write();
      derivation::Derivation derivation(plant.run.program, {});
      turtle::Interpreter(plant.run.program)
          .interpret(derivation, plant.run.state, i, plant.placement, {.records = &records, .fillsQueries = false});
    }
    return makeTurtleFrame(records, symbols_, {});
  }

  /// That the chain's numbers fit each other.
  void expectSound(const RecordChain& chain) {
    std::uint32_t records = 0;
    std::uint64_t bytes = 0;
    for (std::size_t plant = 0; plant < plants_.size(); ++plant) {
      std::uint64_t module = 0;
      for (std::size_t i = chain.firstLink[plant]; i < chain.firstLink[plant + 1]; ++i) {
        const RecordChain::Link& link = chain.links[i];
        const turtle::RecordGroup& group = *link.group;
        EXPECT_EQ(link.firstModule, module);
        EXPECT_EQ(link.firstRecord, records);
        EXPECT_GE(group.links.size(), 1U);
        EXPECT_LT(group.links.size(), turtle::kMostStretches);
        module += group.passage.modules;
        records += group.passage.records;
        bytes += group.bytes;
      }
      EXPECT_EQ(module, plants_[plant].tokens.size());
    }
    EXPECT_EQ(chain.recordCount, records);
    EXPECT_EQ(chain.bytes, bytes);
  }

  std::uint64_t chainCount_ = 0;
  std::vector<Plant> plants_;
  std::shared_ptr<const std::vector<std::string>> symbols_;
};

TEST_F(ChainEdits, AnyEditIsToldAsTheWholeWouldBe) {
  std::size_t kept = 0;
  std::size_t sharedGroups = 0;
  for (unsigned round = 0; round < 60; ++round) {
    Editor editor(round);
    for (Plant& plant : plants_) {
      plant.tokens = editor.piece(plant, 200 + editor.draw(2'000));
    }
    const std::uint64_t stretchModules = 1 + editor.draw(8);
    std::shared_ptr<const RecordChain> base;
    TurtleFrame viewed;
    for (int step = 0; step < 16; ++step) {
      const TurtleFrame frame = whole();
      const auto made = chain(base.get(), stretchModules);
      expectSound(*made);
      expectSameRows(makeTurtleFrame(*made, symbols_), frame);
      if (base != nullptr) {
        const TurtleChange change = differenceOf(*base, *made, symbols_);
        viewed = viewedAfter(viewed, change);
        expectSameRows(viewed, frame);
        kept += frame.rows() - change.fresh->rows();
        std::set<const turtle::RecordGroup*> groups;
        for (const RecordChain::Link& link : base->links) {
          groups.insert(link.group.get());
        }
        for (const RecordChain::Link& link : made->links) {
          sharedGroups += groups.count(link.group.get());
        }
      } else {
        viewed = frame;
      }
      ASSERT_FALSE(testing::Test::HasFailure()) << "round " << round << ", step " << step;
      base = made;
      for (Plant& plant : plants_) {
        for (std::size_t edits = editor.draw(4) * editor.draw(4); edits > 0; --edits) {
          editor.edit(plant);
        }
      }
    }
  }
  EXPECT_GT(kept, 100'000U);
  EXPECT_GT(sharedGroups, 5'000U);
}

TEST_F(ChainEdits, WhatStoodAtTheEndOfTheStringMayMeanSomethingElseBeforeMore) {
  // `@` alone does nothing; with what is appended it is a sphere
  Plant& plant = plants_[0];
  plant.tokens = {{plant.typeOf("F", 0), {}}, {plant.typeOf("@", 0), {}}};
  const auto base = chain(nullptr, 4);
  EXPECT_EQ(base->recordCount, 1U);
  plant.tokens.push_back({plant.typeOf("O", 1), {0.5}});
  const auto made = chain(base.get(), 4);
  EXPECT_EQ(made->recordCount, 2U);
  expectSameRows(makeTurtleFrame(*made, symbols_), whole());
}

TEST_F(ChainEdits, OneEditLeavesAllGroupsButAFew) {
  Editor editor(5);
  plants_[0].tokens = editor.piece(plants_[0], 20'000);
  auto base = chain(nullptr, 4);
  // between two modules a turn by nothing, at a hundred places one after the other
  const core::ModuleTypeId turn = plants_[0].typeOf("/", 1);
  for (int edit = 0; edit < 100; ++edit) {
    Tokens& tokens = plants_[0].tokens;
    tokens.insert(tokens.begin() + static_cast<std::ptrdiff_t>(editor.draw(tokens.size())), Token{turn, {0.0}});
    const auto made = chain(base.get(), 4);
    std::set<const turtle::RecordGroup*> groups;
    for (const RecordChain::Link& link : base->links) {
      groups.insert(link.group.get());
    }
    std::size_t fresh = 0;
    for (const RecordChain::Link& link : made->links) {
      fresh += 1 - groups.count(link.group.get());
    }
    EXPECT_LE(fresh, 3U);
    base = made;
  }
  // groups neither grow without bound nor fall to pieces
  const std::size_t stretches = base->places(0, base->links.size()).size();
  EXPECT_GT(base->links.size(), stretches / turtle::kMostStretches);
  EXPECT_LT(base->links.size(), stretches / 16);
}

TEST_F(ChainEdits, GrowthAtOnePlaceMakesFullGroups) {
  Editor editor(6);
  plants_[0].tokens = editor.piece(plants_[0], 2'000);
  auto base = chain(nullptr, 4);
  const core::ModuleTypeId turn = plants_[0].typeOf("/", 1);
  const std::size_t tip = plants_[0].tokens.size() / 2;
  for (int step = 0; step < 2'000; ++step) {
    Tokens& tokens = plants_[0].tokens;
    tokens.insert(tokens.begin() + static_cast<std::ptrdiff_t>(tip), Token{turn, {0.0}});
    base = chain(base.get(), 4);
  }
  expectSound(*base);
  const std::size_t stretches = base->places(0, base->links.size()).size();
  EXPECT_LT(base->links.size(), stretches / 12);
}

}  // namespace
}  // namespace espalier::server::chain_edits_test
