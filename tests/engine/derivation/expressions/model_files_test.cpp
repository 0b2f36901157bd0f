#include "engine/derivation/expressions/model_files.h"

#include <gtest/gtest.h>

#include <array>

namespace espalier::derivation::model_files_test {
namespace {

using language::FileMode;

/// A Program that names three files: one that is read, one that is written, one that is both. The first exists.
class ModelFilesTest : public testing::Test {
 protected:
  ModelFilesTest() {
    program_.sources.push_back({"folder/in.txt", "1 2\n3\n"});
    program_.files.push_back({.name = "in.txt", .isRead = true, .source = 0});
    program_.files.push_back({.name = "out.txt", .isWritten = true});
    program_.files.push_back({.name = "both.txt", .isRead = true, .isWritten = true});
    program_.files.push_back({.name = "../x", .isWritten = true, .isRefused = true});
  }
  ModelFiles files(bool canWrite = true) { return {program_, state_, limits_, canWrite}; }
  double open(std::uint32_t file, const char* mode, bool canWrite = true) {
    const auto opened = files(canWrite).open(file, *FileMode::parse(mode));
    return opened.value_or(0.0);
  }
  std::string refusal(std::uint32_t file, const char* mode, bool canWrite = true) {
    const auto opened = files(canWrite).open(file, *FileMode::parse(mode));
    return opened ? std::string() : opened.error();
  }
  double scan(double handle) {
    std::array<double, 1> number{};
    return files().scan(handle, "%g", number) == 1 ? number[0] : -1.0;
  }
  void write(double handle, const std::string& text) {
    EXPECT_EQ(files().write(handle, text), ModelFiles::Written::Done);
  }

  language::Program program_;
  FileState state_;
  core::Limits limits_;
};

TEST_F(ModelFilesTest, EveryHandleReadsAtItsOwnPlace) {
  const double first = open(0, "r");
  const double second = open(0, "r");
  EXPECT_EQ(first, 1.0);
  EXPECT_EQ(second, 2.0);
  EXPECT_EQ(scan(first), 1.0);
  EXPECT_EQ(scan(first), 2.0);
  EXPECT_EQ(scan(second), 1.0);
  EXPECT_EQ(scan(first), 3.0);
  EXPECT_EQ(scan(first), -1.0);
}

TEST_F(ModelFilesTest, AClosedHandleIsGivenToTheNextFile) {
  const double first = open(0, "r");
  EXPECT_TRUE(files().close(first));
  EXPECT_FALSE(files().close(first));
  EXPECT_FALSE(files().canRead(first));
  EXPECT_EQ(open(0, "r"), first);
  EXPECT_FALSE(files().close(0.0));
  EXPECT_FALSE(files().close(-1.0));
  EXPECT_FALSE(files().close(99.0));
}

TEST_F(ModelFilesTest, WhatIsWrittenWaitsInOnePieceForEachFile) {
  const double out = open(1, "w");
  const double both = open(2, "w+");
  write(out, "a");
  write(both, "b");
  write(out, "c");
  const std::vector<FileOutput> output = takeOutput(state_);
  ASSERT_EQ(output.size(), 2U);
  EXPECT_TRUE(output[0].replaces);
  EXPECT_EQ(output[0].bytes, "ac");
  EXPECT_TRUE(output[1].replaces);
  EXPECT_EQ(output[1].bytes, "b");
  EXPECT_TRUE(state_.output.empty());

  // the next step adds to the file; a kept file is given whole
  write(out, "d");
  write(both, "e");
  const std::vector<FileOutput> more = takeOutput(state_);
  ASSERT_EQ(more.size(), 2U);
  EXPECT_FALSE(more[0].replaces);
  EXPECT_EQ(more[0].bytes, "d");
  EXPECT_TRUE(more[1].replaces);
  EXPECT_EQ(more[1].bytes, "be");
}

TEST_F(ModelFilesTest, OpeningForWritingMakesAnEmptyFileAndAppendingKeepsTheOld) {
  open(1, "w");
  EXPECT_EQ(takeOutput(state_).at(0).replaces, true);
  const double out = open(1, "a");
  write(out, "x");
  const std::vector<FileOutput> output = takeOutput(state_);
  ASSERT_EQ(output.size(), 1U);
  EXPECT_FALSE(output[0].replaces);
  EXPECT_EQ(output[0].bytes, "x");
}

TEST_F(ModelFilesTest, AModelReadsWhatItHasWritten) {
  const double out = open(2, "w");
  write(out, "4 5");
  EXPECT_TRUE(files().close(out));
  const double in = open(2, "r+");
  EXPECT_EQ(scan(in), 4.0);
  write(in, "678");  // over what follows
  const double again = open(2, "r");
  EXPECT_EQ(scan(again), 4678.0);
  const double end = open(2, "a+");
  write(end, " 9");
  EXPECT_EQ(takeOutput(state_).at(0).bytes, "4678 9");
}

TEST_F(ModelFilesTest, RefusalsSayWhy) {
  EXPECT_EQ(refusal(3, "w"), "a model can open only files inside its folder, and cannot overwrite its own text");
  EXPECT_EQ(refusal(1, "w", false), "models write no files here");
  EXPECT_EQ(refusal(2, "r"), "there is no such file in the model's folder");
  limits_.maximumOpenFiles = 1;
  open(0, "r");
  EXPECT_EQ(refusal(0, "r"), "more than 1 files are open (limit openFiles)");
}

TEST_F(ModelFilesTest, WritingNeedsAFileThatIsOpenForItAndHasRoom) {
  EXPECT_EQ(files().write(0.0, "x"), ModelFiles::Written::NotOpen);
  const double in = open(0, "r");
  EXPECT_EQ(files().write(in, "x"), ModelFiles::Written::NotForWriting);
  limits_.maximumFileBytes = 3;
  const double out = open(1, "w");
  write(out, "123");
  EXPECT_EQ(files().write(out, "4"), ModelFiles::Written::TooLong);
  const double both = open(2, "w+");
  EXPECT_EQ(files().write(both, "1234"), ModelFiles::Written::TooLong);
}

TEST(ModelFiles, ModesAreThoseOfC) {
  for (const char* text : {"r", "w", "a", "r+", "w+", "a+"}) {
    const auto mode = FileMode::parse(text);
    ASSERT_TRUE(mode) << text;
    EXPECT_EQ(FileMode::fromBits(mode->bits()).text(), text);
  }
  EXPECT_EQ(FileMode::parse("rb+")->text(), "r+");
  EXPECT_EQ(FileMode::parse("wt")->text(), "w");
  EXPECT_FALSE(FileMode::parse(""));
  EXPECT_FALSE(FileMode::parse("x"));
  EXPECT_FALSE(FileMode::parse("rx"));
}

TEST(ModelFiles, EveryPlantBeyondTheFirstHasItsOwnFile) {
  EXPECT_EQ(fileNameOfPlant("growth.txt", 0), "growth.txt");
  EXPECT_EQ(fileNameOfPlant("growth.txt", 2), "growth.2.txt");
  EXPECT_EQ(fileNameOfPlant("a.b/growth", 1), "a.b/growth.1");
  EXPECT_EQ(fileNameOfPlant("a/.hidden", 1), "a/.hidden.1");
}

}  // namespace
}  // namespace espalier::derivation::model_files_test
