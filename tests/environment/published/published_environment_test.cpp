#include <gtest/gtest.h>

#include "environment/published/published_environment.h"
#include "tests/environment/query_builder.h"

namespace espalier::environment::published_environment_test {
namespace {

using core::Compatibility;

struct Loaded {
  std::unique_ptr<turtle::EnvironmentProcess> process;
  std::string errors;
  std::string warnings;
};

Loaded load(const std::map<std::string, std::string>& contents, Compatibility compatibility = Compatibility::Cpfg,
            const std::string& file = "m/model.e") {
  core::MemoryFileProvider files(contents);
  std::vector<core::Diagnostic> warnings;
  auto made = makeFromEnvironmentFile(file, files, compatibility, warnings);
  Loaded loaded;
  loaded.errors = errorsOf(made);
  if (made) {
    loaded.process = std::move(*made);
    EXPECT_FALSE(loaded.process->open({}));
  }
  for (const core::Diagnostic& warning : warnings) {
    loaded.warnings += (loaded.warnings.empty() ? "" : "\n") + core::formatDiagnostic(warning);
  }
  return loaded;
}

constexpr const char* kHonda = "executable: honda81 -e model.e model.spec\nturtle position: P: %.0f %.0f %.0f\n";

constexpr const char* kExact = "executable: honda81 -e model.e model.spec\nturtle position: P: %.4f %.4f %.4f\n";

std::vector<double> roundingAnswers(turtle::EnvironmentProcess& process) {
  QueryBuilder builder;
  builder.add({0, 0, 0}, {1}).add({0.4, 0, 0.4}, {2}).add({3.4, 0, 0}, {1}).add({3.6, 0, 0}, {1}).add({6.5, 0, 0}, {1});
  builder.add({7.5, 0, 0}, {1});
  return firstValues(answersOf(process, builder.batch()));
}

TEST(PublishedEnvironment, CompatibleModesRoundThroughTheFormatsAsCase182) {
  const Loaded loaded = load({{"m/model.e", kHonda}, {"m/model.spec", "radius: 0.1\n3d case: on\n"}});
  EXPECT_EQ(loaded.errors, "");
  EXPECT_EQ(loaded.warnings, "");
  EXPECT_EQ(roundingAnswers(*loaded.process), (std::vector<double>{0, 1, 1, 1, 1, 1}));
}

TEST(PublishedEnvironment, EspaliersOwnModeExchangesExactly) {
  const Loaded loaded =
      load({{"m/model.e", kHonda}, {"m/model.spec", "radius: 0.1\n3d case: on\n"}}, Compatibility::Espalier);
  EXPECT_EQ(roundingAnswers(*loaded.process), (std::vector<double>{1, 1, 1, 1, 1, 1}));
}

TEST(PublishedEnvironment, AFileHasAtMostFiftyWarningsAndErrors) {
  std::string unknown = "executable: honda81 model.spec\n";
  std::string wrong;
  for (int i = 0; i < 60; ++i) {
    unknown += "bogus" + std::to_string(i) + ": 1\n";
    wrong += "turtle position: %d\n";
  }
  const auto count = [](const std::string& text, const std::string& word) {
    std::size_t found = 0;
    for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
      ++found;
    }
    return found;
  };
  const Loaded warned = load({{"m/model.e", unknown}, {"m/model.spec", ""}});
  EXPECT_EQ(count(warned.warnings, "unknown keyword"), core::DiagnosticList::kLimit);
  const Loaded failed = load({{"m/model.e", wrong}});
  EXPECT_EQ(count(failed.errors, "'turtle position'"), core::DiagnosticList::kLimit) << failed.errors;
}

TEST(PublishedEnvironment, SpecificationIsReadBesideTheEnvironmentFile) {
  const Loaded loaded =
      load({{"model.e", "executable: /opt/bin/honda81.exe model.spec -e model.e"}, {"model.spec", "radius: 100"}},
           Compatibility::Espalier, "model.e");
  EXPECT_EQ(loaded.errors, "");
  EXPECT_EQ(roundingAnswers(*loaded.process), (std::vector<double>{0, 1, 0, 0, 0, 0}));
}

TEST(PublishedEnvironment, UnknownKeywordsAreIgnoredWithAWarning) {
  const Loaded loaded =
      load({{"m/model.e", kHonda}, {"m/model.spec", "radius: 5\n3D case: on\n"}}, Compatibility::Espalier);
  EXPECT_EQ(loaded.errors, "");
  EXPECT_EQ(loaded.warnings,
            "m/model.spec:2:1: warning: unknown keyword '3D case' of 'honda' is ignored\n"
            "    2 | 3D case: on\n      | ^~~~~~~\n"
            "   hint: Did you mean '3d case'? Available: radius, 3d case.");
}

TEST(PublishedEnvironment, ASwitchThatIsNeitherOnNorOffIsOffWithAWarning) {
  const Loaded loaded = load({{"m/model.e", kHonda}, {"m/model.spec", "3d case: one\n"}});
  EXPECT_EQ(loaded.warnings.substr(0, loaded.warnings.find('\n')),
            "m/model.spec:1:10: warning: '3d case' is switched on only by 'on': taken as off");
}

std::string firstWarning(const std::string& program, const std::string& specification) {
  const Loaded loaded =
      load({{"m/model.e", "executable: " + program + " -e model.e model.spec\n"}, {"m/model.spec", specification}});
  EXPECT_EQ(loaded.errors, "");
  return loaded.warnings.substr(0, loaded.warnings.find('\n'));
}

TEST(PublishedEnvironment, OnlyTheExactWordOfASwitchCounts) {
  for (const char* line :
       {"3d case: on", "3d case\ton", "3d case: off", "3d case: no", "verbose: on", "verbose: off"}) {
    EXPECT_EQ(firstWarning("honda81", line), "") << line;
  }
  EXPECT_EQ(firstWarning("honda81", "3d case: yes"),
            "m/model.spec:1:10: warning: '3d case' is switched on only by 'on': taken as off");
  EXPECT_EQ(firstWarning("ecosystem", "3d case: yes"), "");
  EXPECT_EQ(firstWarning("chiba", "use CIE formula: on"),
            "m/model.spec:1:18: warning: 'use CIE formula' is switched on only by 'yes': taken as off");
  EXPECT_EQ(firstWarning("chiba", "estimate intersection area: yes"),
            "m/model.spec:1:29: warning: 'estimate intersection area' is switched on only by 'on': taken as off");
  EXPECT_EQ(firstWarning("soil", "depletion: none"),
            "m/model.spec:1:12: warning: 'depletion' is switched off only by 'off': taken as on");
  EXPECT_EQ(firstWarning("soil", "depletion: off"), "");
  EXPECT_EQ(firstWarning("clover", "z is up: maybe"),
            "m/model.spec:1:10: warning: 'z is up' is switched off only by 'no' or 'off': taken as yes");
  EXPECT_EQ(firstWarning("clover", "remove old leaves: on\nz is up: no"), "");
}

TEST(PublishedEnvironment, NumbersAreReadAsThePublishedProgramsDo) {
  // a recorded run of honda81: two tips at one place and two 0.4 apart
  const auto answers = [](const std::string& specification) {
    const Loaded loaded = load({{"m/model.e", kExact}, {"m/model.spec", specification}});
    EXPECT_EQ(loaded.errors, "");
    QueryBuilder builder;
    builder.add({0, 0, 0}, {1}).add({0.4, 0, 0}, {1}).add({5, 0, 0}, {1}).add({5, 0, 0}, {1});
    return firstValues(answersOf(*loaded.process, builder.batch()));
  };
  EXPECT_EQ(answers("radius: 0.5m, say"), (std::vector<double>{0, 0, 0, 0}));
  EXPECT_EQ(answers("radius\t0.5"), (std::vector<double>{0, 0, 0, 0}));
  EXPECT_EQ(answers("radius: half"), (std::vector<double>{1, 1, 0, 0}));
  EXPECT_EQ(answers("radius:"), (std::vector<double>{1, 1, 0, 0}));
}

TEST(PublishedEnvironment, WhatIsDroppedOfNumbersIsAWarning) {
  EXPECT_EQ(firstWarning("honda81", "radius: 0.5m, say"),
            "m/model.spec:1:9: warning: 'radius': '0.5m, say' is read as '0.5'");
  EXPECT_EQ(firstWarning("honda81", "radius: half"), "m/model.spec:1:9: warning: 'radius': 'half' is read as '0'");
  EXPECT_EQ(firstWarning("clover", "grid size: 100x100view"),
            "m/model.spec:1:12: warning: 'grid size': '100x100view' is read as '100 100'");
  EXPECT_EQ(firstWarning("clover", "grid size: 4x"),
            "m/model.spec:1:12: warning: 'grid size' has 1 of 2 numbers: the others keep their defaults");
  EXPECT_EQ(firstWarning("chiba", "grid size: 4view"),
            "m/model.spec:1:12: warning: 'grid size': '4view' is read as '4'; it has 1 of 3 numbers: the others keep "
            "their defaults");
  EXPECT_EQ(firstWarning("honda81", "radius:"),
            "m/model.spec:1:1: warning: 'radius' has 0 of 1 number: the default counts");
  EXPECT_EQ(firstWarning("soil", "geotropic angles: 1 2 3\nlayer thicknesses: 1+2\n"),
            "m/model.spec:1:19: warning: 'geotropic angles' has 3 angles for 2 layers: the others are ignored");
  EXPECT_EQ(firstWarning("chiba", "source direction: 0 1 0"),
            "m/model.spec:1:19: warning: 'source direction' needs 4 numbers, found 3: the line is dropped");
  EXPECT_EQ(firstWarning("chiba", "radius: 1\n5 6\n"),
            "m/model.spec:2:1: warning: line of numbers is ignored: 'radius' takes none");
  EXPECT_EQ(firstWarning("soil", "diffusion: much"),
            "m/model.spec:1:12: warning: 'diffusion' is read as 0 sweeps: the "
            "rest is ignored");
}

TEST(PublishedEnvironment, AMissingNumberLeavesTheDefault) {
  // 4 columns and 512 rows of the raster −1 … 1: a leaf of radius 0.001 at the origin covers the cells 1 and 2 of x
  const Loaded loaded = load({{"m/model.e", "executable: clover -e model.e model.spec\nturtle position: %f %f %f\n"},
                              {"m/model.spec", "grid size: 4x\n"}});
  QueryBuilder builder;
  builder.add({0.1, 0.001, 0}, {1, 3.2e-6}).add({-0.4, 0.001, 0}, {0}).add({0.4, 0.001, 0}, {0});
  builder.add({0.4, -0.003, 0}, {0}).add({0.4, -0.006, 0}, {0});
  const auto light = firstValues(answersOf(*loaded.process, builder.batch()));
  EXPECT_EQ((std::vector<double>{light.begin() + 1, light.end()}), (std::vector<double>{0.6, 0.6, 0.6, 1}));
}

TEST(PublishedEnvironment, WrongValuesAreLocatedInTheSpecification) {
  EXPECT_EQ(load({{"m/model.e", kHonda}, {"m/model.spec", "radius: -2\n"}}).errors,
            "m/model.spec:1:9: error: environment process 'honda': 'radius' must be at least 0, found -2\n"
            "    1 | radius: -2\n      |         ^~\n   hint: radius: distance up to which tips collide");
  EXPECT_EQ(load({{"m/model.e", kHonda}, {"m/model.spec", "radius: 1e999\n"}}).errors,
            "m/model.spec:1:9: error: 'radius' has a number that is too large\n"
            "    1 | radius: 1e999\n      |         ^~~~~\n   hint: write a number below 1e308");
}

TEST(PublishedEnvironment, WhatFollowsTheValuesIsIgnoredWithAWarning) {
  const Loaded loaded = load({{"m/model.e", kHonda}, {"m/model.spec", "radius: 1 2\n"}});
  EXPECT_EQ(loaded.errors, "");
  EXPECT_EQ(loaded.warnings.substr(0, loaded.warnings.find('\n')),
            "m/model.spec:1:9: warning: 'radius': '1 2' is read as '1'");
}

TEST(PublishedEnvironment, UnknownProgramListsWhatThereIs) {
  const Loaded loaded = load({{"m/model.e", "executable: radiosity -e model.e x.spec\n"}});
  EXPECT_EQ(loaded.errors.find("m/model.e:1:13: error: environment process 'radiosity' is unknown."), 0U)
      << loaded.errors;
  EXPECT_NE(loaded.errors.find("Available: "), std::string::npos);
  EXPECT_NE(loaded.errors.find("    1 | executable: radiosity -e model.e x.spec\n      |             ^~~~~~~~~"),
            std::string::npos)
      << loaded.errors;
}

TEST(PublishedEnvironment, MissingFilesAreNamed) {
  EXPECT_EQ(
      load({}).errors,
      "error: cannot read the environment file 'm/model.e'\n   hint: check the name and that the file can be read");
  const std::string text = load({{"m/model.e", kHonda}}).errors;
  EXPECT_EQ(text.substr(0, text.find('\n')),
            "m/model.e:1:13: error: cannot read the specification file 'm/model.spec'");
}

TEST(PublishedEnvironment, AFileWithoutAProgramIsAnError) {
  const std::string text = load({{"m/model.e", "turtle position: %f %f %f\n"}}).errors;
  EXPECT_EQ(text.substr(0, text.find('\n')), "m/model.e:1:1: error: the environment file names no program");
  const std::string empty = load({{"m/model.e", "executable:\n"}}).errors;
  EXPECT_EQ(empty.substr(0, empty.find('\n')), "m/model.e:1:1: error: 'executable' names no program");
}

TEST(PublishedEnvironment, BadFormatsAreLocated) {
  const std::string text = load({{"m/model.e", "executable: height\nturtle position: P %d %d %d\n"}}).errors;
  EXPECT_EQ(
      text.substr(0, text.find('\n')),
      "m/model.e:2:18: error: 'turtle position': the conversion '%d' does not print a real number; use %f, %e or %g, "
      "as in 'P: %.4f %.4f %.4f'");
}

TEST(PublishedEnvironment, EveryPublishedKeywordIsKnown) {
  const Loaded loaded = load({{"m/model.e",
                               "executable: height\ncommunication type: pipes 10\nturtle position: %f %f %f\n"
                               "turtle heading: %f %f %f\nturtle left: %f %f %f\nturtle up: %f %f %f\n"
                               "turtle line width: %f\nturtle scale factor: %f\nfollowing module: no\nverbose: on\n"
                               "strings only: on\nbinary data: on\n"}});
  EXPECT_EQ(loaded.errors, "");
  EXPECT_EQ(loaded.warnings, "");
  const Loaded other = load({{"m/model.e",
                              "executable: height -x a b\nremote host: h\ninterpreted modules: all\n"
                              "turtle positon: %f\nfollowing module: maybe\nturtle position: %f\n"}});
  for (const char* text :
       {"m/model.e:1:13: warning: option '-x' of the program is ignored",
        "m/model.e:1:13: warning: argument 'b' of the program is ignored",
        "m/model.e:2:1: warning: 'remote host' is not used: the process runs inside Espalier",
        "m/model.e:3:1: warning: 'interpreted modules' is not used: no geometry is sent with a query",
        "m/model.e:4:1: warning: unknown keyword 'turtle positon' is ignored",
        "m/model.e:5:19: warning: 'following module' is neither yes nor no: taken as yes",
        "m/model.e:6:18: warning: 'turtle position' sends 1 of 3 numbers: the others arrive as 0"}) {
    EXPECT_NE(other.warnings.find(text), std::string::npos) << text << "\n" << other.warnings;
  }
}

TEST(PublishedEnvironment, TurtleItemsThatAreNotConfiguredArriveAsZeros) {
  const Loaded loaded = load({{"m/model.e", "executable: height\n"}});
  QueryBuilder builder;
  builder.add({0, 5, 0}, {9});
  EXPECT_EQ(firstValues(answersOf(*loaded.process, builder.batch())), (std::vector<double>{0}));
}

TEST(PublishedEnvironment, TheShadowPyramidReadsItsKeywords) {
  const std::string spec =
      "grid size: 101\ngrid span: 100\nshadow spread: 1\nshadow depth: 6\nshadow weight: 0.5\nshadow dissipation: 6.9\n"
      "light randomness: 0\nlight vertical bias: 0\nsample radius: 1.6\n";
  const Loaded loaded = load(
      {{"m/model.e", "executable: shadowpyramid -e model.e s.spec\nturtle position: %f %f %f\n"}, {"m/s.spec", spec}});
  EXPECT_EQ(loaded.errors, "");
  EXPECT_EQ(loaded.warnings, "");
  QueryBuilder builder;
  builder.add({0, 20, 0}, {1});
  EXPECT_EQ(firstValues(answersOf(*loaded.process, builder.batch())), (std::vector<double>{0.5}));
}

TEST(PublishedEnvironment, MultipleReadsTheFilesOfItsEnvironmentsInOrder) {
  const std::string box = "range: 10 10 10\nposition: -5 -5 -5\ngrid size: 10 10 10\n";
  const std::map<std::string, std::string> contents{
      {"m/model.e", "executable: multiple -e model.e model.spec\nturtle position: %.4f %.4f %.4f\n"},
      {"m/model.spec", "field communication file: honda.e\nfield communication file: sub/voxel.e\n"},
      {"m/honda.e", "executable: honda81 -e honda.e honda.spec\nturtle position: %.4f %.4f %.4f\n"},
      {"m/honda.spec", "radius: 1\n3d case: on\n"},
      {"m/sub/voxel.e", "executable: density3d -e voxel.e voxel.spec\nturtle position: %.4f %.4f %.4f\n"},
      {"m/sub/voxel.spec", box}};
  const Loaded loaded = load(contents);
  EXPECT_EQ(loaded.errors, "");
  EXPECT_EQ(loaded.warnings, "");
  QueryBuilder builder;
  builder.add({0, 0, 0}, {1, 1}).add({0, 0, 0}, {2, 3}).add({0.2, 0, 0}, {1, 2}).add({0.2, 0, 0}, {2, 4});
  const ReplyTable table = answersOf(*loaded.process, builder.batch());
  EXPECT_EQ(table[0][1], 0.0);
  EXPECT_EQ(table[1][1], 3.0);  // string order, as the published programs
  EXPECT_EQ(table[2][1], 1.0);
  EXPECT_EQ(table[3][1], 7.0);
}

TEST(PublishedEnvironment, ErrorsOfMultipleAreLocated) {
  const auto firstLine = [](const std::map<std::string, std::string>& contents) {
    const std::string text = load(contents).errors;
    return text.substr(0, text.find('\n'));
  };
  const std::string executable = "executable: multiple -e model.e model.spec\n";
  EXPECT_EQ(firstLine({{"m/model.e", executable}, {"m/model.spec", "\n"}}),
            "m/model.spec:1:1: error: the specification of 'multiple' names no environment");
  EXPECT_EQ(firstLine({{"m/model.e", executable}, {"m/model.spec", "field communication file: x.e\n"}}),
            "m/model.spec:1:27: error: cannot read the environment file 'm/x.e'");
  EXPECT_EQ(firstLine({{"m/model.e", executable}, {"m/model.spec", "field communication file: model.e\n"}}),
            "m/model.e:1:13: error: an environment of 'multiple' cannot be 'multiple' itself");
  const Loaded loaded = load({{"m/model.e", executable}, {"m/model.spec", "fields: model.e\n"}});
  EXPECT_EQ(loaded.warnings.substr(0, loaded.warnings.find('\n')),
            "m/model.spec:1:1: warning: unknown keyword 'fields' of 'multiple' is ignored");
}

}  // namespace
}  // namespace espalier::environment::published_environment_test
