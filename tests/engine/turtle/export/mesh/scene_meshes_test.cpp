#include "engine/turtle/export/mesh/scene_meshes.h"

#include <array>
#include <cmath>
#include <numbers>
#include <set>

#include "tests/engine/turtle/textured_view.h"
#include "tests/engine/turtle/turtle_fixture.h"
#include "tests/support/mesh_measures.h"

namespace espalier::turtle::scene_meshes_test {
namespace {

using core::Vec3;
using test::measure;
using test::MeshMeasures;

files::ViewSettings cylinderView(int sides) {
  files::ViewSettings view;
  view.lineStyle = files::LineStyle::Cylinder;
  view.contourSides = sides;
  return view;
}

// all meshes of a string's scene
std::vector<Mesh> meshesOf(const std::string& string, const files::ViewSettings& view, double detail = 1.0) {
  TurtleRun run(string, view);
  run.draw();
  const ExportInput input{.scene = run.scene, .view = view, .detail = detail};
  MaterialTable materials;
  core::WorkerTeam team(2);
  const SceneMeshes meshes(input, materials, team);
  std::vector<Mesh> made;
  for (const MeshPart& part : meshes.parts()) {
    meshes.make(part, made.emplace_back());
  }
  return made;
}

// area of a regular polygon of unit circumradius, and its side
double polygonArea(int sides) {
  return 0.5 * sides * std::sin(2.0 * std::numbers::pi / sides);
}
double polygonSide(int sides) {
  return 2.0 * std::sin(std::numbers::pi / sides);
}

void expectClosed(const Mesh& mesh, const std::string& what) {
  const MeshMeasures measures = measure(mesh);
  EXPECT_EQ(measures.openEdgeCount, 0U) << what;
  EXPECT_GT(measures.triangleCount, 0U) << what;
  EXPECT_GT(measures.signedVolume, 0.0) << what;
  EXPECT_GT(measures.smallestFacing, 0.0) << what;
  EXPECT_LT(measures.largestNormalError, 1e-9) << what;
}

TEST(SceneMeshes, AStraightTubeIsAPrismOfItsSides) {
  // radius 0.5, length 3: volume A r² l, area of the sides n s r l and of two ends A r² each
  const std::vector<Mesh> meshes = meshesOf("!(1)F(1)F(2)", cylinderView(7));
  ASSERT_EQ(meshes.size(), 1U);
  const MeshMeasures measures = measure(meshes[0]);
  EXPECT_NEAR(measures.signedVolume, polygonArea(7) * 0.25 * 3.0, 1e-12);
  EXPECT_NEAR(measures.area, 7.0 * polygonSide(7) * 0.5 * 3.0 + 2.0 * polygonArea(7) * 0.25, 1e-12);
  expectClosed(meshes[0], "straight");
}

TEST(SceneMeshes, ABentTubeKeepsTheVolumeAndSideAreaOfItsLength) {
  // cut obliquely through its axis, a prism keeps volume and side area: what one side gains the other loses. So bends
  // neither pinch the tube nor fatten it
  for (const std::string bend : {"+(20)", "+(45)", "&(60)", "+(30)&(30)"}) {
    const std::vector<Mesh> meshes = meshesOf("!(0.4)F(2)" + bend + "F(3)" + bend + "F(2)", cylinderView(9));
    ASSERT_EQ(meshes.size(), 1U);
    const MeshMeasures measures = measure(meshes[0]);
    EXPECT_NEAR(measures.signedVolume, polygonArea(9) * 0.04 * 7.0, 1e-9) << bend;
    EXPECT_NEAR(measures.area, 9.0 * polygonSide(9) * 0.2 * 7.0 + 2.0 * polygonArea(9) * 0.04, 0.02 * measures.area)
        << bend;
    expectClosed(meshes[0], bend);
  }
}

TEST(SceneMeshes, ATaperedTubeIsAFrustum) {
  // radii 1 and 0.5 over length 6: A l (R² + R r + r²) / 3
  const std::vector<Mesh> meshes = meshesOf("!(2)F(1e-9)!(1)F(6)", cylinderView(12));
  ASSERT_EQ(meshes.size(), 1U);
  EXPECT_NEAR(measure(meshes[0]).signedVolume, polygonArea(12) * 6.0 * (1.0 + 0.5 + 0.25) / 3.0, 1e-6);
  // normals lean outward by the slope 0.5 / 6
  const Vec3& normal = meshes[0].normals[13 * 2];
  EXPECT_NEAR(normal.y / std::hypot(normal.x, normal.z), 0.5 / 6.0, 1e-9);
}

TEST(SceneMeshes, SweptLinesAreClosedAtAnyBend) {
  for (const int angle : {0, 5, 59, 61, 90, 120, 150, 170, 180}) {
    const std::string turn = "+(" + std::to_string(angle) + ")";
    for (const Mesh& mesh : meshesOf("!(0.3)F(2)" + turn + "F(2)/(40)" + turn + "F(2)", cylinderView(8))) {
      const MeshMeasures measures = measure(mesh);
      EXPECT_EQ(measures.openEdgeCount, 0U) << angle;
      EXPECT_GT(measures.signedVolume, 0.0) << angle;
      EXPECT_LT(measures.largestNormalError, 1e-9) << angle;
    }
  }
}

TEST(SceneMeshes, AnElbowIsNoThinnerThanItsTube) {
  // a right-angled bend of radius 0.5 at (0,2): the outer side goes round the joint at that distance
  const std::vector<Mesh> meshes = meshesOf("!(1)F(2)-(90)F(2)", cylinderView(16));
  ASSERT_EQ(meshes.size(), 1U);
  double farthest = 0.0;
  for (const Vec3& p : meshes[0].positions) {
    if (p.x < 0.0 && p.y > 2.0) {
      farthest = std::max(farthest, std::hypot(p.x, p.y - 2.0));
    }
  }
  EXPECT_NEAR(farthest, 0.5, 1e-9);
}

TEST(SceneMeshes, AChangeOfWidthOrColourOnAnAxisLeavesNoGap) {
  files::ViewSettings view = cylinderView(6);
  view.hasTaperedLines = false;
  for (const std::string string : {"!(1)F!(0.5)+(30)F", "!(1)F!(0.5)+(80)F"}) {
    const std::vector<Mesh> meshes = meshesOf(string, view);
    ASSERT_EQ(meshes.size(), 1U);
    EXPECT_EQ(measure(meshes[0]).openEdgeCount, 0U) << string;
  }
  // one mesh for each colour; the second begins with the ring at which the first ends although the turtle has rolled
  const std::vector<Mesh> pieces = meshesOf("!(0.2);(3)F+(30)/(77)F/(10);(4)&(20)F", view);
  ASSERT_EQ(pieces.size(), 2U);
  expectClosed(pieces[0], "first");
  expectClosed(pieces[1], "second");
  for (std::size_t k = 0; k < 7; ++k) {
    const Vec3 difference = pieces[0].positions[14 + k] - pieces[1].positions[k];
    EXPECT_LT(core::length(difference), 1e-12);
  }
  EXPECT_NEAR(pieces[1].coordinates[0][1], 2.0, 1e-12) << "the texture goes on along the axis";
}

TEST(SceneMeshes, ALongLineIsMadeInPiecesThatMeet) {
  std::string string = "!(0.2);(3)";
  for (std::uint32_t i = 0; i < 3 * kLongestChain + 5; ++i) {
    // mitres, elbows, steps of width and rolls; the bends of neighbours cancel, so that the line does not cross itself
    const std::array<std::string, 6> modules{"+(40)F", "-(40)F", "&(80)F", "^(80)F", "/(25)F", "!(0.2)F(1.5)"};
    string += i % 6 == 5 && i % 12 == 11 ? "!(0.3)F" : modules[i % 6];
  }
  files::ViewSettings view = cylinderView(6);
  view.hasTaperedLines = false;
  const std::vector<Mesh> pieces = meshesOf(string, view);
  ASSERT_EQ(pieces.size(), 4U);
  Mesh whole;
  double length = 0.0;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    EXPECT_GT(measure(pieces[i]).openEdgeCount, 0U) << "a piece is open where it goes on";
    append(whole, pieces[i]);
    if (i == 0) {
      continue;
    }
    // the vertices of a tube's rings come first, then those of its flat ends
    const std::size_t end = pieces[i - 1].positions.size() - (i == 1 ? 6 : 0) - 7;
    for (std::size_t k = 0; k < 7; ++k) {
      EXPECT_EQ(pieces[i].positions[k], pieces[i - 1].positions[end + k]) << i;
      EXPECT_EQ(pieces[i].normals[k], pieces[i - 1].normals[end + k]) << i;
      EXPECT_EQ(pieces[i].coordinates[k], pieces[i - 1].coordinates[end + k]) << i;
    }
    EXPECT_GT(pieces[i].coordinates[0][1], length);
    length = pieces[i].coordinates[0][1];
  }
  const MeshMeasures measures = measure(whole);
  EXPECT_EQ(measures.openEdgeCount, 0U);
  EXPECT_GT(measures.signedVolume, 0.0);
}

TEST(SceneMeshes, ALongCylinderIsMadeInRunsThatMeet) {
  for (const std::string ends : {"@Gs|@Ge(2)", "{(2)|}(2)", "{(1)|}(1)", "{(3)|}(3)"}) {
    std::string middle;
    for (std::size_t i = 0; i < 2 * kLongestRun + 9; ++i) {
      // around a screw; a colour of its own here and there
      middle += (i % 50 == 7 ? ";(" + std::to_string(3 + i / 50) + ")" : "") + "+(9)^(4)f(0.5)." +
                (ends[0] == '@' ? "@Gc(2)" : "");
    }
    const std::string string = "!(0.2)" + ends.substr(0, ends.find('|')) + middle + ends.substr(ends.find('|') + 1);
    TurtleRun run(string, cylinderView(6));
    run.draw();
    ASSERT_EQ(run.scene.cylinders.size(), 1U) << string;
    const SweptCylinder swept(run.scene.cylinders[0], run.program.view);
    EXPECT_GE(swept.runs().size(), 4U);
    Mesh whole;
    std::size_t lastRing = 0;
    for (const CylinderRun& cylinderRun : swept.runs()) {
      EXPECT_LE(cylinderRun.count, kLongestRun);
      const std::size_t first = whole.positions.size();
      swept.appendRun(whole, cylinderRun);
      for (std::size_t k = 0; first > 0 && k < 7; ++k) {
        EXPECT_EQ(whole.positions[first + k], whole.positions[lastRing + k]);
        EXPECT_EQ(whole.normals[first + k], whole.normals[lastRing + k]);
        EXPECT_EQ(whole.coordinates[first + k], whole.coordinates[lastRing + k]);
      }
      // a run ends with a ring of seven vertices; the first has the vertices of the end behind its rings
      lastRing = whole.positions.size() - 7 - (first == 0 && !run.scene.cylinders[0].isClosed ? 6 : 0);
    }
    // the same as in one piece
    Mesh single;
    const CylinderRun& last = swept.runs().back();
    swept.appendRun(single, {0, last.first + last.count, 3});
    EXPECT_EQ(whole.faces.size(), single.faces.size());
    const MeshMeasures measures = measure(whole);
    const MeshMeasures expected = measure(single);
    EXPECT_EQ(measures.openEdgeCount, expected.openEdgeCount) << ends;
    EXPECT_NEAR(measures.area, expected.area, 1e-9 * expected.area);
    EXPECT_NEAR(measures.signedVolume, expected.signedVolume, 1e-9);
    // parts in any order have the same meshes as all runs one after the other
    const ExportInput input{.scene = run.scene, .view = run.program.view};
    MaterialTable materials;
    core::WorkerTeam team(2);
    const SceneMeshes meshes(input, materials, team, true);
    ASSERT_EQ(meshes.parts().size(), swept.runs().size());
    for (std::size_t i = meshes.parts().size(); i-- > 0;) {
      Mesh made;
      Mesh again;
      meshes.make(meshes.parts()[i], made);
      swept.appendRun(again, swept.runs()[i]);
      EXPECT_EQ(made.positions, again.positions);
    }
  }
}

TEST(SceneMeshes, APieceOfALongLineKnowsTheModulesOfItsFaces) {
  TurtleRun run(std::string(kLongestChain + 10, 'F'), cylinderView(5));
  run.draw();
  const ExportInput input{.scene = run.scene, .view = run.program.view};
  MaterialTable materials;
  core::WorkerTeam team(2);
  const SceneMeshes meshes(input, materials, team);
  ASSERT_EQ(meshes.parts().size(), 2U);
  Mesh mesh;
  for (std::uint64_t part = 0; part < 2; ++part) {
    meshes.make(meshes.parts()[part], mesh);
    EXPECT_EQ(meshes.provenanceOf(meshes.parts()[part], mesh, mesh.faces[0][2]).module, part * kLongestChain);
  }
  // behind the quads between the rings stand the three triangles of the flat end
  EXPECT_EQ(meshes.provenanceOf(meshes.parts()[1], mesh, mesh.faces[10 * 5 - 1][2]).module, kLongestChain + 9);
  EXPECT_EQ(mesh.faces.size(), 10U * 5 + 3);
}

TEST(SceneMeshes, ATextureGoesOnWhereTheColourChangesWhateverTheUnitOfWidths) {
  files::ViewSettings view = texturedView();
  view.lineStyle = files::LineStyle::Pixel;  // a width is a part of the scene's extent
  const std::vector<Mesh> pieces = meshesOf("@Tx(1)!(2);(3)F(3)F(2);(4)F(3)", view);
  ASSERT_EQ(pieces.size(), 2U);
  const std::size_t sides = static_cast<std::size_t>(view.contourSides);
  EXPECT_NEAR(pieces[1].coordinates[0][1], pieces[0].coordinates[2 * (sides + 1)][1], 1e-9);
}

TEST(SceneMeshes, TextureCoordinatesRunAroundAndAlongByLength) {
  const std::vector<Mesh> meshes = meshesOf("F(1)F(2)", cylinderView(4));
  ASSERT_EQ(meshes.size(), 1U);
  for (std::size_t ring = 0; ring < 3; ++ring) {
    for (std::size_t k = 0; k < 5; ++k) {
      EXPECT_DOUBLE_EQ(meshes[0].coordinates[5 * ring + k][0], 0.25 * static_cast<double>(k));
      EXPECT_DOUBLE_EQ(meshes[0].coordinates[5 * ring + k][1], ring == 0 ? 0.0 : ring == 1 ? 1.0 : 3.0);
    }
  }
}

TEST(SceneMeshes, AForkGoesOnIntoOneLimbAndTheOtherBeginsInThePlaneBetweenItAndItsParent) {
  files::ViewSettings view = cylinderView(8);
  view.initialColour = 3;  // all one colour
  const std::vector<Mesh> meshes = meshesOf(";(3)!(0.2)F(1)[+(50)F(1)][-(50)F(1)]", view);
  ASSERT_EQ(meshes.size(), 2U) << "trunk and first limb are one tube";
  expectClosed(meshes[0], "trunk and limb");
  const double half = 25.0 * std::numbers::pi / 180.0;
  const Mesh& branch = meshes[1];
  for (std::size_t k = 0; k < 8; ++k) {
    const Vec3 offset = branch.positions[k] - Vec3{0.0, 1.0, 0.0};
    EXPECT_NEAR(core::dot(offset, {std::sin(half), std::cos(half), 0.0}), 0.0, 1e-12);
  }
  expectClosed(branch, "branch");
  // no ring of the first tube is flat across the trunk's end
  bool hasFlatEnd = false;
  for (std::size_t i = 0; i < meshes[0].positions.size(); ++i) {
    const Vec3& p = meshes[0].positions[i];
    hasFlatEnd =
        hasFlatEnd || (std::abs(p.y - 1.0) < 1e-9 && core::length(meshes[0].normals[i] - Vec3{0, 1, 0}) < 1e-6);
  }
  EXPECT_FALSE(hasFlatEnd);
}

TEST(SceneMeshes, TheThickestLimbOfAForkGoesOnAndOfEqualOnesTheStraightest) {
  const auto headsOf = [](const std::string& string) {
    TurtleRun run(string, cylinderView(8));
    run.draw();
    core::WorkerTeam team(2);
    return chainsOf(run.scene, Palette(run.scene, {}), {}, team).heads;
  };
  // segments: trunk 0, first limb 1, second limb 2
  EXPECT_EQ(headsOf(";(3)!(0.4)F[+(50)!(0.1)F][-(50)!(0.2)F]"), (std::vector<std::uint32_t>{0, 1}));
  EXPECT_EQ(headsOf(";(3)!(0.4)F[+(50)F][-(20)F]"), (std::vector<std::uint32_t>{0, 1}));
  EXPECT_EQ(headsOf(";(3)!(0.4)F[+(20)F][-(50)F]"), (std::vector<std::uint32_t>{0, 2}));
  EXPECT_EQ(headsOf(";(3)!(0.4)F[+(20)F]F"), (std::vector<std::uint32_t>{0, 1})) << "the axis goes on, not the branch";
}

TEST(SceneMeshes, AtAForkTheTubeTakesTheLimbsWidthOverAShortWay) {
  files::ViewSettings view = cylinderView(16);
  view.hasTaperedLines = false;
  const std::vector<Mesh> meshes = meshesOf(";(3)!(0.4)F(1)[!(0.2)F(2)]", view);
  ASSERT_EQ(meshes.size(), 1U);
  expectClosed(meshes[0], "a thinner limb");
  // rings at heights 0, 1 (radius 0.2), 1.4 (two radii on, radius 0.1) and 3
  const auto radiusAt = [&](double y) {
    double largest = 0.0;
    for (const Vec3& p : meshes[0].positions) {
      largest = std::abs(p.y - y) < 1e-9 ? std::max(largest, std::hypot(p.x, p.z)) : largest;
    }
    return largest;
  };
  EXPECT_NEAR(radiusAt(1.0), 0.2, 1e-9);
  EXPECT_NEAR(radiusAt(1.4), 0.1, 1e-9);
  EXPECT_NEAR(radiusAt(3.0), 0.1, 1e-9);
}

TEST(SceneMeshes, AGeneralizedCylinderOfSeveralColoursIsClosedAndItsPartsMeet) {
  TurtleRun run("!(1);(3){(1)f(1)+(20)f(1);(7)f(1)+(20)f(1)}(1)");
  run.draw();
  const ExportInput input{.scene = run.scene, .view = run.program.view};
  MaterialTable table;
  core::WorkerTeam team(2);
  const SceneMeshes meshes(input, table, team);
  ASSERT_EQ(meshes.parts().size(), 2U);
  EXPECT_EQ(table.materials()[meshes.parts()[0].material].name, "bark");
  EXPECT_EQ(table.materials()[meshes.parts()[1].material].name, "bark_7");
  Mesh both;
  Mesh mesh;
  for (const MeshPart& part : meshes.parts()) {
    meshes.make(part, mesh);
    append(both, mesh);
  }
  expectClosed(both, "two colours");
  EXPECT_EQ(run.scene.cylinders.size(), 1U);
}

TEST(SceneMeshes, EachOrderOfBranchesHasAMaterialOfItsOwnName) {
  // names have the order's last byte, so those of order 256 and more meet names that are given already
  std::string string = "F";
  for (int order = 1; order <= 600; ++order) {
    string += "[F";
  }
  TurtleRun run(string);
  run.draw();
  const ExportInput input{.scene = run.scene, .view = run.program.view};
  MaterialTable table;
  core::WorkerTeam team(2);
  const SceneMeshes meshes(input, table, team);
  std::set<std::string> names;
  for (const MeshMaterial& material : table.materials()) {
    names.insert(material.name);
  }
  EXPECT_EQ(table.materials().size(), 601U);
  EXPECT_EQ(names.size(), 601U);
  EXPECT_TRUE(names.contains("bark_0"));
  EXPECT_TRUE(names.contains("bark_1_2"));
  EXPECT_TRUE(names.contains("bark_1_3"));
  // the same scene again needs no new one
  static_cast<void>(SceneMeshes(input, table, team));
  EXPECT_EQ(table.materials().size(), 601U);
}

TEST(SceneMeshes, PartsKnowTheirModules) {
  TurtleRun run("F[+F@O(1)]F{.f+f+f}@c(1)");
  run.draw();
  const ExportInput input{.scene = run.scene, .view = run.program.view};
  MaterialTable materials;
  core::WorkerTeam team(2);
  const SceneMeshes meshes(input, materials, team);
  std::vector<std::pair<OrganKind, std::uint64_t>> seen;
  for (const MeshPart& part : meshes.parts()) {
    seen.emplace_back(part.kind, meshes.provenanceOf(part).module);
  }
  // modules: F 0, [ 1, + 2, F 3, @ 4, O 5, ] 6, F 7, { 8
  ASSERT_EQ(seen.size(), 5U);
  EXPECT_EQ(seen[0], std::pair(OrganKind::Branch, std::uint64_t{0}));
  EXPECT_EQ(seen[1], std::pair(OrganKind::Branch, std::uint64_t{3}));
  EXPECT_EQ(seen[2], std::pair(OrganKind::Polygon, std::uint64_t{8}));
  EXPECT_EQ(run.scene.balls[0].branchOrder, 1U);
  EXPECT_EQ(run.scene.balls[0].parent, 1U) << "the sphere grows on the branch's segment";
  EXPECT_EQ(run.scene.balls[1].parent, 2U);
  EXPECT_EQ(run.scene.polygons[0].branchOrder, 0U);
  // each ring of a tube belongs to the segment that ends there
  Mesh tube;
  meshes.make(meshes.parts()[0], tube);
  ASSERT_EQ(tube.vertexSegments.size(), tube.positions.size());
  const auto moduleOfFace = [&](std::size_t face) {
    return meshes.provenanceOf(meshes.parts()[0], tube, tube.faces[face][2]).module;
  };
  EXPECT_EQ(moduleOfFace(0), 0U);
  EXPECT_EQ(moduleOfFace(8), 7U);
}

TEST(SceneMeshes, DetailScalesSidesAndSubdivisions) {
  const std::size_t full = meshesOf("F", cylinderView(12))[0].positions.size();
  const std::size_t half = meshesOf("F", cylinderView(12), 0.5)[0].positions.size();
  EXPECT_EQ(full, 2U * 13U + 2U * 12U);
  EXPECT_EQ(half, 2U * 7U + 2U * 6U);
  EXPECT_EQ(meshesOf("F", cylinderView(12), 0.01)[0].positions.size(), 2U * 4U + 2U * 3U);
}

TEST(SceneMeshes, PixelLinesAreSweptAtAFixedPartOfTheExtent) {
  files::ViewSettings view = cylinderView(4);
  view.lineStyle = files::LineStyle::Pixel;
  view.isLineStyleGiven = true;
  const MeshMeasures measures = measure(meshesOf("!(2)F(400)", view)[0]);
  // two of 800 pixels across
  EXPECT_NEAR(measures.high.x - measures.low.x, 1.0, 1e-9);
}

TEST(SceneMeshes, GeneralizedCylindersAreClosed) {
  files::ViewSettings view = cylinderView(8);
  // a concave section, clockwise and counter-clockwise
  std::vector<Vec3> section{{1, 0, 0}, {0.2, 0.2, 0}, {0, 1, 0}, {-0.2, 0.2, 0}, {-1, 0, 0}, {0, -1, 0}};
  view.contours.push_back({.id = 1, .isClosed = true, .points = section});
  std::ranges::reverse(section);
  view.contours.push_back({.id = 2, .isClosed = true, .points = section});
  const std::string path = "f(2)+(30)f(2)&(40)f(2)+(60)f(2)";
  for (const std::string contour : {"", "@#(1)@!(24)", "@#(2)@!(24)"}) {
    for (const std::string type : {"1", "2", "3", "4"}) {
      const std::string string = "!(0.3)" + contour + "{(" + type + ",6)" + path + "}(" + type + ")";
      const std::vector<Mesh> meshes = meshesOf(string, view);
      ASSERT_EQ(meshes.size(), 1U) << string;
      const MeshMeasures measures = measure(meshes[0]);
      EXPECT_EQ(measures.openEdgeCount, 0U) << string;
      EXPECT_GT(measures.signedVolume, 0.0) << string;
      EXPECT_GT(measures.smallestFacing, 0.0) << string;
      EXPECT_LT(measures.largestNormalError, 1e-9) << string;
    }
  }
}

TEST(SceneMeshes, AStraightGeneralizedCylinderIsAPrism) {
  const std::vector<Mesh> meshes = meshesOf("!(1)@!(10)@Gs f(1)@Gc(3)f(2)@Ge(4)", cylinderView(8));
  ASSERT_EQ(meshes.size(), 1U);
  EXPECT_NEAR(measure(meshes[0]).signedVolume, polygonArea(10) * 0.25 * 3.0, 1e-12);
}

TEST(SceneMeshes, AGeneralizedCylinderWithALinearRadiusLeansItsNormals) {
  // radius 1 to 0.5 along 2
  const std::vector<Mesh> meshes = meshesOf("!(2)@!(8)@Gs f(2)!(1)@Ge(4)", cylinderView(8));
  ASSERT_EQ(meshes.size(), 1U);
  const Vec3& normal = meshes[0].normals[9 * 2];
  EXPECT_NEAR(normal.y / std::hypot(normal.x, normal.z), 0.5 / 2.0, 0.1);
  EXPECT_GT(normal.y, 0.1);
}

// along a helix the frame turns against the tangent only: up' has no part along tangent x up
TEST(SceneMeshes, TheFrameOfAGeneralizedCylinderDoesNotTurnAboutItsAxis) {
  std::string path;
  for (int i = 0; i < 12; ++i) {
    path += "/(20)+(30)f(1)";
  }
  const std::vector<Mesh> meshes = meshesOf("!(0.02)@!(4){(1,32)" + path + "}(1)", cylinderView(4));
  ASSERT_EQ(meshes.size(), 1U);
  const Mesh& mesh = meshes[0];
  const std::size_t rings = (mesh.positions.size() - 8) / 5;
  double turned = 0.0;
  for (std::size_t i = 1; i < rings; ++i) {
    const auto at = [&](std::size_t ring, std::size_t k) { return mesh.positions[5 * ring + k]; };
    const auto up = [&](std::size_t ring) { return core::normalised(at(ring, 0) - at(ring, 2)); };
    const auto side = [&](std::size_t ring) { return core::normalised(at(ring, 1) - at(ring, 3)); };
    turned += core::dot(up(i) - up(i - 1), core::normalised(side(i) + side(i - 1)));
  }
  EXPECT_NEAR(turned, 0.0, 2e-3);
}

TEST(SceneMeshes, SpheresAreClosedAndDiscsLookAlongTheirNormal) {
  const std::vector<Mesh> meshes = meshesOf("@O(2)@c(2)&(35)+(70)@c(1)", cylinderView(8));
  ASSERT_EQ(meshes.size(), 3U);
  expectClosed(meshes[0], "sphere");
  const double ball = 4.0 / 3.0 * std::numbers::pi;
  EXPECT_GT(measure(meshes[0]).signedVolume, 0.85 * ball);
  EXPECT_LT(measure(meshes[0]).signedVolume, ball);
  EXPECT_NEAR(measure(meshes[1]).smallestFacing, 1.0, 1e-12);
  EXPECT_NEAR(measure(meshes[2]).smallestFacing, 1.0, 1e-12);
}

TEST(Mesh, AMirroredPlacementKeepsItsSidesOutward) {
  Mesh sphere;
  appendSphere(sphere, {}, 1.0, 8, 12);
  for (const Vec3 scale : {Vec3{1, 2, 3}, Vec3{-1, 2, 3}, Vec3{-1, -2, -3}}) {
    Mesh placed;
    appendPlaced(placed, sphere, {.position = {5, 6, 7}, .frame = core::Frame{}, .scale = scale});
    expectClosed(placed, "placed");
    EXPECT_NEAR(measure(placed).signedVolume, 6.0 * measure(sphere).signedVolume, 1e-9);
  }
}

}  // namespace
}  // namespace espalier::turtle::scene_meshes_test
