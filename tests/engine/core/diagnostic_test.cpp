#include "engine/core/diagnostic.h"

#include <gtest/gtest.h>

#include "engine/core/message_text.h"

namespace espalier::core::diagnostic_test {
namespace {

TEST(Diagnostic, ShowsPlaceLineCaretAndHint) {
  const Diagnostic diagnostic{Severity::Error,
                              "unknown name 'ww' in the successor of A(l,w)",
                              {"tree.l", 12, 33, 2, "A(l,w) : l > 1 --> F(l)[+A(l*R, ww)]A(l*R, w)", ""},
                              "did you mean 'w'?"};
  EXPECT_EQ(formatDiagnostic(diagnostic),
            "tree.l:12:33: error: unknown name 'ww' in the successor of A(l,w)\n"
            "   12 | A(l,w) : l > 1 --> F(l)[+A(l*R, ww)]A(l*R, w)\n"
            "      |                                 ^~\n"
            "   hint: did you mean 'w'?");
}

TEST(Diagnostic, KeepsTabsBelowTabs) {
  const Diagnostic diagnostic{Severity::Warning, "odd", {"a.l", 3, 3, 1, "\tAB", ""}, ""};
  EXPECT_EQ(formatDiagnostic(diagnostic), "a.l:3:3: warning: odd\n    3 | \tAB\n      | \t ^");
}

TEST(Diagnostic, UnderlineStaysOnTheLine) {
  const Diagnostic diagnostic{Severity::Error, "m", {"a.l", 1, 2, 99, "ABC", ""}, ""};
  EXPECT_EQ(formatDiagnostic(diagnostic), "a.l:1:2: error: m\n    1 | ABC\n      |  ^~");
}

TEST(Diagnostic, TheCaretStandsBelowItsCharacterInUtf8) {
  const Diagnostic diagnostic{Severity::Error, "m", {"a.txt", 2, 6, 3, "δ = xé", ""}, ""};
  EXPECT_EQ(formatDiagnostic(diagnostic), "a.txt:2:5: error: m\n    2 | δ = xé\n      |     ^~");
}

TEST(Diagnostic, ColumnsCountCharacters) {
  EXPECT_EQ(placeText({"a.l", 1, 8, 1, "äöü A", ""}), "a.l:1:5");
  // Latin-1: each byte is a character
  EXPECT_EQ(placeText({"a.l", 1, 5, 1, "\xB0\xE4\xF6 A", ""}), "a.l:1:5");
  // beyond the line, and without it
  EXPECT_EQ(placeText({"a.l", 1, 9, 1, "äB", ""}), "a.l:1:8");
  EXPECT_EQ(placeText({"a.l", 1, 9, 1, "", ""}), "a.l:1:9");
}

TEST(Diagnostic, PlaceBeyondTheLineStillHasACaret) {
  const Diagnostic diagnostic{Severity::Error, "m", {"a.l", 1, 9, 1, "ABC", ""}, ""};
  EXPECT_EQ(formatDiagnostic(diagnostic), "a.l:1:9: error: m\n    1 | ABC\n      |    ^");
}

TEST(Diagnostic, WithoutAPlaceIsOneLine) {
  EXPECT_EQ(formatDiagnostic({Severity::Error, "cannot read 'x.l'", {}, ""}), "error: cannot read 'x.l'");
  EXPECT_EQ(formatDiagnostic({Severity::Error, "cannot be read", {"x.l", 0, 0, 1, "", ""}, ""}),
            "x.l: error: cannot be read");
}

TEST(Diagnostic, ShowsTheMacroExpansion) {
  const Diagnostic diagnostic{Severity::Note, "m", {"a.l", 1, 1, 1, "R", "in the expansion of R (a.l:3:9)"}, ""};
  EXPECT_EQ(formatDiagnostic(diagnostic), "a.l:1:1: note: m\n    1 | R\n      | ^\n   in the expansion of R (a.l:3:9)");
}

TEST(DiagnosticList, KeepsAtMostTheLimitAndCountsAll) {
  DiagnosticList list;
  for (std::size_t i = 0; i < DiagnosticList::kLimit + 7; ++i) {
    list.add({Severity::Error, "e", {}, ""});
  }
  list.add({Severity::Warning, "w", {}, ""});
  EXPECT_EQ(list.errorCount(), DiagnosticList::kLimit + 7);
  EXPECT_EQ(list.entries().size(), DiagnosticList::kLimit + 1);
  EXPECT_TRUE(list.hasErrors());
}

TEST(NearestName, FindsTypingMistakes) {
  EXPECT_EQ(nearestName("chibba", {"clover", "chiba", "honda"}), "chiba");
  EXPECT_EQ(nearestName("hodna", {"clover", "chiba", "honda"}), "honda");
  EXPECT_EQ(nearestName("Sin", {"cos", "sin"}), "sin");
}

TEST(NearestName, FindsNothingFarAway) {
  EXPECT_EQ(nearestName("zzzz", {"clover", "chiba"}), "");
  EXPECT_EQ(nearestName("x", {"y"}), "");
  EXPECT_EQ(nearestName("ww", {"w", "l"}), "w");
  // of two that are as near the first
  EXPECT_EQ(nearestName("shade", {"share", "shape", "shadow"}), "share");
}

TEST(SuggestName, NamesTheNearestAndTheList) {
  EXPECT_EQ(suggestName("chibba", {"chiba", "clover"}), "Did you mean 'chiba'? Available: chiba, clover.");
  EXPECT_EQ(suggestName("wind", {"chiba", "clover"}), "Available: chiba, clover.");
}

}  // namespace
}  // namespace espalier::core::diagnostic_test
