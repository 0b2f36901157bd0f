#include "engine/derivation/parallel/string_chunks.h"

#include <gtest/gtest.h>

#include <cstdint>

#include "tests/support/derived_model.h"

namespace espalier::string_chunks_test {
namespace {

using derivation::ScanPlace;
using derivation::StringChunks;
using derivation::StringIndex;
using test::DerivedModel;
using test::modelText;

TEST(StringChunks, ChunksBeginAtTheirModulesAndParametersAndLinkBrackets) {
  // modules with 0 to 2 parameters, branches over many chunks, and brackets without partner
  DerivedModel model(modelText("", "A(1)[B(2,3)", "A(x) --> A(x)[B(x,2)C]\nC --> C]D(1)[\n"));
  static_cast<void>(model.steps(12));
  const derivation::ModuleString& string = model.state().string;
  ASSERT_GT(string.size(), 60U);
  StringIndex whole(model.program());
  whole.extend(string);
  for (const unsigned threads : {1U, 3U}) {
    core::WorkerTeam team(threads);
    StringChunks chunks(model.program());
    for (const std::uint64_t length : {std::uint64_t{1}, std::uint64_t{3}, string.size(), 2 * string.size()}) {
      StringIndex links(model.program());
      chunks.cut(string, length, team, &links);
      EXPECT_EQ(chunks.count(), (string.size() + length - 1) / length);
      std::uint64_t offset = 0;
      for (std::uint64_t i = 0; i < string.size(); ++i) {
        if (i % length == 0) {
          const ScanPlace begin = chunks.begin(i / length);
          EXPECT_EQ(begin.module, i);
          EXPECT_EQ(begin.offset, offset);
        }
        const core::ModuleTypeId type = string.types()[i];
        if (type == model.program().openBranch || type == model.program().closeBranch) {
          EXPECT_EQ(links.link(i).partner, whole.link(i).partner) << i;
          EXPECT_EQ(links.link(i).parameterCount, whole.link(i).parameterCount) << i;
        }
        offset += model.program().arity[type];
      }
      EXPECT_EQ(chunks.begin(chunks.count()).module, string.size());
      EXPECT_EQ(chunks.begin(chunks.count()).offset, string.parameterCount());
    }
  }
}

}  // namespace
}  // namespace espalier::string_chunks_test
