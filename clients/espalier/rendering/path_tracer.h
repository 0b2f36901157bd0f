#pragma once

#include <cstdint>
#include <optional>

#include "clients/espalier/rendering/render_light.h"
#include "clients/espalier/rendering/render_scene.h"
#include "engine/core/vec3.h"

namespace espalier::command {

/// Numbers from 0 to 1 for one sample of a pixel. The first ones fill their range evenly over the samples (Kronecker
/// sequences, turned at random for each pixel), later ones are random.
class SampleNumbers {
 public:
  SampleNumbers(std::uint64_t pixel, std::uint32_t sample) : pixel_(pixel), sample_(sample) {}
  [[nodiscard]] double next();

 private:
  std::uint64_t pixel_;
  std::uint32_t sample_;
  std::uint32_t dimension_ = 0;
};

/// The result of following one ray of the viewer.
struct Seen {
  bool isPlant = false;
  Light light{};       // of a plant
  double shade = 1.0;  // of the page, or the ground: the share of free light that arrives
};

/// Follows light backward from the viewer (path tracing, Kajiya 1986). At each meeting the sun is asked for directly,
/// and one direction of reflected or transmitted light is followed. Thread-safe.
class PathTracer {
 public:
  /// `ground`: its height; nothing: there is none. All must outlive the object.
  PathTracer(const RenderScene& scene, const Daylight& above, std::optional<double> ground)
      : scene_(scene), daylight_(above), ground_(ground) {}

  [[nodiscard]] Seen look(core::Vec3 origin, core::Vec3 direction, SampleNumbers& numbers) const;

 private:
  [[nodiscard]] std::optional<core::Vec3> groundOn(const core::Vec3& origin, const core::Vec3& direction) const;
  [[nodiscard]] double shadeOf(const core::Vec3& place, SampleNumbers& numbers) const;
  void addSun(const Meeting& met, const core::Vec3& towardViewer, const Light& share, SampleNumbers& numbers,
              Light& light) const;
  [[nodiscard]] Light outside(const core::Vec3& origin, const core::Vec3& direction, SampleNumbers& numbers) const;

  const RenderScene& scene_;
  const Daylight& daylight_;
  std::optional<double> ground_;
};

}  // namespace espalier::command
