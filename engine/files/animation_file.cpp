#include "engine/files/animation_file.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

namespace espalier::files {
namespace {

constexpr std::string_view kBetweenWords = " \t\r,:";
constexpr std::size_t kMostIntervals = 1000;

std::string_view firstWord(TextCursor line) {
  line.skip(kBetweenWords);
  const std::string_view rest = line.rest();
  return rest.substr(0, rest.find_first_of(kBetweenWords));
}

class AnimationReader {
 public:
  explicit AnimationReader(const DataFile& file) : file_(file) {}

  AnimationSettings read() {
    TextCursor cursor = file_.cursor();
    while (!cursor.atEnd()) {
      readLine(cursor.takeLine());
    }
    // the intervals override first and last, wherever they stand
    if (!settings_.intervals.empty()) {
      settings_.firstFrame = settings_.intervals.front().start;
      settings_.lastFrame = settings_.intervals.back().end;
    }
    return std::move(settings_);
  }

 private:
  void readLine(TextCursor line) {
    const std::size_t begin = line.position();
    const std::size_t colon = line.rest().find(':');
    if (colon == std::string_view::npos) {
      return;
    }
    const std::string_view keyword = line.rest().substr(0, colon);
    line.setPosition(begin + colon + 1);
    if (keyword == "first frame") {
      if (const auto value = number(line, keyword)) {
        settings_.firstFrame = std::max<std::int64_t>(*value, 0);
      }
    } else if (keyword == "last frame") {
      if (const auto value = number(line, keyword)) {
        settings_.lastFrame =
            *value < 0 ? std::nullopt : std::optional<std::int64_t>(std::max(*value, settings_.firstFrame));
      }
    } else if (keyword == "step") {
      if (const auto value = number(line, keyword)) {
        settings_.step = *value <= 0 ? 1 : *value;
      }
    } else if (keyword == "swap interval") {
      settings_.swapInterval = number(line, keyword).value_or(settings_.swapInterval);
    } else if (keyword == "frame intervals") {
      readIntervals(line);
    } else {
      readFlag(line, keyword);
    }
  }

  void readFlag(const TextCursor& line, std::string_view keyword) {
    const std::pair<std::string_view, bool*> flags[] = {
        {"clear between frames", &settings_.clearsBetweenFrames},
        {"new view between frames", &settings_.readsViewBetweenFrames},
        {"scale between frames", &settings_.scalesBetweenFrames},
        {"center between frames", &settings_.centresBetweenFrames},
        {"hcenter between frames", &settings_.centresHorizontally},
        {"double buffer", &settings_.hasDoubleBuffer},
    };
    for (const auto& [name, flag] : flags) {
      if (name != keyword) {
        continue;
      }
      const std::string_view word = firstWord(line);
      if (word.empty()) {
        expected(line, "'on' or 'off'", keyword);
      } else {
        *flag = word == "on";
      }
    }
  }

  std::optional<std::int64_t> number(TextCursor line, std::string_view keyword) {
    line.skip(kBetweenWords);
    const std::optional<int> value = line.integer();
    if (!value) {
      expected(line, "an integer", keyword);
      return std::nullopt;
    }
    return *value;
  }

  void readIntervals(TextCursor line) {
    settings_.intervals.clear();
    while (!line.atLineEnd()) {
      FrameInterval interval;
      if (!readInterval(line, interval)) {
        return;
      }
      if (settings_.intervals.size() >= kMostIntervals) {
        file_.warn(line.rangeFrom(line.position()), "at most 1000 frame intervals are used");
        return;
      }
      settings_.intervals.push_back(interval);
      line.skipBlanks();
      if (!line.take(',') && !line.atLineEnd()) {
        return expected(line, "a comma between intervals", "frame intervals");
      }
    }
  }

  /// `a`, `a-b`, `a-b step s`, then optionally `rotate x y z` or `scale x y z`.
  bool readInterval(TextCursor& line, FrameInterval& interval) {
    if (!readStep(line, interval.start)) {
      return false;
    }
    interval.end = interval.start;
    line.skipBlanks();
    if (line.take('-') && !readStep(line, interval.end)) {
      return false;
    }
    line.skipBlanks();
    if (line.takeKeywords("step ")) {
      std::int64_t step = 0;
      if (!readStep(line, step)) {
        return false;
      }
      interval.step = step;
      line.skipBlanks();
    }
    if (line.takeKeywords("rotate ")) {
      interval.motion = FrameInterval::Motion::Rotate;
    } else if (line.takeKeywords("scale ")) {
      interval.motion = FrameInterval::Motion::Scale;
    } else {
      return true;
    }
    for (double& amount : interval.amount) {
      line.skipBlanks();
      const std::optional<double> value = line.number();
      if (!value) {
        expected(line, "three numbers of a motion", "frame intervals");
        return false;
      }
      amount = *value;
    }
    return true;
  }

  bool readStep(TextCursor& line, std::int64_t& value) {
    line.skipBlanks();
    const std::optional<int> read = line.integer();
    if (!read || *read < 0) {
      expected(line, "a step number", "frame intervals");
      return false;
    }
    value = *read;
    return true;
  }

  void expected(const TextCursor& at, const std::string& what, std::string_view keyword) {
    file_.warnExpected(at, what, "'" + std::string(keyword) + ":'");
  }

  const DataFile& file_;
  AnimationSettings settings_;
};

}  // namespace

AnimationSettings readAnimationFile(const DataFile& file) {
  return AnimationReader(file).read();
}

AnimationFrame firstFrame(const AnimationSettings& settings) {
  return {settings.firstFrame, settings.firstFrame};
}

std::optional<AnimationFrame> nextFrame(const AnimationSettings& settings, std::int64_t derivationLength,
                                        AnimationFrame current) {
  if (current.counter >= settings.lastFrame.value_or(derivationLength)) {
    return std::nullopt;
  }
  for (const FrameInterval& interval : settings.intervals) {
    if (current.counter >= interval.end) {
      continue;
    }
    const std::int64_t step = interval.step.value_or(settings.step);
    if (step == 0) {
      // a turntable: frames without derivation
      const std::int64_t counter = std::max(current.counter + 1, interval.start);
      return AnimationFrame{counter, current.derivedSteps};
    }
    // the first of start, start + step, ... beyond the current one
    std::int64_t next = interval.start;
    if (next <= current.counter) {
      next += ((current.counter - next) / step + 1) * step;
    }
    if (next <= interval.end) {
      return AnimationFrame{next, current.derivedSteps + (next - current.counter)};
    }
  }
  return AnimationFrame{current.counter + settings.step, current.derivedSteps + settings.step};
}

AnimationFrame finalFrame(const AnimationSettings& settings, std::int64_t derivationLength) {
  AnimationFrame frame = firstFrame(settings);
  if (settings.intervals.empty()) {
    // as many advances as reach the last frame
    const std::int64_t missing =
        std::max<std::int64_t>(0, settings.lastFrame.value_or(derivationLength) - frame.counter);
    const std::int64_t advance = (missing + settings.step - 1) / settings.step * settings.step;
    return {frame.counter + advance, frame.derivedSteps + advance};
  }
  while (const std::optional<AnimationFrame> next = nextFrame(settings, derivationLength, frame)) {
    frame = *next;
  }
  return frame;
}

}  // namespace espalier::files
