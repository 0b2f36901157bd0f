// The program from the shell: what it prints where, its messages, its exit status.

#include <gtest/gtest.h>

#include <filesystem>
#include <regex>

#include "tests/clients/program_run.h"
#include "tests/support/places.h"

namespace espalier::test::cli_test {
namespace {

constexpr const char* kAlgae = "Lsystem: 1\nderivation length: 3\nAxiom: A\nA --> AB\nB --> A\nendlsystem\n";
constexpr const char* kPrinting =
    "Lsystem: 1\nderivation length: 2\nEndEach: {printf(\"step %g\\n\",Q);}\nAxiom: A\nA --> AA\nendlsystem\n";
constexpr const char* kStochastic =
    "Lsystem: 1\nderivation length: 8\nAxiom: A\nA --> AA : 1\nA --> AB : 1\nendlsystem\n";

class Cli : public testing::Test {
 protected:
  ProgramRun run(const std::string& arguments) const { return runProgram(arguments, folder_.path()); }

  TemporaryFolder folder_;
};

TEST_F(Cli, DerivePrintsTheLastString) {
  folder_.write("algae.l", kAlgae);
  const ProgramRun result = run("derive algae.l");
  EXPECT_EQ(result.output, "ABAAB\n");
  EXPECT_EQ(result.errors, "");
  EXPECT_EQ(result.status, 0);
}

TEST_F(Cli, DeriveEveryPrintsAllSteps) {
  folder_.write("algae.l", kAlgae);
  EXPECT_EQ(run("derive algae.l --every").output, "0\tA\n1\tAB\n2\tABA\n3\tABAAB\n");
  EXPECT_EQ(run("derive algae.l --every --steps 1").output, "0\tA\n1\tAB\n");
}

TEST_F(Cli, DeriveAnsweredPrintsTheStringsThatTheStepsReadFrom) {
  folder_.write("up.l", kHeight);
  // F goes up by 1 a step; the query after F^k stands at height k, and the last string is never answered
  EXPECT_EQ(run("derive up.l --every --environment height").output, "0\tA?E(0)\n1\tFA?E(0)\n2\tFFA?E(1)\n3\tFF?E(2)\n");
  EXPECT_EQ(run("derive up.l --every --answered --environment height").output, "0\tA?E(0)\n1\tFA?E(1)\n2\tFFA?E(2)\n");
  const ProgramRun alone = run("derive up.l --answered");
  EXPECT_EQ(alone.status, 2);
  EXPECT_TRUE(contains(alone.errors, "--every")) << alone.errors;
}

TEST_F(Cli, FilesBesideTheModelAreUsedUnlessOptionsSayOtherwise) {
  folder_.write("up.l", kHeight);
  folder_.write("up.e", "executable: height -e up.e\nturtle position: P: %g %g %g\n");
  EXPECT_EQ(run("derive up.l").output, "FF?E(2)\n");
  EXPECT_EQ(run("derive up.l --environment constant").output, "FFFA?E(1)\n");
  EXPECT_EQ(run("derive .").output, "FF?E(2)\n");
}

TEST_F(Cli, ANameThatIsNothingHereIsThatOfAGalleryModel) {
  EXPECT_EQ(run("derive classic-dragon --steps 1").output,
            run("derive '" + sourceFolder() + "/clients/gallery/classic-dragon' --steps 1").output);
  folder_.write("classic-dragon", kAlgae);
  EXPECT_EQ(run("derive classic-dragon").output, "ABAAB\n");
  const ProgramRun unknown = run("derive classic-dragoon");
  EXPECT_EQ(unknown.status, 1);
  EXPECT_TRUE(contains(unknown.errors, "there is no file 'classic-dragoon'")) << unknown.errors;
}

TEST_F(Cli, ModelsWriteIntoTheirFolderAndNowhereElse) {
  std::filesystem::create_directories(folder_.path() + "/plant");
  folder_.write("plant/in.txt", "2 5\n");
  folder_.write(
      "plant/m.l",
      "Lsystem: 1\nderivation length: 2\nStart: {f = fopen(\"in.txt\", \"r\"); fscanf(f, \"%g %g\", &a, &b);\n"
      "\tg = fopen(OUT, \"w\");}\nEndEach: {fprintf(g, \"%g\\n\", Q + b);}\nAxiom: A(a)\nA(n) --> A(n+1)\n"
      "endlsystem\n");
  const ProgramRun result = run("derive plant/m.l --define 'OUT=\"growth.txt\"'");
  EXPECT_EQ(result.output, "A(4)\n");
  EXPECT_EQ(result.errors, "");
  EXPECT_EQ(folder_.read("plant/growth.txt"), "6\n7\n");

  // a link leads out of the folder
  folder_.write("outside", "mine");
  std::filesystem::create_symlink("../outside", folder_.path() + "/plant/link");
  const ProgramRun linked = run("derive plant/m.l --define 'OUT=\"link\"'");
  EXPECT_EQ(linked.status, 1);
  EXPECT_TRUE(contains(linked.errors, "the model cannot write the file 'plant/link': it is a symbolic link"))
      << linked.errors;
  EXPECT_EQ(folder_.read("outside"), "mine");
  const ProgramRun missing = run("derive plant/m.l --define 'OUT=\"none/a\"'");
  EXPECT_TRUE(contains(missing.errors, "there is no folder 'plant/none'; make it")) << missing.errors;

  // an explanation of a step writes nothing
  std::filesystem::remove(folder_.path() + "/plant/growth.txt");
  EXPECT_EQ(run("explain plant/m.l --step 2 --module 0 --define 'OUT=\"growth.txt\"'").status, 0);
  EXPECT_FALSE(std::filesystem::exists(folder_.path() + "/plant/growth.txt"));
}

TEST_F(Cli, LimitsAreOptionsAndErrorsNameThem) {
  folder_.write("grow.l", "Lsystem: 1\nderivation length: 50\nAxiom: A\nA --> AA\nendlsystem\n");
  const ProgramRun grown = run("derive grow.l --limit modules=1000");
  EXPECT_EQ(grown.status, 1);
  EXPECT_TRUE(contains(grown.errors,
                       "the string has more than 1000 modules (limit modules). The simulation stays at step 9. "
                       "(--limit modules=N sets another bound.)"))
      << grown.errors;
  folder_.write("loop.l",
                "Lsystem: 1\nderivation length: 5\nAxiom: AAAAAAAAAAAAAAAA\n"
                "A : {i = 0; while (i < 90000000) {i = i + 1;}} 1 --> A\nendlsystem\n");
  const ProgramRun timed = run("derive loop.l --limit seconds=1");
  EXPECT_EQ(timed.status, 1);
  EXPECT_TRUE(contains(timed.errors,
                       "error: step 1: the run has computed for more than 1 s (--limit seconds=N sets another bound)."))
      << timed.errors;
  const ProgramRun unknown = run("derive grow.l --limit modulse=5");
  EXPECT_EQ(unknown.status, 2);
  EXPECT_TRUE(contains(unknown.errors, "there is no limit 'modulse'. Did you mean 'modules'?")) << unknown.errors;
  EXPECT_TRUE(contains(run("derive grow.l --limit sessions=5").errors,
                       "the limit sessions is a limit of servers, not of a run"));
  EXPECT_TRUE(
      contains(run("derive grow.l --limit seconds=abc").errors, "'seconds=abc' is not a limit; write NAME=NUMBER"));
  EXPECT_TRUE(contains(run("derive grow.l --step-duration '3 parsec'").errors,
                       "--step-duration: '3 parsec' is not a time: give one above 0, such as \"1 h\", \"0.25 d\" or "));
}

TEST_F(Cli, AWarningOfARunIsMarkedOnce) {
  folder_.write("warn.l", "Lsystem: 1\nderivation length: 1\nAxiom: A(0)@Ti\nA(n) --> A(1/n)?P(0)\nendlsystem\n");
  const std::string errors = run("derive warn.l --steps 2").errors;
  EXPECT_TRUE(contains("\n" + errors, "\nwarning: '@Ts', '@Ti' and '@Td' need the number")) << errors;
  EXPECT_TRUE(contains(errors, "warn.l:4:12: warning: division by 0")) << errors;
  EXPECT_FALSE(contains(errors, "warning: warn.l")) << errors;
}

TEST_F(Cli, AnUnknownCommandIsNamedOnce) {
  folder_.write("at.l", "Lsystem: 1\nderivation length: 1\nAxiom: A\nA --> F@z(1)A\nendlsystem\n");
  const std::string errors = run("run at.l -o at.obj").errors;
  const std::size_t first = errors.find("no command '@z'");
  EXPECT_NE(first, std::string::npos) << errors;
  EXPECT_EQ(errors.find("no command '@z'", first + 1), std::string::npos) << errors;
  // the compiler does not see a string from a file
  folder_.write("at.string", "@ F A\n");
  folder_.write("plain.l", "Lsystem: 1\nderivation length: 1\nAxiom: A\nA --> F[A]@M(1,2)\nendlsystem\n");
  EXPECT_TRUE(contains(run("run plain.l --from at.string -o at.obj").errors, "no command '@F'"));
}

TEST_F(Cli, AFileOfNoDialectIsNotConverted) {
  folder_.write("words.txt", "hello world\n");
  const ProgramRun unknown = run("convert words.txt --to cpfg");
  EXPECT_EQ(unknown.status, 1);
  EXPECT_EQ(unknown.output, "");
  EXPECT_TRUE(contains(unknown.errors, "'words.txt' is a model of no dialect that is known")) << unknown.errors;
  // a line of the preprocessor alone makes no model
  folder_.write("notes.txt", "#include \"none.h\"\nhello world\n");
  const ProgramRun notes = run("convert notes.txt --to cpfg");
  EXPECT_EQ(notes.status, 1);
  EXPECT_EQ(notes.output, "");
  EXPECT_TRUE(contains(notes.errors, "notes.txt:1:10: error: cannot read the included file 'none.h'")) << notes.errors;
  const std::string model = "Lsystem: 1\nderivation length: 1\nAxiom: A\nA --> FA\nendlsystem\n";
  folder_.write("own.l", model);
  const ProgramRun own = run("convert own.l --to cpfg");
  EXPECT_EQ(own.status, 0);
  EXPECT_EQ(own.output, model);
  EXPECT_EQ(own.errors, "'own.l' is already a cpfg model: it is written as it is\n");
}

TEST_F(Cli, DefinesWinOverTheModel) {
  folder_.write("n.l", "#define N 1\nLsystem: 1\nderivation length: N\nAxiom: A\nA --> AB\nendlsystem\n");
  EXPECT_EQ(run("derive n.l").output, "AB\n");
  EXPECT_EQ(run("derive n.l --define N=3").output, "ABBB\n");
  EXPECT_EQ(run("derive n.l --define =3").status, 2);
}

TEST_F(Cli, CompatibleModePrintsSixDigits) {
  folder_.write("third.l", "Lsystem: 1\nderivation length: 1\nAxiom: A(1)\nA(x) --> A(x/3)\nendlsystem\n");
  EXPECT_EQ(run("derive third.l").output, "A(0.3333333333333333)\n");
  EXPECT_EQ(run("derive third.l --compat cpfg").output, "A(0.333333)\n");
  EXPECT_EQ(run("derive third.l --compat lpfg").status, 2);
}

TEST_F(Cli, PrintfGoesToStandardError) {
  folder_.write("p.l", kPrinting);
  const ProgramRun result = run("derive p.l");
  EXPECT_EQ(result.output, "AAAA\n");
  EXPECT_EQ(result.errors, "step 1\nstep 2\n");
}

TEST_F(Cli, SeedIsDrawnOnceAndSaid) {
  folder_.write("s.l", kStochastic);
  const ProgramRun first = run("derive s.l");
  std::smatch seed;
  ASSERT_TRUE(std::regex_match(first.errors, seed, std::regex("seed ([0-9]+)\n"))) << first.errors;
  const ProgramRun again = run("derive s.l --seed " + seed[1].str());
  EXPECT_EQ(again.output, first.output);
  EXPECT_EQ(again.errors, "");
  EXPECT_EQ(run("derive s.l --seed 7 --threads 2").output, run("derive s.l --seed 7").output);
  EXPECT_EQ(run("derive s.l --seed 7 --threads 1").output, run("derive s.l --seed 7 --threads 0").output);
  EXPECT_NE(run("derive s.l --seed 7").output, run("derive s.l --seed 8").output);
}

TEST_F(Cli, StatisticsAreOneJsonObjectOnStandardError) {
  folder_.write("up.l", kHeight);
  const ProgramRun result = run("derive up.l --environment height --statistics");
  EXPECT_EQ(result.output, "FF?E(2)\n");
  // two bytes a module and eight a parameter
  EXPECT_TRUE(std::regex_match(result.errors,
                               std::regex(R"(\{"steps":3,"modules":4,"parameters":1,"queries":3,)"
                                          R"("derivationMilliseconds":[0-9.]+,"environmentMilliseconds":[0-9.]+,)"
                                          R"("bytes":16\}\n)")))
      << result.errors;
}

TEST_F(Cli, ErrorsOfAModelAreLocatedAndNothingIsDerived) {
  folder_.write("bad.l", "Lsystem: 1\nderivation length: 1\nAxiom: A(1)\nA(x --> A\nendlsystem\n");
  for (const char* command : {"derive bad.l", "check bad.l"}) {
    const ProgramRun result = run(command);
    EXPECT_EQ(result.status, 1) << command;
    EXPECT_EQ(result.output, "") << command;
    EXPECT_TRUE(contains(result.errors, "bad.l:4:")) << result.errors;
    EXPECT_TRUE(contains(result.errors, "error: ")) << result.errors;
    EXPECT_TRUE(contains(result.errors, "^")) << result.errors;
  }
}

TEST_F(Cli, CheckSaysThatAModelIsRight) {
  folder_.write("algae.l", kAlgae);
  const ProgramRun result = run("check algae.l");
  EXPECT_EQ(result.output, "algae.l: no errors\n");
  EXPECT_EQ(result.status, 0);
}

TEST_F(Cli, AMeshOfPlantsFarFromZeroIsSaidToBeCoarse) {
  const std::string model = "Lsystem: 1\nderivation length: 0\nAxiom: @M(X,0,0)F(1)[+F(2)]F(3)\nendlsystem\n";
  folder_.write("m.l", "#define X 500000\n" + model);
  const std::string errors = run("run m.l -o m.glb -o m.obj -o m.png").errors;
  const std::string sentence = "meshes have single precision: their points lie on steps of 0.03125.";
  EXPECT_EQ(errors.find(sentence), errors.rfind(sentence)) << errors;
  EXPECT_TRUE(contains(errors, sentence)) << errors;
  EXPECT_FALSE(contains(run("run m.l -o m.png -o m.rsml").errors, "single precision"));
  EXPECT_FALSE(contains(run("run m.l --define X=1000 -o m.glb").errors, "single precision"));
}

TEST_F(Cli, CheckTakesSeveralModels) {
  folder_.write("algae.l", kAlgae);
  folder_.write("bad.l", "Lsystem: 1\nAxiom A\nendlsystem\n");
  const ProgramRun result = run("check algae.l bad.l none.l algae.l");
  EXPECT_EQ(result.output, "algae.l: no errors\nalgae.l: no errors\n");
  EXPECT_TRUE(contains(result.errors, "bad.l:2:")) << result.errors;
  EXPECT_TRUE(contains(result.errors, "there is no file 'none.l'")) << result.errors;
  EXPECT_EQ(result.status, 1);
}

TEST_F(Cli, CheckStartsAndConnectsToNoOtherProcess) {
  folder_.write("height.l", kHeight);
  for (const char* environment : {"tcp://127.0.0.1:9", "stdio:touch started"}) {
    const ProgramRun result = run(std::string("check height.l --environment '") + environment + "'");
    EXPECT_EQ(result.output, "height.l: no errors\n");
    EXPECT_EQ(result.errors, "");
    EXPECT_EQ(result.status, 0);
  }
  EXPECT_FALSE(std::filesystem::exists(folder_.path() + "/started"));
}

TEST_F(Cli, WrongOptionsNameThePageThatListsTheRightOnes) {
  const auto error = [&](const std::string& arguments) {
    const ProgramRun result = run(arguments);
    EXPECT_EQ(result.status, 2) << arguments;
    return result.errors;
  };
  EXPECT_EQ(
      error("token new a --role king"),
      "error: --role: king not in {controller,viewer,environment}; `espalier token new --help` lists the options\n");
  EXPECT_EQ(error("connect 127.0.0.1:1 get"),
            "error: SIMULATION is required; `espalier connect ADDRESS get --help` lists the options\n");
  EXPECT_EQ(error("--nonsense"), "error: A subcommand is required; `espalier --help` lists the options\n");
}

TEST_F(Cli, MissingFilesSayWhatToDo) {
  folder_.write("algae.l", kAlgae);
  folder_.write("many/a.l", kAlgae);
  folder_.write("many/b.l", kAlgae);
  folder_.write("none/readme", "");
  const auto error = [&](const std::string& arguments) {
    const ProgramRun result = run(arguments);
    EXPECT_EQ(result.status, 1) << arguments;
    EXPECT_EQ(result.output, "") << arguments;
    return result.errors;
  };
  EXPECT_EQ(error("derive nosuch.l"),
            "error: there is no file 'nosuch.l': give the name of an L-system file (.l) or of its folder\n");
  EXPECT_EQ(error("derive lilax"), "error: there is no file 'lilax'. Did you mean the model 'lilac' of the gallery?\n");
  EXPECT_EQ(error("format lilac"), "error: there is no file 'lilac'. A model of the gallery has this name\n");
  EXPECT_EQ(error("derive many"),
            "error: the folder 'many' holds more than one L-system file (a.l, b.l): give the name of one\n");
  EXPECT_EQ(error("derive none"),
            "error: the folder 'none' holds no L-system file (.l): give another folder, or the file itself\n");
  EXPECT_EQ(error("derive algae.l --view nosuch.v"),
            "error: there is no file 'nosuch.v' (--view): check the name and the working folder\n");
  EXPECT_EQ(error("derive algae.l --environment nosuch.json"),
            "error: there is no environment file 'nosuch.json': check the name and the working folder\n");
  folder_.write("cut.json", "{\"type\": \"height\",\n");
  const std::string cut = error("derive algae.l --environment cut.json");
  EXPECT_EQ(cut.substr(0, cut.find(" JSON")), "cut.json:2:1: error: the environment is not valid") << cut;
  EXPECT_EQ(error("run algae.l -o nosuch/a.svg"),
            "error: cannot write 'nosuch/a.svg': there is no folder 'nosuch'; make it first\n");
  EXPECT_EQ(error("run --resume nosuch.snapshot -o a.svg"),
            "error: there is no snapshot 'nosuch.snapshot' (--resume): check the name and the working folder\n");
}

TEST_F(Cli, AProgramInPlaceOfAnEnvironmentGetsTheSpellingThatStartsIt) {
  folder_.write("up.l", kHeight);
  folder_.write("ceiling.py", "print('never started')\n");
  const auto error = [&](const std::string& environment) {
    const ProgramRun result = run("derive up.l --environment '" + environment + "'");
    EXPECT_EQ(result.status, 1);
    EXPECT_EQ(result.output, "");
    return result.errors;
  };
  const auto expected = [](const std::string& given, const std::string& command) {
    return "error: '" + given +
           "' is a program, not the name of an environment: write --environment 'stdio:" + command +
           "', which starts it\n";
  };
  EXPECT_EQ(error("ceiling.py"), expected("ceiling.py", "python3 ceiling.py"));
  EXPECT_EQ(error("none/ceiling.R"), expected("none/ceiling.R", "Rscript none/ceiling.R"));
  EXPECT_EQ(error("python3 ceiling.py --height 5"),
            expected("python3 ceiling.py --height 5", "python3 ceiling.py --height 5"));
  EXPECT_EQ(error("tcp://127.0.0.1"),
            "error: 'tcp://127.0.0.1' is not an address: write tcp://HOST:PORT, for example tcp://127.0.0.1:4000.\n");
  EXPECT_EQ(error("offered:ceiling"),
            "error: 'offered:ceiling' is offered to a server, which `espalier connect` asks: write tcp://HOST:PORT, "
            "unix:PATH or stdio:COMMAND\n");
  // a published environment file may have any name
  folder_.write("my sky", "executable: height -e up.e\nturtle position: P: %g %g %g\n");
  EXPECT_EQ(run("derive up.l --environment './my sky'").output, "FF?E(2)\n");
}

TEST_F(Cli, UnknownEnvironmentNamesTheNearest) {
  folder_.write("up.l", kHeight);
  const ProgramRun result = run("derive up.l --environment hight");
  EXPECT_EQ(result.status, 1);
  EXPECT_TRUE(contains(result.errors, "environment process 'hight' is unknown. Did you mean 'height'?"))
      << result.errors;
}

TEST_F(Cli, AnEnvironmentAsTextIsSentToAFile) {
  folder_.write("up.l", kHeight);
  const ProgramRun result = run("derive up.l --environment '[{\"type\":\"height\"}]'");
  EXPECT_EQ(result.status, 1);
  EXPECT_TRUE(contains(result.errors, "not JSON text: write the text into a file such as light.json")) << result.errors;
}

TEST_F(Cli, ConfigurationMistakesNameTheFile) {
  folder_.write("up.l", kHeight);
  folder_.write("honda.json", R"({"type":"honda","radios":1})");
  const ProgramRun result = run("derive up.l --environment honda.json");
  EXPECT_EQ(result.status, 1);
  EXPECT_TRUE(contains(result.errors, "honda.json")) << result.errors;
  EXPECT_TRUE(contains(result.errors, "radios")) << result.errors;
}

TEST_F(Cli, MistakesOfAnEnvironmentFileHaveTheirPlaces) {
  folder_.write("up.l", kHeight);
  const auto error = [&](const std::string& json) {
    folder_.write("e.json", json);
    const std::string all = run("derive up.l --environment e.json").errors;
    return all.substr(0, all.find('\n'));
  };
  EXPECT_EQ(error("{\n  \"type\": \"honda\",\n    \"radios\": 1\n}"),
            "error: e.json:3:5: environment process 'honda': unknown key 'radios'");
  EXPECT_EQ(error("[{\"type\": \"height\"},\n {\"type\": \"honda\", \"radius\": \"x\"}]"),
            "error: e.json:2:20: environment process 'honda': 'radius' must be a number, found the text 'x'");
  // of the object, when a member is missing
  EXPECT_EQ(error("[{\"type\": \"height\"},\n {\"radius\": 1}]"), "error: e.json:2:2: environment[1] has no 'type'");
  EXPECT_EQ(error("\n {\"type\": \"tcp\"}"),
            "error: e.json:2:2: the environment 'tcp' needs a member 'address': HOST:PORT");
}

TEST_F(Cli, MistakesOfAWorldAndAForestHaveTheirPlaces) {
  folder_.write("up.l", kHeight);
  const auto error = [&](const std::string& file, const std::string& json, const std::string& arguments) {
    folder_.write(file, json);
    return run(arguments).errors;
  };
  const std::string world = "derive up.l --world w.json";
  EXPECT_EQ(error("w.json", "{\n  \"latitude\": 49, \"start\": \"2020\\\"-01\",\n  \"upp\": [0, 0, 1]\n}\n", world),
            "error: w.json:3:3: upp: this key is not known; did you mean 'up'? There are lengthUnit, up, north, "
            "stepDuration, latitude, longitude, start, baseTemperature, weather\n");
  EXPECT_EQ(error("w.json", "{\"weather\": \"\u017E.csv\", \"up\": \"z\"}", world),
            "error: w.json:1:22: up: expected three numbers such as [0, 0, 1], found \"z\"\n");
  EXPECT_TRUE(
      error("f.json",
            "{\"models\": [{\"name\": \"a\", \"file\": \"up.l\"}],\n \"plants\": [{\"position\": [0, 0, 0]},\n  "
            "{\"positon\": [1, 0, 0]}]}",
            "derive f.json")
          .starts_with("error: f.json:3:4: plants[1].positon: this key is not known; did you mean 'position'?"));
}

TEST_F(Cli, AnEnvironmentThatIsAwayStopsTheRun) {
  folder_.write("up.l", kHeight);
  const ProgramRun result = run("derive up.l --environment tcp://127.0.0.1:1");
  EXPECT_EQ(result.status, 1);
  EXPECT_EQ(result.output, "");
  EXPECT_TRUE(contains(result.errors, "127.0.0.1:1")) << result.errors;
}

TEST_F(Cli, WrongUsageIsStatusTwo) {
  folder_.write("algae.l", kAlgae);
  EXPECT_EQ(run("").status, 2);
  EXPECT_EQ(run("nosuch").status, 2);
  EXPECT_EQ(run("derive").status, 2);
  EXPECT_EQ(run("derive algae.l --steps many").status, 2);
  EXPECT_EQ(run("run algae.l").status, 2);
  EXPECT_EQ(run("run -o a.svg").status, 2);
  const ProgramRun suffix = run("run algae.l -o a.sgv");
  EXPECT_EQ(suffix.status, 2);
  EXPECT_TRUE(contains(suffix.errors,
                       "'a.sgv' has no known suffix: give one of these, or choose a format with --format:\n  png "))
      << suffix.errors;
}

TEST_F(Cli, HelpNamesEverySubcommand) {
  const ProgramRun result = run("--help");
  EXPECT_EQ(result.status, 0);
  for (const char* name : {"derive", "run", "check", "serve", "environment", "connect"}) {
    EXPECT_TRUE(contains(result.output, name)) << name;
    EXPECT_EQ(run(std::string(name) + " --help").status, 0) << name;
  }
}

TEST_F(Cli, RunWritesPictureGeometryAndSnapshot) {
  folder_.write("tree.l", "Lsystem: 1\nderivation length: 4\nAxiom: F\nF --> F[+F]F[-F]F\nendlsystem\n");
  folder_.write("tree.v", "angle increment: 25\n");
  const ProgramRun result = run("run tree.l -o tree.svg -o tree.obj -o tree.snapshot");
  EXPECT_EQ(result.status, 0) << result.errors;
  EXPECT_EQ(result.output, "");
  EXPECT_TRUE(contains(result.errors, "wrote tree.svg (step 4, ")) << result.errors;
  EXPECT_TRUE(contains(folder_.read("tree.svg"), "<svg"));
  EXPECT_TRUE(contains(folder_.read("tree.obj"), "mtllib tree.mtl"));
  EXPECT_TRUE(contains(folder_.read("tree.mtl"), "newmtl"));
  EXPECT_EQ(folder_.read("tree.snapshot").substr(0, 8), "ESPALIER");
}

TEST_F(Cli, ResumedRunEqualsARunWithoutAPause) {
  folder_.write("up.l", kHeight);
  folder_.write("shade.json", R"({"type":"constant","values":[1]})");
  ASSERT_EQ(run("run up.l --environment shade.json --steps 4 --quiet -o half.snapshot").status, 0);
  ASSERT_EQ(run("run up.l --environment shade.json --steps 9 --quiet -o whole.svg").status, 0);
  // the snapshot carries its model and its environment
  folder_.write("up.l", "");
  folder_.write("shade.json", "");
  const ProgramRun resumed = run("run --resume half.snapshot --steps 9 -o resumed.svg");
  EXPECT_EQ(resumed.status, 0) << resumed.errors;
  EXPECT_TRUE(contains(resumed.errors, "wrote resumed.svg (step 9, ")) << resumed.errors;
  EXPECT_EQ(folder_.read("resumed.svg"), folder_.read("whole.svg"));
}

TEST_F(Cli, FileThatIsNoSnapshotIsSaid) {
  folder_.write("a.snapshot", "hello");
  const ProgramRun result = run("run --resume a.snapshot -o a.svg");
  EXPECT_EQ(result.status, 1);
  EXPECT_TRUE(contains(result.errors, "'a.snapshot'")) << result.errors;
}

TEST_F(Cli, QuietLeavesResultsAndErrorsOnly) {
  folder_.write("s.l", kStochastic);
  EXPECT_EQ(run("derive s.l --quiet").errors, "");
  EXPECT_NE(run("derive s.l --quiet").output, "");
  EXPECT_NE(run("derive nosuch.l --quiet").errors, "");
}

TEST_F(Cli, EnvironmentTakesTheConfigurationFileThatDeriveTakes) {
  folder_.write("tiers.json", R"({"type":"honda81","name":"Tiers","radius":0.5})");
  const ProgramRun described = run("environment honda --describe --json --configuration tiers.json");
  EXPECT_EQ(described.status, 0) << described.errors;
  EXPECT_TRUE(contains(described.output, R"("name":"honda")")) << described.output;
  // the contract: other names, the paper, the keys
  EXPECT_TRUE(contains(described.output, R"("aliases":["honda81"],"source":"Honda, Tomlinson)")) << described.output;
  EXPECT_TRUE(contains(described.output, "distance up to which tips collide")) << described.output;
  const ProgramRun other = run("environment shadow --describe --configuration tiers.json");
  EXPECT_EQ(other.status, 1);
  EXPECT_TRUE(contains(other.errors,
                       "the configuration file 'tiers.json' is for 'honda81', not for 'shadow': name that environment, "
                       "or another file"))
      << other.errors;
}

TEST_F(Cli, DescribesAnEnvironmentInWords) {
  const ProgramRun described = run("environment shadow --describe");
  EXPECT_EQ(described.status, 0);
  EXPECT_TRUE(described.output.starts_with("shadow: Light by shadow propagation")) << described.output;
  EXPECT_TRUE(contains(described.output, "A module sends   castsShadow\n"));
  EXPECT_TRUE(contains(described.output, "and gets back    light, gradientX (1/m)"));
  constexpr const char* kWorld = "m stands for the world's lengthUnit";
  EXPECT_TRUE(contains(described.output, kWorld));
  EXPECT_TRUE(contains(run("environment soil-water --describe").output, kWorld));
  EXPECT_FALSE(contains(run("environment light --describe").output, kWorld)) << "W/m^2 is the same in all worlds";
  EXPECT_TRUE(contains(described.output, "voxels along each side of the grid. (default 201)")) << described.output;
  EXPECT_FALSE(contains(described.output, "{\"name\"")) << "words, not JSON";
  EXPECT_TRUE(run("environment shadow --describe --json").output.starts_with("{\"name\":\"shadow\""));
}

TEST_F(Cli, AMistypedOptionGetsTheNearestName) {
  folder_.write("m.l", kStochastic);
  const ProgramRun wrong = run("derive m.l --step 3");
  EXPECT_EQ(wrong.status, 2);
  EXPECT_TRUE(contains(wrong.errors, "Did you mean --steps?")) << wrong.errors;
  EXPECT_TRUE(contains(wrong.errors, "were not expected: --step 3; ")) << wrong.errors;
}

TEST_F(Cli, SwitchesOfTheReferenceAreNamed) {
  folder_.write("a.l", kAlgae);
  const auto error = [&](const std::string& arguments) {
    const ProgramRun result = run(arguments);
    EXPECT_EQ(result.status, 2) << arguments;
    return result.errors;
  };
  EXPECT_EQ(
      error("run -m99 a.l a.v"),
      "error: '-m99' is a switch of cpfg: leave it out: the colour map is the .map file beside the model, or that "
      "of a model folder\n");
  EXPECT_EQ(error("run -g a.l a.v"),
            "error: '-g' is a switch of cpfg: write --compat cpfg-batch, and -o for the output\n");
  EXPECT_EQ(error("run a.l -rmode expl"), "error: '-rmode' is a switch of cpfg: leave it out, it has no effect here\n");
  EXPECT_EQ(error("run a.l -obj a.obj"), "error: '-obj' is a switch of cpfg: write -o FILE.obj\n");
  EXPECT_EQ(error("derive -homo a.l"),
            "error: '-homo' is a switch of cpfg: leave it out: strings are written before homomorphism\n");
  EXPECT_TRUE(contains(error("run a.l a.v -o a.png"), "give 'a.v' with its option: --view a.v\n"));
  EXPECT_TRUE(contains(error("derive a.l a.map"), "'a.map' is not named: the file beside the model"));
  // options of this program keep their meaning
  EXPECT_EQ(run("derive a.l").output, "ABAAB\n");
  EXPECT_EQ(run("run a.l -o a.string -a").status, run("run a.l -o a.string --animate").status);
}

TEST_F(Cli, HelpOfForestListsOnlyFormatsThatItWrites) {
  const std::string help = run("forest --help").output;
  EXPECT_TRUE(contains(help, ".glb"));
  EXPECT_FALSE(contains(help, ".mtg"));
  EXPECT_FALSE(contains(help, ".snapshot"));
}

TEST_F(Cli, ServeRefusesATokenFileThatOthersRead) {
  folder_.write("token", "secret\n");
  const ProgramRun refused = run("serve --listen 127.0.0.1:0 --token-file token");
  EXPECT_EQ(refused.status, 1);
  EXPECT_TRUE(contains(refused.errors, "other users of the machine may read or change the token file 'token'"))
      << refused.errors;
}

TEST_F(Cli, StatusAndLoadTakeTheAddressesOfConnect) {
  for (const char* command : {"status", "load --sessions 1 --seconds 0.1"}) {
    const ProgramRun failed = run(std::string(command) + " unix:nowhere");
    EXPECT_EQ(failed.status, 1);
    EXPECT_TRUE(contains(failed.errors, "Cannot connect to unix:nowhere: No such file or directory")) << failed.errors;
  }
}

}  // namespace
}  // namespace espalier::test::cli_test
