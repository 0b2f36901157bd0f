#include "environment/published/text_coupling.h"

#include <gtest/gtest.h>

#include "tests/environment/query_builder.h"

namespace espalier::environment::text_coupling_test {
namespace {

TurtleFormat formatOf(std::string_view text, std::size_t count = 3) {
  const auto result = TurtleFormat::parse(text, count);
  EXPECT_TRUE(result.has_value()) << text;
  return result.value();
}

std::string formatError(std::string_view text) {
  return TurtleFormat::parse(text, 3).error();
}

TEST(TurtleFormat, RoundsAsPrintfDoes) {
  EXPECT_EQ(formatOf("P: %.4f %.4f %.4f").exchanged({1.23456, -0.00004, 2}), (core::Vec3{1.2346F, -0.0, 2}));
  EXPECT_EQ(formatOf("%.0f,%.0f,%.0f").exchanged({3.6, 6.5, 7.5}), (core::Vec3{4, 6, 8}));
  EXPECT_EQ(formatOf("%g %e %G").exchanged({1234567, 1234567.5, 0.1}), (core::Vec3{1.23457e6, 1.234568e6, 0.1F}));
  EXPECT_EQ(formatOf("%8.2lf|%-8.1f|%+08.3F").exchanged({1.239, 2.25, 3}), (core::Vec3{1.24F, 2.2F, 3}));
  EXPECT_EQ(formatOf("100%% %f").exchanged(0, 0.25), 0.25);
}

TEST(TurtleFormat, MissingConversionsArriveAsZero) {
  EXPECT_EQ(formatOf("%.1f %.1f").exchanged({1, 2, 3}), (core::Vec3{1, 2, 0}));
  EXPECT_EQ(formatOf("%f %f", 1).conversionCount(), 1U);
}

TEST(TurtleFormat, RefusesWhatDoesNotPrintARealNumber) {
  EXPECT_EQ(formatError("P: %d"),
            "the conversion '%d' does not print a real number; use %f, %e or %g, as in 'P: %.4f %.4f %.4f'");
  EXPECT_EQ(formatError("%.4f %n"),
            "the conversion '%n' does not print a real number; use %f, %e or %g, as in 'P: %.4f %.4f %.4f'");
  EXPECT_EQ(formatError("%*f"),
            "the conversion '%*' does not print a real number; use %f, %e or %g, as in 'P: %.4f %.4f %.4f'");
  EXPECT_EQ(formatError("position"), "the format has no conversion; use %f, %e or %g, as in 'P: %.4f %.4f %.4f'");
  EXPECT_EQ(formatError("%.9999f"), "the conversion '%.9999f' is wider than 999 characters");
  EXPECT_EQ(formatError("abc %"),
            "the conversion '%' does not print a real number; use %f, %e or %g, as in 'P: %.4f %.4f %.4f'");
}

/// Returns the values that arrive: p1 = first parameter, p2 = x, p3 = heading y, p4 = width, p5 = a third; counts
/// ticks.
class Echo final : public turtle::EnvironmentProcess {
 public:
  explicit Echo(int& tickCount) : tickCount_(tickCount) {}
  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    return {.name = "echo",
            .summary = "Echoes.",
            .needs = {.position = true, .heading = true, .width = true, .parameters = true, .following = true},
            .inputs = {},
            .outputs = {}};
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext&) override { return {}; }
  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& q,
                                                             turtle::ReplyBatch& replies) override {
    for (std::size_t i = 0; i < q.size(); ++i) {
      replies.set(q, i, 0, q.parametersOf(i)[0]);
      replies.set(q, i, 1, q.position[i].x);
      replies.set(q, i, 2, q.heading[i].y);
      replies.set(q, i, 3, q.width[i]);
      replies.set(q, i, 4, 1.0 / 3.0);
      replies.set(q, i, 5, q.following[i] == core::kNoSymbol ? -1.0 : q.followingParametersOf(i)[0]);
    }
    return {};
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> tick(std::uint64_t) override {
    ++tickCount_;
    return {};
  }

 private:
  int& tickCount_;
};

turtle::QueryBatch oneQuery(QueryBuilder& builder) {
  builder.add({1.23456789, 0, 0}, {0.123456789, 0, 0, 0, 0, 0});
  builder.batch().following = {4};
  builder.batch().followingOffset = {0, 1};
  builder.batch().followingParameters = {7.6543217};
  return builder.batch();
}

TEST(TextCoupling, RoundsWhatIsSentAndWhatComesBack) {
  int ticks = 0;
  TurtleFormats formats;
  formats.position = formatOf("%.3f %.3f %.3f");
  formats.width = formatOf("%f", 1);
  const auto process = makeTextCoupling(std::make_unique<Echo>(ticks), formats);
  ASSERT_FALSE(process->open({}));
  QueryBuilder builder;
  const auto row = answersOf(*process, oneQuery(builder))[0];
  EXPECT_EQ(row[0], 0.123457);  // %g
  EXPECT_EQ(row[1], 1.235);     // %.3f; answers are %g of floats
  EXPECT_EQ(row[2], 0.0);       // the heading is not sent
  EXPECT_EQ(row[3], 1.0);
  EXPECT_EQ(row[4], 0.333333);  // %g on the way back
  EXPECT_EQ(row[5], 7.65432);   // parameters of the following module
}

TEST(TextCoupling, TheFollowingModuleCanBeLeftOut) {
  int ticks = 0;
  TurtleFormats formats;
  formats.isFollowingSent = false;
  const auto process = makeTextCoupling(std::make_unique<Echo>(ticks), formats);
  QueryBuilder builder;
  EXPECT_EQ(answersOf(*process, oneQuery(builder))[0][5], -1.0);
}

TEST(TextCoupling, DescribesWhatIsStillNeeded) {
  int ticks = 0;
  TurtleFormats formats;
  formats.position = formatOf("%f %f %f");
  formats.isFollowingSent = false;
  const auto needs = makeTextCoupling(std::make_unique<Echo>(ticks), formats)->describe().needs;
  EXPECT_TRUE(needs.position);
  EXPECT_TRUE(needs.parameters);
  EXPECT_FALSE(needs.heading);
  EXPECT_FALSE(needs.width);
  EXPECT_FALSE(needs.following);
}

TEST(TextCoupling, TimePassesOnlyWithQueries) {
  int ticks = 0;
  const auto process = makeTextCoupling(std::make_unique<Echo>(ticks), {});
  ASSERT_FALSE(process->tick(3));
  EXPECT_EQ(ticks, 0);
}

}  // namespace
}  // namespace espalier::environment::text_coupling_test
