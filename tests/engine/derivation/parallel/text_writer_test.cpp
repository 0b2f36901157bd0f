#include "engine/derivation/parallel/text_writer.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

#include "engine/derivation/state/string_text.h"
#include "tests/support/derived_model.h"

namespace espalier::text_writer_test {
namespace {

using test::DerivedModel;
using test::modelText;

// one module after the other, each number by itself
std::string plainText(const DerivedModel& model, const derivation::ModuleString& string, core::NumberStyle style) {
  const language::Program& program = model.program();
  std::string text;
  std::size_t offset = 0;
  for (const core::ModuleTypeId type : string.types()) {
    text += program.nameOf(type);
    const std::size_t arity = program.arity[type];
    for (std::size_t i = 0; i < arity; ++i) {
      text += i == 0 ? '(' : ',';
      core::appendNumber(text, string.parameters()[offset + i], style);
    }
    text += arity > 0 ? ")" : "";
    offset += arity;
  }
  return text;
}

// the text of a plant of several pieces, by several numbers of threads and in both styles
void expectPlainText(DerivedModel& plant) {
  const derivation::ModuleString& string = plant.state().string;
  ASSERT_GT(string.size(), 100'000U);
  for (const core::NumberStyle style : {core::NumberStyle::Shortest, core::NumberStyle::PercentG}) {
    const std::string expected = plainText(plant, string, style);
    EXPECT_TRUE(derivation::toText(plant.program(), string, style) == expected);
    for (const unsigned threads : {1U, 2U, 3U, 5U}) {
      derivation::TextWriter writer(threads);
      core::StringSink sink;
      writer.write(sink, plant.program(), string, style);
      writer.write(sink, plant.program(), {}, style);
      writer.write(sink, plant.program(), string, style);
      EXPECT_TRUE(sink.text() == expected + expected) << threads;
    }
  }
}

TEST(TextWriter, AnyNumberOfThreadsWritesOneTextOfModulesWithParameters) {
  DerivedModel plant(modelText(
      "", "A(1,1/3)B", "A(x,y) --> A(x+1,y*1.5)[-(30)C(x,y,1/x)B]A(-x,y/7)\nB --> BBD(1)\nD(x) --> D(x*1.0e+20)\n"));
  plant.steps(14);
  expectPlainText(plant);
}

TEST(TextWriter, AnyNumberOfThreadsWritesOneTextOfModulesWithoutParameters) {
  DerivedModel plant(modelText("", "F", "F --> F[+F]F\n"));
  plant.steps(10);
  expectPlainText(plant);
}

TEST(TextWriter, ManyTypesAndOddNumbersOfModulesAreWritten) {
  // more types than there are pairs in a table, and strings of odd and even length
  std::string letters;
  for (char letter = 'a'; letter <= 'z'; ++letter) {
    letters += {letter, static_cast<char>(letter - 'a' + 'A')};
  }
  DerivedModel many(modelText("", "F" + letters, "F --> F[+F]F" + letters + "-&^/|!.{}\nA --> AA\n"));
  ASSERT_GT(many.program().arity.size(), 63U);
  many.steps(8);
  expectPlainText(many);
  DerivedModel few(modelText("", "AB", "B --> BAB\n"));
  for (int step = 0; step < 6; ++step) {
    const derivation::ModuleString& string = few.state().string;
    EXPECT_EQ(derivation::toText(few.program(), string, core::NumberStyle::Shortest),
              plainText(few, string, core::NumberStyle::Shortest));
    few.steps(1);
  }
}

TEST(TextWriter, NamesMayBeOfAnyLength) {
  const std::string fifteen(15, 'p');
  const std::string sixteen(16, 'q');
  const std::string forty(40, 'r');
  const std::string four = fifteen + "(x)" + sixteen + "(x,0.5)" + forty + "(1/x)";
  DerivedModel plant(
      modelText("Module: Apex, " + fifteen + "(a), " + sixteen + "(a,b), " + forty + "(a), s" + forty + "\n",
                "Apex s" + forty, "Apex --> Apex F Apex B(3)\nB(x) --> B(x/3)" + four + "\n"));
  plant.steps(15);
  expectPlainText(plant);
}

TEST(TextWriter, AFailureOfTheSinkEndsAllThreads) {
  class FailingSink final : public core::ByteSink {
   public:
    void write(std::string_view /*bytes*/) override {
      if (++pieces_ == 3) {
        throw std::runtime_error("full");
      }
    }

   private:
    int pieces_ = 0;
  };
  DerivedModel plant(modelText("", "F", "F --> F[+F]F\n"));
  plant.steps(10);
  for (const unsigned threads : {1U, 4U}) {
    FailingSink sink;
    derivation::TextWriter writer(threads);
    EXPECT_THROW(writer.write(sink, plant.program(), plant.state().string, core::NumberStyle::Shortest),
                 std::runtime_error);
  }
}

}  // namespace
}  // namespace espalier::text_writer_test
