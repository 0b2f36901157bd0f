// The text that models write to files, and when it is passed on.

#include <map>

#include "tests/engine/simulation/simulation_fixture.h"

namespace espalier::simulation::model_output_test {
namespace {

constexpr const char* kWritingModel =
    "Lsystem: 1\nderivation length: 9\nStart: {f = fopen(\"out.txt\", \"w\"); fprintf(f, \"start\\n\");}\n"
    "EndEach: {fprintf(f, \"step %g\\n\", Q);}\n"
    "Axiom: A(1)\nA(n) : {fprintf(f, \"A(%g)\\n\", n);} 1 --> A(12 / (4 - n) / 4)\nendlsystem\n";

/// Keeps the files in memory; refuses the writes that it is told to.
class MemoryWriter final : public core::FileWriter {
 public:
  std::optional<std::string> write(const std::string& name, bool replaces, std::string_view bytes) override {
    if (refusals > 0) {
      --refusals;
      return "there is no room for '" + name + "'.";
    }
    std::string& content = contents[name];
    content = (replaces ? std::string() : content) + std::string(bytes);
    ++writeCount;
    return std::nullopt;
  }
  std::map<std::string, std::string> contents;
  int refusals = 0;
  int writeCount = 0;
};

struct WritingRun {
  explicit WritingRun(const std::string& model, std::size_t plantCount = 1)
      : simulation(compileText(model), std::vector<turtle::PlantPlacement>(plantCount), nullptr, options(writer)) {}
  static SimulationOptions options(std::shared_ptr<MemoryWriter> writer) {
    SimulationOptions result;
    result.fileWriter = std::move(writer);
    return result;
  }
  std::shared_ptr<MemoryWriter> writer = std::make_shared<MemoryWriter>();
  Simulation simulation;
};

TEST(ModelOutput, IsPassedOnWhenAStepIsComplete) {
  WritingRun run(kWritingModel);
  expectSuccess(run.simulation.rewind());
  EXPECT_EQ(run.writer->contents["out.txt"], "start\n");
  expectSuccess(run.simulation.step());
  EXPECT_EQ(run.writer->contents["out.txt"], "start\nA(1)\nstep 1\n");
  EXPECT_EQ(run.writer->writeCount, 2);
  // starting again makes a new file
  expectSuccess(run.simulation.rewind());
  EXPECT_EQ(run.writer->contents["out.txt"], "start\n");
}

TEST(ModelOutput, OfAStepThatFailsIsNotWritten) {
  // the module becomes 1, then 12 / 3 / 4 = 1 for ever; with 4 the next parameter is infinite after fprintf has run
  std::string model = kWritingModel;
  model.replace(model.find("Axiom: A(1)"), 11, "Axiom: A(4.0e300)");
  model.replace(model.find("12 / (4 - n) / 4"), 16, "n * n");
  WritingRun run(model);
  expectSuccess(run.simulation.rewind());
  const std::optional<core::SimulationError> error = run.simulation.step();
  ASSERT_TRUE(error);
  EXPECT_EQ(error->code, core::SimulationErrorCode::NonFinite);
  EXPECT_EQ(run.writer->contents["out.txt"], "start\n");
}

TEST(ModelOutput, ThatCannotBeWrittenFailsTheStepWhichCanBeTriedAgain) {
  WritingRun run(kWritingModel);
  expectSuccess(run.simulation.rewind());
  const std::uint64_t before = run.simulation.stateHash();
  run.writer->refusals = 1;
  const std::optional<core::SimulationError> error = run.simulation.step();
  ASSERT_TRUE(error);
  EXPECT_EQ(error->message, "step 1, plant 0: there is no room for 'out.txt'. The simulation stays at step 0.");
  EXPECT_EQ(run.simulation.stateHash(), before);
  expectSuccess(run.simulation.step());
  EXPECT_EQ(run.writer->contents["out.txt"], "start\nA(1)\nstep 1\n");
}

TEST(ModelOutput, OfEveryPlantHasItsOwnFile) {
  WritingRun run(kWritingModel, 3);
  expectSuccess(run.simulation.rewind());
  expectSuccess(run.simulation.step());
  ASSERT_EQ(run.writer->contents.size(), 3U);
  for (const char* name : {"out.txt", "out.1.txt", "out.2.txt"}) {
    EXPECT_EQ(run.writer->contents[name], "start\nA(1)\nstep 1\n") << name;
  }
}

TEST(ModelOutput, IsNotMadeByPictures) {
  WritingRun run(
      "Lsystem: 1\nderivation length: 9\nStart: {f = fopen(\"out.txt\", \"w\");}\nAxiom: A\nA --> A\n"
      "homomorphism\nA : {fprintf(f, \"drawn\\n\");} 1 --> F\nendlsystem\n");
  expectSuccess(run.simulation.rewind());
  EXPECT_TRUE(run.simulation.scene().has_value());
  expectSuccess(run.simulation.step());
  EXPECT_EQ(run.writer->contents["out.txt"], "");
}

TEST(ModelOutput, WithoutAWriterIsRefusedWithAWarning) {
  std::vector<std::string> warnings;
  SimulationOptions options;
  options.messages = [&](core::MessageKind, std::string_view text) { warnings.emplace_back(text); };
  Simulation simulation(compileText(kWritingModel), {turtle::PlantPlacement{}}, nullptr, std::move(options));
  expectSuccess(simulation.rewind());
  ASSERT_EQ(warnings.size(), 2U);
  EXPECT_NE(warnings[0].find("model.l:3:13: warning: fopen(\"out.txt\", \"w\") gives 0: models write no files here"),
            std::string::npos)
      << warnings[0];
  EXPECT_NE(warnings[1].find("fprintf: the variable holds no open file; nothing is written"), std::string::npos)
      << warnings[1];
}

TEST(ModelOutput, GoesOnFromASnapshot) {
  const std::string model =
      "Lsystem: 1\nderivation length: 9\nStart: {f = fopen(\"log.txt\", \"w+\"); fprintf(f, \"10 20 30 40 50\");}\n"
      "Axiom: A(0)\nA(n) : 1 {fscanf(f, \"%g\", &x);} --> A(x)\nendlsystem\n";
  // reading from where writing ended finds nothing: the model reads through a second handle
  std::string reading = model;
  reading.replace(reading.find("20 30 40 50\");}"), 15, "20 30 40 50\"); f = fopen(\"log.txt\", \"r\");}");
  WritingRun run(reading);
  expectSuccess(run.simulation.rewind());
  expectSuccess(run.simulation.step());
  EXPECT_EQ(run.simulation.stringText(), "A(10)");
  core::StringSink sink;
  run.simulation.save(sink);

  WritingRun other(reading);
  expectSuccess(other.simulation.restore(sink.text()));
  EXPECT_EQ(other.simulation.stateHash(), run.simulation.stateHash());
  expectSuccess(other.simulation.step());
  EXPECT_EQ(other.simulation.stringText(), "A(20)");
}

}  // namespace
}  // namespace espalier::simulation::model_output_test
