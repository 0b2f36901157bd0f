#include "engine/derivation/batch/column_evaluator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include "engine/derivation/batch/column_plan.h"
#include "engine/derivation/expressions/evaluator.h"
#include "engine/derivation/expressions/random_source.h"
#include "engine/derivation/system_tables.h"
#include "tests/support/derived_model.h"

namespace espalier::column_evaluator_test {
namespace {

using derivation::ColumnCode;
using derivation::ColumnCompiler;
using derivation::ColumnEvaluator;
using derivation::ColumnValue;
using derivation::SlotSource;
using test::DerivedModel;
using test::modelText;

constexpr double kStep = 3.0;

/// An expression over x and y for a few values of both, by columns and one by one.
class Compared {
 public:
  explicit Compared(const std::string& expression)
      : model_(modelText("Define: { array w[3]={2,4,6}; array g[2][3]={10,11,12,20,21,22}; }\n", "A(1,2)",
                         "A(x,y) --> A(" + expression + ",0)\n")),
        expression_(model_.program().systems[0].productions.productions[0].expressions[0]) {}

  [[nodiscard]] const language::Expression& expression() const { return expression_; }
  [[nodiscard]] bool isUnusual() const { return isUnusual_; }

  void expectEqual(bool hasWarned = false) {
    const std::vector<double> numbers{-2.5, -1.0, 0.0, 0.5, 1.0, 3.0, 1e10};
    std::vector<double> parameters;
    for (const double x : numbers) {
      for (const double y : numbers) {
        parameters.insert(parameters.end(), {x, y});
      }
    }
    std::vector<std::uint32_t> own(parameters.size() / 2);
    for (std::size_t i = 0; i < own.size(); ++i) {
      own[i] = static_cast<std::uint32_t>(2 * i);
    }
    const language::Program& program = model_.program();
    const ColumnCode column =
        ColumnCompiler(program, program.systems[0].productions.productions[0]).expression(expression_, false).value();
    ColumnEvaluator columns(program, 2, column.columnCount);
    const std::vector<std::uint8_t> warned(program.code.size(), hasWarned ? 1 : 0);
    derivation::ColumnInputs inputs;
    inputs.step = kStep;
    inputs.length = static_cast<double>(model_.state().derivationLength);
    inputs.hasWarned = warned.data();
    inputs.elements = model_.state().instances.front().elements.data();
    columns.begin(inputs);
    std::vector<std::uint32_t> sites(own.size());
    std::iota(sites.begin(), sites.end(), 0U);
    const std::vector<SlotSource> slots{{SlotSource::Kind::Own, 0}, {SlotSource::Kind::Own, 1}};
    columns.setLanes(
        {own.size(), slots.data(), parameters.data(), nullptr, nullptr, sites.data(), own.data(), nullptr, nullptr});
    const ColumnValue made = columns.value(column);
    isUnusual_ = columns.isUnusual();

    derivation::RandomSource random(core::Compatibility::Espalier, 0);
    derivation::Evaluator evaluator(program, random, {});
    derivation::PlantState state = model_.state();
    evaluator.attach(state);
    evaluator.enter(state.instances.front());
    evaluator.setStep(static_cast<std::uint64_t>(kStep), 0);
    for (std::size_t i = 0; i < own.size(); ++i) {
      std::vector<double> frame{parameters[2 * i], parameters[2 * i + 1], 0.0};
      const double expected = evaluator.value(expression_, frame.data());
      const double value = made.values == nullptr ? made.constant : made.values[i];
      EXPECT_TRUE(value == expected || (std::isnan(value) && std::isnan(expected)))
          << "x " << frame[0] << " y " << frame[1] << ": " << value << " instead of " << expected;
      EXPECT_EQ(std::signbit(value), std::signbit(expected));
    }
  }

 private:
  DerivedModel model_;
  const language::Expression& expression_;
  bool isUnusual_ = false;
};

TEST(ColumnEvaluator, GivesWhatTheEvaluatorGives) {
  for (const char* text : {"x",
                           "7",
                           "Q",
                           "Z",
                           "Q+Z*x",
                           "x+y",
                           "x-2",
                           "2-x",
                           "x*y",
                           "x*0.5+y*0.5",
                           "x/4",
                           "4/(x*x+1)",
                           "x/(y*y+1)",
                           "x<y",
                           "x<=y",
                           "x>y",
                           "x>=1",
                           "x==y",
                           "x!=y",
                           "x&&y",
                           "x||y",
                           "!x",
                           "-x",
                           "-(x+y)*2",
                           "x>1 ? y : x",
                           "x^2",
                           "x%3",
                           "sqrt(x*x)",
                           "sin(x)+cos(y)",
                           "max(x,y)-min(x,1)",
                           "clamp(x,0,y*y)",
                           "atan2(x,y)",
                           "hypot(x,y)",
                           "floor(x/2)",
                           "log(x)",
                           "(x+1)*(y+1)-(x-1)*(y-1)",
                           "x>0 && log(x)>0",
                           "x<0 || sqrt(x)<1",
                           "x>0 ? log(x) : exp(y)",
                           "x%(y>=1 ? y : 2)",
                           "w[Q%3]",
                           "w[1]*x",
                           "w[clamp(x,0-0.9,2.9)]",
                           "g[y>0][clamp(x,0,2)]",
                           "x>=0 && x<3 ? w[x] : y"}) {
    SCOPED_TRACE(text);
    Compared compared(text);
    compared.expectEqual();
    EXPECT_FALSE(compared.isUnusual());
  }
}

TEST(ColumnEvaluator, DivisionsByZeroAreNotedUntilTheyHaveWarned) {
  for (const char* text : {"x/y", "x%y", "mod(x,y)", "x>0 && x/y>1"}) {
    SCOPED_TRACE(text);
    Compared compared(text);
    compared.expectEqual();
    EXPECT_TRUE(compared.isUnusual());
    compared.expectEqual(true);
    EXPECT_FALSE(compared.isUnusual());
  }
}

TEST(ColumnEvaluator, SubscriptsOutsideAreNotedUntilTheyHaveWarned) {
  for (const char* text : {"w[x]", "g[x][1]", "g[1][y]", "w[log(x)]", "x<100 && w[x]>1"}) {
    SCOPED_TRACE(text);
    Compared compared(text);
    compared.expectEqual();
    EXPECT_TRUE(compared.isUnusual());
    compared.expectEqual(true);
    EXPECT_FALSE(compared.isUnusual());
  }
}

TEST(ColumnEvaluator, WhatIsNotEvaluatedDoesNotDivide) {
  Compared compared("y!=0 && x/y>1");
  compared.expectEqual();
  EXPECT_FALSE(compared.isUnusual());
}

/// Why a batch cannot run the parameter of a production; empty when it can.
std::string problemOf(const std::string& production) {
  const DerivedModel model(modelText("", "A(1)", production));
  const language::Production& first = model.program().systems[0].productions.productions[0];
  ColumnCompiler columns(model.program(), first);
  const bool isDone = columns.block(first.preBlock, true) && columns.block(first.postBlock, false) &&
                      columns.expression(first.expressions[0], true);
  return isDone ? "" : columns.problem();
}

TEST(ColumnCompiler, TakesCodeThatDependsOnTheModuleAlone) {
  EXPECT_EQ(problemOf("A(x) --> A(sqrt(x)+1)\n"), "");
  EXPECT_EQ(problemOf("A(x) --> A(func(1,x)+ran(x))\n"), "");
  EXPECT_EQ(problemOf("A(x) --> A(x>1 ? nran(x,ran(2)) : bran(x,1))\n"), "");
  EXPECT_EQ(problemOf("A(x) : {u=x; if (u>1) {u=u-1;}} 1 {v=u*u;} --> A(u+v)\n"), "");
  EXPECT_EQ(problemOf("A(x) : {u=ran(x); x=u;} 1 {if (x>1) {x=0;}} --> A(x)\n"), "");
  EXPECT_EQ(problemOf("A(x) : {u=0; while (u<x) {u=u+1;}} 1 --> A(u)\n"), "");
  EXPECT_EQ(problemOf("A(x) : {if (x>1) {u=1;} else {u=2;}} 1 --> A(u)\n"), "");
}

TEST(ColumnCompiler, NamesWhatABatchCannotRun) {
  EXPECT_EQ(problemOf("A(x) --> A(biran(x,0.5))\n"), "it calls a function that draws or has an effect");
  EXPECT_EQ(problemOf("A(x) : 1 {u=ran(x);} --> A(u)\n"), "it calls a function that draws or has an effect");
  EXPECT_EQ(problemOf("A(x) : {u=u+1;} 1 --> A(u)\n"),
            "it reads a local variable that the module before may have left");
  EXPECT_EQ(problemOf("A(x) : {if (x>1) {u=1;}} 1 --> A(u)\n"),
            "it reads a local variable that the module before may have left");
  EXPECT_EQ(problemOf("A(x) : {printf(\"%f\", x);} 1 --> A(x)\n"), "it prints, or uses files");
}

}  // namespace
}  // namespace espalier::column_evaluator_test
