#include "engine/language/checks/model_queries.h"

#include <gtest/gtest.h>

#include "tests/engine/language/compile_text.h"

namespace espalier::language::model_queries_test {
namespace {

Messages unanswered(const std::vector<std::string>& processes) {
  const CompileResult result = compileText(
      "Module: ?Light(flux), ?Water(amount), ?Never(x)\nLsystem: 1\nAxiom: A?E(1)\nA --> ?Light(0)A?Light(1)\n"
      "homomorphism\nA --> ?Water(1)\nendlsystem\n");
  Messages messages;
  for (const core::Diagnostic& diagnostic : unansweredQueries(*result.program, processes)) {
    messages.push_back(brief(diagnostic));
  }
  return messages;
}

TEST(ModelQueries, AreThoseThatAxiomsAndSuccessorsMake) {
  const CompileResult result =
      compileText("Module: ?Light(flux)\nLsystem: 1\nAxiom: A?E(1)E(2)?P(1,2,3)\nA --> ?Light(0)?E(3)\nendlsystem\n");
  const std::vector<ModelQuery> queries = queriesOf(*result.program);
  ASSERT_EQ(queries.size(), 2U);
  EXPECT_EQ(queries[0].name, "E");
  EXPECT_EQ(queries[1].name, "Light");
}

TEST(ModelQueries, AModelWithoutQueriesHasNone) {
  const CompileResult result = compileText("Lsystem: 1\nAxiom: AE(1)\nA --> AE(1)\nendlsystem\n");
  EXPECT_TRUE(queriesOf(*result.program).empty());
  EXPECT_TRUE(unansweredQueries(*result.program, {}).empty());
}

TEST(ModelQueries, EachQueryThatNoProcessAnswersIsReported) {
  EXPECT_EQ(unanswered({"light", "WATER"}), Messages{});
  EXPECT_EQ(
      unanswered({"ligth", "Water"}),
      Messages{
          "4:8: warning: no environment process is named 'Light' | Did you mean 'ligth'? Available: ligth, Water."});
}

TEST(ModelQueries, WithoutAnEnvironmentNobodyAnswers) {
  const std::string hint = " | give the model an environment; without one the parameters keep their values";
  EXPECT_EQ(unanswered({}), (Messages{"3:10: warning: ?E gets no answer: no environment is given" + hint,
                                      "4:8: warning: ?Light gets no answer: no environment is given" + hint,
                                      "6:8: warning: ?Water gets no answer: no environment is given" + hint}));
}

TEST(ModelQueries, FilesThatWouldBeWrittenAreReportedWhereNoneAre) {
  const CompileResult result = compileText(
      "Lsystem: 1\nStart: {f = fopen(\"a\", \"r\"); g = fopen(\"b\", \"w\"); h = fopen(\"c\", \"r+\");}\n"
      "Axiom: A\nA --> A\nendlsystem\n");
  Messages messages;
  for (const core::Diagnostic& diagnostic : unwrittenFiles(*result.program)) {
    messages.push_back(brief(diagnostic));
  }
  const std::string hint = " | run the model with the program 'espalier' to write the file beside it";
  EXPECT_EQ(messages, (Messages{"2:34: warning: models cannot write files here: fopen(\"b\") returns 0" + hint,
                                "2:55: warning: models cannot write files here: fopen(\"c\") returns 0" + hint}));
}

}  // namespace
}  // namespace espalier::language::model_queries_test
