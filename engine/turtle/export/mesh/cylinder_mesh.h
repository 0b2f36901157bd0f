#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/core/vec3.h"
#include "engine/files/view_settings.h"
#include "engine/turtle/export/mesh/mesh.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::turtle {

/// Consecutive stretches of a generalized cylinder that have one colour, at most kLongestRun of them. A stretch is a
/// piece of its curve; its colour is that of the control point where it ends.
struct CylinderRun {
  std::size_t first = 0;  // stretch
  std::size_t count = 0;
  std::int32_t colour = 128;
};

inline constexpr std::size_t kLongestRun = 64;

/// The runs of a generalized cylinder, along its axis. O(points).
[[nodiscard]] std::vector<CylinderRun> runsOf(const GeneralizedCylinder& cylinder);

/// A generalized cylinder along its axis, from which the meshes of its runs are made: Hermite or B-spline through its
/// points, circular or with the contours of the view file, with the least twist unless the view file wants the
/// turtle's. Runs meet in equal rings with equal normals; the ends of an open tube are flat. The second texture
/// coordinate is the length along the axis, or, when the cylinder has a texture, that length in pictures as high as the
/// texture's ratio says. Holds some 600 bytes a point.
class SweptCylinder {
 public:
  /// `cylinder` must outlive the object. `detail`: factor of the numbers of sides and strips. O(points).
  SweptCylinder(const GeneralizedCylinder& cylinder, const files::ViewSettings& view, double detail = 1.0);

  [[nodiscard]] const std::vector<CylinderRun>& runs() const { return runs_; }
  /// O(stretches of the run).
  void appendRun(Mesh& mesh, const CylinderRun& run) const;
  /// The number of faces of a run, without flat ends.
  [[nodiscard]] std::size_t faceCountOf(const CylinderRun& run) const;

 private:
  /// A place on the axis.
  struct AxisSample {
    core::Vec3 position;
    core::Vec3 tangent;
    core::Vec3 turtleUp;  // the turtle's own, interpolated
    double radius = 0.5;
    std::size_t stretch = 0;  // that ends here or goes on beyond
    std::size_t from = 0;     // control points whose contours are blended
    std::size_t to = 0;
    double blend = 0.0;
  };

  void sampleContours(const files::ViewSettings& view);
  void sampleAxis(double detail);
  void carryNormals(bool hasTurtleTwist);
  void measure(double ratio);
  [[nodiscard]] std::size_t firstSampleOf(std::size_t stretch) const;
  [[nodiscard]] double slopeAt(std::size_t sample) const;
  [[nodiscard]] const std::vector<core::Vec3>& contourOf(std::size_t point) const {
    return contours_[contourNumbers_[point]];
  }
  [[nodiscard]] AxisSample hermite(std::size_t from, std::size_t to, double t) const;
  [[nodiscard]] AxisSample bSpline(std::size_t segment, double t) const;
  static core::Vec3 carried(const core::Vec3& up, const AxisSample& from, const AxisSample& to);

  const GeneralizedCylinder& cylinder_;
  std::vector<CylinderRun> runs_;
  int sides_ = 3;
  std::vector<std::vector<core::Vec3>> contours_;  // those in use
  std::vector<std::uint32_t> contourNumbers_;      // by control point, into contours_
  bool isTube_ = true;                             // all contours are closed
  std::vector<AxisSample> samples_;
  std::vector<core::Vec3> ups_;  // normals of the axis, by sample
  std::vector<double> along_;    // second texture coordinates, by sample
};

}  // namespace espalier::turtle
