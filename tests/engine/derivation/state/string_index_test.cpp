#include "engine/derivation/state/string_index.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "tests/support/derived_model.h"

namespace espalier::string_index_test {
namespace {

using derivation::StringIndex;
using test::DerivedModel;
using test::modelText;

TEST(StringIndex, LinksBracketsBothWaysAndCountsTheParametersBetween) {
  DerivedModel model(modelText("", "A(1)[B(2,3)[C]D(4)]E", "A --> A\n"));
  StringIndex index(model.program());
  index.extend(model.state().string);
  // modules: 0 A, 1 [, 2 B, 3 [, 4 C, 5 ], 6 D, 7 ], 8 E
  EXPECT_EQ(index.link(1).partner, 7U);
  EXPECT_EQ(index.link(7).partner, 1U);
  EXPECT_EQ(index.link(1).parameterCount, 3U);
  EXPECT_EQ(index.link(7).parameterCount, 3U);
  EXPECT_EQ(index.link(3).partner, 5U);
  EXPECT_EQ(index.link(5).parameterCount, 0U);
}

TEST(StringIndex, ClosesBranchesThatWereOpenWhenItWasExtended) {
  DerivedModel model(modelText("", "A[B(1)]", "A --> A\n"));
  const derivation::ModuleString& whole = model.state().string;
  derivation::ModuleString part;
  part.appendAll(whole.types().subspan(0, 2), {});
  StringIndex index(model.program());
  index.extend(part);
  EXPECT_EQ(index.link(1).partner, StringIndex::kNone);
  part.appendAll(whole.types().subspan(2), whole.parameters());
  index.extend(part);
  EXPECT_EQ(index.link(3).partner, 1U);
  EXPECT_EQ(index.link(1).partner, 3U);
  EXPECT_EQ(index.link(3).parameterCount, 1U);
}

TEST(StringIndex, IsSharedByStringsWithTheSameBracketsAndNumbersOfParameters) {
  DerivedModel model(modelText("", "A(1)[B(2)C]DB(3)[]", "A(x) --> A(x)\n"));
  const StringIndex index(model.program());
  const auto type = [&](const char* symbol, std::uint16_t arity) { return model.program().findType(symbol, arity); };
  const auto span = model.state().string.types();
  std::vector<core::ModuleTypeId> before(span.begin(), span.end());
  // so long that several comparisons are made
  for (int i = 0; i < 100; ++i) {
    before.push_back(type("D", 0));
  }
  std::vector<core::ModuleTypeId> now = before;
  EXPECT_TRUE(index.isShared(before, now));
  now[2] = type("A", 1);
  now[70] = type("C", 0);
  EXPECT_TRUE(index.isShared(before, now));
  for (const std::size_t place : {std::size_t{3}, before.size() - 1}) {
    for (const core::ModuleTypeId other : {type("A", 1), type("[", 0), type("]", 0)}) {
      const core::ModuleTypeId kept = std::exchange(now[place], other);
      EXPECT_FALSE(index.isShared(before, now)) << place << " " << other;
      now[place] = kept;
    }
  }
  now[1] = type("]", 0);
  EXPECT_FALSE(index.isShared(before, now));
  now[1] = before[1];
  now.pop_back();
  EXPECT_FALSE(index.isShared(before, now));
}

TEST(StringIndex, KeepsLongBranchesApartAndLinksThemAlike) {
  // a threshold of 3 instead of 2^31 - 1: too many modules in the first, too many parameters in the second
  DerivedModel model(modelText("", "[A(1)[B]CD]E[B(1,2,3,4)][C(1,2,3)]F", "A --> A\n"));
  StringIndex plain(model.program());
  StringIndex apart(model.program(), 3);
  plain.extend(model.state().string);
  apart.extend(model.state().string);
  const auto types = model.state().string.types();
  std::size_t brackets = 0;
  for (std::uint64_t i = 0; i < types.size(); ++i) {
    if (types[i] == model.program().openBranch || types[i] == model.program().closeBranch) {
      EXPECT_EQ(apart.link(i).partner, plain.link(i).partner) << i;
      EXPECT_EQ(apart.link(i).parameterCount, plain.link(i).parameterCount) << i;
      ++brackets;
    }
  }
  EXPECT_EQ(brackets, 8U);
  EXPECT_EQ(apart.link(0).partner, 7U);
  EXPECT_EQ(apart.link(9).parameterCount, 4U);
}

TEST(StringIndex, PartsLinkAsTheWholeDoes) {
  // lone brackets of both kinds, and branches over many parts
  DerivedModel model(modelText("", "A(1)]B[C(2)[D][E(3)[F(4,5)]G]H(6)[[[I(7)]]]J]K[L(8)[M]", "A --> A\n"));
  const derivation::ModuleString& string = model.state().string;
  StringIndex whole(model.program());
  whole.extend(string);
  for (std::uint64_t length = 1; length <= string.size(); ++length) {
    // every other time with a threshold at which branches are kept apart
    StringIndex parts = length % 2 == 0 ? StringIndex(model.program(), 3) : StringIndex(model.program());
    parts.beginParts(string.size());
    const std::uint64_t count = (string.size() + length - 1) / length;
    std::vector<StringIndex::OpenEnds> ends(count);
    for (std::uint64_t i = count; i-- > 0;) {
      parts.linkPart(string.types().data(), i * length, std::min((i + 1) * length, string.size()), ends[i]);
    }
    std::uint64_t offset = 0;
    for (std::uint64_t i = 0; i < string.size(); ++i) {
      if (i % length == 0) {
        parts.joinPart(ends[i / length], offset);
      }
      offset += model.program().arity[string.types()[i]];
    }
    for (std::uint64_t i = 0; i < string.size(); ++i) {
      const core::ModuleTypeId type = string.types()[i];
      if (type == model.program().openBranch || type == model.program().closeBranch) {
        EXPECT_EQ(parts.link(i).partner, whole.link(i).partner) << length << " " << i;
        EXPECT_EQ(parts.link(i).parameterCount, whole.link(i).parameterCount) << length << " " << i;
      }
    }
  }
}

}  // namespace
}  // namespace espalier::string_index_test
