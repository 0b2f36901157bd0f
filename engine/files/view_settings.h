#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/core/vec3.h"
#include "engine/files/colour_files.h"
#include "engine/files/images/image_file.h"
#include "engine/files/surfaces/background_scene.h"

namespace espalier::files {

/// A tropism or torque of the view file, as stored: the direction is already scaled by its intensity.
struct Movement {
  enum class Kind : std::uint8_t { Tropism, Torque };
  Kind kind = Kind::Tropism;
  core::Vec3 direction;
  double angleDegrees = 0.0;
  double elasticity = 0.0;
  double elasticityStep = 0.0;
};

/// The old single tropism (`tropism direction`, symbol `_`).
struct OldTropism {
  bool isActive = false;  // any of its three commands is present
  core::Vec3 direction{0.0, 1.0, 0.0};
  double initialElasticity = 0.0;
  double elasticityIncrement = 0.0;
};

/// A spline function of `function:` or `function set:`, the values of func(id, x).
class SplineFunction {
 public:
  /// Control points with multiplicities already repeated (at least 4). sampleCount <= 2: no table, exact bisection.
  SplineFunction(std::string name, std::vector<std::array<double, 2>> points, int sampleCount);
  /// y at x, x clamped to [0, 1]: clamped uniform cubic B-spline, parameter by bisection to |x error| <= 0.001.
  [[nodiscard]] double value(double x) const;
  /// The `name:` of its file; of a function set: the macro.
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  /// A point of the curve at which the bisection can look, and the points at which it looks next.
  struct Halving {
    double x = 0.0;
    double y = 0.0;
    std::array<std::uint32_t, 2> next{};  // of halvings_: where the sought x is smaller, and where it is larger
  };
  [[nodiscard]] std::array<double, 2> point(double parameter) const;
  [[nodiscard]] double bisect(double x) const;
  void prepareHalvings();

  std::string name_;
  std::vector<std::array<double, 2>> points_;
  std::vector<double> table_;      // y at equidistant x; empty: no table
  std::vector<Halving> halvings_;  // without a table: a tree, because the points do not depend on x
};

/// A parametric curve of `curve:`, the values of curveX/Y/Z(id, t) and curveGAL(id).
class ParametricCurve {
 public:
  static constexpr std::size_t kPatchPoints = 16;  // of a Bezier surface
  enum class Kind : std::uint8_t { BSpline, BSplineEndPoint, BSplineClosed, BSplinePhantom, Bezier, BezierSurface };
  ParametricCurve(Kind kind, std::vector<core::Vec3> points, int sampleCount);
  /// The point at arc-length parameter t in [0, 1] (clamped).
  [[nodiscard]] core::Vec3 point(double t) const;
  /// Total chord length.
  [[nodiscard]] double arcLength() const { return arcLength_; }

 private:
  [[nodiscard]] core::Vec3 rawPoint(double p) const;
  Kind kind_;
  std::vector<core::Vec3> points_;
  std::vector<double> cumulative_;  // normalised chord lengths at equidistant raw parameters
  double arcLength_ = 0.0;
};

/// One 4x4 bicubic Bezier patch of a surface. Local coordinates are components along L, H, U (docs/model-files.md,
/// 6.1).
struct SurfacePatch {
  std::array<core::Vec3, 16> points;  // row by row; row index runs with s, column with t
  int topColour = 0;                  // 0: the turtle's
  int bottomColour = 0;
};

/// A predefined bicubic surface `~c` (`surface:` or `line:` command). All coordinates are relative to the contact
/// point, scaled and turned (docs/model-files.md, 6.1); the turtle multiplies them by its scale.
struct Surface {
  char id = 0;
  std::string file;
  std::vector<SurfacePatch> patches;
  core::Vec3 endPoint;  // local, as the patches
  int subdivisionS = 5;
  int subdivisionT = 5;
  int texture = -1;  // -1: the turtle's current texture; 0: none
};

/// A texture of `texture:` (docs/model-files.md, 11.3): a picture on everything that the turtle draws while this
/// texture is set (`@Tx`).
struct Texture {
  /// How the picture changes the colour below it. Modulate: the two are multiplied. Decal: the picture covers the
  /// colour where it is opaque. Blend: the picture is the share of white that is mixed into the colour.
  enum class Use : std::uint8_t { Modulate, Decal, Blend };
  std::string file;
  std::shared_ptr<const std::string> bytes;  // of the file
  std::shared_ptr<const Image> image;
  Use use = Use::Modulate;
  bool isSmoothNear = false;            // magnified by linear interpolation, else by the nearest point
  std::string_view minification = "n";  // n, l, mnn, mln, mnl or mll, as in the file; `m` is mll
  bool isPerSurface = false;            // of a surface: once over the whole surface, else once over each patch
  double ratio = 1.0;                   // height by width of one picture on a cylinder
};

/// One triangle of a `tsurface:` or of a mesh file; local coordinates along L, H, U.
struct SurfaceTriangle {
  std::array<core::Vec3, 3> points;
  std::array<core::Vec3, 3> normals;
  std::array<std::array<double, 2>, 3> coordinates{};  // of a texture, v upward
};

struct TriangleSurface {
  char id = 0;
  std::string file;
  std::vector<SurfaceTriangle> triangles;
  int texture = -1;  // as of a Surface
};

/// A contour of `contour:` for generalized cylinders.
struct Contour {
  int id = 0;
  bool isClosed = false;
  std::vector<core::Vec3> points;  // control points with multiplicities repeated; z is 0 for plane contours
};

/// A scalar field of `blob:`, the values of inblob(id, x, y, z): a sum over points and segments. The share of each
/// falls to 0 at its radius.
class BlobField {
 public:
  /// A segment; a point when both ends are equal.
  struct Object {
    core::Vec3 start, end;
    double startRadius = 2.0;
    double endRadius = 2.0;
    bool isEllipsoid = false;          // a point whose distance is measured along `axes`; the radius is then 1
    std::array<core::Vec3, 3> axes{};  // semi-axes
    double weight = 1.0;
  };
  void add(const Object& object) { objects_.push_back(object); }
  [[nodiscard]] const std::vector<Object>& objects() const { return objects_; }
  /// The field at a point. O(objects).
  [[nodiscard]] double value(const core::Vec3& point) const;

 private:
  std::vector<Object> objects_;
};

/// A box whose sides are parallel to the axes.
struct Box {
  core::Vec3 minimum;
  core::Vec3 maximum;
};

enum class LineStyle : std::uint8_t { Pixel, Polygon, Cylinder };

/// How a picture fills faces (`render mode:`).
enum class RenderMode : std::uint8_t { Wireframe, Filled, Flat, Interpolated, Shaded, Fast, Shadows };

/// A light of `light:`. Colours are 0 to 1 each.
struct Light {
  bool isDirectional = false;         // it shines from the direction `place`, with the same strength everywhere
  core::Vec3 place{0.0, 0.0, 1.0};    // a point, or a direction toward the light
  core::Vec3 ambient{1.0, 1.0, 1.0};  // red, green, blue
  core::Vec3 diffuse{1.0, 1.0, 1.0};
  core::Vec3 specular{1.0, 1.0, 1.0};
  core::Vec3 spotDirection{0.0, 0.0, -1.0};
  double spotExponent = 0.0;
  double spotCutoffDegrees = 180.0;       // 180: not a spot
  core::Vec3 attenuation{1.0, 0.0, 0.0};  // constant, linear, quadratic
};

/// All settings of a view file that change turtle, geometry, derivation or pictures, with the defaults of the reference
/// program (docs/model-files.md, 4.2).
struct ViewSettings {
  double angleIncrementDegrees = 45.0;
  double initialLineWidth = 1.0;
  double lineWidthIncrement = 0.0;
  double initialScale = 1.0;
  double scaleMultiplier = 1.0;
  int initialColour = 128;
  int initialBackColour = 128;
  bool hasTwoSidedColour = false;
  int colourIncrement = 1;
  int backColourIncrement = 1;
  LineStyle lineStyle = LineStyle::Pixel;
  bool isLineStyleGiven =
      false;  // by a line style or an initial line width; else pictures choose (docs/model-files.md)
  bool hasTaperedLines = true;
  int contourSides = 8;
  bool hasTwistOfCylinders = false;
  bool interpretsPastCut = true;
  bool hasEnvironmentDisplayBefore = false;
  OldTropism oldTropism;
  std::vector<Movement> movements;  // id - 1

  std::vector<SplineFunction> functions;  // id - 1
  bool functionSetDefinesMacros = false;  // the last of these commands is a `function set:`
  std::vector<ParametricCurve> curves;    // id - 1
  std::vector<Surface> surfaces;
  std::vector<TriangleSurface> triangleSurfaces;
  std::vector<Contour> contours;
  std::vector<Texture> textures;      // id - 1; without an image: the file cannot be used
  std::vector<BlobField> blobFields;  // id - 1

  // where the turtle starts, in the plant's coordinates
  core::Vec3 initialPosition{0.0, 0.0, 0.0};   // length units
  core::Vec3 initialHeading{0.0, 1.0, 0.0};    // unit; left and up follow by the least rotation from +y
  core::Vec3 displacement{0.0, 0.0, 0.0};      // of every drawn step and mesh, length units: gravity or wind
  std::map<int, PaletteColour> colourEntries;  // of `color map entry:`, by index; the other colours are Espalier's own

  // camera and colour: pictures and the functions vvXmin ... only
  bool isPerspective = false;
  core::Vec3 viewpoint{0.0, 0.0, 1.0};
  core::Vec3 viewReferencePoint{0.0, 0.0, 0.0};
  double twistDegrees = 0.0;
  double viewingAngleDegrees = 45.0;
  double scaleFactor = 1.0;
  std::optional<Box> box;                             // the view volume; nothing: the bounding box of the drawing
  std::optional<RenderMode> renderMode;               // nothing: not given
  std::vector<Light> lights;                          // of `light:`; at most 8 count
  std::optional<core::Vec3> lightDirection;           // toward the light, unit
  int postScriptLineCap = 1;                          // 0 butt, 1 round, 2 square
  std::shared_ptr<const BackgroundScene> background;  // of `background scene:`; null: none
};

}  // namespace espalier::files
