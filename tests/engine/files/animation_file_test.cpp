#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "engine/files/animation_file.h"

namespace espalier::files::animation_file_test {
namespace {

struct Read {
  AnimationSettings settings;
  std::vector<std::string> messages;
};

Read read(const std::string& text) {
  core::DiagnosticList diagnostics;
  const DataFile file("m.a", text, diagnostics);
  Read result{readAnimationFile(file), {}};
  for (const core::Diagnostic& diagnostic : diagnostics.entries()) {
    result.messages.push_back(std::to_string(diagnostic.location.line) + ":" +
                              std::to_string(diagnostic.location.column) + " " + diagnostic.message);
  }
  return result;
}

std::vector<std::int64_t> shown(const AnimationSettings& settings, std::int64_t derivationLength) {
  std::vector<std::int64_t> steps;
  std::optional<AnimationFrame> frame = firstFrame(settings);
  while (frame && steps.size() < 50) {
    steps.push_back(frame->derivedSteps);
    frame = nextFrame(settings, derivationLength, *frame);
  }
  return steps;
}

using Steps = std::vector<std::int64_t>;

TEST(AnimationFile, ReadsAPublishedForm) {
  const Read result = read(
      "last frame: -1\nfirst frame: 0\nstep: 2\ndouble buffer: off\nclear between frames: off\n"
      "scale between frames: on\nhcenter between frames: on\ndisplay on request: off\nswap interval: 3\n"
      "new view between frames: maybe\n");
  EXPECT_TRUE(result.messages.empty());
  EXPECT_EQ(result.settings.firstFrame, 0);
  EXPECT_FALSE(result.settings.lastFrame.has_value());
  EXPECT_EQ(result.settings.step, 2);
  EXPECT_FALSE(result.settings.hasDoubleBuffer);
  EXPECT_FALSE(result.settings.clearsBetweenFrames);
  EXPECT_TRUE(result.settings.scalesBetweenFrames);
  EXPECT_TRUE(result.settings.centresHorizontally);
  EXPECT_FALSE(result.settings.readsViewBetweenFrames);
  EXPECT_EQ(result.settings.swapInterval, 3);
  EXPECT_EQ(shown(result.settings, 5), (Steps{0, 2, 4, 6}));
}

TEST(AnimationFile, KeywordsStartInColumnOne) {
  EXPECT_EQ(read("  step: 5\n").settings.step, 1);
  EXPECT_EQ(read("step : 5\n").settings.step, 1);
}

TEST(AnimationFile, OddNumbersAreBroughtIntoRange) {
  EXPECT_EQ(read("first frame: -3\n").settings.firstFrame, 0);
  EXPECT_EQ(read("step: 0\n").settings.step, 1);
  EXPECT_EQ(read("first frame: 5\nlast frame: 3\n").settings.lastFrame, 5);
  // first frame is not read yet: the default 1 counts
  EXPECT_EQ(read("last frame: 3\nfirst frame: 5\n").settings.lastFrame, 3);
}

TEST(AnimationFile, KeywordWithoutAValueWarns) {
  EXPECT_EQ(read("first frame:\nstep: many\ndouble buffer:\n").messages,
            (std::vector<std::string>{"1:13 expected an integer while reading 'first frame:', found the end",
                                      "2:7 expected an integer while reading 'step:', found 'many'",
                                      "3:15 expected 'on' or 'off' while reading 'double buffer:', found the end"}));
}

TEST(AnimationFile, LastAdvanceIsNotCut) {
  EXPECT_EQ(shown(read("first frame: 0\nlast frame: 10\nstep: 3\n").settings, 99), (Steps{0, 3, 6, 9, 12}));
}

TEST(AnimationFile, EveryEncodingOfAModelIsRead) {
  const std::string utf16 = "first frame: 2\nlast frame: 3\n";
  std::string bytes = "\xFF\xFE";
  for (const char c : utf16) {
    bytes += c;
    bytes += '\0';
  }
  for (const std::string& text : {std::string("\xEF\xBB\xBF"
                                              "first frame: 2\nlast frame: 3\n"),
                                  std::string("first frame: 2\rlast frame: 3\r"), bytes}) {
    const Read result = read(text);
    EXPECT_TRUE(result.messages.empty());
    EXPECT_EQ(shown(result.settings, 100), (Steps{2, 3}));
  }
  EXPECT_EQ(read("step: 1\rlast frame:\r").messages.at(0).substr(0, 2), "2:");
}

TEST(AnimationFile, IntervalsOverrideFirstLastAndStep) {
  const Read result = read("first frame: 7\nframe intervals: 2-6 step 2, 10, 20-24 step 3\nstep: 5\n");
  EXPECT_TRUE(result.messages.empty());
  // 2 4 6; then 10; then 20 23; 26 is beyond the end of the last item, so `step` goes on to 28
  EXPECT_EQ(shown(result.settings, 0), (Steps{2, 4, 6, 10, 20, 23, 28}));
}

TEST(AnimationFile, StepZeroWithAMotionShowsFramesWithoutDeriving) {
  const Read result = read("frame intervals: 5, 5-8 step 0 rotate 0 30 0\n");
  EXPECT_TRUE(result.messages.empty());
  ASSERT_EQ(result.settings.intervals.size(), 2U);
  EXPECT_EQ(result.settings.intervals[1].motion, FrameInterval::Motion::Rotate);
  EXPECT_EQ(result.settings.intervals[1].amount[1], 30.0);
  EXPECT_EQ(shown(result.settings, 0), (Steps{5, 5, 5, 5}));
}

TEST(AnimationFile, ReportsBrokenIntervals) {
  EXPECT_EQ(read("frame intervals: 1-x\n").messages,
            std::vector<std::string>{"1:20 expected a step number while reading 'frame intervals:', found 'x'"});
  EXPECT_EQ(read("frame intervals: 1 rotate 1 2\n").messages,
            std::vector<std::string>{
                "1:30 expected three numbers of a motion while reading 'frame intervals:', found the end"});
  EXPECT_EQ(
      read("frame intervals: 1 2\n").messages,
      std::vector<std::string>{"1:20 expected a comma between intervals while reading 'frame intervals:', found '2'"});
  std::string many = "frame intervals: 0";
  for (int i = 1; i <= 1000; ++i) {
    many += "," + std::to_string(i);
  }
  const Read result = read(many);
  EXPECT_EQ(result.settings.intervals.size(), 1000U);
  ASSERT_EQ(result.messages.size(), 1U);
  EXPECT_NE(result.messages[0].find("at most 1000 frame intervals are used"), std::string::npos);
}

TEST(AnimationFile, TheFinalFrameIsWhereTheFramesEnd) {
  const auto endOf = [](std::int64_t first, std::optional<std::int64_t> last, std::int64_t step) {
    AnimationSettings settings;
    settings.firstFrame = first;
    settings.lastFrame = last;
    settings.step = step;
    return finalFrame(settings, 7).derivedSteps;
  };
  EXPECT_EQ(endOf(0, 10, 3), 12);
  EXPECT_EQ(endOf(0, 10, 5), 10);
  EXPECT_EQ(endOf(4, 4, 3), 4);
  EXPECT_EQ(endOf(1, std::nullopt, 1), 7);
  EXPECT_EQ(endOf(9, std::nullopt, 1), 9);
  EXPECT_EQ(endOf(0, 2'000'000'000, 1), 2'000'000'000);

  // ten frames of a turntable derive nothing
  AnimationSettings settings;
  settings.firstFrame = 3;
  settings.lastFrame = 13;
  settings.intervals.push_back({.start = 3, .end = 13, .step = 0, .motion = FrameInterval::Motion::Rotate});
  EXPECT_EQ(finalFrame(settings, 7), (AnimationFrame{13, 3}));
}

}  // namespace
}  // namespace espalier::files::animation_file_test
