#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "engine/files/model_folder.h"

namespace espalier::files::model_folder_test {
namespace {

using Names = std::vector<std::string>;

std::vector<std::string> texts(const core::DiagnosticList& diagnostics) {
  std::vector<std::string> result;
  for (const core::Diagnostic& diagnostic : diagnostics.entries()) {
    result.push_back(core::formatDiagnostic(diagnostic));
  }
  return result;
}

ModelFolder read(const std::string& specifications, const Names& names = {"p.l", "p.v"}) {
  core::MemoryFileProvider files;
  files.add("plant/specifications", specifications);
  return readModelFolder("plant", names, files);
}

TEST(ModelFolder, ReadsAPublishedFolder) {
  const ModelFolder folder = read(
      "p.l\n  p.v  \n; a remark\nrmode: cont\nignore:\n*.swp\n*\nmodel:\n\tgenerate:\n"
      "\t\tcpfg -m p.map -e p.e -a p.l p.v p.a\nview:\n\tedit p.l\n",
      {"p.l", "p.v", "p.a", "p.map", "p.e"});
  EXPECT_EQ(texts(folder.diagnostics), Names{});
  EXPECT_EQ(folder.listedFiles, (Names{"p.l", "p.v"}));
  ASSERT_EQ(folder.commands.size(), 1U);
  const FolderCommand& command = folder.commands[0];
  EXPECT_EQ(command.title, "model / generate");
  EXPECT_EQ(command.model, "plant/p.l");
  EXPECT_EQ(command.view, "plant/p.v");
  EXPECT_EQ(command.animation, "plant/p.a");
  EXPECT_EQ(command.environment, "plant/p.e");
  EXPECT_TRUE(command.startsInAnimation);
  ASSERT_EQ(command.colours.size(), 1U);
  EXPECT_EQ(command.colours[0].file, "plant/p.map");
  EXPECT_EQ(command.colours[0].block, 1);
  EXPECT_FALSE(command.colours[0].isMaterial);
}

TEST(ModelFolder, SpecificationsMayBeInUtf16) {
  std::string specifications = "\xFF\xFE";
  for (const char c : std::string("p.l\n*\nmodel:\n\tcpfg p.l p.v\n")) {
    specifications += c;
    specifications += '\0';
  }
  const ModelFolder folder = read(specifications);
  ASSERT_EQ(folder.commands.size(), 1U);
  EXPECT_EQ(folder.commands[0].model, "plant/p.l");
}

TEST(ModelFolder, OffersSeveralCommandsByTheirTitles) {
  const ModelFolder folder =
      read("*\nplant:\n\twhole:\n\t\tcpfg p.l p.v\n\tleaf:\n\t\t/usr/bin/cpfg.exe q.l q.v\nother:\n\tcpfg r.l r.v\n",
           {"p.l", "p.v", "q.l", "q.v", "r.l", "r.v"});
  ASSERT_EQ(folder.commands.size(), 3U);
  EXPECT_EQ(folder.commands[0].title, "plant / whole");
  EXPECT_EQ(folder.commands[1].title, "plant / leaf");
  EXPECT_EQ(folder.commands[1].model, "plant/q.l");
  EXPECT_EQ(folder.commands[2].title, "other");
}

TEST(ModelFolder, EditorsAndPipelinesAreNoCommands) {
  const ModelFolder folder = read("*\nedit:\n\tpanel panel.l | awkped p.l\n\tEDIT p.l\ngo:\n\tcpfg p.l p.v &\n");
  ASSERT_EQ(folder.commands.size(), 1U);
  EXPECT_EQ(folder.commands[0].view, "plant/p.v");
  EXPECT_EQ(folder.commands[0].animation, "");
}

TEST(ModelFolder, PositionsDecideNotSuffixes) {
  const ModelFolder folder =
      read("*\ngo:\n\tcpfg 'a model' view.txt libcomm.a\n", {"a model", "view.txt", "libcomm.a"});
  ASSERT_EQ(folder.commands.size(), 1U);
  EXPECT_EQ(folder.commands[0].model, "plant/a model");
  EXPECT_EQ(folder.commands[0].view, "plant/view.txt");
  EXPECT_EQ(folder.commands[0].animation, "plant/libcomm.a");
}

TEST(ModelFolder, ReadsEverySwitchThatMatters) {
  const ModelFolder folder = read("*\ngo:\n\tcpfg -m2 b.map -M m.mat -c 3 -s100 -homo -rmode cont -v p.l p.v\n",
                                  {"p.l", "p.v", "b.map", "m.mat"});
  EXPECT_EQ(texts(folder.diagnostics), Names{});
  const FolderCommand& command = folder.commands.at(0);
  ASSERT_EQ(command.colours.size(), 2U);
  EXPECT_EQ(command.colours[0].block, 2);
  EXPECT_TRUE(command.colours[1].isMaterial);
  EXPECT_EQ(command.colourBase, 3);
  EXPECT_TRUE(command.writesAfterHomomorphism);
}

TEST(ModelFolder, NamesUnusedSwitchesWithTheirConsequence) {
  const ModelFolder folder = read("*\ngo:\n\tcpfg -w 300 200 -wt title -ps out.ps -g p.l p.v\n");
  EXPECT_EQ(texts(folder.diagnostics), (Names{"plant/specifications:3:7: note: the switch -w is not used: this program "
                                              "has no window; choose the size of a picture with its options\n"
                                              "    3 | \tcpfg -w 300 200 -wt title -ps out.ps -g p.l p.v\n"
                                              "      | \t     ^~",
                                              "plant/specifications:3:18: note: the switch -wt is not used: this "
                                              "program has no window; choose the size of a picture with its options\n"
                                              "    3 | \tcpfg -w 300 200 -wt title -ps out.ps -g p.l p.v\n"
                                              "      | \t                ^~~",
                                              "plant/specifications:3:28: note: the switch -ps is not used: choose the "
                                              "output with the options of this program\n"
                                              "    3 | \tcpfg -w 300 200 -wt title -ps out.ps -g p.l p.v\n"
                                              "      | \t                          ^~~",
                                              "plant/specifications:3:39: note: the switch -g runs in batch mode, "
                                              "which has other random numbers; choose --compat cpfg-batch for them\n"
                                              "    3 | \tcpfg -w 300 200 -wt title -ps out.ps -g p.l p.v\n"
                                              "      | \t                                     ^~"}));
  ASSERT_EQ(folder.commands.size(), 1U);
  EXPECT_TRUE(folder.commands[0].isBatch);
  EXPECT_EQ(folder.commands[0].model, "plant/p.l");
}

std::string firstMessage(const ModelFolder& folder) {
  if (folder.diagnostics.entries().empty()) {
    return "";
  }
  const core::Diagnostic& first = folder.diagnostics.entries()[0];
  return std::to_string(first.location.line) + ":" + std::to_string(first.location.column) + " " + first.message;
}

TEST(ModelFolder, WarnsAboutUnknownParts) {
  EXPECT_EQ(firstMessage(read("*\ngo:\n\tcpfg -q p.l p.v\n")), "3:7 unknown switch '-q' is ignored");
  EXPECT_EQ(firstMessage(read("*\ngo:\n\tcpfg -m12 p.map p.l p.v\n")),
            "3:7 the colour block of -m is 0 to 11, found '-m12'; its file is ignored");
  EXPECT_EQ(firstMessage(read("*\ngo:\n\tcpfg p.l p.v -e\n")),
            "3:15 expected an environment file after '-e', found the end of the command");
  EXPECT_EQ(firstMessage(read("*\ngo:\n\tcpfg -c x p.l p.v\n")), "3:10 the colour base of -c is 0 to 11, found 'x'");
  EXPECT_EQ(firstMessage(read("*\ngo:\n\tcpfg p.l p.v p.a more\n")),
            "3:19 'more' is ignored: a command names only a model, a view file and an animation file");
  EXPECT_EQ(firstMessage(read("*\ngo:\n\tcpfg p.l\n")), "3:2 the command is ignored: it names no view file");
}

TEST(ModelFolder, MissingAndUnusedFilesAreNamedWithTheirConsequence) {
  const ModelFolder folder =
      read("*\ngo:\n\tcpfg -M leafs.mat p.l p.v\n", {"p.l", "p.v", "leaf.mat", "panel.a", "old.e"});
  EXPECT_EQ(texts(folder.diagnostics),
            (Names{"plant: warning: the folder has no file 'leafs.mat': its colours are the default ones\n"
                   "   hint: did you mean 'leaf.mat'?",
                   "plant: note: no command names 'leaf.mat': its materials are not used",
                   "plant: note: no command names 'old.e': it does not answer communication modules"}));
}

TEST(ModelFolder, WithoutSpecificationsTheOnlyModelIsRun) {
  core::MemoryFileProvider files;
  const ModelFolder folder = readModelFolder("", {"a.l", "a.v", "panel.l", "panel.v"}, files);
  EXPECT_EQ(texts(folder.diagnostics), Names{});
  ASSERT_EQ(folder.commands.size(), 1U);
  EXPECT_EQ(folder.commands[0].model, "a.l");
  EXPECT_EQ(folder.commands[0].title, "");
}

TEST(ModelFolder, NothingToRunIsAnError) {
  core::MemoryFileProvider files;
  const ModelFolder several = readModelFolder("x", {"a.l", "b.l", "a.v"}, files);
  EXPECT_TRUE(several.commands.empty());
  EXPECT_EQ(texts(several.diagnostics),
            Names{"x: error: the folder has no file 'specifications', and 2 models and 1 view files to choose from\n"
                  "   hint: name the model and its view file"});
  EXPECT_EQ(texts(read("p.l\n*\nedit:\n\tvi p.l\n").diagnostics),
            Names{"plant/specifications: error: no command of the menu runs cpfg\n"
                  "   hint: name the model and its view file"});
}

TEST(ModelFolder, TheWordOfAWrongSwitchIsNoModel) {
  for (const char* const switches : {"-zz 3", "-m12 p.map", "-q"}) {
    const ModelFolder folder = read("*\ngo:\n\tcpfg " + std::string(switches) + " p.l p.v\n");
    ASSERT_EQ(folder.commands.size(), 1U) << switches;
    EXPECT_EQ(folder.commands[0].model, "plant/p.l");
    EXPECT_EQ(folder.commands[0].view, "plant/p.v");
    EXPECT_TRUE(folder.commands[0].colours.empty());
  }
}

TEST(ModelFolder, SaysWhyThereIsNoCommand) {
  const auto error = [](const std::string& specifications) {
    const ModelFolder folder = read(specifications);
    for (const core::Diagnostic& diagnostic : folder.diagnostics.entries()) {
      if (diagnostic.severity == core::Severity::Error) {
        return diagnostic.message;
      }
    }
    return std::string();
  };
  EXPECT_EQ(error("*\ngo:\n\tcpfg -e p.l p.v\n"), "the cpfg command of the menu names no view file behind 'p.v'");
  EXPECT_EQ(error("*\ngo:\n\tcpfg -c p.l p.v\n"), "the cpfg command of the menu names no view file behind 'p.v'");
  EXPECT_EQ(error("*\ngo:\n\tcpfg\n"), "the cpfg command of the menu names no model");
  EXPECT_EQ(error("p.l\ngo:\n\tcpfg p.l p.v\n"), "the file has no menu, because no line '*' ends its list of files");
  EXPECT_EQ(error("*\ngo:\n\t/bin/lpfg.exe p.l p.v\n"),
            "the menu runs lpfg, and Espalier does not read L+C, the language of its models");
  EXPECT_EQ(error("*\ngo:\n\tlpfg p.l p.v\n\tcpfg p.l p.v\n"), "");
}

TEST(ModelFolder, ReadsThePaletteOfACommand) {
  core::MemoryFileProvider files;
  files.add("plant/p.map", std::string(768, '\x05'));
  FolderCommand command;
  command.colours = {{"plant/p.map", 1, false}, {"plant/none.mat", 1, true}};
  core::DiagnosticList diagnostics;
  const Palette palette = readPalette(command, files, diagnostics);
  EXPECT_EQ(texts(diagnostics),
            Names{"plant/none.mat: warning: the file cannot be read; its colours are the default ones"});
  EXPECT_TRUE(palette.usesMaterials);
  EXPECT_EQ(palette.maps.count(1), 1U);
}

}  // namespace
}  // namespace espalier::files::model_folder_test
