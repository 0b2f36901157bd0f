#include "engine/core/message_text.h"

#include <gtest/gtest.h>

#include "engine/core/diagnostic.h"

namespace espalier::core::message_text_test {
namespace {

TEST(MessageText, IsUtf8WithoutControlCharacters) {
  EXPECT_EQ(messageText("a\x1b[31mb\x7f\tc\nd"), "a [31mb \tc\nd");
  EXPECT_EQ(messageText("\xffgr\xc3\xb6\xc3"), "?gr\xc3\xb6?");
  EXPECT_EQ(messageText("\xc2\x85"), "  ");  // a control character of two bytes
}

TEST(MessageText, GoesOnBelowWhereALineWouldBeTooLong) {
  const std::string word(60, 'x');
  const std::string text = word + " " + word + " " + word + " " + word;
  EXPECT_EQ(messageText(text), word + " " + word + " " + word + "\n         " + word);
  // columns before the text count, and characters, not bytes
  EXPECT_EQ(messageText(word + " " + word, 100), word + "\n         " + word);
  std::string umlauts;
  for (int i = 0; i < 150; ++i) {
    umlauts += "\xc3\xb6";
  }
  EXPECT_EQ(messageText(umlauts + " a"), umlauts + " a");
  // a line that ends in the text begins anew
  EXPECT_EQ(messageText(word + "\n" + word + " " + word + " " + word), word + "\n" + word + " " + word + " " + word);
  // without a blank it stays whole
  EXPECT_EQ(messageText(std::string(300, 'y')), std::string(300, 'y'));
}

TEST(MessageText, OfADiagnosticFitsTwoHundredColumns) {
  Diagnostic diagnostic;
  diagnostic.message = "wrong";
  diagnostic.location = {
      .file = "a.l", .line = 12345, .column = 150, .length = 1, .lineText = std::string(198, 'F'), .expansion = {}};
  for (int i = 0; i < 60; ++i) {
    diagnostic.hint += "Available: name, ";
  }
  const std::string text = formatDiagnostic(diagnostic);
  std::size_t begin = 0;
  for (std::size_t end = text.find('\n'); begin < text.size(); end = std::min(text.find('\n', begin), text.size())) {
    EXPECT_LE(end - begin, 200U) << text.substr(begin, end - begin);
    begin = end + 1;
  }
}

}  // namespace
}  // namespace espalier::core::message_text_test
