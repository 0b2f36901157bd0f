#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "engine/files/data_file.h"

namespace espalier::files {

/// One item of `frame intervals:`.
struct FrameInterval {
  enum class Motion : std::uint8_t { None, Rotate, Scale };
  std::int64_t start = 0;
  std::int64_t end = 0;
  std::optional<std::int64_t> step;  // nothing: AnimationSettings::step
  Motion motion = Motion::None;
  std::array<double, 3> amount{};  // degrees added, or factors, per frame
};

/// The settings of an animation file `.a`: which steps are shown.
struct AnimationSettings {
  std::int64_t firstFrame = 1;
  std::optional<std::int64_t> lastFrame = 1;  // nothing: the derivation length
  std::int64_t step = 1;                      // derivation steps per frame
  std::vector<FrameInterval> intervals;
  bool clearsBetweenFrames = true;
  bool readsViewBetweenFrames = false;
  bool scalesBetweenFrames = false;
  bool centresBetweenFrames = false;
  bool centresHorizontally = false;
  bool hasDoubleBuffer = true;
  std::int64_t swapInterval = 1;  // tenths of a second per frame
};

/// A shown frame. The counter is the derivation step, except that intervals with step 0 count frames without deriving.
struct AnimationFrame {
  std::int64_t counter = 0;
  std::int64_t derivedSteps = 0;

  constexpr bool operator==(const AnimationFrame&) const = default;
};

/// Reads an animation file (docs/model-files.md, 3). Unknown keywords are ignored
/// silently; every mistake is a warning.
[[nodiscard]] AnimationSettings readAnimationFile(const DataFile& file);

/// The first frame shown.
[[nodiscard]] AnimationFrame firstFrame(const AnimationSettings& settings);
/// The frame after one; nothing after the last. The last advance may pass the end: first 0, last 10, step 3 shows
/// 0 3 6 9 12.
[[nodiscard]] std::optional<AnimationFrame> nextFrame(const AnimationSettings& settings, std::int64_t derivationLength,
                                                      AnimationFrame current);

/// The last frame shown; it may be the first.
[[nodiscard]] AnimationFrame finalFrame(const AnimationSettings& settings, std::int64_t derivationLength);

}  // namespace espalier::files
