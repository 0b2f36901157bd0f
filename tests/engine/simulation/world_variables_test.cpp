#include "engine/simulation/plants/world_variables.h"

#include "engine/turtle/weather.h"
#include "tests/engine/simulation/crafted_snapshot.h"
#include "tests/engine/simulation/simulation_fixture.h"

namespace espalier::simulation::world_variables_test {
namespace {

SimulationOptions inWeather(const std::string& table) {
  SimulationOptions options;
  options.world.stepDurationDays = 0.5;
  options.world.baseTemperature = 10;
  options.world.weather = std::make_shared<const turtle::Weather>(*turtle::Weather::read(table, ""));
  return options;
}

constexpr const char* kReading = R"(Lsystem: 1
derivation length: 3
Axiom: A(0,0,0)
A(t,s,n) --> A(world.temperature, world.thermalTime, world.time)
endlsystem
)";

TEST(WorldVariables, AreTheWeatherOfTheStep) {
  TestRun run(compileText(kReading), 1, inWeather("time,temperature\n0,12\n1,30\n2,2\n"), false);
  expectSuccess(run.simulation.rewind());
  std::vector<std::string> strings;
  for (int i = 0; i < 4; ++i) {
    expectSuccess(run.simulation.step());
    strings.push_back(run.simulation.stringText());
  }
  // means over half days; thermal time above 10 °C up to the beginning of the step
  EXPECT_EQ(strings, (std::vector<std::string>{"A(12,0,0)", "A(12,1,0.5)", "A(30,2,1)", "A(30,12,1.5)"}));
}

TEST(WorldVariables, ThermalTimeReachesAThresholdInItsStep) {
  // 24 °C above the base: a degree day an hour, so the bud of threshold n opens in the step that begins after n hours
  constexpr int kSteps = 40;
  std::string table = "time,temperature\n";
  for (int hour = 0; hour <= kSteps; ++hour) {
    const int ofDay = (5 + hour) % 24;
    table += "2026-06-" + std::to_string(20 + (5 + hour) / 24) + "T" + (ofDay < 10 ? "0" : "") + std::to_string(ofDay) +
             ":00Z,34.0\n";
  }
  SimulationOptions options;
  options.world.stepDurationDays = 1.0 / 24;
  options.world.baseTemperature = 10;
  options.world.start = "2026-06-20T05:00Z";
  options.world.weather = std::make_shared<const turtle::Weather>(*turtle::Weather::read(table, options.world.start));
  TestRun run(compileText(R"(Lsystem: 1
derivation length: 40
Axiom: A(1)
A(n) : world.thermalTime >= n --> B(n,world.thermalTime)A(n+1)
endlsystem
)"),
              1, options, false);
  expectSuccess(run.simulation.rewind());
  std::string buds;
  for (int step = 0; step < kSteps; ++step) {
    expectSuccess(run.simulation.step());
    buds += step == 0 ? "" : "B(" + std::to_string(step) + "," + std::to_string(step) + ")";
    EXPECT_EQ(run.simulation.stringText(), buds + "A(" + std::to_string(step + 1) + ")");
  }
}

TEST(WorldVariables, GoOnFromASnapshotAndAfterARewind) {
  const auto program = compileText(kReading);
  TestRun run(program, 1, inWeather("time,temperature\n0,12\n1,30\n2,2\n"), false);
  expectSuccess(run.simulation.rewind());
  expectSuccess(run.simulation.step());
  const std::string snapshot = snapshotOf(run.simulation);
  TestRun restored(program, 1, {}, false);
  expectSuccess(restored.simulation.restore(snapshot));
  EXPECT_EQ(restored.simulation.stateHash(), run.simulation.stateHash());
  expectSuccess(restored.simulation.step());
  EXPECT_EQ(restored.simulation.stringText(), "A(12,1,0.5)");
  expectSuccess(run.simulation.rewind());
  expectSuccess(run.simulation.step());
  EXPECT_EQ(run.simulation.stringText(), "A(12,0,0)");
}

TEST(WorldVariables, AreTheSameInEveryBlockAndSubLSystem) {
  const auto program = compileText(R"(Lsystem: 1
derivation length: 2
StartEach: { warm = world.temperature; }
Axiom: A(0)?(2,1)B(0)$
A(x) --> A(warm)
endlsystem
Lsystem: 2
Axiom: B(0)
B(x) --> B(world.temperature)
endlsystem
)");
  TestRun run(program, 1, inWeather("time,temperature\n0,12\n0.5,30\n"), false);
  expectSuccess(run.simulation.rewind());
  expectSuccess(run.simulation.step());
  EXPECT_EQ(run.simulation.stringText(), "A(12)?(2,1)B(12)$");
  expectSuccess(run.simulation.step());
  EXPECT_EQ(run.simulation.stringText(), "A(30)?(2,1)B(30)$");
}

TEST(WorldVariables, WeatherThatIsNotThereFailsTheStep) {
  TestRun none(compileText(kReading), 1, {}, false);
  expectSuccess(none.simulation.rewind());
  EXPECT_EQ(none.simulation.step()->message.substr(0, 123),
            "step 1: the model reads 'world.temperature' and needs the weather's 'temperature', and the world has no "
            "'weather'. Give the");
  TestRun brief(compileText(kReading), 1, inWeather("time,temperature\n0,12\n0.5,30\n"), false);
  expectSuccess(brief.simulation.rewind());
  expectSuccess(brief.simulation.step());
  expectSuccess(brief.simulation.step());
  const std::uint64_t hash = brief.simulation.stateHash();
  EXPECT_EQ(brief.simulation.step()->message,
            "step 3: the model reads 'world.temperature' and needs the weather from day 1 to day 1.5, and the table "
            "covers the time from day 0 to day 1 after the start. Add rows to the table, or make fewer steps. The "
            "simulation stays at step 2.");
  EXPECT_EQ(brief.simulation.stateHash(), hash);
}

std::vector<std::string> errorsOf(const std::string& model, core::Compatibility mode = core::Compatibility::Espalier) {
  core::MemoryFileProvider files;
  files.add("model.l", model);
  language::CompileInput input;
  input.modelFile = "model.l";
  input.compatibility = mode;
  std::vector<std::string> errors;
  const language::CompileResult compiled = language::compile(input, files);
  for (const core::Diagnostic& diagnostic : compiled.diagnostics.entries()) {
    if (diagnostic.severity == core::Severity::Error) {
      errors.push_back(diagnostic.message + " / " + diagnostic.hint);
    }
  }
  return errors;
}

TEST(WorldVariables, WrongNamesAndPlacesAreErrors) {
  const std::string head = "Lsystem: 1\nderivation length: 1\n";
  EXPECT_EQ(
      errorsOf(head + "Axiom: A(0)\nA(x) --> A(world.temperatur)\nendlsystem\n").front(),
      "the world has no 'temperatur' / did you mean 'world.temperature'? There are time, thermalTime, temperature, "
      "humidity, wind, rain, co2, global, direct, diffuse");
  EXPECT_EQ(
      errorsOf(head + "Axiom: A(world.wind)\nA(x) --> A(x)\nendlsystem\n").front(),
      "'world.wind' has no value yet in the axiom / read it in a production or in StartEach: the weather is that of "
      "a step");
  EXPECT_EQ(errorsOf(head + "StartEach: { world.wind = 3; }\nAxiom: A(0)\nA(x) --> A(x)\nendlsystem\n").front(),
            "'world.wind' cannot be assigned: it comes from the world / give the variable another name");
  EXPECT_EQ(errorsOf(head + "Axiom: A(0)\nA(x) --> A(world.wind)\nendlsystem\n", core::Compatibility::Cpfg).front(),
            "'world.wind' is a name of Espalier's own mode / leave out --compat, or use a #define");
}

}  // namespace
}  // namespace espalier::simulation::world_variables_test
