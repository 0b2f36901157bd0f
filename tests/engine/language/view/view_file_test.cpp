#include <gtest/gtest.h>

#include <algorithm>

#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "engine/language/view/view_file.h"

namespace espalier::language::view_file_test {
namespace {

using core::Compatibility;
using core::Vec3;

ViewFileResult read(const std::string& text, std::map<std::string, std::string> others = {},
                    Compatibility compatibility = Compatibility::Espalier) {
  core::MemoryFileProvider files(std::move(others));
  files.add("m/model.v", text);
  return readViewFile("m/model.v", files, compatibility, core::Limits{});
}

/// "line:column message" of every diagnostic.
std::vector<std::string> messages(const ViewFileResult& result) {
  std::vector<std::string> texts;
  for (const core::Diagnostic& diagnostic : result.diagnostics.entries()) {
    texts.push_back(std::to_string(diagnostic.location.line) + ":" + std::to_string(diagnostic.location.column) + " " +
                    diagnostic.message);
  }
  return texts;
}

using Texts = std::vector<std::string>;

TEST(ViewFile, DefaultsAreTheReferences) {
  const ViewFileResult result = read("");
  EXPECT_EQ(messages(result), Texts{});
  EXPECT_EQ(result.settings.angleIncrementDegrees, 45.0);
  EXPECT_EQ(result.settings.contourSides, 8);
  EXPECT_EQ(result.settings.initialColour, 128);
  EXPECT_EQ(result.settings.lineStyle, files::LineStyle::Pixel);
  EXPECT_TRUE(result.settings.interpretsPastCut);
}

TEST(ViewFile, TheBoxIsThreePairsOnOneLine) {
  const ViewFileResult result = read("box: x: -1,1 y:0, 2.5 z: -3,4\nangle increment: 7\n");
  EXPECT_EQ(messages(result), Texts{});
  ASSERT_TRUE(result.settings.box);
  EXPECT_EQ(result.settings.box->minimum, (core::Vec3{-1.0, 0.0, -3.0}));
  EXPECT_EQ(result.settings.box->maximum, (core::Vec3{1.0, 2.5, 4.0}));
  EXPECT_EQ(result.settings.angleIncrementDegrees, 7.0);
  EXPECT_FALSE(read("").settings.box);
  EXPECT_EQ(messages(read("box: x: 1 2\n")), Texts{"1:1 the box is ignored: expected a number and a comma, found '2'"});
  EXPECT_EQ(messages(read("box: x: 1,2 z: 1,2\n")), Texts{"1:1 the box is ignored: expected 'y:', found 'z:'"});
}

TEST(ViewFile, MissingFileIsAWarningWithDefaults) {
  core::MemoryFileProvider files;
  const ViewFileResult result = readViewFile("a/x.v", files, Compatibility::Espalier, core::Limits{});
  ASSERT_EQ(result.diagnostics.entries().size(), 1U);
  EXPECT_EQ(core::formatDiagnostic(result.diagnostics.entries()[0]),
            "a/x.v: warning: the view file cannot be read; every view setting has its default");
  EXPECT_FALSE(result.diagnostics.hasErrors());
}

TEST(ViewFile, SetsNumbersFlagsAndVectors) {
  const files::ViewSettings s =
      read(
          "angle increment: 30\nline width increment: .5\ninitial scale: 2.\nscale multiplier: 1e1\n"
          "initial color: 2 3\ncolor increment: 4 5\ntapered lines: off\ncontour sides: 5\n"
          "twist of cylinders: on\ninterpretation past %: off\nenvironment display: before\n"
          "projection: perspective\nviewpoint: 1, 2,3\nview reference point: 4,5,6\ntwist: 450\n"
          "viewing angle: 60\nscale factor: 1.5\n")
          .settings;
  EXPECT_EQ(s.angleIncrementDegrees, 30.0);
  EXPECT_EQ(s.lineWidthIncrement, 0.5);
  EXPECT_EQ(s.initialScale, 2.0);
  EXPECT_EQ(s.scaleMultiplier, 10.0);
  EXPECT_EQ(s.initialColour, 2);
  EXPECT_EQ(s.initialBackColour, 3);
  EXPECT_TRUE(s.hasTwoSidedColour);
  EXPECT_EQ(s.colourIncrement, 4);
  EXPECT_EQ(s.backColourIncrement, 5);
  EXPECT_FALSE(s.hasTaperedLines);
  EXPECT_EQ(s.contourSides, 5);
  EXPECT_TRUE(s.hasTwistOfCylinders);
  EXPECT_FALSE(s.interpretsPastCut);
  EXPECT_TRUE(s.hasEnvironmentDisplayBefore);
  EXPECT_TRUE(s.isPerspective);
  EXPECT_EQ(s.viewpoint, (Vec3{1, 2, 3}));
  EXPECT_EQ(s.viewReferencePoint, (Vec3{4, 5, 6}));
  EXPECT_EQ(s.twistDegrees, 45.0);
  EXPECT_EQ(s.viewingAngleDegrees, 60.0);
  EXPECT_EQ(s.scaleFactor, 1.5);
}

TEST(ViewFile, LaterOfAngleFactorAndIncrementWins) {
  EXPECT_EQ(read("angle increment: 30\nangle factor: 8\n").settings.angleIncrementDegrees, 45.0);
  EXPECT_EQ(read("angle factor: 8\nangle increment: 30\n").settings.angleIncrementDegrees, 30.0);
  EXPECT_EQ(messages(read("angle factor: 0\n")), Texts{"1:1 an angle factor of 0 is ignored"});
}

TEST(ViewFile, ReadingContinuesOnTheSameLine) {
  const ViewFileResult result = read("angle increment: 30 angle factor: 8\n");
  EXPECT_EQ(result.settings.angleIncrementDegrees, 45.0);
  EXPECT_EQ(messages(result), Texts{});
}

TEST(ViewFile, UnknownLabelsWarnWithTheNearestOneAndSkipTheLine) {
  const ViewFileResult result = read("angel increment: 10 initial scale: 3\na remark\ninitial scale: 2\n");
  EXPECT_EQ(messages(result), (Texts{"1:1 unknown view command 'angel increment'",
                                     "2:1 expected a view command while reading a view file, found 'a remark'"}));
  EXPECT_EQ(result.diagnostics.entries()[0].hint, "did you mean 'angle increment:'?");
  EXPECT_EQ(result.settings.initialScale, 2.0);
  for (const char* const label : {"angle increment :", "angle  increment:", "angle \t increment : "}) {
    EXPECT_EQ(read(label + std::string(" 10\n")).diagnostics.entries()[0].hint,
              "write 'angle increment:', with single blanks and no blank before the colon");
  }
  EXPECT_EQ(read("angle increment = 30\n").diagnostics.entries()[0].hint, "write ':' in place of '='");
  EXPECT_EQ(read("angle increment: 22,5\n").diagnostics.entries()[0].hint, "write 22.5 with a point");
  EXPECT_EQ(read("color increment: 0x1F\n").diagnostics.entries()[0].hint,
            "numbers are decimal: write 31 in place of 0x1F");
  EXPECT_FALSE(result.diagnostics.hasErrors());
}

TEST(ViewFile, LeadingTabMakesALineUnknownButBlanksDoNot) {
  const ViewFileResult result = read("\tangle increment: 10\n   initial scale: 2\n");
  EXPECT_EQ(messages(result), Texts{"1:1 the line is skipped because a TAB stands before its label"});
  EXPECT_EQ(result.settings.angleIncrementDegrees, 45.0);
  EXPECT_EQ(result.settings.initialScale, 2.0);
}

TEST(ViewFile, IsPreprocessed) {
  const ViewFileResult result =
      read("#define A 25\n/* a comment */\nangle increment: A // degrees\n#if 0\ninitial scale: 9\n#endif\n");
  EXPECT_EQ(messages(result), Texts{});
  EXPECT_EQ(result.settings.angleIncrementDegrees, 25.0);
  EXPECT_EQ(result.settings.initialScale, 1.0);
}

TEST(ViewFile, AcceptsCarriageReturnsAndAMissingFinalNewline) {
  const ViewFileResult result = read("line style: cylinder\r\nangle increment: 30\r\nz buffer: on\r\ninitial scale: 2");
  EXPECT_EQ(messages(result), Texts{});
  EXPECT_EQ(result.settings.lineStyle, files::LineStyle::Cylinder);
  EXPECT_EQ(result.settings.initialScale, 2.0);
}

TEST(ViewFile, MissingArgumentKeepsTheNextLineInEspalierMode) {
  const ViewFileResult result = read("initial scale:\nangle increment: 30\n");
  EXPECT_EQ(messages(result), Texts{"1:1 expected a number while reading 'initial scale:', found 'angle'"});
  EXPECT_EQ(result.settings.angleIncrementDegrees, 30.0);
}

TEST(ViewFile, MissingArgumentSwallowsTheNextLineInCompatibleModes) {
  const ViewFileResult result =
      read("initial scale:\nangle increment: 30\ncontour sides: 6\n", {}, Compatibility::Cpfg);
  EXPECT_EQ(messages(result), Texts{"1:1 expected a number while reading 'initial scale:', found 'angle'"});
  EXPECT_EQ(result.settings.angleIncrementDegrees, 45.0);
  EXPECT_EQ(result.settings.contourSides, 6);
}

TEST(ViewFile, NumbersAreFoundOnTheNextLine) {
  EXPECT_EQ(read("initial scale:\n 3\n").settings.initialScale, 3.0);
}

TEST(ViewFile, LineWidthAlsoSetsTheLineStyle) {
  EXPECT_EQ(read("initial line width: 2 pixels\n").settings.lineStyle, files::LineStyle::Pixel);
  EXPECT_EQ(read("initial line width: 2 s\n").settings.lineStyle, files::LineStyle::Cylinder);
  EXPECT_EQ(read("initial line width: 2\n").settings.lineStyle, files::LineStyle::Polygon);
  EXPECT_EQ(read("initial line width: 2 world\n").settings.lineStyle, files::LineStyle::Polygon);
  EXPECT_EQ(read("line style: cylinder\ninitial line width: 2 p\n").settings.lineStyle, files::LineStyle::Pixel);
  EXPECT_EQ(read("initial line width: 2 p\nline style: 3\n").settings.lineStyle, files::LineStyle::Cylinder);
  // behind a TAB there is no unit
  EXPECT_EQ(read("initial line width: 2\tpixels\n").settings.lineStyle, files::LineStyle::Polygon);
}

TEST(ViewFile, UnknownLineStyleKeepsTheStyle) {
  const ViewFileResult result = read("line style: cylinder\nline style: wireframe\nline style: cilinder\n");
  EXPECT_EQ(result.settings.lineStyle, files::LineStyle::Cylinder);
  EXPECT_EQ(messages(result), Texts{"3:1 unknown line style 'cilinder'; the style stays as it is"});
}

TEST(ViewFile, ZeroScalesBecomeOne) {
  const ViewFileResult result = read("initial scale: 0\n");
  EXPECT_EQ(result.settings.initialScale, 1.0);
  EXPECT_EQ(messages(result), Texts{"1:1 a scale of 0 is taken as 1"});
}

TEST(ViewFile, ContourSidesStayWithinTheirBounds) {
  EXPECT_EQ(read("contour sides: 2\n").settings.contourSides, 3);
  EXPECT_EQ(read("polygonization level: 2\n").settings.contourSides, 8);
  const ViewFileResult result = read("contour sides: 1000000000\n");
  EXPECT_EQ(result.settings.contourSides, 1000);
  EXPECT_EQ(messages(result), Texts{"1:1 more than 1000 contour sides; 1000 are used"});
}

TEST(ViewFile, VectorsNeedCommasDirectlyBehindTheirNumbers) {
  const ViewFileResult result = read("tropism direction: 0 1 0\nviewpoint: 1 ,2,3\n");
  EXPECT_FALSE(result.settings.oldTropism.isActive);
  EXPECT_EQ(result.settings.viewpoint, (Vec3{0, 0, 1}));
  EXPECT_EQ(messages(result),
            (Texts{"1:1 expected three numbers separated by commas while reading 'tropism direction:', found '1'",
                   "2:1 expected three numbers separated by commas while reading 'viewpoint:', found ',2,3'"}));
}

TEST(ViewFile, OldTropismIsNormalised) {
  const files::ViewSettings s =
      read("tropism direction: 0,-2,0\ninitial elasticity: .2\nelasticity increment: .1\n").settings;
  EXPECT_TRUE(s.oldTropism.isActive);
  EXPECT_EQ(s.oldTropism.direction, (Vec3{0, -1, 0}));
  EXPECT_EQ(s.oldTropism.initialElasticity, 0.2);
  EXPECT_EQ(s.oldTropism.elasticityIncrement, 0.1);
}

TEST(ViewFile, MovementsAcceptEverySeparator) {
  const ViewFileResult result = read("tropism: T: 0,1,0 A 90 E:.2\ntorque: T 0 0 2, S:.5\n");
  EXPECT_EQ(messages(result), Texts{});
  ASSERT_EQ(result.settings.movements.size(), 2U);
  EXPECT_EQ(result.settings.movements[0].kind, files::Movement::Kind::Tropism);
  EXPECT_EQ(result.settings.movements[0].direction, (Vec3{0, 1, 0}));
  EXPECT_EQ(result.settings.movements[0].angleDegrees, 90.0);
  EXPECT_EQ(result.settings.movements[0].elasticity, 0.2);
  EXPECT_EQ(result.settings.movements[1].kind, files::Movement::Kind::Torque);
  EXPECT_EQ(result.settings.movements[1].direction, (Vec3{0, 0, 1}));
  EXPECT_EQ(result.settings.movements[1].elasticityStep, 0.5);
}

TEST(ViewFile, IntensityScalesTheGivenDirectionWithinItsLength) {
  const auto direction = [](const std::string& line) {
    return read("tropism: " + line + "\n").settings.movements.at(0).direction;
  };
  EXPECT_EQ(direction("T: 0,1,0 I: 0.5"), (Vec3{0, 0.5, 0}));
  EXPECT_EQ(direction("T: 0,1,0 I: 2"), (Vec3{0, 1, 0}));
  EXPECT_EQ(direction("T: 0,2,0 I: 2"), (Vec3{0, 2, 0}));
  EXPECT_EQ(direction("T: 0,1,0 I: -1"), (Vec3{0, -1, 0}));
  // an intensity before the direction is lost
  EXPECT_EQ(direction("I: 0.5 T: 0,2,0"), (Vec3{0, 1, 0}));
}

TEST(ViewFile, WrongMovementsAreDroppedAndTheirIdIsUsedAgain) {
  const ViewFileResult result = read(
      "tropism: T: 0,0,0\ntropism: T: 0,1,0 X: 2\ntorque: E: 1\ntropism: T: 0,1\ntropism: T: 0,1,0 I: 0\n"
      "tropism: T: 1,0,0\n");
  EXPECT_EQ(messages(result), (Texts{"1:1 the tropism is dropped: its direction has no length",
                                     "2:1 the tropism is dropped: expected T, A, I, E or S, found 'X:'",
                                     "3:1 the torque is dropped: it has no direction",
                                     "4:1 the tropism is dropped: expected three numbers after 'T', found the end",
                                     "5:1 the tropism is dropped: its intensity is 0"}));
  ASSERT_EQ(result.settings.movements.size(), 1U);
  EXPECT_EQ(result.settings.movements[0].direction, (Vec3{1, 0, 0}));
}

TEST(ViewFile, PictureCommandsAreAcceptedSilently) {
  const ViewFileResult result = read(
      "front distance: -100\nback distance: 100\nbox: x: -1,1 y: 0,2 z: -1,1\nmin zoom: .1\nrender mode: shaded\n"
      "shade mode: 3\nz buffer: on\nantialiasing: off\nconcave polygons: off\ncue range: 5\nlight: O 1 2 3 D 1 1 1\n"
      "light direction: 1,0,0\ndiffuse reflection: 10\nsurface ambient: 0.15\nsurface diffuse: 0.75\n"
      "shadow map: size: 512\nfont: DejaVu Sans,12,-1\n"
      "winfont: \"Arial\" 12\nPS linecap: 1\nrayshade scale: 1\nbackground color: 0,0,0\nambient light: 1,1,1\n"
      "interpretation step: 50\ngenerate on view change: off\n");
  EXPECT_EQ(messages(result), Texts{});
}

TEST(ViewFile, FilesThatNoPictureShowsAreNamedWithTheConsequence) {
  const ViewFileResult result = read("rayshade objects: box.ray\n");
  EXPECT_EQ(messages(result), (Texts{"1:1 the objects are not used: no scene for Rayshade is written"}));
}

TEST(ViewFile, BackgroundScenesArePreprocessedAndJoined) {
  const ViewFileResult result =
      read("background scene: a.bg, b.bg; c.bg\nangle factor: 8\n",
           {{"m/a.bg", "#define SIDE 2\nmaterial 0 0 0 1 1 0 0 1\nprism SIDE SIDE /* high */ SIDE\ngrass 1\n"},
            {"m/b.bg", "sphere 1\n sphere\n"}});
  EXPECT_EQ(messages(result),
            (Texts{"4:1 unknown keyword 'grass': it is skipped",
                   "2:2 'sphere' needs a radius, found 0 numbers: it is skipped",
                   "1:1 the file 'm/c.bg' cannot be read; this part of the background is not drawn"}));
  ASSERT_NE(result.settings.background, nullptr);
  const files::BackgroundScene& scene = *result.settings.background;
  ASSERT_EQ(scene.shapes.size(), 2U);
  EXPECT_EQ(scene.shapes[0].vertices.at(7), (Vec3{2, 2, 2}));
  EXPECT_EQ(scene.materials.at(scene.shapes[0].material).diffuse, (std::array<double, 3>{1, 0, 0}));
  EXPECT_TRUE(scene.shapes[1].isSphere);
  EXPECT_EQ(scene.materials.at(scene.shapes[1].material).diffuse, (std::array<double, 3>{0.8, 0.8, 0.8}));
  EXPECT_EQ(result.settings.angleIncrementDegrees, 45.0);
  // the files are kept with the model's sources
  EXPECT_TRUE(std::ranges::any_of(result.sources, [](const auto& source) { return source.name == "m/b.bg"; }));
  // a later command replaces an earlier one
  const ViewFileResult later = read("background scene: b.bg\nbackground scene:\n", {{"m/b.bg", "sphere 1\n"}});
  EXPECT_EQ(later.settings.background, nullptr);
}

TEST(ViewFile, FlagsAreOnOrOff) {
  EXPECT_EQ(messages(read("tapered lines: maybe\n")), Texts{"1:1 expected 'on' or 'off', found 'maybe'; it stays on"});
}

TEST(ViewFile, EqualViewpointAndReferencePointAreMovedApart) {
  const ViewFileResult result = read("viewpoint: 1,1,1\nview reference point: 1,1,1\n");
  EXPECT_EQ(messages(result),
            Texts{"1:1 viewpoint and view reference point are equal; the view is from 0,0,-1 to 0,0,0"});
  EXPECT_EQ(result.settings.viewpoint, (Vec3{0, 0, -1}));
}

constexpr const char* kFunction = "fver 1 1\nname: one\nsamples: 10\nflip: off\npoints: 4\n0 1\n0.3 1\n0.6 1\n1 1\n";

TEST(ViewFile, FunctionsAreReadBesideTheViewFileAndKeepTheirIds) {
  const ViewFileResult result = read("function: missing.func\nfunction: one.func 5\n", {{"m/one.func", kFunction}});
  ASSERT_EQ(result.settings.functions.size(), 2U);
  EXPECT_EQ(result.settings.functions[0].value(0.5), 0.0);
  EXPECT_EQ(result.settings.functions[1].value(0.5), 1.0);
  EXPECT_FALSE(result.settings.functionSetDefinesMacros);
  EXPECT_EQ(messages(result), Texts{"1:1 the file 'm/missing.func' cannot be read; function 1 is 0 everywhere"});
  ASSERT_EQ(result.sources.size(), 2U);
  EXPECT_EQ(result.sources[0].name, "m/model.v");
  EXPECT_EQ(result.sources[1].name, "m/one.func");
}

TEST(ViewFile, WarningsInNamedFilesPointIntoThem) {
  const ViewFileResult result = read("function: bad.func\n", {{"m/bad.func", "fver 1 1\nname: a\nsample: 3\n"}});
  ASSERT_EQ(result.diagnostics.entries().size(), 1U);
  EXPECT_EQ(core::formatDiagnostic(result.diagnostics.entries()[0]),
            "m/bad.func:3:1: warning: expected 'samples:' while reading function 'a', found 'sample:'\n"
            "    3 | sample: 3\n"
            "      | ^~~~~~~\n"
            "   hint: this function is 0 everywhere");
}

TEST(ViewFile, FunctionSetDiscardsEarlierFunctionsAndDefinesMacrosUntilAFunctionFollows) {
  const std::map<std::string, std::string> files = {
      {"m/one.func", kFunction}, {"m/s.fset", std::string("funcgalleryver 1 1\nitems: 1\n") + kFunction}};
  const ViewFileResult set = read("function: one.func\nfunction set: s.fset\n", files);
  EXPECT_EQ(set.settings.functions.size(), 1U);
  EXPECT_TRUE(set.settings.functionSetDefinesMacros);
  EXPECT_EQ(set.settings.functions[0].name(), "one");
  const ViewFileResult both = read("function set: s.fset\nfunction: one.func\n", files);
  EXPECT_EQ(both.settings.functions.size(), 2U);
  EXPECT_FALSE(both.settings.functionSetDefinesMacros);
  // the reference's batch run defines none
  EXPECT_FALSE(read("function set: s.fset\n", files, Compatibility::CpfgBatch).settings.functionSetDefinesMacros);
}

constexpr const char* kSurface =
    "0 1 0 1 0 0\nCONTACT POINT X: 0 Y: 0 Z: 0\nEND POINT X: 0 Y: 1 Z: 0\nHEADING X: 0 Y: 1 Z: 0\nUP X: 0 Y: 0 Z: -1\n"
    "SIZE: 1\n";

TEST(ViewFile, SurfaceArgumentsAreScaleThenTextureOrSubdivisions) {
  const files::ViewSettings s =
      read("surface: a p.s 2\nsurface: b p.s 1 3\nline: c p.s 1 4 6\nsurface: d p.s -1 4 6 0\n", {{"m/p.s", kSurface}})
          .settings;
  ASSERT_EQ(s.surfaces.size(), 4U);
  EXPECT_EQ(s.surfaces[0].endPoint, (Vec3{0, 2, 0}));
  EXPECT_EQ(s.surfaces[0].texture, -1);
  EXPECT_EQ(s.surfaces[1].texture, 3);
  EXPECT_EQ(s.surfaces[1].subdivisionS, 5);
  EXPECT_EQ(s.surfaces[2].id, 'c');
  EXPECT_EQ(s.surfaces[2].subdivisionS, 4);
  EXPECT_EQ(s.surfaces[2].subdivisionT, 6);
  EXPECT_EQ(s.surfaces[2].texture, -1);
  // a scale that is not positive becomes 1
  EXPECT_EQ(s.surfaces[3].endPoint, (Vec3{0, 1, 0}));
  EXPECT_EQ(s.surfaces[3].texture, 0);
}

TEST(ViewFile, SurfaceIdsAreUniqueSingleCharacters) {
  const ViewFileResult result =
      read("surface: a p.s 1\ntsurface: a t.ray 1\nsurface: leaf p.s 1\nsurface: ~ p.s 1\nsurface: x none.s 1\n",
           {{"m/p.s", kSurface}, {"m/t.ray", ""}});
  EXPECT_EQ(result.settings.surfaces.size(), 1U);
  EXPECT_EQ(messages(result), (Texts{"2:1 the surface 'a' is defined already; this one is ignored",
                                     "3:1 the name of a surface is one character, found 'leaf'; the surface is ignored",
                                     "4:1 only the first surface can be named '~'; this one is ignored",
                                     "5:1 the file 'm/none.s' cannot be read; ~x draws nothing and the turtle stays"}));
}

TEST(ViewFile, SurfaceScaleIsMandatory) {
  const ViewFileResult result = read("surface: a p.s\nangle increment: 30\n", {{"m/p.s", kSurface}});
  EXPECT_TRUE(result.settings.surfaces.empty());
  EXPECT_EQ(messages(result), Texts{"1:1 expected a number while reading 'surface:', found 'angle'"});
  EXPECT_EQ(result.settings.angleIncrementDegrees, 30.0);
}

TEST(ViewFile, ContoursAreNumberedAndTheLastOfANumberCounts) {
  const std::string open = "cver 1 3\nname: a\npoints: 2 6\ntype: or\nsamples: 8\n-1 0 0 3\n1 0 0 3\n";
  const ViewFileResult result = read("contour: 2 a.con\ncontour: 2 b.con\ncontour: 40 a.con\ncontour: 3 none.con\n",
                                     {{"m/a.con", open}, {"m/b.con", "3 2 closed\n1 0\n0 1\n-1 0\n"}});
  ASSERT_EQ(result.settings.contours.size(), 1U);
  EXPECT_TRUE(result.settings.contours[0].isClosed);
  EXPECT_EQ(messages(result),
            (Texts{"3:1 contour 40 is ignored", "4:1 the file 'm/none.con' cannot be read; contour 3 is the circle"}));
}

TEST(ViewFile, CurvesKeepTheirIds) {
  const ViewFileResult result =
      read("curve: none.con\ncurve: c.con 50\n", {{"m/c.con", "points: 4\n0 0\n1 0\n2 0\n3 0\n"}});
  ASSERT_EQ(result.settings.curves.size(), 2U);
  EXPECT_EQ(result.settings.curves[0].arcLength(), 0.0);
  EXPECT_NEAR(result.settings.curves[1].arcLength(), 1.0, 1e-5);
  EXPECT_EQ(messages(result), Texts{"1:1 the file 'm/none.con' cannot be read; curve 1 is the origin everywhere"});
}

TEST(ViewFile, BlobNamesEndInSdat) {
  const ViewFileResult result = read("blob: a.b.sdat\nblob: c.sdat\n", {{"m/c.sdat", "L 0 0 0 1 0 0\n"}});
  ASSERT_EQ(result.settings.blobFields.size(), 1U);
  EXPECT_EQ(result.settings.blobFields[0].objects().size(), 1U);
  EXPECT_EQ(messages(result),
            Texts{"1:1 the name of a blob field ends in .sdat and has no other point; 'a.b.sdat' is ignored"});
}

TEST(ViewFile, ReferenceTablesEndOnlyInCompatibleModes) {
  std::string text;
  for (int i = 0; i < 11; ++i) {
    text += "tropism: T: 0,1,0\n";
  }
  EXPECT_EQ(read(text).settings.movements.size(), 11U);
  const ViewFileResult compatible = read(text, {}, Compatibility::Cpfg);
  EXPECT_EQ(compatible.settings.movements.size(), 10U);
  EXPECT_EQ(messages(compatible), Texts{"11:1 the tropism is dropped: the reference program has at most 10 movements"});
}

TEST(ViewFile, TooManyFilesAreNotOpened) {
  std::string text;
  for (int i = 0; i < 1001; ++i) {
    text += "function: f.func\n";
  }
  const ViewFileResult result = read(text, {{"m/f.func", kFunction}});
  EXPECT_EQ(result.settings.functions.size(), 1001U);
  EXPECT_EQ(messages(result), Texts{"1001:1 more than 1000 files in one view file; function 1001 is 0 everywhere"});
}

TEST(ViewFile, AllFilesTogetherHaveABudget) {
  const std::string many = "fver 1 1\nname: one\nsamples: 10000\nflip: off\npoints: 4\n0 1 90000\n0.3 1\n0.6 1\n1 1\n";
  std::string text;
  for (int i = 0; i < 12; ++i) {
    text += "function: f.func\n";
  }
  const ViewFileResult points = read(text, {{"m/f.func", many}});
  EXPECT_EQ(points.settings.functions[10].value(0.9), 1.0);
  EXPECT_EQ(points.settings.functions[11].value(0.9), 0.0);
  EXPECT_EQ(messages(points),
            Texts{"6:1 the files of one view file have too many points; function 'one' is 0 everywhere"});

  std::string set = "funcgalleryver 1 1\nitems: 51\n";
  for (int i = 0; i < 51; ++i) {
    set += "fver 1 1\nname: one\nsamples: 10000\nflip: off\npoints: 4\n0 1\n0.3 1\n0.6 1\n1 1\n";
  }
  const ViewFileResult samples = read("function set: s.fset\n", {{"m/s.fset", set}});
  EXPECT_EQ(samples.settings.functions.size(), 51U);
  EXPECT_EQ(messages(samples),
            Texts{"455:1 the functions and curves of one view file have too many samples; this one has no table"});

  core::MemoryFileProvider files({{"model.v", "function: f.func\n"}, {"f.func", kFunction}});
  core::Limits limits;
  limits.maximumSourceBytes = 40;
  EXPECT_EQ(
      messages(readViewFile("model.v", files, Compatibility::Espalier, limits)),
      Texts{"1:1 the files of the view file have more bytes than the limit of a model's source allows: 'f.func' is not "
            "read; function 1 is 0 everywhere"});
}

}  // namespace
}  // namespace espalier::language::view_file_test
