// Published model folders from the shell: what of them is used, and what is said about the rest.

#include <gtest/gtest.h>

#include <string>

#include "tests/clients/program_run.h"

namespace espalier::test::model_folder_test {
namespace {

constexpr const char* kModel = "Lsystem: 1\nderivation length: 3\nAxiom: A\nA --> FA\nendlsystem\n";
constexpr const char* kField = "executable: height -e field\nturtle position: P: %g %g %g\n";

// 256 times the same colour, except entry 0
std::string colourMap(const std::string& background, const std::string& colour) {
  std::string map = background;
  for (int i = 1; i < 256; ++i) {
    map += colour;
  }
  return map;
}

class Folder : public testing::Test {
 protected:
  ProgramRun run(const std::string& arguments) const { return runProgram(arguments, folder_.path()); }
  void write(const std::string& name, const std::string& text) const { folder_.write("plant/" + name, text); }
  void writeCommand(const std::string& command) const {
    write("specifications", "p.l\np.v\nignore:\n*\nmodel:\n\tgenerate:\n\t\t" + command + "\n");
  }
  // the error of a run that must fail with nothing on standard output
  std::string error(const std::string& arguments) const {
    const ProgramRun result = run(arguments);
    EXPECT_EQ(result.status, 1) << arguments;
    EXPECT_EQ(result.output, "") << arguments;
    return result.errors;
  }

  TemporaryFolder folder_;
};

TEST_F(Folder, RunsTheCommandOfItsSpecifications) {
  writeCommand("cpfg p.l p.v");
  write("p.l", kModel);
  write("old.l", "Lsystem: 1\n");
  write("p.v", "angle factor: 8\n");
  for (const char* name : {"plant", "plant/"}) {
    const ProgramRun result = run(std::string("derive ") + name);
    EXPECT_EQ(result.output, "FFFA\n");
    EXPECT_EQ(result.errors, "");
    EXPECT_EQ(result.status, 0);
  }
  EXPECT_EQ(run("check plant").output, "plant/p.l: no errors\n");
  EXPECT_EQ(run("derive plant --steps 1").output, "FA\n");
}

TEST_F(Folder, EveryTextFileMayBeInUtf16) {
  const auto utf16 = [](const std::string& text) {
    std::string bytes = "\xFF\xFE";
    for (const char c : text) {
      bytes += c;
      bytes += '\0';
    }
    return bytes;
  };
  write("specifications", utf16("p.l\n*\nmodel:\n\tcpfg -a p.l p.v p.a\n"));
  write("p.l", utf16(kModel));
  write("p.v", utf16("angle factor: 8\n"));
  write("p.a", utf16("last frame: 2\n"));
  write("world.json", utf16("{\"latitude\": 45}"));
  const ProgramRun result = run("derive plant --world plant/world.json");
  EXPECT_EQ(result.output, "FFA\n");
  EXPECT_EQ(result.errors, "");
  write("e.json", utf16("{\"type\": \"height\"}"));
  EXPECT_EQ(run("derive plant --environment plant/e.json").status, 0);
}

TEST_F(Folder, TheCommandsEnvironmentAnswersWhateverItsName) {
  writeCommand("cpfg -e field p.l p.v");
  write("p.l", kHeight);
  write("p.v", "");
  write("field", kField);
  EXPECT_EQ(run("derive plant").output, "FF?E(2)\n");
  EXPECT_EQ(run("derive plant --environment constant").output, "FFFA?E(1)\n");
  EXPECT_EQ(run("check plant").status, 0);
}

TEST_F(Folder, TheAnimationFileDecidesTheLastStepWithTheSwitchOrTheOption) {
  write("p.l", kModel);
  write("p.v", "");
  write("p.a", "first frame: 1\nlast frame: 4\nstep: 2\n");
  writeCommand("cpfg -a p.l p.v p.a");
  // the last advance is not cut: frames 1, 3 and 5
  EXPECT_EQ(run("derive plant").output, "FFFFFA\n");
  EXPECT_TRUE(contains(run("run plant -o p.svg").errors, "wrote p.svg (step 5, "));
  EXPECT_EQ(run("derive plant --steps 2").output, "FFA\n");

  writeCommand("cpfg p.l p.v p.a");
  const ProgramRun still = run("derive plant");
  EXPECT_EQ(still.output, "FFFA\n");
  EXPECT_EQ(still.errors,
            "plant/p.a: note: the animation file is not read without --animate or the switch -a; the derivation length "
            "decides which step is last\n");
  const ProgramRun animated = run("derive plant --animate");
  EXPECT_EQ(animated.output, "FFFFFA\n");
  EXPECT_EQ(animated.errors, "");
}

TEST_F(Folder, AnimationMayEndBeforeTheDerivationLength) {
  write("p.l", kModel);
  write("p.v", "");
  write("p.a", "first frame: 0\nlast frame: 1\n");
  writeCommand("cpfg -a p.l p.v p.a");
  EXPECT_EQ(run("derive plant --every").output, "0\tA\n1\tFA\n");
  write("p.a", "first frame: 0\nlast frame: -1\n");
  EXPECT_EQ(run("derive plant").output, "FFFA\n");
}

TEST_F(Folder, PicturesHaveTheColoursOfTheMap) {
  write("p.l", kModel);
  write("p.v", "initial color: 7\nline style: pixel\n");
  write("p.map", colourMap("\x01\x02\x03", "\xFF\x80\x10"));
  writeCommand("cpfg -m p.map p.l p.v");
  const ProgramRun result = run("run plant -o p.svg -o p.obj");
  EXPECT_EQ(result.status, 0) << result.errors;
  EXPECT_TRUE(contains(folder_.read("p.svg"), "fill=\"#010203\""));
  EXPECT_TRUE(contains(folder_.read("p.mtl"), "newmtl bark\nKd 1 0.502 0.0627\n")) << folder_.read("p.mtl");
}

TEST_F(Folder, PicturesHaveTheFoldersMaterials) {
  write("p.l", kModel);
  write("p.v", "initial color: 7\n");
  using namespace std::string_literals;
  // number, transparency, ambient, diffuse, emission, specular, shininess
  write("p.mat", "\x07\x33\x00\x00\xFF\x00\xFF\x00\x00\x00\x00\xFF\xFF\xFF\x20"s +
                     "\x00\x00\x00\x00\x00\x00\x00\x00\x0A\x0B\x0C\x00\x00\x00\x00"s);
  writeCommand("cpfg -M p.mat p.l p.v");
  EXPECT_EQ(run("run plant -o p.svg -o p.obj").status, 0);
  EXPECT_EQ(folder_.read("p.mtl"), "newmtl bark\nKd 0 1 0\nKa 0 0 1\nKs 1 1 1\nKe 0 0 0\nNs 32\nd 0.8\nillum 2\n");
  EXPECT_TRUE(contains(folder_.read("p.svg"), "fill=\"#0a0b0c\""));
  EXPECT_TRUE(contains(folder_.read("p.svg"), " opacity=\"0.8\""));
}

TEST_F(Folder, SeveralCommandsAreOfferedAndChosen) {
  write("specifications", "*\nplant:\n\twhole:\n\t\tcpfg p.l p.v\n\tleaf:\n\t\tcpfg leaf.l p.v\n");
  write("p.l", kModel);
  write("leaf.l", "Lsystem: 1\nderivation length: 1\nAxiom: L\nL --> LL\nendlsystem\n");
  write("p.v", "");
  const ProgramRun first = run("derive plant");
  EXPECT_EQ(first.output, "FFFA\n");
  EXPECT_EQ(
      first.errors,
      "plant: note: the folder offers 2 objects, and the first is used: 1 'plant / whole' (p.l), 2 'plant / leaf' "
      "(leaf.l)\n   hint: --object TITLE chooses another\n");
  for (const char* object : {"'plant / leaf'", "leaf", "leaf.l", "2"}) {
    const ProgramRun chosen = run(std::string("derive plant --object ") + object);
    EXPECT_EQ(chosen.output, "LL\n") << object;
    EXPECT_EQ(chosen.errors, "") << object;
  }
  EXPECT_EQ(error("derive plant --object root"),
            "error: the folder 'plant' has no object 'root': give one of 1 'plant / whole' (p.l), 2 'plant / leaf' "
            "(leaf.l)\n");
  EXPECT_EQ(error("derive plant/p.l --object leaf"),
            "error: --object chooses one of the models that the specifications of a folder list, and 'plant/p.l' has "
            "none: leave "
            "out --object\n");
}

TEST_F(Folder, WithoutSpecificationsTheOnlyFilesOfTheirKindAreUsed) {
  write("p.l", kModel);
  write("panel.l", "sliders");
  write("view.v", "initial color: 7\n");
  write("colours.map", colourMap("\x01\x02\x03", "\xFF\x80\x10"));
  EXPECT_EQ(run("run plant -o p.obj").status, 0);
  EXPECT_TRUE(contains(folder_.read("p.mtl"), "newmtl bark\nKd 1 0.502 0.0627\n")) << folder_.read("p.mtl");
  write("more.map", "");
  EXPECT_EQ(run("derive plant").errors,
            "plant/colours.map: note: the file is not used: its colours are not used\n"
            "plant/more.map: note: the file is not used: its colours are not used\n");
}

TEST_F(Folder, AMissingModelIsOneLine) {
  writeCommand("cpfg p.l p.v");
  write("p.v", "");
  EXPECT_EQ(
      error("derive plant"),
      "error: the folder 'plant' has no file 'p.l', the model that its specifications run: did you mean 'p.v'?\n");
}

TEST_F(Folder, AMissingViewFileIsOneLine) {
  writeCommand("cpfg p.l p.v");
  write("p.l", kModel);
  const ProgramRun result = run("derive plant");
  EXPECT_EQ(result.output, "FFFA\n");
  EXPECT_EQ(result.errors,
            "plant: warning: the folder has no file 'p.v': every view setting has its default\n"
            "   hint: did you mean 'p.l'?\n");
}

TEST_F(Folder, TheAnimationFileBesideAFileCountsWhenAskedFor) {
  write("p.l", kModel);
  write("p.a", "first frame: 2\n");
  EXPECT_EQ(run("derive plant/p.l").output, "FFFA\n");
  EXPECT_EQ(run("derive plant/p.l").errors, "");
  EXPECT_EQ(run("derive plant/p.l -a").output, "FFA\n");
}

TEST_F(Folder, TwoModelsWithoutSpecificationsAreOneLine) {
  write("a.l", kModel);
  write("b.l", kModel);
  EXPECT_EQ(error("run plant -o p.svg"),
            "error: the folder 'plant' holds more than one L-system file (a.l, b.l): give the name of one\n");
}

TEST_F(Folder, SpecificationsWithoutACommandAreOneLine) {
  writeCommand("vi p.l");
  EXPECT_EQ(error("check plant"),
            "error: plant/specifications: no command of the menu runs cpfg: name the model and its view file\n");
}

TEST_F(Folder, WhatCannotBeUsedIsNamedAndTheModelRuns) {
  write("p.l", kModel);
  write("p.v", "surface: l leaf.s 1\n");
  write("short.map", "\x01\x02\x03");
  writeCommand("cpfg -q -m short.map -m2 none.map -e none.e p.l p.v");
  const ProgramRun result = run("derive plant");
  EXPECT_EQ(result.status, 0);
  EXPECT_EQ(result.output, "FFFA\n");
  EXPECT_EQ(result.errors,
            "plant/specifications:7:8: warning: unknown switch '-q' is ignored\n"
            "    7 | \t\tcpfg -q -m short.map -m2 none.map -e none.e p.l p.v\n"
            "      | \t\t     ^~\n"
            "plant: warning: the folder has no file 'none.e': communication modules are not answered\n"
            "plant: warning: the folder has no file 'none.map': its colours are the default ones\n"
            "plant/short.map: warning: the colour map has 3 bytes instead of 768; the missing colours are grey\n"
            "plant/p.v:1:1: warning: the file 'plant/leaf.s' cannot be read; ~l draws nothing and the turtle stays\n"
            "    1 | surface: l leaf.s 1\n"
            "      | ^~~~~~~~~~~~~~~~~~~\n"
            "   hint: the file is looked for beside the view file\n");
  EXPECT_EQ(run("derive plant --quiet").errors, "");
}

TEST_F(Folder, SwitchesAndSettingsThatAreNotUsedAreNamed) {
  write("p.l", kModel);
  write("p.v", "rayshade objects: hill.txt\n");
  write("p.a", "frame intervals: 0-3 step 1 rotate 0 10 0\n");
  writeCommand("cpfg -homo -a p.l p.v p.a");
  EXPECT_EQ(run("derive plant").errors,
            "plant/specifications: note: the switch -homo is not used: strings are printed before homomorphism\n"
            "plant/p.a: note: pictures ignore the rotations and scalings of its frame intervals\n"
            "plant/p.v:1:1: note: the objects are not used: no scene for Rayshade is written\n"
            "    1 | rayshade objects: hill.txt\n"
            "      | ^~~~~~~~~~~~~~~~~\n");
}

TEST_F(Folder, StrictReadingMakesWarningsErrors) {
  write("p.l", "Lsystem: 1\nAxiom: A(1)\nA(x) --> A(x @)\nendlsystem\n");
  write("p.v", "");
  writeCommand("cpfg p.l p.v");
  EXPECT_EQ(run("check plant").status, 0);
  EXPECT_EQ(error("check plant --strict"),
            "plant/p.l:3:14: error: the character '@' has no meaning in expressions and is skipped\n"
            "    3 | A(x) --> A(x @)\n"
            "      |              ^\n"
            "   hint: remove it\n"
            "error: a warning is an error here: mend the file, or leave out --strict\n");
  // also in the view file, in the environment's files, and about the model as a whole
  write("p.l", kHeight);
  write("p.v", "angel factor: 8\n");
  EXPECT_TRUE(
      contains(error("derive plant --strict --environment height"), "error: unknown view command 'angel factor'"));
  write("p.v", "");
  EXPECT_TRUE(contains(error("derive plant --strict"), "error: ?E gets no answer"));
  write("field", std::string(kField) + "colour: red\n");
  writeCommand("cpfg -e field p.l p.v");
  EXPECT_EQ(run("derive plant").output, "FF?E(2)\n");
  EXPECT_TRUE(contains(error("derive plant --strict"), "plant/field:3:1: error: unknown keyword 'colour' is ignored"));
  write("field", kField);
  EXPECT_EQ(run("derive plant --strict").output, "FF?E(2)\n");
}

TEST_F(Folder, ABackgroundSceneIsInPictures) {
  write("p.l", kModel);
  write("p.v", "viewpoint: 0,0,1\n");
  writeCommand("cpfg p.l p.v");
  ASSERT_EQ(run("run plant -o plain.png").status, 0);
  write("p.v", "viewpoint: 0,0,1\nbackground scene: hill.txt, none.txt\n");
  write("hill.txt", "#define R 2\ntranslate 0 -R 0 material 0 0 0 1 0 1 0 1 sphere R\n");
  const ProgramRun result = run("run plant -o hill.png");
  EXPECT_EQ(result.status, 0);
  EXPECT_TRUE(contains(result.errors,
                       "plant/p.v:2:1: warning: the file 'plant/none.txt' cannot be read; this part of the "
                       "background is not drawn"))
      << result.errors;
  EXPECT_NE(folder_.read("hill.png"), folder_.read("plain.png"));
}

TEST_F(Folder, AnimationWithoutItsFileGoesToTheDerivationLength) {
  write("p.l", kModel);
  write("p.v", "");
  writeCommand("cpfg -a p.l p.v");
  const ProgramRun result = run("derive plant");
  EXPECT_EQ(result.output, "FFFA\n");
  EXPECT_EQ(result.errors,
            "plant/p.l: warning: the model has no animation file; the derivation length decides which step is last\n");
}

}  // namespace
}  // namespace espalier::test::model_folder_test
