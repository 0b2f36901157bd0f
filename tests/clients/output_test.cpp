// The output of run, export and watch: formats, numbered files, failures that leave nothing.

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "engine/files/images/image_file.h"
#include "tests/clients/program_run.h"
#include "tests/support/places.h"

namespace espalier::test::output_test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTree =
    "Lsystem: 1\nderivation length: 3\nAxiom: A(1)\nA(l) --> F(l)[+(30)A(l*0.7)][-(40)A(l*0.6)]\nendlsystem\n";
constexpr const char* kBush =
    "Lsystem: 1\nderivation length: 3\nAxiom: F\nF --> F[+F]F : 1\nF --> F[-F]F : 1\nendlsystem\n";

class Output : public testing::Test {
 protected:
  void SetUp() override {
    folder_.write("tree.l", kTree);
    folder_.write("tree.v", "line style: cylinder\ninitial line width: 0.1 s\n");
    folder_.write("bush.l", kBush);
  }
  ProgramRun run(const std::string& arguments) const { return runProgram(arguments, folder_.path()); }
  std::set<std::string> files() const {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_.path())) {
      names.insert(entry.path().filename().string());
    }
    return names;
  }

  TemporaryFolder folder_;
};

TEST_F(Output, APictureWithoutAnythingInItIsSaidToBeEmpty) {
  folder_.write("bud.l", "Lsystem: 1\nderivation length: 2\nAxiom: A\nA --> AB\nendlsystem\n");
  const auto warns = [this](const std::string& arguments) {
    return contains(run("run " + arguments).errors, "warning: nothing is drawn. F(1) draws");
  };
  EXPECT_TRUE(warns("bud.l -o bud.svg -o bud.obj"));
  EXPECT_FALSE(warns("bud.l -o bud.string"));
  EXPECT_FALSE(warns("bud.l -o bud.svg --quiet"));
  EXPECT_FALSE(warns("tree.l -o tree.svg"));
}

TEST_F(Output, ManyFormatsAreWrittenAtOnceEachByItsSuffix) {
  const ProgramRun result =
      run("run tree.l -o a.png -o a.svg -o a.eps -o a.obj -o a.mtg -o a.csv -o a.string -o a.snapshot --size 80x60");
  ASSERT_EQ(result.status, 0) << result.errors;
  EXPECT_EQ(folder_.read("a.png").substr(1, 3), "PNG");
  EXPECT_TRUE(contains(folder_.read("a.svg"), "<svg"));
  EXPECT_TRUE(folder_.read("a.eps").starts_with("%!PS-Adobe-3.0 EPSF-3.0\n"));
  EXPECT_TRUE(contains(folder_.read("a.obj"), "mtllib a.mtl"));
  EXPECT_TRUE(folder_.read("a.mtg").starts_with("CODE:\tFORM-A\n"));
  EXPECT_TRUE(folder_.read("a.csv").starts_with("plant,module,symbol,"));
  EXPECT_EQ(folder_.read("a.string"), run("derive tree.l").output);
  // nothing else, no temporary file
  EXPECT_EQ(files(), (std::set<std::string>{"a.png", "a.svg", "a.eps", "a.obj", "a.mtl", "a.mtg", "a.csv", "a.string",
                                            "a.snapshot", "tree.l", "tree.v", "bush.l"}));
}

TEST_F(Output, TheSameCommandAndSeedGiveTheSameBytes) {
  const std::string outputs = " -o %d.png -o %d.svg -o %d.eps -o %d.mtg -o %d.csv -o %d.snapshot";
  const auto named = [&](char name) {
    std::string text = outputs;
    for (char& c : text) {
      c = c == '%' ? name : c;
    }
    return text;
  };
  ASSERT_EQ(run("run bush.l --seed 5" + named('a')).status, 0);
  ASSERT_EQ(run("run bush.l --seed 5 --threads 3" + named('b')).status, 0);
  for (const char* const suffix : {".png", ".svg", ".eps", ".mtg", ".csv", ".snapshot"}) {
    EXPECT_EQ(folder_.read(std::string("ad") + suffix), folder_.read(std::string("bd") + suffix)) << suffix;
  }
}

TEST_F(Output, FormatOverridesTheSuffixAndUnknownOnesListWhatThereIs) {
  ASSERT_EQ(run("run tree.l -o drawing --format svg").status, 0);
  EXPECT_TRUE(contains(folder_.read("drawing"), "<svg"));
  const ProgramRun result = run("run tree.l -o a.txt --format txt");
  EXPECT_EQ(result.status, 2);
  EXPECT_TRUE(contains(result.errors, "there is no format 'txt'. Formats, with the suffixes that choose them:"))
      << result.errors;
  EXPECT_TRUE(contains(result.errors, "\n  mtg      .mtg      a multiscale tree graph")) << result.errors;
  EXPECT_EQ(run("run tree.l -o a.PNG --size 10x10").status, 0);
}

TEST_F(Output, StandardOutputCanBeWrittenTo) {
  const ProgramRun result = run("run tree.l --format string -o /dev/stdout --quiet");
  EXPECT_EQ(result.status, 0) << result.errors;
  EXPECT_EQ(result.output, run("derive tree.l").output);
  // also where it leads to a file, which keeps what was in it
  folder_.write("log", "before\n");
  EXPECT_EQ(run("run tree.l --format string -o /dev/stdout --quiet >>log; exit $?").status, 0);
  EXPECT_EQ(folder_.read("log"), "before\n" + result.output);
}

TEST_F(Output, SharedMemoryHoldsPlainFiles) {
  const std::string name = "/dev/shm/espalier-test-" + std::to_string(::getpid()) + ".svg";
  const bool isThere = fs::is_directory("/dev/shm");
  const ProgramRun result = run("run tree.l -o " + name + " --quiet");
  EXPECT_EQ(result.status, isThere ? 0 : 1) << result.errors;
  EXPECT_EQ(fs::remove(name), isThere);
}

TEST_F(Output, SizesAndColoursAreChecked) {
  for (const char* const size : {"800", "0x5", "5x", "-3x5", "5x99999"}) {
    const ProgramRun result = run(std::string("run tree.l -o a.png --size=") + size);
    EXPECT_EQ(result.status, 2);
    EXPECT_TRUE(contains(result.errors, std::string("'") + size + "' is not a size: give WIDTHxHEIGHT in pixels"))
        << result.errors;
  }
  EXPECT_EQ(run("run tree.l -o a.png --colours 1").status, 2);
  EXPECT_EQ(run("run tree.l -o a.png --background pink").status, 2);
  EXPECT_EQ(run("run tree.l -o a.png --detail 0").status, 2);
  EXPECT_FALSE(contains(folder_.read("a.png"), "PNG"));
}

TEST_F(Output, EveryStepIsAFileWithItsNumber) {
  ASSERT_EQ(run("run tree.l --every -o f.svg --quiet").status, 0);
  ASSERT_EQ(run("run tree.l --every -o g%02d.svg --quiet").status, 0);
  for (int step = 0; step <= 3; ++step) {
    const std::string frame = folder_.read("f-000" + std::to_string(step) + ".svg");
    EXPECT_TRUE(contains(frame, "</svg>")) << step;
    EXPECT_EQ(folder_.read("g0" + std::to_string(step) + ".svg"), frame);
  }
  EXPECT_FALSE(files().contains("f.svg"));
  EXPECT_FALSE(files().contains("f-0004.svg"));
}

TEST_F(Output, EveryStepOfAUsdStageIsAFrameOfOneFile) {
  const ProgramRun result = run("run tree.l --every -o grow.usda -o f.svg");
  ASSERT_EQ(result.status, 0) << result.errors;
  EXPECT_TRUE(contains(result.errors, "wrote grow.usda (4 steps)")) << result.errors;
  const std::string stage = folder_.read("grow.usda");
  EXPECT_TRUE(contains(stage, "    startTimeCode = 0\n    endTimeCode = 3\n"));
  for (int step = 0; step <= 3; ++step) {
    EXPECT_TRUE(contains(stage, "def Xform \"step_" + std::to_string(step) + "\"\n")) << step;
    EXPECT_TRUE(files().contains("f-000" + std::to_string(step) + ".svg")) << step;
  }
  EXPECT_FALSE(files().contains("grow-0000.usda"));
  // with a place for the number: a stage for each step
  ASSERT_EQ(run("run tree.l --every -o s%d.usda --quiet").status, 0);
  EXPECT_TRUE(files().contains("s3.usda"));
}

TEST_F(Output, VariantsAreRunsOfConsecutiveSeeds) {
  ASSERT_EQ(run("run bush.l --variants 3 --seed 7 -o v.string --quiet").status, 0);
  std::set<std::string> strings;
  for (int i = 0; i < 3; ++i) {
    const std::string string = folder_.read("v-00" + std::to_string(i + 1) + ".string");
    EXPECT_EQ(string, run("derive bush.l --seed " + std::to_string(7 + i)).output);
    strings.insert(string);
  }
  EXPECT_GT(strings.size(), 1U);
  const ProgramRun equal = run("run tree.l --variants 2 -o t.string");
  EXPECT_TRUE(contains(equal.errors, "the model draws no random numbers, so all variants are equal")) << equal.errors;
  EXPECT_EQ(run("run bush.l --variants 2 --every -o v.svg").status, 2);
}

TEST_F(Output, WarningsAboutAModelComeOnceForAllVariants) {
  folder_.write(
      "warns.l",
      "Lsystem: 1\nderivation length: 2\nAxiom: A(1)\nA(x) --> A(y+1/(x-1)) : 1\nA(x) --> B : 1\nendlsystem\n");
  const std::string errors = run("run warns.l --variants 4 -o w.string").errors;
  const auto count = [&errors](const std::string& text) {
    std::size_t found = 0;
    for (std::size_t at = errors.find(text); at != std::string::npos; at = errors.find(text, at + 1)) {
      ++found;
    }
    return found;
  };
  EXPECT_EQ(count("unknown name 'y'"), 1U) << errors;
  // warnings of a run itself are of that plant
  EXPECT_GT(count("division by 0"), 1U) << errors;
  EXPECT_EQ(count("wrote w-00"), 4U) << errors;
}

TEST_F(Output, VariantsInRowsAreOneFileAndEqualOnesShareTheirMesh) {
  ASSERT_EQ(run("run tree.l --variants 5 --in-rows 0 -o row.glb -o row.png --size 80x60").status, 0);
  const ProgramRun far = run("run tree.l --variants 5 --in-rows 100 -o far.glb");
  ASSERT_EQ(far.status, 0) << far.errors;
  EXPECT_TRUE(contains(far.errors, "wrote far.glb (5 plants, 1 different)")) << far.errors;
  // rows of three and two
  EXPECT_TRUE(contains(folder_.read("far.glb"), "\"name\":\"plant_4\",\"translation\":[100,0,-100]"));
  const std::size_t one = [&] {
    EXPECT_EQ(run("run tree.l -o one.glb").status, 0);
    return folder_.read("one.glb").size();
  }();
  EXPECT_LT(folder_.read("row.glb").size(), one + 5 * 160);
  // plants that differ have each their own
  const ProgramRun bush = run("run bush.l --variants 3 --in-rows 2.5 -o bush.glb");
  EXPECT_TRUE(contains(bush.errors, "wrote bush.glb (3 plants, 3 different)")) << bush.errors;
  ASSERT_EQ(run("run tree.l --variants 5 --in-rows 0 -o node.glb --instancing").status, 0);
  EXPECT_TRUE(contains(folder_.read("node.glb"), "EXT_mesh_gpu_instancing"));
  const ProgramRun wrong = run("run bush.l --variants 3 --in-rows 1 -o bush.svg");
  EXPECT_EQ(wrong.status, 2);
  EXPECT_EQ(
      wrong.errors,
      "error: 'bush.svg' cannot hold several plants side by side: give one of .png, .glb, .obj, .ply, .stl, .usda, "
      ".vtp, .vtu\n");
  EXPECT_EQ(run("run bush.l --in-rows 1 -o bush.glb").status, 2) << "without --variants";
}

TEST_F(Output, RowsOfAPictureStandBelowEachOther) {
  folder_.write("line.l", "Lsystem: 1\nderivation length: 1\nAxiom: F(2)\nA --> A\nendlsystem\n");
  ASSERT_EQ(run("run line.l --variants 5 --in-rows 1 -o row.png --size 90x120 --background transparent").status, 0);
  const files::Image image = files::readPngImage(folder_.read("row.png")).value();
  // three plants above, and two below on the left
  std::array<std::set<int>, 2> columns;
  for (int row = 0; row < image.height; ++row) {
    for (int x = 0; x < image.width; ++x) {
      if (image.at(x, row, 3) > 128) {
        columns[row < image.height / 2 ? 0 : 1].insert(x);
      }
    }
  }
  ASSERT_FALSE(columns[0].empty());
  ASSERT_FALSE(columns[1].empty());
  EXPECT_EQ(*columns[0].begin(), *columns[1].begin());
  EXPECT_GT(*columns[0].rbegin(), *columns[1].rbegin() + 10);
}

TEST_F(Output, VariantsWhoseImagesAreRandomDiffer) {
  // the strings are equal, and what is drawn for them is not
  folder_.write("random.l",
                "Lsystem: 1\nderivation length: 1\nAxiom: A\nB --> B\nhomomorphism\nA --> F(1+ran(1))\nendlsystem\n");
  const ProgramRun random = run("run random.l --seed 1 --variants 3 --in-rows 3 -o random.glb");
  EXPECT_TRUE(contains(random.errors, "wrote random.glb (3 plants, 3 different)")) << random.errors;
}

TEST_F(Output, FramesOfAnAnimationShareOneScaleUnlessEachIsToFill) {
  folder_.write("line.v", "line style: pixel\n");
  folder_.write("line.l", "Lsystem: 1\nderivation length: 3\nAxiom: F\nF --> FF\nendlsystem\n");
  // the height of each drawing
  const auto heights = [&](const std::string& options) {
    EXPECT_EQ(run("run line.l --every -o f.svg " + options).status, 0);
    std::vector<std::string> found;
    for (int step = 0; step <= 3; ++step) {
      const std::string text = folder_.read("f-000" + std::to_string(step) + ".svg");
      const std::size_t at = text.find("viewBox=\"");
      found.push_back(text.substr(at, text.find('"', at + 9) - at));
    }
    return found;
  };
  // a line of length 1, 2, 4, 8: with one scale all pages are the last one's, and the first line an eighth of it
  const std::vector<std::string> shared = heights("");
  EXPECT_EQ(std::set<std::string>(shared.begin(), shared.end()).size(), 1U);
  const auto inkOf = [&](const std::string& options, int step) {
    EXPECT_EQ(run("run line.l --every -o p.png --size 40x160 --background transparent " + options).status, 0);
    const std::string bytes = folder_.read("p-000" + std::to_string(step) + ".png");
    const auto pixels = files::readPngImage(bytes).value().pixels;
    double ink = 0.0;
    for (std::size_t at = 3; at < pixels.size(); at += 4) {
      ink += pixels[at] / 255.0;
    }
    return ink;
  };
  EXPECT_NEAR(inkOf("", 0) * 8.0, inkOf("", 3), 0.15 * inkOf("", 3));
  EXPECT_NEAR(inkOf("--frames own", 0), inkOf("--frames own", 3), 0.15 * inkOf("--frames own", 3));
  EXPECT_EQ(run("run line.l --frames own -o p.png").status, 2) << "without --every";
}

TEST_F(Output, WhatAModelPrintsIsPrintedOnceAlsoWhenFramesAreMeasured) {
  folder_.write(
      "print.l",
      "Lsystem: 1\nderivation length: 2\nStartEach: {printf(\"step\\n\");}\nAxiom: F\nF --> FF\nendlsystem\n");
  const ProgramRun result = run("run print.l --every -o f.png --size 20x20");
  ASSERT_EQ(result.status, 0) << result.errors;
  std::size_t count = 0;
  for (std::size_t at = result.errors.find("step\n"); at != std::string::npos;
       at = result.errors.find("step\n", at + 1)) {
    ++count;
  }
  EXPECT_EQ(count, 2U) << result.errors;
}

TEST_F(Output, ExportDrawsASnapshotWithoutDerivingOrItsEnvironment) {
  folder_.write("up.l", "Lsystem: 1\nderivation length: 2\nAxiom: A?E(0)\nA > ?E(h) : h < 2 --> FA\nendlsystem\n");
  folder_.write("up.json", R"({"type":"constant","values":[1]})");
  ASSERT_EQ(run("run up.l --environment up.json -o up.snapshot -o up.svg -o up.csv --quiet").status, 0);
  folder_.write("up.l", "");
  folder_.write("up.json", "");
  const ProgramRun result = run("export up.snapshot -o again.svg -o again.csv");
  ASSERT_EQ(result.status, 0) << result.errors;
  EXPECT_TRUE(contains(result.errors, "wrote again.svg (step 2, ")) << result.errors;
  EXPECT_EQ(folder_.read("again.svg"), folder_.read("up.svg"));
  EXPECT_EQ(folder_.read("again.csv"), folder_.read("up.csv"));
  EXPECT_TRUE(contains(run("export nosuch.snapshot -o a.svg").errors,
                       "error: there is no snapshot 'nosuch.snapshot': check the name and the working folder"));
  EXPECT_EQ(run("export tree.l -o a.svg").status, 1);
}

TEST_F(Output, SnapshotsKeepTheColoursOfTheirFolder) {
  std::string map(768, '\x40');
  map[3 * 128] = '\x01';
  map[3 * 128 + 1] = '\x02';
  map[3 * 128 + 2] = '\x03';
  fs::create_directory(folder_.path() + "/plant");
  folder_.write("plant/plant.l", kTree);
  folder_.write("plant/plant.v", "initial line width: 2 p\n");
  folder_.write("plant/plant.map", map);
  ASSERT_EQ(run("run plant -o p.snapshot -o p.svg --quiet").status, 0);
  EXPECT_TRUE(contains(folder_.read("p.svg"), "stroke=\"#010203\""));
  fs::remove_all(folder_.path() + "/plant");
  ASSERT_EQ(run("export p.snapshot -o exported.svg").status, 0);
  EXPECT_EQ(folder_.read("exported.svg"), folder_.read("p.svg"));
  ASSERT_EQ(run("run --resume p.snapshot -o resumed.svg").status, 0);
  EXPECT_EQ(folder_.read("resumed.svg"), folder_.read("p.svg"));
}

TEST_F(Output, AResumedRunSaysWhenItDerivesNothing) {
  ASSERT_EQ(run("run tree.l -o t.snapshot --quiet").status, 0);
  EXPECT_TRUE(contains(run("run --resume t.snapshot -o t.svg").errors,
                       "the snapshot is at step 3, the last one: no step is derived. --steps N continues to step N\n"));
  EXPECT_TRUE(contains(run("run --resume t.snapshot --steps 1 -o t.svg").errors,
                       "the snapshot is at step 3, beyond step 1: no step is derived, and step 3 is written\n"));
  const ProgramRun further = run("run --resume t.snapshot --steps 4 -o t.svg");
  EXPECT_FALSE(contains(further.errors, "nothing is derived")) << further.errors;
  EXPECT_TRUE(contains(further.errors, "wrote t.svg (step 4, ")) << further.errors;
}

TEST_F(Output, ARunStartsFromAStringFile) {
  ASSERT_EQ(run("run tree.l --steps 2 -o two.string --quiet").status, 0);
  EXPECT_EQ(run("derive tree.l --from two.string --steps 1").output, run("derive tree.l --steps 3").output);
  ASSERT_EQ(run("run tree.l --steps 2 -o two.mtg --quiet").status, 0);
  EXPECT_EQ(run("derive tree.l --from two.mtg --steps 1").output, run("derive tree.l --steps 3").output);
  // modules that only the string has may occur
  folder_.write("two.l", "Lsystem: 1\nderivation length: 1\nAxiom: A\nA --> FA\nB --> CB\nendlsystem\n");
  folder_.write("b.string", "B\n");
  EXPECT_TRUE(contains(run("derive two.l").errors, "'B' never matches"));
  const ProgramRun given = run("derive two.l --from b.string");
  EXPECT_EQ(given.output, "CB\n");
  EXPECT_EQ(given.errors, "");
  folder_.write("bad.string", "A(1)\n F(2)X(3)\n");
  const ProgramRun bad = run("derive tree.l --from bad.string");
  EXPECT_EQ(bad.status, 1);
  EXPECT_TRUE(contains(
      bad.errors, "error: the string to start from, 2:6: the model has no module 'X' with 1 parameters: only modules"))
      << bad.errors;
  folder_.write("empty.string", "\n");
  EXPECT_TRUE(contains(run("derive tree.l --from empty.string").errors, "'empty.string' (--from) has no modules"));
  EXPECT_TRUE(contains(run("derive tree.l --from none.string").errors,
                       "there is no file 'none.string' (--from): check the name and the working folder"));
  folder_.write("bad.mtg", "CODE: FORM-B\n");
  EXPECT_TRUE(
      contains(run("derive tree.l --from bad.mtg").errors, "bad.mtg:1: only the form FORM-A is read, not 'FORM-B'"));
}

TEST_F(Output, AFullDiskIsSaidAndLeavesNoFile) {
  const ProgramRun device = run("run tree.l --format svg -o /dev/full");
  EXPECT_EQ(device.status, 1);
  EXPECT_TRUE(contains(device.errors,
                       "error: cannot write '/dev/full': No space left on device. Check that the folder "
                       "exists, is writable and has room.\n"))
      << device.errors;
  // files of at most 512 bytes: the snapshot is longer
  const auto before = files();
  const ProgramRun limited = run("run tree.l -o long.snapshot -o long.obj; exit $?");
  ASSERT_EQ(limited.status, 0) << limited.errors;
  fs::remove(folder_.path() + "/long.snapshot");
  fs::remove(folder_.path() + "/long.obj");
  fs::remove(folder_.path() + "/long.mtl");
  const std::string program = buildFolder() + "/bin/espalier";
  const std::string command =
      "cd '" + folder_.path() + "' && ulimit -f 1 && '" + program + "' run tree.l -o long.obj > limited.txt 2>&1";
  EXPECT_NE(std::system(command.c_str()), 0);
  EXPECT_TRUE(contains(folder_.read("limited.txt"), "cannot write 'long.obj': File too large"))
      << folder_.read("limited.txt");
  fs::remove(folder_.path() + "/limited.txt");
  EXPECT_EQ(files(), before);
}

TEST_F(Output, AFolderThatCannotBeWrittenToIsSaid) {
  if (::geteuid() == 0) {
    GTEST_SKIP() << "permissions do not bind the superuser";
  }
  fs::create_directory(folder_.path() + "/closed");
  ::chmod((folder_.path() + "/closed").c_str(), 0500);
  const ProgramRun result = run("run tree.l -o closed/a.svg");
  EXPECT_EQ(result.status, 1);
  EXPECT_TRUE(contains(result.errors, "cannot write 'closed/a.svg': Permission denied")) << result.errors;
}

TEST_F(Output, NumbersAreCheckedWithTheirRange) {
  for (const char* const wrong : {"-1", "1.5", "many", "99999999999999999999", "1000000001"}) {
    const ProgramRun result = run(std::string("derive tree.l --steps=") + wrong);
    EXPECT_EQ(result.status, 2) << wrong;
    EXPECT_TRUE(contains(result.errors,
                         std::string("'") + wrong + "' is not possible: give a whole number from 0 to 1000000000"))
        << result.errors;
  }
  EXPECT_EQ(run("derive bush.l --seed -1").status, 2);
  EXPECT_EQ(run("derive bush.l --seed 18446744073709551615").status, 0);
  EXPECT_EQ(run("explain tree.l --step 0 --module 0").status, 2);
}

TEST_F(Output, AMistypedCommandNamesTheNearest) {
  const ProgramRun result = run("rnu tree.l");
  EXPECT_EQ(result.status, 2);
  EXPECT_TRUE(contains(result.errors, "error: there is no command 'rnu'. Did you mean 'run'? Available: "))
      << result.errors;
}

}  // namespace
}  // namespace espalier::test::output_test
