#include "clients/espalier/roots/root_system.h"

#include <gtest/gtest.h>

#include "clients/espalier/roots/root_traits.h"

namespace espalier::roots::root_system_test {
namespace {

/// A primary root of 4 cm with laterals of 1 and 2 cm at 1 and 3 cm, rows out of order.
constexpr const char* kTable =
    "# a root\nnode\tparent\tx\ty\tz\tradius\torder\n0\t-1\t0\t0\t0\t0.1\t1\n3\t2\t0\t0\t-3\t0.1\t1\n"
    "4\t3\t0\t0\t-4\t0.1\t1\n1\t0\t0\t0\t-1\t0.1\t1\n2\t1\t0\t0\t-2\t0.1\t1\n"
    "9\t1\t1\t0\t-1\t0.05\t2\n7\t3\t0\t2\t-3\t0.05\t2\n";

constexpr const char* kRsml = R"(<?xml version="1.0"?>
<rsml><metadata><unit>cm</unit></metadata><scene><plant ID="1">
<root ID="a"><geometry><polyline><point x="0" y="0" z="0"/><point x="0" y="0" z="-1"/><point x="0" y="0" z="-2"/>
<point x="0" y="0" z="-3"/><point x="0" y="0" z="-4"/></polyline></geometry>
<functions><function name="diameter" domain="polyline"><sample>0.2</sample></function>
<function name="emergence_time" domain="polyline"><sample value="0"/><sample value="2.5"/><sample value="3"/>
<sample value="4"/><sample value="5"/></function></functions>
<root ID="b"><properties><parent-node value="1"/></properties><geometry><polyline><point x="0" y="0" z="-1"/>
<point x="1" y="0" z="-1"/></polyline></geometry>
<functions><function name="diameter"><sample value="0.1"/></function></functions></root>
<root ID="c"><geometry><polyline><point x="0" y="0" z="-3"/><point x="0" y="2" z="-3"/></polyline></geometry>
<functions><function name="diameter"><sample value="0.1"/></function></functions></root>
</root></plant></scene></rsml>)";

TEST(RootSystem, BothFilesGiveTheSameTraits) {
  for (const auto& roots : {readRootTable(kTable), readRsml(kRsml)}) {
    ASSERT_TRUE(roots) << roots.error();
    ASSERT_EQ(roots->nodes.size(), 7U);
    const RootTraits traits = traitsOf(*roots, 2);
    EXPECT_DOUBLE_EQ(traits.length, 7.0);
    EXPECT_EQ(traits.orders.at(1).number, 1U);
    EXPECT_DOUBLE_EQ(traits.orders.at(1).length, 4.0);
    EXPECT_EQ(traits.orders.at(2).number, 2U);
    EXPECT_DOUBLE_EQ(traits.orders.at(2).length, 3.0);
    EXPECT_DOUBLE_EQ(traits.orders.at(1).diameter, 0.2);
    EXPECT_DOUBLE_EQ(traits.orders.at(2).diameter, 0.1);
    EXPECT_DOUBLE_EQ(traits.height, 4.0);
    EXPECT_DOUBLE_EQ(traits.width, 2.0);
    // a herringbone of magnitude μ = 3 has the path length (μ² + 3μ − 2)/2 (Fitter 1987)
    EXPECT_EQ(traits.magnitude, 3U);
    EXPECT_EQ(traits.altitude, 3U);
    EXPECT_EQ(traits.pathLength, 8U);
  }
  EXPECT_EQ(readRsml(kRsml)->unit, "cm");
  EXPECT_EQ(readRsml(kRsml)->nodes[1].emergence, 2.5);
}

TEST(RootSystem, ALateralThatBeginsFarFromItsParentIsNamed) {
  EXPECT_EQ(readRsml(kRsml)->remark, "");
  std::string far = kRsml;
  far.replace(far.find("<point x=\"0\" y=\"0\" z=\"-3\"/><point x=\"0\" y=\"2\""), 27,
              "<point x=\"5\" y=\"0\" z=\"-3\"/>");
  EXPECT_EQ(readRsml(far)->remark,
            "1 lateral begins farther from the parent than the parent's points lie apart; a straight piece joins them: "
            "line 11, 5 away");
}

TEST(RootSystem, APublishedFileThatLeavesOutFirstPointsButCountsThemIsJoinedWhereItsLateralsAre) {
  // as R-SWMS writes the root systems of Schnepf et al. 2020: numbered functions, laterals that begin a piece away from
  // the main root, an empty root in each, and the first two points of the main root missing
  const std::string text = R"(<rsml><metadata><unit>cm</unit></metadata><scene><plant><root ID="1"><geometry><polyline>
<point x="0" y="0" z="-2"/><point x="0" y="0" z="-3"/><point x="0" y="0" z="-4"/><point x="0" y="0" z="-5"/>
<point x="0" y="0" z="-6"/></polyline></geometry><properties><parent-node value="-1"/></properties>
<functions><function domain="polyline" name="emergence_time"><sample value="1"/></function>
<function1 domain="polyline" name="diameter"><sample value="0.25"/></function1></functions>
<root ID="2"><geometry><polyline><point x="0.9" y="0" z="-4"/><point x="1.8" y="0" z="-4"/></polyline></geometry>
<properties><parent-node value="4"/></properties>
<functions><function1 domain="polyline" name="diameter"><sample value="0.125"/></function1></functions><root/></root>
<root ID="3"><geometry><polyline><point x="0" y="0.5" z="-3"/></polyline></geometry>
<properties><parent-node value="1"/></properties></root></root></plant></scene></rsml>)";
  const auto roots = readRsml(text);
  ASSERT_TRUE(roots) << roots.error();
  ASSERT_EQ(roots->nodes.size(), 8U);
  EXPECT_EQ(roots->nodes[0].radius, 0.125);
  EXPECT_EQ(roots->nodes[5].radius, 0.0625);
  EXPECT_EQ(roots->nodes[5].parent, 2U) << "the point at -4, not the fifth at -6";
  EXPECT_EQ(roots->nodes[7].parent, 1U) << "a point that the file names and that is near stays";
  EXPECT_EQ(
      roots->remark,
      "1 lateral begins at the nearest point of the parent, because the point that the file names is farther away "
      "than the parent's points lie apart: line 6; 1 root has no points of a polyline and is left out: line 8");
}

TEST(RootSystem, ADichotomousTreeHasThePathLengthOfItsForm) {
  // 8 tips, each 4 links from the collar
  RootSystem roots;
  roots.nodes.resize(16);
  for (std::uint32_t i = 1; i < 16; ++i) {
    roots.nodes[i].parent = i / 2;
    roots.nodes[i].axis = i;
    roots.nodes[i].place = {static_cast<double>(i), 0, 0};
  }
  const RootTraits traits = traitsOf(roots, 1);
  EXPECT_EQ(traits.magnitude, 8U);
  EXPECT_EQ(traits.altitude, 4U);
  EXPECT_EQ(traits.pathLength, 32U);
}

TEST(RootSystem, LateralsOfOnePointLeaveAtItsBranchingsOneAfterTheOther) {
  // two laterals at the first point of an axis are two branchings: the first has one link from there, the second two,
  // and the axis passes both
  const auto roots = readRootTable(
      "node\tparent\tx\ty\tz\torder\n0\t-1\t0\t0\t0\t1\n1\t0\t0\t0\t-1\t1\n2\t1\t0\t0\t-2\t1\n"
      "3\t1\t1\t0\t-1\t2\n4\t1\t-1\t0\t-1\t2\n");
  ASSERT_TRUE(roots) << roots.error();
  const RootTraits traits = traitsOf(*roots, 2);
  EXPECT_EQ(traits.magnitude, 3U);
  EXPECT_EQ(traits.altitude, 3U);
  EXPECT_EQ(traits.pathLength, 2U + 3U + 3U);
}

TEST(RootSystem, RootsThatBeginAtTheCollarAreOfOrderOneAlsoInBrackets) {
  // [F[F]F][F]: two first-order roots side by side, the first with a lateral
  turtle::Scene scene;
  const auto add = [&](const core::Vec3& start, const core::Vec3& end, std::uint32_t order, std::uint32_t parent) {
    turtle::Segment segment;
    segment.start = start;
    segment.end = end;
    segment.branchOrder = order;
    segment.parent = parent;
    scene.segments.push_back(segment);
  };
  add({0, 0, 0}, {0, -1, 0}, 1, turtle::kNoParent);
  add({0, -1, 0}, {3, -1, 0}, 2, 0);
  add({0, -1, 0}, {0, -2, 0}, 1, 0);
  add({0, 0, 0}, {5, 0, 0}, 1, turtle::kNoParent);
  const RootTraits traits = traitsOf(rootsOf(scene), 1);
  EXPECT_EQ(traits.orders.at(1).number, 2U);
  EXPECT_DOUBLE_EQ(traits.orders.at(1).length, 7.0);
  EXPECT_EQ(traits.orders.at(2).number, 1U);
  EXPECT_DOUBLE_EQ(traits.orders.at(2).length, 3.0);
  EXPECT_EQ(traits.orders.size(), 2U);
  EXPECT_EQ(traits.magnitude, 3U);
}

TEST(RootSystem, TheStringDrawsTheRoots) {
  EXPECT_EQ(stringOf(*readRootTable("node\tparent\tx\ty\tz\tradius\torder\temergence\n0\t-1\t1\t2\t3\t0.1\t1\t0\n"
                                    "1\t0\t1\t2\t1\t0.1\t1\t4\n2\t1\t1\t2\t0\t0.1\t1\t5\n3\t1\t2\t2\t1\t0.05\t2\t6\n")),
            "[@M(1,2,3)@R(0,0,-2)!(0.2)F(2)?E(2,1,0,0,0,0,0,0,0,0)[@R(1,0,0)!(0.1)F(1)?E(0,2,0,0,0,0,0,0,0,0)]"
            "@R(0,0,-1)!(0.2)F(1)?E(1,1,0,0,0,0,0,0,0,0)]");
}

/// A root with points and functions; its functions are in line 2.
std::string rootWith(const std::string& points, const std::string& functions = "", const std::string& more = "") {
  return "<rsml><metadata><unit>cm</unit></metadata><scene><plant><root ID='a'><geometry><polyline>" + points +
         "</polyline>" + more + "</geometry>\n<functions>" + functions + "</functions></root></plant></scene></rsml>";
}

constexpr const char* kThreePoints = "<point x='0' y='0'/><point x='0' y='-10'/><point x='0' y='-40'/>";

TEST(RsmlReader, OnlyPointsOfAPolylineBelongToARoot) {
  // a root of 20 cm, an annotation 5 cm beside it, and the points that control a spline
  for (const std::string& text :
       {rootWith("<point x='0' y='0'/><point x='0' y='-20'/>", "",
                 "<rootnavspline controlpointseparation='50'><point x='1' y='2'/><point x='5' y='5'/></rootnavspline>"),
        std::string("<rsml><scene><plant><root><geometry><polyline><point x='0' y='0'/><point x='0' y='-20'/>"
                    "</polyline></geometry><annotations><annotation name='tip'><point x='5' y='-20'/><value>1</value>"
                    "</annotation></annotations></root></plant></scene></rsml>")}) {
    const auto roots = readRsml(text);
    ASSERT_TRUE(roots) << roots.error();
    EXPECT_EQ(roots->nodes.size(), 2U);
    EXPECT_DOUBLE_EQ(traitsOf(*roots, 1).length, 20.0);
    EXPECT_EQ(roots->remark, "");
  }
  const auto roots = readRsml(
      "<rsml><scene><plant>\n<root><geometry><rootnavspline><point x='1' y='2'/>"
      "<point x='5' y='5'/></rootnavspline></geometry></root></plant></scene></rsml>");
  ASSERT_TRUE(roots) << roots.error();
  EXPECT_TRUE(roots->nodes.empty());
  EXPECT_EQ(roots->remark, "1 root has no points of a polyline and is left out: line 2");
}

TEST(RsmlReader, OnlySamplesOfAFunctionBelongToIt) {
  const auto roots = readRsml(rootWith(
      kThreePoints, "<function name='diameter'><sample value='2'/><sample value='2'/><sample value='1'/></function>",
      "<annotations><annotation><function name='diameter'><sample value='9'/></function><sample value='9'/>"
      "</annotation></annotations>"));
  ASSERT_TRUE(roots) << roots.error();
  EXPECT_EQ(roots->nodes[0].radius, 1.0);
  EXPECT_EQ(roots->nodes[2].radius, 0.5);
}

/// The diameters at the points 0, 10 and 40 along a root.
std::vector<double> diametersBy(const std::string& function) {
  const auto roots = readRsml(rootWith(kThreePoints, function));
  EXPECT_TRUE(roots) << roots.error();
  std::vector<double> diameters;
  for (const RootSystem::Node& node : roots ? roots->nodes : std::vector<RootSystem::Node>()) {
    diameters.push_back(2.0 * node.radius);
  }
  return diameters;
}

TEST(RsmlReader, SamplesAreAtTheirPlacesInTheDomain) {
  using Values = std::vector<double>;
  EXPECT_EQ(diametersBy("<function name='diameter' domain='polyline'><sample>4</sample><sample value='2'/>"
                        "<sample value='1'/></function>"),
            (Values{4, 2, 1}));
  // from 4 at 0 to 8 at 40: 4 + 4 · 10/40 = 5 at 10; the order of samples does not count
  EXPECT_EQ(diametersBy("<function name='diameter' domain='length'><sample position='40' value='8'/>"
                        "<sample position='0'>4</sample></function>"),
            (Values{4, 5, 8}));
  // before the first sample and behind the last
  EXPECT_EQ(diametersBy("<function name='diameter' domain='length'><sample position='20' value='8'/>"
                        "<sample position='30' value='4'/></function>"),
            (Values{8, 8, 4}));
  // samples at 5, 15, 25, 35 and 45: 10 is between the first two, 40 between the last two
  EXPECT_EQ(diametersBy("<function name='diameter' domain='length' origin='5' step='10'><sample value='8'/>"
                        "<sample value='6'/><sample value='5'/><sample value='4'/><sample value='1'/></function>"),
            (Values{8, 7, 2.5}));
  // at 0, 20 and 40
  EXPECT_EQ(diametersBy("<function name='diameter' domain='Uniform'><sample value='8'/><sample value='4'/>"
                        "<sample value='1'/></function>"),
            (Values{8, 6, 1}));
  // one sample is that of the whole root
  for (const char* domain : {"", "domain='polyline'", "domain='length'", "domain='uniform'"}) {
    EXPECT_EQ(diametersBy("<function name='diameter' " + std::string(domain) + "><sample value='3'/></function>"),
              (Values{3, 3, 3}));
  }
  // functions with other names are not read
  EXPECT_EQ(diametersBy("<function name='angle' domain='east' step='x'><sample position='y' value='z'/></function>"),
            (Values{0, 0, 0}));
  // laterals inside of the root have functions of their own, and emergence has the same domains
  const auto roots = readRsml(
      rootWith(kThreePoints,
               "<function name='emergence_time' domain='uniform'><sample value='0'/><sample value='8'/></function>"
               "<function name='node_creation_time'><sample value='7'/></function>"));
  ASSERT_TRUE(roots) << roots.error();
  EXPECT_EQ(roots->nodes[1].emergence, 2.0);
  EXPECT_EQ(roots->nodes[2].emergence, 8.0);
}

TEST(RsmlReader, SamplesWithoutAPlaceAreRefused) {
  const auto problem = [](const std::string& function, const char* points = kThreePoints) {
    return readRsml(rootWith(points, function)).error();
  };
  EXPECT_EQ(
      problem("<function name='diameter' domain='polyline'><sample value='4'/><sample value='2'/><sample value='2'/>"
              "<sample value='2'/></function>"),
      "line 2: the function 'diameter' of the root 'a' has 4 samples, and the root has 3 points. Write at most one "
      "sample for each point, or one for the whole root");
  EXPECT_EQ(problem("<function name='emergence_time'><sample value='4'/><sample value='2'/></function>",
                    "<point x='0' y='0'/>"),
            "line 2: the function 'emergence_time' of the root 'a' has 2 samples, and the root has 1 point. Write at "
            "most one sample for each point, or one for the whole root");
  EXPECT_EQ(problem("<function name='diameter' domain='length'><sample value='4'/><sample value='2'/></function>"),
            "line 2: the function 'diameter' of the root 'a' has samples along the length without a position. Write it "
            "at each sample, or a step");
  EXPECT_EQ(problem("<function name='diameter' domain='length' step='0'><sample value='4'/><sample value='2'/>"
                    "</function>"),
            "line 2: the function 'diameter' of the root 'a' has a step that is not above 0. Correct the number");
  EXPECT_EQ(problem("<function name='diameter' domain='time'><sample value='4'/></function>"),
            "line 2: the function 'diameter' of the root 'a' has the unknown domain 'time'. Write polyline, length or "
            "uniform");
  EXPECT_EQ(problem("<function name='diameter' domain='length'><sample position='one' value='4'/></function>"),
            "line 2: expected a number, found 'one'. Write a number there, with a decimal point");
}

TEST(RsmlReader, TheLastPointsMayHaveNoSample) {
  const auto roots = readRsml(rootWith(
      kThreePoints, "<function name='diameter' domain='polyline'><sample value='4'/><sample value='2'/></function>"));
  ASSERT_TRUE(roots) << roots.error();
  EXPECT_EQ(roots->nodes[1].radius, 1.0);
  EXPECT_EQ(roots->nodes[2].radius, 0.0);
  ASSERT_EQ(roots->axes.size(), 1U);
  EXPECT_EQ(roots->axes[0].id, "a");
  EXPECT_EQ(roots->axes[0].firstDiameter, 4.0);
}

TEST(RsmlReader, MorePointsThanAreAllowedEndTheReading) {
  const auto refused = readRsml(rootWith(kThreePoints, ""), 2);
  ASSERT_FALSE(refused);
  EXPECT_TRUE(refused.error().starts_with("line 1: the file has more than 2 points, which is as many as can be drawn"))
      << refused.error();
}

TEST(RsmlReader, ElementsMayHaveThePrefixOfANamespace) {
  std::string text = kRsml;
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at + 1)) {
    if (text[at + 1] != '?') {
      text.insert(at + (text[at + 1] == '/' ? 2 : 1), "r:");
    }
  }
  text.replace(text.find("<r:rsml>"), 8, "<r:rsml xmlns:r='http://example.org/rsml'>");
  const auto roots = readRsml(text);
  ASSERT_TRUE(roots) << roots.error();
  EXPECT_EQ(roots->unit, "cm");
  EXPECT_EQ(stringOf(*roots), stringOf(*readRsml(kRsml)));
}

TEST(RsmlReader, UnitAndResolutionAreThoseOfTheMetadata) {
  const auto roots = readRsml(
      "<rsml><metadata><unit>cm</unit><image><unit>parsec</unit><resolution>0</resolution></image></metadata>"
      "<scene><plant/></scene></rsml>");
  ASSERT_TRUE(roots) << roots.error();
  EXPECT_EQ(roots->unit, "cm");
}

std::string withUnit(const std::string& unit) {
  std::string text = kRsml;
  return text.replace(text.find("<unit>cm</unit>"), 15, unit);
}

TEST(RootSystem, UnitsAreKnownByTheirNames) {
  for (const auto& [written, unit] : {std::pair<std::string, std::string>{"Centimetre", "cm"},
                                      {" mm\n", "mm"},
                                      {"inch", "inch"},
                                      {"px", "pixel"},
                                      {"unknown", ""},
                                      {"", ""}}) {
    const auto roots = readRsml(withUnit("<unit>" + written + "</unit><resolution>300</resolution>"));
    ASSERT_TRUE(roots) << roots.error();
    EXPECT_EQ(roots->unit, unit);
  }
  EXPECT_EQ(readRsml(withUnit("<unit>parsec</unit>")).error(),
            "line 2: the unit 'parsec' is unknown. Write one of m, dm, cm, mm, um, nm, inch, pixel, or unknown");
  EXPECT_EQ(readRsml(withUnit("<unit>pixel</unit><resolution>0</resolution>")).error(),
            "line 2: the resolution is not above 0. Write the number of pixels in a unit, or leave it out");
  // the unit of a property is not that of lengths
  EXPECT_EQ(readRsml(withUnit("<unit>cm</unit><property-definitions><property-definition><label>age</label>"
                              "<unit>day</unit></property-definition></property-definitions>"))
                ->unit,
            "cm");
}

TEST(RootSystem, DaysOfEmergenceAreStepsOfAnAnimation) {
  // a collar, segments that emerge on days 2, 4.5 and 5, and a lateral that has no day
  const auto roots = readRootTable(
      "node\tparent\tx\ty\tz\tradius\torder\temergence\n0\t-1\t0\t0\t0\t0.1\t1\t2\n1\t0\t0\t0\t-1\t0.1\t1\t2\n"
      "2\t1\t0\t0\t-2\t0.1\t1\t4.5\n3\t2\t0\t0\t-2\t0.1\t1\t5\n");
  ASSERT_TRUE(roots) << roots.error();
  const std::string model = modelOf(*roots);
  EXPECT_EQ(model.substr(0, model.find("\nW(t")),
            "Lsystem: 1\nderivation length: 5\nAxiom: [@M(0,0,0)W(2,0,0,-1,0.2,1,0,1)W(5,0,0,-1,0.2,1,0.5,1)V(5,0,1)]");
  // a segment whose day is before that of the segment it grows from waits for it
  const auto early = readRoots(
      "early.tsv",
      "node\tparent\tx\ty\tz\tradius\torder\temergence\n0\t-1\t0\t0\t0\t0.1\t1\t0\n1\t0\t0\t0\t-1\t0.1\t1\t3\n"
      "2\t1\t0\t0\t-2\t0.1\t1\t1\n");
  ASSERT_TRUE(early) << early.error();
  EXPECT_EQ(early->remark, "1 point emerges before the point that it grows from, and is shown with it");
  const std::string waiting = modelOf(*early);
  EXPECT_EQ(waiting.substr(0, waiting.find("\nW(t")),
            "Lsystem: 1\nderivation length: 3\nAxiom: [@M(0,0,0)W(3,0,0,-1,0.2,1,0,1)W(3,0,0,-1,0.2,1,2,1)]");
  // a day below 0 makes the first day the beginning
  const auto earlier = readRootTable(
      "node\tparent\tx\ty\tz\tradius\torder\temergence\n0\t-1\t0\t0\t0\t0.1\t1\t-2\n1\t0\t0\t0\t-1\t0.1\t1\t-2\n"
      "2\t1\t0\t0\t-2\t0.1\t1\t1\n");
  ASSERT_TRUE(earlier) << earlier.error();
  const std::string shifted = modelOf(*earlier);
  EXPECT_EQ(shifted.substr(0, shifted.find("\nW(t")),
            "Lsystem: 1\nderivation length: 3\nAxiom: [@M(0,0,0)@R(0,0,-1)!(0.2)F(1)?E(0,1,0,0,0,0,0,0,0,0)"
            "W(3,0,0,-1,0.2,1,0,1)]");
  // without days, or within one, it stands from the start
  EXPECT_TRUE(modelOf(*readRootTable(kTable)).starts_with("Lsystem: 1\nderivation length: 1\nAxiom: [@M(0,0,0)@R("));
}

TEST(RootSystem, WrongFilesAreRefusedInOneSentence) {
  const auto ofTable = [](const std::string& rows) { return readRootTable("node\tparent\tx\ty\tz\n" + rows).error(); };
  EXPECT_EQ(ofTable("0\t-1\t0\t0\t0\n1\t2\t0\t0\t0\n2\t1\t0\t0\t0\n"),
            "line 4: the node 2 is its own ancestor. Let parents lead to a collar, whose parent is -1");
  EXPECT_EQ(ofTable("0\t-1\t0\t0\t0\n1\t7\t0\t0\t0\n"),
            "line 3: the node 1 has the parent 7, which is not in the file. Add it, or write -1 for a collar");
  EXPECT_EQ(
      ofTable("0\t-1\t0\t0\t0\n100000\t1e30\t0\t0\t0\n"),
      "line 3: the node 100000 has the parent 1.0e+30, which is not in the file. Add it, or write -1 for a collar");
  EXPECT_EQ(ofTable("0\t-1\t0\t0\t0\n0\t-1\t0\t0\t0\n"),
            "line 3: the node 0 is there twice. Give each node a number of its own");
  EXPECT_EQ(ofTable("0\t-1\t0\tnorth\t0\n"),
            "line 2: expected a number in the column 'y', found 'north'. Write a number there, with a decimal point");
  EXPECT_EQ(ofTable("0\t-1\t0\t0\t0\n1\t0\t0\t0\t-1e308\n"),
            "line 3: a coordinate is beyond 1e100. Correct the number");
  EXPECT_EQ(ofTable("0\t-1\t0\n"),
            "line 2: expected a number in the column 'y', found ''. Write a number there, with a decimal point");
  EXPECT_EQ(
      readRootTable("x\ty\n1\t2\n").error(),
      "line 1: the header has no column 'node'. A table of roots has the columns node, parent, x, y, z, separated "
      "by tabs");
  EXPECT_EQ(readRootTable("node\tparent\tx\tx\ty\tz\n0\t-1\t0\t0\t0\t0\n").error(),
            "line 1: the header has the column 'x' twice. Give each column a name of its own");
  for (const std::string order : {"1.5", "0", "1001"}) {
    EXPECT_EQ(readRootTable("node\tparent\tx\ty\tz\torder\n0\t-1\t0\t0\t0\t" + order + "\n").error(),
              "line 2: an order is no whole number from 1 to 1000. Correct the number");
  }
  EXPECT_EQ(readRootTable("node\tparent\tx\ty\tz\n").error(),
            "the file has no nodes. Give a table with a header and a row for each node");
  EXPECT_EQ(readRsml("<rsml><scene>").error(),
            "line 1: the file is no XML: no element found. Give a file in the Root System Markup Language");
  EXPECT_EQ(readRsml("<rsml></rsml>").error(),
            "line 1: the file has no 'scene' of plants. Give a file in the Root System Markup Language");
  EXPECT_EQ(readRsml(rootWith("<point x='1' z='2'/>")).error(),
            "line 1: a point has no 'y'. Write its coordinates as attributes x, y and z");
  EXPECT_EQ(readRsml(rootWith("\n<point x='1' y='up'/>")).error(),
            "line 2: expected a number, found 'up'. Write a number there, with a decimal point");
  EXPECT_EQ(readRsml("<!DOCTYPE a [<!ENTITY b \"cccc\">]>\n<rsml/>").error(),
            "line 1: the file declares an entity, which root files do not need. Remove it");
  EXPECT_EQ(readRsml(rootWith("<point x='1' y='2e200'/>")).error(),
            "line 1: the coordinate 2e200 is beyond 1e100. Correct the number");
  EXPECT_EQ(readRsml("<rsml><metadata>\n<unit>parsec</unit></metadata><scene/></rsml>").error(),
            "line 2: the unit 'parsec' is unknown. Write one of m, dm, cm, mm, um, nm, inch, pixel, or unknown");
  // a property has a unit of its own
  const std::string property = "<property-definitions><property-definition><unit>day</unit></property-definition>";
  EXPECT_EQ(readRsml("<rsml><metadata><unit> cm </unit>" + property +
                     "</property-definitions></metadata><scene><root><point x='1' y='2'/></root></scene></rsml>")
                ->unit,
            "cm");
  std::string deep = "<rsml><scene>";
  for (int i = 0; i < 1001; ++i) {
    deep += "<root>";
  }
  EXPECT_EQ(readRsml(deep).error(),
            "line 1: roots stand inside each other more than 1000 deep. Give a file with fewer orders");
}

}  // namespace
}  // namespace espalier::roots::root_system_test
