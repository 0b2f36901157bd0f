#include "engine/turtle/export/text/mtg.h"

#include <fstream>
#include <iterator>
#include <random>

#include "engine/turtle/export/text/module_table.h"
#include "tests/engine/turtle/turtle_fixture.h"
#include "tests/support/places.h"

namespace espalier::turtle::mtg_test {
namespace {

// the text that a writer of modules makes of a string
std::string written(TurtleRun& run, std::string_view format, const ExportProgress& progress = {}) {
  const std::vector<const derivation::ModuleString*> strings{&run.state.string};
  const auto visit = [&run](const ModuleVisitor& visitor) -> std::optional<std::string> {
    InterpretationOutput output;
    output.onModule = visitor;
    output.fillsQueries = false;
    run.interpret({}, output);
    return std::nullopt;
  };
  const ExportInput input{
      .scene = run.scene, .view = run.program.view, .program = &run.program, .strings = strings, .visitModules = visit};
  core::StringSink sink;
  const ExportTarget target{.fileName = "a", .sink = sink, .openCompanion = {}, .progress = progress};
  const auto problem = findExportFormat(format)->write(input, target);
  return problem ? "problem: " + *problem : sink.take();
}

std::vector<std::string> read(std::string_view mtg) {
  auto result = readMtg(mtg);
  return std::holds_alternative<std::string>(result) ? std::vector{std::get<std::string>(result)}
                                                     : std::get<MtgStrings>(std::move(result)).strings;
}

std::vector<std::string> linesOf(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = text.find('\n', begin);
    lines.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return lines;
}

TEST(Mtg, ACopyThatWasCutIsRefused) {
  TurtleRun run("F(2)[+(90)F(1)L]F(3)");
  const std::string mtg = written(run, "mtg");
  ASSERT_TRUE(mtg.ends_with("\n# end\n"));
  const std::size_t head = mtg.find("MTG:\n");
  std::size_t refused = 0;
  for (std::size_t size = head; size + 1 < mtg.size(); ++size) {
    const std::string said = read(mtg.substr(0, size)).front();
    refused += said.find("the file was cut: its last line is not '# end', as its head says. Get a complete copy") !=
                       std::string::npos
                   ? 1
                   : 0;
    ASSERT_NE(said.find(": "), std::string::npos) << said;
  }
  EXPECT_GT(refused, 100U);
  // the last line is whole without its end, or with that of another system
  EXPECT_EQ(read(mtg.substr(0, mtg.size() - 1)), std::vector<std::string>{"F(2)[+(90)F(1)L]F(3)"});
  EXPECT_EQ(read(mtg.substr(0, mtg.size() - 1) + "\r\n\n"), std::vector<std::string>{"F(2)[+(90)F(1)L]F(3)"});
}

TEST(Mtg, TopologyIsAsTheBranchesAre) {
  TurtleRun run("F(2)[+(90)F(1)L]F(3)");
  const std::string mtg = written(run, "mtg");
  const std::size_t begin = mtg.find("MTG:\n");
  const auto lines = linesOf(mtg.substr(begin));
  ASSERT_EQ(lines.size(), 8U);
  EXPECT_EQ(lines[1],
            "ENTITY-CODE\t\t\tText\tModule\tXX\tYY\tZZ\tHX\tHY\tHZ\tDiameter\tColor\tOrder\tLength\tParent\tTime\tP1");
  EXPECT_EQ(lines[2], "/P1/A1");
  // nothing before it says where it begins
  EXPECT_EQ(lines[3], "\t/F1\t\tF(2)\t0\t0\t2\t0\t0\t1\t0\t1\t128\t0\t\t\t\t2");
  EXPECT_TRUE(lines[4].starts_with("\t\t+A2/F2\t+(90)F(1)\t3\t-1\t2\t0\t-1\t")) << lines[4];
  EXPECT_TRUE(lines[4].ends_with("\t1\t1\t0\t\t1")) << lines[4];
  EXPECT_TRUE(lines[5].starts_with("\t\t^<L3\tL\t4\t-1\t2\t0\t")) << lines[5];
  EXPECT_TRUE(lines[5].ends_with("\t1\t0\t3\t")) << lines[5];
  EXPECT_TRUE(lines[6].starts_with("\t^<F4\t\tF(3)\t6\t0\t5\t0\t")) << lines[6];
  EXPECT_TRUE(lines[6].ends_with("\t0\t3\t0\t\t3")) << lines[6];
}

TEST(Mtg, EveryBracketedStringIsReadBack) {
  for (const char* const text :
       {"F", "F(1.5)[+(30)F]F", "[F]F", "[[F]]", "[]", "F[]F[[A]B]", "+(3)", "F[+(3)]-(2)", "A[B[C[D]E]F]G[H][I]J",
        "ABCDEFGHIJ[A]PZ", "~l(2)@O(0.5)F#(2)\\(30);(3){.f.}", "P[Z]Y"}) {
    TurtleRun run(text);
    EXPECT_EQ(read(written(run, "mtg")), std::vector<std::string>{run.text()}) << text;
  }
}

TEST(Mtg, RandomStringsAreReadBack) {
  std::mt19937 random(7);
  for (int i = 0; i < 200; ++i) {
    std::string text;
    int open = 0;
    for (int k = 0; k < 40; ++k) {
      const unsigned choice = random() % 8;
      if (choice == 0) {
        text += "[";
        ++open;
      } else if (choice == 1 && open > 0) {
        text += "]";
        --open;
      } else if (choice < 5) {
        text += std::string(1, static_cast<char>('A' + random() % 5)) + "(" + std::to_string(random() % 1000) + ")";
      } else {
        text += choice == 5 ? "+" : choice == 6 ? "-(20)" : "F";
      }
    }
    text += std::string(static_cast<std::size_t>(open), ']');
    TurtleRun run(text);
    ASSERT_EQ(read(written(run, "mtg")), std::vector<std::string>{run.text()}) << text;
  }
}

TEST(Mtg, BracketsThatDoNotMatchAreRefused) {
  TurtleRun open("F[F");
  EXPECT_EQ(written(open, "mtg"),
            "problem: the branch that module 1 of plant 0 opens is never closed; an MTG has whole branches only");
  TurtleRun closed("F]F");
  EXPECT_EQ(written(closed, "mtg"),
            "problem: module 1 of plant 0 closes a branch that none opened; an MTG has whole branches only");
}

constexpr const char* kHead =
    "CODE:\tFORM-A\nCLASSES:\nSYMBOL\tSCALE\tDECOMPOSITION\tINDEXATION\tDEFINITION\n$\t0\tFREE\tFREE\tIMPLICIT\n"
    "P\t1\tFREE\tFREE\tIMPLICIT\nA\t2\tFREE\tFREE\tIMPLICIT\nU\t3\tFREE\tFREE\tEXPLICIT\n"
    "DESCRIPTION:\nLEFT\tRIGHT\tRELTYPE\tMAX\nU\tU\t+\t?\nU\tU\t<\t1\nFEATURES:\nNAME\tTYPE\n";

TEST(Mtg, AFileOfThreeScalesIsReadAtTheFinest) {
  // plants of axes of growth units; a branch is an axis whose first unit grows on a unit
  const std::string mtg = std::string(kHead) +
                          "Length\tREAL\nSpecies\tALPHA\nMTG:\nENTITY-CODE\t\t\tLength\tSpecies\n"
                          "/P1/A1\t\t\t\tapple # a comment\n"
                          "\t/U1\t\t10\n"
                          "\t\t+A2/U1\t2.5\n"
                          "\t\t^<U2\t3\n"
                          "\t^<U2\t\t8\n"
                          "/P2/A1/U1\t\t\t4\n"
                          "^<U2\n";
  EXPECT_EQ(read(mtg), (std::vector<std::string>{"U(10)[U(2.5)U(3)]U(8)", "U(4)U(0)"}));
}

TEST(Mtg, BlanksAroundColonsAndWindowsLineEndsAreRead) {
  std::string mtg =
      "CODE :\tFORM-A\n\nCLASSES :\nSYMBOL\tSCALE\tDECOMPOSITION\tINDEXATION\tDEFINITION\n$\t0\tFREE\tFREE\tIMPLICIT\n"
      "plant\t1\tFREE\tFREE\tIMPLICIT\ninternode\t2\tFREE\tFREE\tIMPLICIT\n\nDESCRIPTION :\n"
      "LEFT\tRIGHT\tRELTYPE\tMAX\ninternode\tinternode\t<\t1\n\nFEATURES :\nNAME\tTYPE\n\nMTG :\nENTITY-CODE\n\n"
      "/plant1\n\t/internode1\n\t\t+internode2\n\t\t\t+internode3\n\t^<internode4\n";
  const std::vector<std::string> expected{"internode[internode[internode]]internode"};
  EXPECT_EQ(read(mtg), expected);
  for (std::size_t at = 0; (at = mtg.find('\n', at)) != std::string::npos; at += 2) {
    mtg.replace(at, 1, "\r\n");
  }
  EXPECT_EQ(read(mtg), expected);
}

TEST(Mtg, OneScaleWithoutPlantsIsOneString) {
  EXPECT_EQ(
      read("CODE: FORM-A\nCLASSES:\nSYMBOL\tSCALE\n$\t0\nE\t1\nFEATURES:\nNAME\tTYPE\nMTG:\nTOPO\n/E1\n^<E2\n\t+E3\n"
           "\t+E4\n^<E5\n"),
      std::vector<std::string>{"EE[E][E]E"});
}

// after the files that other programs write: what each is known for, in words of our own
TEST(Mtg, EntitiesInOneCodeAreAllThereAndFeaturesBelongToTheLast) {
  EXPECT_EQ(
      read(std::string(kHead) + "Length\tREAL\nMTG:\nTOPO\t\t\tLength\n/P1/A1/U1<U2<U3\t\t\t5\n\t+A2/U1<U2\t\t7\n"),
      std::vector<std::string>{"U(0)U(0)U(5)[U(0)U(7)]"});
}

TEST(Mtg, OlderFilesGoOnWithTheFirstColumnWithoutASign) {
  EXPECT_EQ(read(std::string(kHead) + "MTG:\nTOPO\n/P1/A1/U1\n<U2<U3\n\t+A2/U1\n<U4\n/P2/A1/U1\n"),
            (std::vector<std::string>{"UUU[U]U", "U"}));
}

TEST(Mtg, AnUndeclaredSceneIsAboveThePlantsAndScalesMayBeLeftOut) {
  EXPECT_EQ(read("CODE:\tFORM-A\nCLASSES:\nSYMBOL\tSCALE\n$\t0\nIndividual\t1\nAxis\t2\nInternode\t3\nLeaf\t3\n"
                 "DESCRIPTION:\nLEFT\tRIGHT\tRELTYPE\tMAX\nFEATURES:\nNAME\tTYPE\nWidth\tREAL\nMTG:\n"
                 "ENTITY-CODE\t\tWidth\n/Scene0\n^/Individual0\n^/Axis0\n^/"
                 "Internode0\n\t+Leaf0\t6.0\n^<Internode1\n\t+Leaf0\t7.0\n"),
            std::vector<std::string>{"Internode[Leaf(6)]Internode[Leaf(7)]"});
  EXPECT_EQ(read(std::string(kHead) + "MTG:\nENTITY-CODE\n/P1/U1\n^<U2\n"), std::vector<std::string>{"UU"});
}

TEST(Mtg, ASeriesOfEntitiesIsWrittenByItsEnds) {
  EXPECT_EQ(read(std::string(kHead) +
                 "Length\tREAL\nMTG:\nTOPO\t\t\tLength\n/P1/A1/U1<<U4\t\t\t5\n^<U5<<U6\n\t+A2/U1<U2++U4\n"),
            std::vector<std::string>{"U(0)U(0)U(0)U(5)U(0)U(0)[U(0)U(0)[U(0)[U(0)]]]"});
}

TEST(Mtg, OfAnEntityThatIsObservedAgainTheLastNumbersCount) {
  EXPECT_EQ(read(std::string(kHead) + "Length\tREAL\nWidth\tREAL\nMTG:\nENTITY-CODE\t\t\tLength\tWidth\n"
                                      "/P1/A1\n^/U1\t\t\t93.5\t3\n*\t\t\t152\n^<U2\t\t\t7\t1\n"),
            std::vector<std::string>{"U(152,3)U(7,1)"});
}

TEST(Mtg, AllModulesOfAClassHaveTheParametersThatAnyOfThemHas) {
  const std::string mtg =
      "CODE: FORM-A\nCLASSES:\nSYMBOL\tSCALE\n$\t0\nP\t1\nInternode\t2\nLeaf\t2\nFEATURES:\nNAME\tTYPE\nLength\tREAL\n"
      "Width\tREAL\nAngle\tREAL\nMTG:\nENTITY-CODE\t\tLength\tWidth\tAngle\n/P1\n^/"
      "Internode1\t\t12\tNA\n\t+Leaf1\t\t\t40\n"
      "^<Internode2\t\t\t0.5\n";
  const auto result = std::get<MtgStrings>(readMtg(mtg));
  EXPECT_EQ(result.strings, std::vector<std::string>{"Internode(12,0)[Leaf(40)]Internode(0,0.5)"});
  EXPECT_EQ(result.modules, "Internode(Length,Width), Leaf(Angle)");
  // the first internode's width, which is NA, and the second's length
  EXPECT_EQ(result.missingNumbers, 2U);
}

MtgStrings readFile(const std::string& name) {
  std::ifstream file(sourceFolder() + "/tests/engine/turtle/export/text/mtg/" + name, std::ios::binary);
  EXPECT_TRUE(file.good()) << name;
  auto result = readMtg(std::string(std::istreambuf_iterator<char>(file), {}));
  if (const auto* problem = std::get_if<std::string>(&result)) {
    ADD_FAILURE() << name << ":" << *problem;
    return {};
  }
  return std::get<MtgStrings>(std::move(result));
}

TEST(Mtg, FilesOfOtherProgramsAreRead) {
  // what each draws, from its text by hand
  const MtgStrings simple = readFile("simple_plant.mtg");
  EXPECT_EQ(simple.strings, std::vector<std::string>{"Internode(0)[Leaf]Internode(170)[Leaf]"});
  EXPECT_EQ(simple.modules, "Internode(XEuler), Leaf");
  EXPECT_EQ(readFile("simple_plant-P1U1.mtg").strings,
            std::vector<std::string>{"Internode(1)[Leaf]Internode(180)[Leaf]"});
  // the first leaf's numbers stand two columns too far to the left there; those of the others are features of text
  EXPECT_EQ(readFile("simple_plant_3.mtg").strings,
            std::vector<std::string>{"Internode[Leaf(10,6)][Internode[Leaf(0,0)]]Internode[Internode[Leaf(0,0)]]"});
  const MtgStrings palm = readFile("palm.mtg");
  EXPECT_EQ(palm.strings, std::vector<std::string>{"Internode[Leaf]"});
  EXPECT_EQ(palm.modules, "Internode, Leaf");
  // ten nodes on the trunk; branches of eight and of seven nodes on its third and fourth
  EXPECT_EQ(readFile("simple_plant-follow.mtg").strings, std::vector<std::string>{"NNN[NNNNNNNN]N[NNNNNNN]NNNNNN"});
}

TEST(Mtg, MistakesAreNamedWithTheirLine) {
  EXPECT_EQ(read(""),
            std::vector<std::string>{"0: the file has no entities: it is no MTG, or ends before its section MTG"});
  EXPECT_EQ(read("hello\n"), std::vector<std::string>{"1: expected 'CODE:', 'CLASSES:', 'FEATURES:' or 'MTG:'"});
  const auto problem = [](const std::string& graph) {
    return read(std::string(kHead) + "MTG:\nENTITY-CODE\n" + graph).front();
  };
  EXPECT_EQ(problem("/P1/X1\n"), "16: the class 'X' is not in the section CLASSES");
  EXPECT_EQ(problem("/P1\n\t^<U1\n"), "17: '^' follows no entity of its column");
  EXPECT_EQ(problem("/P1\n\tU1\n"),
            "17: expected '/', '<' or '+' before an entity, found 'U1' (columns are separated by tabs)");
  EXPECT_EQ(problem("/P1\n\t/7\n"), "17: expected the class of an entity, found '7'");
  EXPECT_EQ(problem("+P1\n"), "16: '+P' has no entity before it to join");
  EXPECT_EQ(problem("/P1/A1\n^+P2/U1\n\t<A3\n"), "18: '<A' has no entity of its scale before it to join");
  EXPECT_EQ(problem("*\n"), "16: '*' follows no entity of its column");
  EXPECT_EQ(problem("/P1/U3<<U3\n"), "16: '<<U3' needs an entity 'U' with a smaller number before it");
  EXPECT_EQ(problem("/P1++U3\n"), "16: '++U3' needs an entity 'U' with a smaller number before it");
  EXPECT_EQ(problem("/P1/U3<<U1000004\n"),
            "16: with '<<U1000004' the series of the file have more than 1000000 entities");
  // several series share the bound
  EXPECT_EQ(problem("/P1/U1<<U600001\n/P2/U1<<U600001\n"),
            "17: with '<<U600001' the series of the file have more than 1000000 entities");
  EXPECT_EQ(problem("/P1/U99999999999999999999\n"), "16: the number of 'U99999999999999999999' is too large");
  EXPECT_EQ(read("CLASSES:\nSYMBOL\tSCALE\nP\tone\n").front(), "3: the scale of class 'P' is not a whole number");
}

TEST(Mtg, WhatIsNoNumberInAColumnOfNumbersIsRefused) {
  const auto of = [](const std::string& type, const std::string& cells) {
    return read(std::string(kHead) + "Width\tREAL\nLength\t" + type +
                "\nMTG:\nENTITY-CODE\t\t\tWidth\tLength\n/P1/U1\t\t\t" + cells + "\n")
        .front();
  };
  EXPECT_EQ(
      of("REAL", "1\t0,5"),
      "18: expected a number in the column 'Length', found '0,5'. Write it with a decimal point, or leave the cell "
      "empty");
  EXPECT_EQ(
      of("INT", "12 cm\t3"),
      "18: expected a number in the column 'Width', found '12 cm'. Write it with a decimal point, or leave the cell "
      "empty");
  EXPECT_EQ(
      of("INT", "1\tinf"),
      "18: expected a number in the column 'Length', found 'inf'. Write it with a decimal point, or leave the cell "
      "empty");
  // also where an entity is observed again
  EXPECT_EQ(
      of("REAL", "1\t2\n*\t\t\t1\t2,5"),
      "19: expected a number in the column 'Length', found '2,5'. Write it with a decimal point, or leave the cell "
      "empty");
  EXPECT_EQ(of("REAL", "+1.5\t-2e1"), "U(1.5,-20)");
  EXPECT_EQ(of("REAL", "nan\t2"), "U(2)");
  // text may be anything
  EXPECT_EQ(of("ALPHA", "1\t0,5"), "U(1)");
}

TEST(ModuleTable, FormatsOfModulesSayHowFarTheyAre) {
  for (const char* format : {"csv", "mtg"}) {
    TurtleRun run("F[+F]F");
    std::uint64_t lastDone = 0;
    std::uint64_t lastTotal = 0;
    static_cast<void>(written(run, format, [&](std::uint64_t done, std::uint64_t total) {
      lastDone = done;
      lastTotal = total;
    }));
    EXPECT_EQ(lastDone, 6U) << format;
    EXPECT_EQ(lastTotal, 6U) << format;
  }
}

TEST(ModuleTable, EveryModuleHasARowWithItsState) {
  TurtleRun run("F(2)[+(90)F(1)]@O(3)\"");
  const auto rows = linesOf(written(run, "csv"));
  ASSERT_EQ(rows.size(), 9U);
  EXPECT_EQ(rows[0], "plant,module,symbol,parameters,x,y,z,hx,hy,hz,lx,ly,lz,ux,uy,uz,width,colour,order,parent");
  EXPECT_EQ(rows[1], "0,0,F,2,0,2,0,0,1,0,-1,0,0,0,0,-1,1,128,0,");
  EXPECT_EQ(rows[2], "0,1,[,,0,2,0,0,1,0,-1,0,0,0,0,-1,1,128,0,0");
  EXPECT_TRUE(rows[3].starts_with("0,2,+,90,0,2,0,-1,")) << rows[3];
  EXPECT_TRUE(rows[3].ends_with(",1,0")) << rows[3];
  EXPECT_TRUE(rows[4].starts_with("0,3,F,1,-1,2,0,")) << rows[4];
  EXPECT_TRUE(rows[4].ends_with(",1,2")) << rows[4];
  EXPECT_TRUE(rows[5].starts_with("0,4,],,0,2,0,")) << rows[5];
  // the two symbols of a ball stand together; both have the state after it
  EXPECT_TRUE(rows[6].starts_with("0,5,@,,0,2,0,")) << rows[6];
  EXPECT_TRUE(rows[7].starts_with("0,6,O,3,0,2,0,")) << rows[7];
  EXPECT_TRUE(rows[8].starts_with("0,7,\"\"\"\",,0,2,0,")) << rows[8];
}

TEST(ModuleTable, WhatWasCutOffHasNoState) {
  files::ViewSettings view;
  view.interpretsPastCut = false;
  TurtleRun run("F[%F]F", view);
  const auto rows = linesOf(written(run, "csv"));
  ASSERT_EQ(rows.size(), 7U);
  EXPECT_EQ(rows[4], "0,3,F,,,,,,,,,,,,,,,,1,2");
  EXPECT_TRUE(rows[6].starts_with("0,5,F,,0,2,0,")) << rows[6];
}

}  // namespace
}  // namespace espalier::turtle::mtg_test
