#include "engine/derivation/expressions/evaluator.h"

#include <gtest/gtest.h>

#include "tests/support/derived_model.h"

namespace espalier::evaluator_test {
namespace {

using core::Compatibility;
using core::SimulationErrorCode;
using test::derive;
using test::DerivedModel;
using test::modelText;

/// The value of an expression of x = 7 and y = -2.5, as printed.
std::string value(const std::string& expression) {
  return derive(modelText("", "A(7,-2.5)", "A(x,y) --> B(" + expression + ")\n"), 1);
}

TEST(Evaluator, ComputesOperators) {
  EXPECT_EQ(value("x+y*2"), "B(2)");
  EXPECT_EQ(value("x/2-y"), "B(6)");
  EXPECT_EQ(value("2^3^2"), "B(64)");
  EXPECT_EQ(value("-y^2"), "B(6.25)");
  EXPECT_EQ(value("x%4"), "B(3)");
  EXPECT_EQ(value("(x>y)+(x>=7)+(x<y)+(x<=y)+(x==7)+(x!=7)"), "B(3)");
  EXPECT_EQ(value("!x+!0"), "B(1)");
  EXPECT_EQ(value("x>0 && y>0"), "B(0)");
  EXPECT_EQ(value("x>0 || y>0"), "B(1)");
  EXPECT_EQ(value("y>0 ? 1 : x>0 ? 2 : 3"), "B(2)");
}

TEST(Evaluator, ComputesFunctionsOfArguments) {
  EXPECT_EQ(value("floor(y)+ceil(y)+sign(y)"), "B(-6)");
  EXPECT_EQ(value("max(x,y)+min(x,y)"), "B(4.5)");
}

TEST(Evaluator, WarnsOncePerPlaceAboutDivisionByZero) {
  DerivedModel model(modelText("", "A(3)A(4)", "A(x) --> A(x/(x-x))\n"));
  EXPECT_EQ(model.steps(2), "A(3)A(4)");
  ASSERT_EQ(model.warnings().size(), 1U);
  EXPECT_NE(model.warnings()[0].find("model.l:4:"), std::string::npos) << model.warnings()[0];
  EXPECT_NE(model.warnings()[0].find("warning: division by 0; the divisor counts as 1"), std::string::npos)
      << model.warnings()[0];
}

TEST(Evaluator, KeepsArraysInBoundsWithAWarning) {
  DerivedModel model(modelText("Define: { array w[3] = {2,4,6}; }\n", "A(-5)A(1.9)A(9)", "A(i) --> B(w[i])\n"));
  EXPECT_EQ(model.steps(1), "B(2)B(4)B(6)");
  ASSERT_EQ(model.warnings().size(), 1U);
  EXPECT_NE(model.warnings()[0].find("subscript 1 of 'w' is outside the array and is clamped to its ends"),
            std::string::npos)
      << model.warnings()[0];
}

TEST(Evaluator, StoresTwoDimensionsRowByRow) {
  EXPECT_EQ(
      derive(modelText("Define: { array g[2][3] = {10,11,12,20,21,22}; }\n", "A", "A --> B(g[1][0],g[0][2])\n"), 1),
      "B(20,12)");
}

TEST(Evaluator, RunsLoopsAndBranches) {
  EXPECT_EQ(derive(modelText("", "P(84,36)", "P(a,b) : {x=a; y=b; while (y>0) {r=x%y; x=y; y=r;} } * --> G(x)\n"), 1),
            "G(12)");
  EXPECT_EQ(derive(modelText("", "P(3)",
                             "P(a) : {n=0; do {n=n+1;} while (n<a); if (n==3) {n=30;} else {n=40;} } * --> G(n)\n"),
                   1),
            "G(30)");
}

TEST(Evaluator, StopsLoopsAtTheLimit) {
  derivation::DerivationOptions options;
  options.limits.maximumLoopIterations = 1000;
  DerivedModel model(modelText("", "A", "A : {x=1; while (x>0) {x=x+1;} } * --> B(x)\n"), options);
  const core::SimulationError error = model.failingStep();
  EXPECT_EQ(error.code, SimulationErrorCode::LimitExceeded);
  EXPECT_EQ(error.location.line, 4U);
  EXPECT_NE(error.message.find("a loop ran more than 1000 iterations (limit loopIterations). The simulation stays "
                               "at step 0."),
            std::string::npos)
      << error.message;
}

TEST(Evaluator, StopsBinomialDrawsAtTheLimit) {
  derivation::DerivationOptions options;
  options.limits.maximumLoopIterations = 1000;
  DerivedModel model(modelText("", "A", "A --> B(biran(2000,0.5))\n"), options);
  const core::SimulationError error = model.failingStep();
  EXPECT_EQ(error.code, SimulationErrorCode::LimitExceeded);
  EXPECT_NE(error.message.find("biran would draw more than 1000 numbers (limit loopIterations)"), std::string::npos)
      << error.message;
}

TEST(Evaluator, PrintsToTheMessageSink) {
  DerivedModel model(modelText("Start: {printf(\"n is %g of %d%%\\n\", 2.5, 40);}\n", "A", "A --> A\n"));
  EXPECT_EQ(model.printed(), "n is 2.5 of 40%\n");
}

TEST(Evaluator, FilesThatCannotBeUsedAreWarnedAbout) {
  DerivedModel model(
      modelText("Start: {f=fopen(\"data.txt\",\"r\"); fprintf(f,\"%g\",1); x=7; n=fscanf(f,\"%g\",&x); fclose(f);\n"
                "g=fopen(\"model.l\",\"r\"); fprintf(g,\"x\");}\n",
                "A(f,n,x,g)", "A --> A\n"));
  EXPECT_EQ(model.text(), "A(0,-1,7,1)");
  ASSERT_EQ(model.warnings().size(), 5U);
  const std::vector<std::string> expected = {
      "model.l:3:11: warning: fopen(\"data.txt\", \"r\") gives 0: there is no such file in the model's folder",
      "fprintf: the variable holds no open file; nothing is written",
      "fscanf: the variable holds no file that is open for reading; nothing is read",
      "fclose: the variable holds no open file", "fprintf: the file was opened for reading; nothing is written"};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NE(model.warnings()[i].find(expected[i]), std::string::npos) << model.warnings()[i];
  }
}

TEST(Evaluator, ReadsNumbersFromAFileOfTheModel) {
  // the model's own text is one: "Lsystem: 1"
  DerivedModel model(modelText("Start: {f=fopen(\"model.l\",\"r\"); n=fscanf(f,\"Lsystem: %d\",&x); fclose(f);}\n",
                               "A(n,x)", "A --> A\n"));
  EXPECT_EQ(model.text(), "A(1,1)");
}

TEST(Evaluator, AFileThatGrowsWithoutEndIsALimit) {
  derivation::DerivationOptions options;
  options.canWriteFiles = true;
  options.limits.maximumFileBytes = 1000;
  DerivedModel model(
      modelText("Start: {f=fopen(\"out\",\"w\");}\nStartEach: {while (1) {fprintf(f,\"0123456789\");}}\n", "A",
                "A --> A\n"),
      options);
  const core::SimulationError error = model.failingStep();
  EXPECT_EQ(error.code, SimulationErrorCode::LimitExceeded);
  EXPECT_NE(error.message.find("(model.l:4:24): a file is longer than 1000 bytes in one step (limit fileBytes)"),
            std::string::npos)
      << error.message;
}

TEST(Evaluator, WarnsAboutFunctionsThatTheViewFileDoesNotDefine) {
  DerivedModel model(modelText("", "A", "A --> B(func(1,0.5),curveX(1,0.5),inblob(1,0,0,0))\n"));
  EXPECT_EQ(model.steps(1), "B(0,0,0)");
  ASSERT_EQ(model.warnings().size(), 3U);
  EXPECT_NE(model.warnings()[0].find("func: the view file defines no such function; its value is 0"),
            std::string::npos);
  EXPECT_NE(model.warnings()[1].find("curve functions: the view file defines no such curve; the value is 0"),
            std::string::npos);
  EXPECT_NE(model.warnings()[2].find("inblob: the view file defines no such field; its value is 0"), std::string::npos);
}

TEST(Evaluator, TheViewVolumeIsTheBoxOfTheViewFileNarrowedByTheScaleFactor) {
  const std::string text =
      modelText("", "A", "A --> A(vvXmin(0),vvXmax(0),vvYmin(0),vvYmax(0),vvZmin(0),vvZmax(0),vvScale(0))\n");
  DerivedModel boxed(text, {}, Compatibility::Espalier, "box: x: -1,3 y: 0,2 z: -5,5\nscale factor: 2\n");
  EXPECT_EQ(boxed.steps(1), "A(0,2,0.5,1.5,-5,5,2)");
  // without a box it is what the caller measured, 0 before that
  DerivedModel measured(text);
  measured.state().viewVolume = {{-1.0, 0.0, 2.0}, {1.0, 4.0, 3.0}};
  EXPECT_EQ(measured.steps(1), "A(-1,1,0,4,2,3,1)");
}

TEST(Evaluator, StopEndsTheDerivationButStopOneDoesNot) {
  DerivedModel stops(modelText("EndEach: {stop(2);}\nEnd: {printf(\"end\");}\n", "A", "A --> A\n"));
  stops.steps(1);
  EXPECT_TRUE(stops.state().isStopped);
  EXPECT_EQ(stops.printed(), "end");
  DerivedModel continues(modelText("EndEach: {stop(1);}\n", "A", "A --> A\n"));
  continues.steps(1);
  EXPECT_FALSE(continues.state().isStopped);
}

TEST(Evaluator, SetDerivationLengthChangesZ) {
  EXPECT_EQ(
      derive(modelText("Start: {SetDerivationLength(7);}\n", "A(Z)", "A(z) --> A(GetDerivationLength(0)+Z)\n"), 1),
      "A(14)");
}

TEST(Evaluator, CountsStepsInQ) {
  EXPECT_EQ(derive(modelText("", "A(Q,Z)", "A(q,z) --> A(Q,Z)\n"), 3), "A(3,100)");
}

}  // namespace
}  // namespace espalier::evaluator_test
