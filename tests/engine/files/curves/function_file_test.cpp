#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "engine/files/curves/function_file.h"

namespace espalier::files::function_file_test {
namespace {

constexpr const char* kRamp =
    "fver 1 1\nname: ramp\nsamples: 100\nflip: off\npoints: 4\n"
    "0.000000 0.000000\n0.250000 0.500000\n0.750000 0.500000\n1.000000 2.000000\n";

struct Read {
  SplineFunction function = zeroFunction();
  std::string message;  // "line:column text" of the first warning
};

std::string firstMessage(const core::DiagnosticList& diagnostics) {
  if (diagnostics.entries().empty()) {
    return "";
  }
  const core::Diagnostic& first = diagnostics.entries().front();
  return std::to_string(first.location.line) + ":" + std::to_string(first.location.column) + " " + first.message;
}

Read read(const std::string& text, std::optional<int> samples = std::nullopt) {
  core::DiagnosticList diagnostics;
  const DataFile file("f.func", text, diagnostics);
  SplineFunction function = readFunctionFile(file, samples);
  return {std::move(function), firstMessage(diagnostics)};
}

TEST(FunctionFile, ReadsVersion11WithTheSamplesOfTheFile) {
  const Read result = read(kRamp, 3);
  EXPECT_EQ(result.message, "");
  EXPECT_EQ(result.function.name(), "ramp");
  // 100 samples of the file; with the command's 3 the value at 0.25 would lie on the chord from 0 to 0.5
  EXPECT_NEAR(result.function.value(0.25), 0.338344, 1e-5);
}

TEST(FunctionFile, ADecimalCommaIsNamed) {
  const Read result = read("fver 1 1\nname: a\nsamples: 9\nflip: off\npoints: 4\n0 0 1\n.3 0,9 1\n.7 1 1\n1 1 1\n");
  EXPECT_EQ(result.message,
            "7:5 expected a blank between the numbers of a point while reading function 'a', found ',9'");
}

TEST(FunctionFile, AByteOrderMarkIsNoPartOfTheVersion) {
  const Read result = read(std::string("\xEF\xBB\xBF") + kRamp);
  EXPECT_EQ(result.message, "");
  EXPECT_EQ(result.function.name(), "ramp");
}

TEST(FunctionFile, SkipsLinesThatEditorsAdd) {
  const Read result = read(
      "fver 1 1\nname: ramp\nsamples: 100\nbackground: a.png\nbackgroundXY: 1 2\nmarkers: 2\n0.1\n0.2\nflip: on\n"
      "points: 4\r\n0 0 1\n0.25 0.5\n0.75 0.5\n1 2");
  EXPECT_EQ(result.message, "");
  EXPECT_NEAR(result.function.value(0.7), 0.956801, 1e-5);
}

TEST(FunctionFile, MultiplicityRepeatsAPoint) {
  const Read repeated = read("fver 1 1\nname: a\nsamples: 0\nflip: off\npoints: 4\n0 0 3\n.4 1\n.6 1\n1 0 2\n");
  const Read written =
      read("fver 1 1\nname: a\nsamples: 0\nflip: off\npoints: 7\n0 0\n0 0\n0 0\n.4 1\n.6 1\n1 0\n1 0\n");
  EXPECT_EQ(repeated.message, "");
  for (double x = 0.0; x <= 1.0; x += 0.1) {
    EXPECT_EQ(repeated.function.value(x), written.function.value(x));
  }
}

TEST(FunctionFile, OldFormatIgnoresItsRangeAndSamplesAsTheCommandSays) {
  const std::string text = "range: 5 9\npoints: 4\n0 0\n.25 .5\n.75 .5\n1 2\n";
  EXPECT_NEAR(read(text, 100).function.value(0.25), 0.338344, 1e-5);
  // without a table the search alone decides: within its error of the same curve
  EXPECT_NEAR(read(text).function.value(0.25), 0.338344, 0.01);
  EXPECT_NE(read(text).function.value(0.25), read(text, 100).function.value(0.25));
}

TEST(FunctionFile, AnErrorGivesTheFunctionThatIsZeroEverywhere) {
  const Read result = read("fver 1 2\nname: ramp\n");
  EXPECT_EQ(result.message, "1:1 expected version 'fver 1 1' while reading a function file, found 'fver 1 2'");
  EXPECT_EQ(read("\nfver 1 1\n\nname: ramp\n").message,
            "1:1 expected 'fver 1 1' while reading a function file, found an empty line");
  EXPECT_EQ(read("fver x\n").message, "1:1 expected version 'fver 1 1' while reading a function file, found 'fver x'");
  EXPECT_EQ(result.function.value(0.5), 0.0);
}

TEST(FunctionFile, CountsLinesNotMultiplicities) {
  const Read result = read("fver 1 1\nname: a\nsamples: 9\nflip: off\npoints: 2\n0 0 3\n1 1 3\n");
  EXPECT_EQ(result.message, "5:1 a function needs at least 4 lines of points, function 'a' has 2; it is 0 everywhere");
  EXPECT_EQ(result.function.value(0.5), 0.0);
}

TEST(FunctionFile, ReportsEveryMissingPart) {
  EXPECT_EQ(read("fver 1 1\nsamples: 9\n").message, "2:1 expected 'name:' while reading a function, found 'samples:'");
  EXPECT_EQ(read("fver 1 1\nname: a\nflip: off\n").message,
            "3:1 expected 'samples:' while reading function 'a', found 'flip:'");
  EXPECT_EQ(read("fver 1 1\nname: a\nsamples: x\n").message,
            "3:10 expected an integer after 'samples:' while reading function 'a', found 'x'");
  EXPECT_EQ(read("fver 1 1\nname: a\nsamples: 9\nmarkers: x\n").message,
            "4:10 expected 'markers:' with a count while reading function 'a', found 'x'");
  EXPECT_EQ(read("fver 1 1\nname: a\nsamples: 9\npoints: 4\n").message,
            "4:1 expected 'flip:' while reading function 'a', found 'points:'");
  EXPECT_EQ(read("fver 1 1\nname: a\nsamples: 9\nflip: off\n0 0\n").message,
            "5:1 expected 'points:' with a count while reading function 'a', found '0'");
  EXPECT_EQ(read("fver 1 1\nname: a\nsamples: 9\nflip: off\npoints: 4\n0 zero\n").message,
            "6:3 expected two numbers of a point while reading function 'a', found 'zero'");
  EXPECT_EQ(read("").message, "1:1 expected 'fver 1 1' while reading a function file, found the end");
}

TEST(FunctionFile, LargeNumbersAskForNoMemoryBeforeTheDataIsSeen) {
  EXPECT_EQ(read("fver 1 1\nname: a\nsamples: 9\nflip: off\npoints: 1000000000\n0 0\n").message,
            "7:1 expected two numbers of a point while reading function 'a', found the end");
  EXPECT_EQ(read("fver 1 1\nname: a\nsamples: 9\nflip: off\npoints: 4\n0 0 999999999\n").message,
            "6:1 function 'a' has more than 100000 points; it is 0 everywhere");
  EXPECT_EQ(read("fver 1 1\nname: a\nsamples: 999999999\nflip: off\npoints: 4\n0 0\n.3 1\n.6 1\n1 1\n").message,
            "3:1 more than 10000 samples; 10000 are used");
}

TEST(FunctionFile, PointsThatDoNotGoFromZeroToOneAreNamed) {
  const std::string head = "fver 1 1\nname: a\nsamples: 9\nflip: off\npoints: 5\n";
  EXPECT_EQ(read(head + "0 0\n.3 1\n.7 1\n.6 1\n1 1\n").message, "9:1 x of function 'a' falls here");
  EXPECT_EQ(read(head + "0 0\n.3 1\n.6 1\n.6 1\n1.1 1\n").message, "5:1 x of function 'a' does not go from 0 to 1");
  EXPECT_EQ(read(head + "0.05 0\n.3 1\n.6 1\n.6 1\n1 1\n").message, "5:1 x of function 'a' does not go from 0 to 1");
  EXPECT_EQ(read(head + "0 0\n.3 1\n.6 1\n.6 1\n1 1\n").message, "");
}

TEST(FunctionSet, OldFunctionsHaveATableOfOneHundredSamples) {
  const std::string old = "range: 0 1\npoints: 4\n0 1\n0.3 1\n0.7 3\n1 3\n";
  core::DiagnosticList diagnostics;
  const DataFile file("s.fset", "funcgalleryver 1 1\nitems: 1\n" + old, diagnostics);
  const std::vector<SplineFunction> functions = readFunctionSet(file, core::Compatibility::Espalier);
  ASSERT_EQ(functions.size(), 1U);
  EXPECT_EQ(functions[0].value(0.253), read(old, 100).function.value(0.253));
  EXPECT_NE(functions[0].value(0.253), read(old).function.value(0.253));
}

constexpr const char* kSet =
    "funcgalleryver 1 1\nitems: 2\n"
    "fver 1 1\nname: rise\nsamples: 100\nflip: off\npoints: 4\n0 1\n0.3 1\n0.7 3\n1 3\n"
    "fver 1 1\nname: Fall\nsamples: 100\nflip: off\npoints: 4\n0 2\n0.4 0.5\n0.6 0.25\n1 0\n";

TEST(FunctionSet, ReadsItsFunctionsAndNamesThemByTheirMacros) {
  core::DiagnosticList diagnostics;
  const DataFile file("s.fset", kSet, diagnostics);
  const std::vector<SplineFunction> functions = readFunctionSet(file, core::Compatibility::Cpfg);
  ASSERT_EQ(functions.size(), 2U);
  EXPECT_TRUE(diagnostics.entries().empty());
  EXPECT_EQ(functions[0].name(), "rise");
  EXPECT_EQ(functions[1].name(), "Fall");
  // recorded in conformance case 043
  EXPECT_NEAR(functions[0].value(0.3), 1.45138, 1e-5);
  EXPECT_NEAR(functions[1].value(0.6), 0.366491, 1e-5);
}

TEST(FunctionSet, ContinuesBehindAnItemWithAnErrorOutsideTheCompatibleModes) {
  std::string text = kSet;
  text.replace(text.find("points: 4"), 9, "points: 1");
  core::DiagnosticList diagnostics;
  const DataFile file("s.fset", text, diagnostics);
  const std::vector<SplineFunction> ours = readFunctionSet(file, core::Compatibility::Espalier);
  ASSERT_EQ(ours.size(), 2U);
  EXPECT_EQ(ours[0].value(0.3), 0.0);
  EXPECT_NEAR(ours[1].value(0.6), 0.366491, 1e-5);
  // the reference stays in the middle of the failed item, so that the next one is lost too
  const std::vector<SplineFunction> reference = readFunctionSet(file, core::Compatibility::Cpfg);
  ASSERT_EQ(reference.size(), 2U);
  EXPECT_EQ(reference[1].value(0.6), 0.0);
}

TEST(FunctionSet, ReportsItsHeadAndMissingItems) {
  const auto message = [](const std::string& text) {
    core::DiagnosticList diagnostics;
    const DataFile file("s.fset", text, diagnostics);
    (void)readFunctionSet(file, core::Compatibility::Espalier);
    return firstMessage(diagnostics);
  };
  EXPECT_EQ(message("contourgalleryver 1 1\n"),
            "1:1 expected 'funcgalleryver 1 1' while reading a function set, found 'contourgalleryver'");
  EXPECT_EQ(message("funcgalleryver 1 1\nfver 1 1\n"),
            "2:1 expected 'items:' with a count while reading a function set, found 'fver'");
  EXPECT_EQ(message("funcgalleryver 1 1\nitems: 1000000000\n"),
            "3:1 expected function 1 of 1000000000 while reading a function set, found the end");
}

}  // namespace
}  // namespace espalier::files::function_file_test
