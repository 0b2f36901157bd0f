#include "engine/turtle/export/line_look.h"

#include <algorithm>
#include <cmath>

namespace espalier::turtle {

using core::Vec3;

namespace {

constexpr double kPixelsAcross = 800.0;  // a pixel's width is this part of the scene's extent
// widths without a size: parts of the extent, and of the mean length of lines
constexpr double kThickest = 1.0 / 75.0;
constexpr double kThickestOfOwn = 1.0 / 45.0;  // of a model with widths of its own, which has thin lines too
constexpr double kThinnest = 1.0 / 600.0;
constexpr double kPartOfLength = 0.35;
constexpr double kPartOfLengthOfOwn = 1.0;

struct LineMeasures {
  double extent = 0.0;  // diagonal of the box around all lines
  double meanLength = 0.0;
  double largestWidth = 0.0;
  bool hasOwnWidths = false;  // the model sets widths
};

LineMeasures measuresOf(const Scene& scene, double initialWidth) {
  LineMeasures result;
  if (scene.segments.empty()) {
    return result;
  }
  Vec3 low = scene.segments[0].start;
  Vec3 high = low;
  std::size_t count = 0;
  for (const Segment& segment : scene.segments) {
    for (const Vec3& p : {segment.start, segment.end}) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    const double length = core::length(segment.end - segment.start);
    result.meanLength += length;
    count += length > 0.0 ? 1 : 0;
    result.largestWidth = std::max({result.largestWidth, segment.startWidth, segment.endWidth});
    result.hasOwnWidths = result.hasOwnWidths || segment.startWidth != initialWidth || segment.endWidth != initialWidth;
  }
  result.extent = core::length(high - low);
  result.meanLength /= static_cast<double>(std::max<std::size_t>(count, 1));
  return result;
}

}  // namespace

double LineLook::widthOf(const Segment& segment, double width) const {
  return unit * width / (thinsByOrder ? std::sqrt(1.0 + segment.branchOrder) : 1.0);
}

LineLook lineLookOf(const Scene& scene, const files::ViewSettings& view) {
  LineLook look{.style = scene.lineStyle};
  if (view.isLineStyleGiven || scene.lineStyle != files::LineStyle::Pixel) {
    return look;
  }
  const LineMeasures measures = measuresOf(scene, view.initialLineWidth);
  if (!(measures.extent > 0.0) || !(measures.largestWidth > 0.0) || !std::isfinite(measures.extent)) {
    return look;
  }
  look.style = files::LineStyle::Cylinder;
  look.thinsByOrder = !measures.hasOwnWidths;
  const double ofLength = (measures.hasOwnWidths ? kPartOfLengthOfOwn : kPartOfLength) * measures.meanLength;
  const double thickest = (measures.hasOwnWidths ? kThickestOfOwn : kThickest) * measures.extent;
  look.unit = std::clamp(ofLength, kThinnest * measures.extent, thickest) / measures.largestWidth;
  return look;
}

LineLook meshLineLookOf(const Scene& scene, const files::ViewSettings& view) {
  LineLook look = lineLookOf(scene, view);
  if (look.style == files::LineStyle::Pixel) {
    const double extent = measuresOf(scene, view.initialLineWidth).extent;
    look.unit = extent > 0.0 ? extent / kPixelsAcross : 1.0;
  }
  return look;
}

}  // namespace espalier::turtle
