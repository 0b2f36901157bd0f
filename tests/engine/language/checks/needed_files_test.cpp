#include "engine/language/checks/needed_files.h"

#include <gtest/gtest.h>

#include "tests/engine/language/compile_text.h"

namespace espalier::language::needed_files_test {
namespace {

// errors of a model with a view file beside it, and how many warnings there are
struct Result {
  Messages errors;
  std::size_t warningCount = 0;
  bool isCompiled = false;
};

Result compiled(const std::string& view, const std::string& productions, const std::string& axiom = "A",
                core::Compatibility mode = core::Compatibility::Espalier) {
  core::MemoryFileProvider files({{"m.l", model(productions, axiom)},
                                  {"m.v", view},
                                  {"good.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"},
                                  {"bad.s", "nothing"}});
  CompileInput input;
  input.modelFile = "m.l";
  input.viewFile = "m.v";
  input.compatibility = mode;
  const CompileResult result = compile(input, files);
  Result found;
  for (const core::Diagnostic& diagnostic : result.diagnostics.entries()) {
    if (diagnostic.severity == core::Severity::Error) {
      found.errors.push_back(diagnostic.location.file + ":" + brief(diagnostic));
    }
  }
  found.warningCount = result.diagnostics.warningCount();
  found.isCompiled = result.program != nullptr;
  return found;
}

TEST(NeededFiles, ASurfaceThatIsDrawnAndCannotBeReadIsAnErrorWithBothLines) {
  const Result result = compiled("angle increment: 20\nsurface: l none.s 1\n", "A --> F ~l(2) A");
  EXPECT_FALSE(result.isCompiled);
  EXPECT_EQ(result.errors,
            Messages{"m.v:2:1: error: the model draws with ~l, whose file 'none.s' cannot be used (warning above) | "
                     "needed at m.l:3:10; repair or add the file, or remove this from the model"});
  // a broken file counts as a missing one, in an axiom as in a successor
  EXPECT_EQ(compiled("surface: l bad.s 1\n", "A --> F", "~l").errors.size(), 1U);
  EXPECT_EQ(compiled("tsurface: l none.obj 1\n", "A --> F\nhomomorphism\nA --> ~l").errors.size(), 1U);
}

TEST(NeededFiles, AFileThatTheModelDoesNotDrawStaysAWarning) {
  const Result result = compiled("surface: l none.s 1\ncontour: 2 none.con\ntexture: F none.png\n", "A --> F l");
  EXPECT_TRUE(result.isCompiled);
  EXPECT_EQ(result.errors, Messages{});
  EXPECT_EQ(result.warningCount, 3U);
}

TEST(NeededFiles, ASurfaceThatNoFileDefinesIsAWarningAtItsFirstPlace) {
  core::MemoryFileProvider files({{"m.l", model("A --> F[+~l][-~l]~k A\nhomomorphism\nA --> ~l", "A")}});
  CompileInput input;
  input.modelFile = "m.l";
  const CompileResult result = compile(input, files);
  ASSERT_NE(result.program, nullptr);
  Messages messages;
  for (const core::Diagnostic& diagnostic : result.diagnostics.entries()) {
    messages.push_back(brief(diagnostic));
  }
  const std::string end = " FILE.s' into the view file, which has the model's name and the suffix .v";
  EXPECT_EQ(messages,
            (Messages{"3:11: warning: the surface '~l' is not defined and is not drawn | write 'surface: l" + end,
                      "3:19: warning: the surface '~k' is not defined and is not drawn | write 'surface: k" + end}));
  EXPECT_EQ(compiled("tsurface: l good.obj 1\n", "A --> ~l").warningCount, 0U);
}

TEST(NeededFiles, AnotherFileOfTheSameNameServes) {
  EXPECT_TRUE(compiled("surface: l none.s 1\nsurface: l good.obj 1\n", "A --> ~l").isCompiled);
}

TEST(NeededFiles, ContoursCountByTheirNumbers) {
  const std::string view = "contour: 2 none.con\ntexture: F none.png\n";
  const auto errors = [&view](const std::string& successor) { return compiled(view, "A --> " + successor).errors; };
  EXPECT_EQ(
      errors("@#(2)F"),
      Messages{"m.v:1:1: error: the model draws with contour 2, whose file 'none.con' cannot be "
               "used (warning above) | needed at m.l:3:8; repair or add the file, or remove this from the model"});
  EXPECT_EQ(errors("@#(1)F@#"), Messages{});
  EXPECT_EQ(errors("@Tx(2)F@Tx(0)"), Messages{});
  // a number that is only known in the run
  EXPECT_EQ(compiled(view, "A(i) --> @#(i)F", "A(1)").errors.size(), 1U);
}

TEST(NeededFiles, AMissingTextureStopsNothing) {
  const std::string view = "contour: 2 none.con\ntexture: F none.png\n";
  for (const char* const successor : {"@Tx(1)F", "@Tx(Q)F"}) {
    const Result result = compiled(view, std::string("A --> ") + successor);
    EXPECT_TRUE(result.isCompiled);
    EXPECT_EQ(result.errors, Messages{});
    EXPECT_EQ(result.warningCount, 3U) << successor;
  }
  EXPECT_EQ(compiled(view, "A --> @Tx(2)F").warningCount, 2U);
}

TEST(NeededFiles, ATextureThatASurfaceInUseWearsIsNeeded) {
  const std::string view = "texture: F none.png\nsurface: l good.obj 1 1\n";
  EXPECT_EQ(compiled(view, "A --> ~l").warningCount, 2U);
  EXPECT_EQ(compiled(view, "A --> F").warningCount, 1U);
}

TEST(NeededFiles, TheReferencesModesDrawNothingInstead) {
  const Result result = compiled("surface: l none.s 1\n", "A --> ~l", "A", core::Compatibility::Cpfg);
  EXPECT_TRUE(result.isCompiled);
  EXPECT_EQ(result.errors, Messages{});
}

}  // namespace
}  // namespace espalier::language::needed_files_test
