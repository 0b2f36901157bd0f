#include "environment/published/environment_file.h"

#include <gtest/gtest.h>

namespace espalier::environment::environment_file_test {
namespace {

EnvironmentFile fileOf(const std::string& text) {
  std::vector<core::Diagnostic> warnings;
  std::vector<core::Diagnostic> errors;
  EnvironmentFile file = readEnvironmentFile("m.e", text, warnings, errors);
  EXPECT_TRUE(warnings.empty() && errors.empty());
  return file;
}

TEST(EnvironmentFile, FormatsKeepTheBlanksBeforeThem) {
  EXPECT_EQ(fileOf("turtle position: P: %f %f %f\r\n").printed[0], " P: %f %f %f");
  EXPECT_EQ(fileOf("turtle position:P: %f %f %f\n").printed[0], "P: %f %f %f");
  EXPECT_EQ(fileOf("turtle heading\t  %f %f %f \n").printed[1], "  %f %f %f ");
}

TEST(EnvironmentFile, EveryCommunicationTypeSaysHowLargeAChunkIs) {
  EXPECT_EQ(fileOf("communication type: files 7\n").chunkModules, 7U);
  EXPECT_EQ(fileOf("communication type:pipes 8\n").chunkModules, 8U);
  EXPECT_EQ(fileOf("communication type: files\n").chunkModules, 100U);
}

TEST(EnvironmentFile, OnlyOtherTypesAreRewrittenForPipes) {
  EXPECT_EQ(textForPipes("executable: a\ncommunication type: pipes 5\n"), std::nullopt);
  EXPECT_EQ(textForPipes("executable: a\n Communication type: files\n"), std::nullopt);
  EXPECT_EQ(textForPipes("executable: a\ncommunication type: files 5\r\nturtle up: %f %f %f"),
            "executable: a\ncommunication type: pipes 5\nturtle up: %f %f %f");
  EXPECT_EQ(textForPipes("communication type\tsockets"), "communication type: pipes");
  EXPECT_EQ(textForPipes("communication type:\n"), "communication type: pipes\n");
}

TEST(EnvironmentFile, ArgumentsAreIgnoredOnlyByABuiltInProcess) {
  const EnvironmentFile file = fileOf("executable: ./tips -e m.e -v fast log\n");
  ASSERT_EQ(file.ignoredArguments.size(), 2U);
  EXPECT_EQ(file.ignoredArguments[0].message, "option '-v' of the program is ignored");
  EXPECT_EQ(file.ignoredArguments[1].message, "argument 'log' of the program is ignored");
  // the last line counts
  EXPECT_TRUE(fileOf("executable: a -v\nexecutable: a\n").ignoredArguments.empty());
}

}  // namespace
}  // namespace espalier::environment::environment_file_test
