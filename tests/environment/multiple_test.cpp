#include "environment/multiple.h"

#include <gtest/gtest.h>

#include "tests/environment/query_builder.h"

namespace espalier::environment::multiple_test {
namespace {

constexpr const char* kHondaAndVoxels =
    R"({"fields":[{"type":"honda","radius":1,"threeDimensional":true},
                  {"type":"density3d","range":[10,10,10],"position":[-5,-5,-5],"gridSize":[10,10,10]}]})";

QueryBuilder sixQueries() {
  QueryBuilder builder;
  builder.add({0, 0, 0}, {1, 1}).add({0, 0, 0}, {2, 3}).add({0.2, 0, 0}, {1, 2}).add({0.2, 0, 0}, {2, 4});
  builder.add({4, 0, 0}, {1, 1}).add({4, 0, 0}, {2, 5});
  return builder;
}

TEST(Multiple, TheFirstParameterChoosesTheFieldAndIsNotPassedOn) {
  const auto process = openProcess("multiple", kHondaAndVoxels);
  QueryBuilder builder = sixQueries();
  const ReplyTable table = answersOf(*process, builder.batch());
  const std::vector<double> expected{0, 7, 1, 7, 1, 5};
  for (std::size_t query = 0; query < expected.size(); ++query) {
    EXPECT_EQ(table[query], (std::vector<std::optional<double>>{std::nullopt, expected[query]})) << query;
  }
}

TEST(Multiple, AFieldThatDoesNotExistIsAnErrorAndNothingAdvances) {
  const auto process = openProcess("multiple", kHondaAndVoxels);
  QueryBuilder builder;
  builder.add({0, 0, 0}, {2, 3}).add({0, 0, 0}, {3, 1});
  turtle::ReplyBatch replies;
  replies.prepare(builder.batch());
  const std::string before = process->save();
  const auto error = process->step(builder.batch(), replies);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->message,
            "Environment 'multiple' has no environment with the number 3, which module 1 asks. Available: 1 honda, 2 "
            "density3d. Parameter 1 of the "
            "query must be one of these numbers.");
  EXPECT_EQ(process->save(), before);
}

TEST(Multiple, CompatibleLeavesSuchAQueryUnanswered) {
  std::string configuration = kHondaAndVoxels;
  configuration.insert(1, R"("compatible":true,)");
  const auto process = openProcess("multiple", configuration);
  QueryBuilder builder;
  builder.add({0, 0, 0}, {3, 1}).add({0, 0, 0}, {}).add({0, 0, 0}, {2.9, 4}).add({0, 0, 0}, {-1, 4});
  const ReplyTable table = answersOf(*process, builder.batch());
  EXPECT_EQ(table[0][1], std::nullopt);
  EXPECT_EQ(table[2][1], 4.0);
  EXPECT_EQ(table[3][1], std::nullopt);
}

TEST(Multiple, StateOfTheFieldsIsSavedAndRestored) {
  const auto process = openProcess("multiple", kHondaAndVoxels);
  QueryBuilder builder = sixQueries();
  answersOf(*process, builder.batch());
  const auto other = openProcess("multiple", kHondaAndVoxels);
  ASSERT_FALSE(other->restore(process->save()));
  EXPECT_EQ(other->save(), process->save());
  EXPECT_EQ(answersOf(*other, builder.batch()), answersOf(*process, builder.batch()));
  EXPECT_TRUE(process->describe().isStateful);
}

TEST(Multiple, ErrorsNameTheField) {
  const auto message = [](const char* configuration) {
    const std::string text = errorsOf(makeProcess("multiple", configuration));
    return text.substr(0, text.find('\n'));
  };
  EXPECT_EQ(
      message(R"({"fields":[{"type":"honda"},{"type":"honda","radius":-1}]})"),
      "error: environment process 'multiple': fields[1]: environment process 'honda': 'radius' must be at least 0, "
      "found -1");
  EXPECT_EQ(message(R"({"fields":[{"radius":1}]})"),
            "error: environment process 'multiple': fields[0]: environment has no 'type'");
  EXPECT_EQ(
      message(R"({"fields":[{"type":"multiple"}]})"),
      "error: environment process 'multiple': fields[0]: an environment of 'multiple' cannot be 'multiple' itself");
  EXPECT_EQ(
      message(R"({"fields":[3]})"),
      "error: environment process 'multiple': fields[0]: environment must be an object or a list of objects, found the "
      "number 3");
  EXPECT_EQ(message(R"({"fields":{}})"),
            "error: environment process 'multiple': 'fields' must be a list of environments, found an object");
}

}  // namespace
}  // namespace espalier::environment::multiple_test
