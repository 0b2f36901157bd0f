#include "tests/architecture/rules.h"
#include "tests/support/places.h"

#include <gtest/gtest.h>

namespace espalier::test::rules_test {
namespace {

using Breaches = std::vector<std::string>;

const std::vector<SourceFile>& tree() {
  static const std::vector<SourceFile> kTree = readSourceTree(sourceFolder());
  return kTree;
}

std::string lines(const Breaches& breaches) {
  std::string text;
  for (const std::string& breach : breaches) {
    text += breach + "\n";
  }
  return text;
}

TEST(Architecture, SourceTreeIsRead) {
  EXPECT_GT(tree().size(), 50U);
}

TEST(Architecture, IncludesFollowTheArrows) {
  EXPECT_EQ(lines(wrongDirections(tree())), "");
}

TEST(Architecture, PublicHeadersNameNoThirdPartyLibrary) {
  EXPECT_EQ(lines(thirdPartyNamesInPublicHeaders(tree())), "");
}

TEST(Architecture, EngineEnvironmentAndProtocolDoNoInputOrOutput) {
  EXPECT_EQ(lines(inputAndOutput(tree())), "");
}

TEST(Architecture, OnlyTheControlGroupAsksForTheProcessorsOfTheMachine) {
  EXPECT_EQ(lines(processorsOfTheMachine(tree())), "");
}

TEST(Architecture, OwnModeUsesNoElementaryFunctionOfTheCLibrary) {
  EXPECT_EQ(lines(elementaryFunctionsOfTheCLibrary(tree())), "");
}

TEST(Architecture, NoFailureIsTheLastOfAVariant) {
  EXPECT_EQ(lines(failuresInVariants(tree())), "");
}

TEST(Architecture, CodeFilesAreShort) {
  EXPECT_EQ(lines(longFiles(tree())), "");
}

TEST(Architecture, NoFileNamesAFolderOfOneMachine) {
  EXPECT_EQ(lines(machinePaths(tree())), "");
}

TEST(Architecture, EveryFolderHasAReadme) {
  EXPECT_EQ(lines(foldersWithoutReadme(tree())), "");
}

TEST(Architecture, FoldersAreNotCrowded) {
  EXPECT_EQ(lines(crowdedFolders(tree())), "");
}

TEST(ArchitectureRules, WrongDirectionIsSeen) {
  EXPECT_EQ(wrongDirections({{"engine/core/a.h", "#include \"engine/language/program.h\"\n"}}),
            Breaches{"engine/core/a.h includes engine/language/program.h, which engine/core/ may not"});
  EXPECT_EQ(wrongDirections({{"protocol/a.cpp", "#include \"engine/core/vec3.h\"\n"}}).size(), 1U);
  EXPECT_EQ(wrongDirections({{"environment/a.cpp", "#include \"engine/simulation/simulation.h\"\n"}}).size(), 1U);
  EXPECT_EQ(wrongDirections({{"engine/files/a.cpp", "#include \"engine/language/program.h\"\n"}}).size(), 1U);
  EXPECT_EQ(wrongDirections({{"server/remote/a.cpp", "#include \"server/session/session.h\"\n"}}).size(), 1U);
  EXPECT_EQ(wrongDirections({{"clients/cpp/a.cpp", "#include \"server/server.h\"\n"}}).size(), 1U);
}

TEST(ArchitectureRules, RightDirectionsAreAllowed) {
  EXPECT_EQ(wrongDirections({{"engine/simulation/a.h", "#include \"engine/turtle/scene/scene.h\"\n"},
                             {"environment/a.h", "#include \"engine/turtle/environment_process.h\"\n"},
                             {"server/a.cpp", "#include \"protocol/messages.h\"\n"},
                             {"tests/a.cpp", "#include \"engine/core/vec3.h\"\n"}}),
            Breaches{});
}

TEST(ArchitectureRules, ThirdPartyNameIsSeenThroughOtherHeaders) {
  // a.h is seen by the server, and a.h shows b.h; c.h is private
  EXPECT_EQ(thirdPartyNamesInPublicHeaders({{"server/s.cpp", "#include \"environment/a.h\"\n"},
                                            {"environment/a.h", "#include \"environment/b.h\"\n"},
                                            {"environment/b.h", "#include <nlohmann/json.hpp>\n"},
                                            {"environment/c.h", "#include <nlohmann/json.hpp>\n"}}),
            Breaches{"environment/b.h is a public header and names nlohmann"});
}

TEST(ArchitectureRules, ThirdPartyNameInACommentIsNoBreach) {
  EXPECT_EQ(thirdPartyNamesInPublicHeaders(
                {{"server/s.cpp", "#include \"environment/a.h\"\n"}, {"environment/a.h", "// no nlohmann here\n"}}),
            Breaches{});
}

TEST(ArchitectureRules, InputAndOutputAreSeen) {
  EXPECT_EQ(inputAndOutput({{"engine/core/a.cpp", "#include <iostream>\n"}}),
            Breaches{"engine/core/a.cpp uses <iostream>"});
  EXPECT_EQ(inputAndOutput({{"environment/a.cpp", "void f() { std::printf (\"x\"); }"}}).size(), 1U);
  EXPECT_EQ(inputAndOutput({{"protocol/a.cpp", "#include <chrono>\n"}}).size(), 1U);
  EXPECT_EQ(inputAndOutput({{"engine/core/a.cpp", "auto f = fopen(name, mode);"}}).size(), 1U);
}

TEST(ArchitectureRules, AskingTheMachineForItsProcessorsIsSeen) {
  EXPECT_EQ(
      processorsOfTheMachine({{"engine/a.cpp", "auto n = std::thread::hardware_concurrency();"}}),
      Breaches{"engine/a.cpp uses hardware_concurrency: use processorCount() of server/remote/control_group.h, or "
               "take the number from the caller"});
  EXPECT_EQ(processorsOfTheMachine({{"clients/espalier/a.cpp", "::sysconf(_SC_NPROCESSORS_ONLN)"}}).size(), 1U);
  EXPECT_EQ(processorsOfTheMachine({{"server/remote/control_group.cpp", "hardware_concurrency()"},
                                    {"tests/a.cpp", "hardware_concurrency()"},
                                    {"engine/b.cpp", "// hardware_concurrency"}}),
            Breaches{});
}

TEST(ArchitectureRules, TalkingAboutPrintingIsNoBreach) {
  EXPECT_EQ(inputAndOutput({{"engine/core/a.cpp",
                             "// printf(x)\n/* std::cout */ auto a = \"printf(\"; int b = 1'000; snprintf(c, d);"},
                            {"server/a.cpp", "#include <iostream>\n"}}),
            Breaches{});
}

TEST(ArchitectureRules, ElementaryFunctionOfTheCLibraryIsSeen) {
  EXPECT_EQ(elementaryFunctionsOfTheCLibrary({{"environment/a.cpp", "double b = std::sin(a) + std::log10 (a);"}}),
            (Breaches{"environment/a.cpp uses std::sin(): use core:: of engine/core/elementary.h",
                      "environment/a.cpp uses std::log10 (): use core:: of engine/core/elementary.h"}));
  EXPECT_EQ(elementaryFunctionsOfTheCLibrary({{"environment/light/published_a.cpp", "std::sin(a)"},
                                              {"engine/core/elementary.h", "std::sin(a)"},
                                              {"server/a.cpp", "std::sin(a)"},
                                              {"engine/a.cpp", "core::sin(a) + std::sqrt(a); // std::sin(a)"}}),
            Breaches{});
}

TEST(ArchitectureRules, AFailureInAVariantIsSeen) {
  EXPECT_EQ(failuresInVariants({{"server/a.h", "std::variant<std::string, protocol::Error> f();"}}),
            Breaches{"server/a.h uses std::variant<std::string, protocol::Error>: use tl::expected"});
  EXPECT_EQ(failuresInVariants({{"engine/a.cpp", "std::variant<std::map<int, int>,\n    std::string> f();"}}).size(),
            1U);
  EXPECT_EQ(failuresInVariants({{"clients/espalier/a.h", "std::variant<Programs, core::DiagnosticList> f();"}}).size(),
            1U);
  // kinds of values are no failures
  EXPECT_EQ(failuresInVariants({{"environment/a.h",
                                 "std::variant<double, std::string, std::vector<std::string>> value;\n"
                                 "std::variant<Tcp, Tls> stream; std::function<void(int, std::string)> done;"}}),
            Breaches{});
}

TEST(ArchitectureRules, LongFileIsSeen) {
  EXPECT_EQ(longFiles({{"engine/a.cpp", std::string(701, '\n')}}), Breaches{"engine/a.cpp has 701 lines"});
  EXPECT_EQ(longFiles({{"engine/a.cpp", std::string(700, '\n')}, {"README.md", std::string(900, '\n')}}), Breaches{});
}

TEST(ArchitectureRules, MachinePathIsSeen) {
  const std::string folder = std::string("/wo") + "rk/main";
  EXPECT_EQ(machinePaths({{"a.md", "one\nsee " + folder + "\n"}}), Breaches{"a.md:2 names a folder of one machine"});
  EXPECT_EQ(machinePaths({{"a.md", "a" + folder + " and tests" + folder}}), Breaches{});
}

TEST(ArchitectureRules, MissingReadmeIsSeen) {
  EXPECT_EQ(foldersWithoutReadme({{"engine/core/a.h", ""}}), Breaches{"engine/core has no README.md"});
  EXPECT_EQ(foldersWithoutReadme({{"engine/turtle/export/mesh/a.h", ""}, {"engine/turtle/README.md", ""}}), Breaches{});
}

TEST(ArchitectureRules, CrowdedFolderIsSeen) {
  std::vector<SourceFile> files;
  for (int i = 0; i < 36; ++i) {
    files.push_back({"server/session/" + std::to_string(i) + ".cpp", ""});
    files.push_back({"tests/server/" + std::to_string(i) + ".cpp", ""});
  }
  EXPECT_EQ(crowdedFolders(files), Breaches{"server/session has 36 source files: give it subfolders"});
  files.erase(files.begin(), files.begin() + 2);
  EXPECT_EQ(crowdedFolders(files), Breaches{});
}

}  // namespace
}  // namespace espalier::test::rules_test
