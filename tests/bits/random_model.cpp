#include "tests/bits/random_model.h"

#include <array>
#include <initializer_list>
#include <random>
#include <string_view>

namespace espalier::test {
namespace {

// The parts of a text, made from the left to the right: the operands of a sum of texts have no order, so that two
// compilers would draw other numbers for them.
std::string joined(std::initializer_list<std::string> parts) {
  std::string text;
  for (const std::string& part : parts) {
    text += part;
  }
  return text;
}

constexpr std::array<std::string_view, 22> kProcesses{
    "arvo",      "attractors", "chiba",   "clover", "colonization", "crowding", "density",      "density3d",
    "ecosystem", "emission",   "gravity", "height", "honda",        "light",    "light-voxels", "meadow",
    "obstacles", "ornament",   "shadow",  "soil",   "takenaka",     "wind"};

class ModelMaker {
 public:
  explicit ModelMaker(std::uint32_t number) : number_(number), random_(number) {}

  RandomModel model() {
    const bool isBig = number_ % 100 == 99;
    RandomModel made;
    made.steps = isBig ? 16 : 5 + below(5);
    asks_ = !isBig && chance(60);
    if (asks_) {
      made.process = kProcesses[below(kProcesses.size())];
    }
    made.view = view();
    made.text = "Lsystem: 1\nderivation length: " + std::to_string(made.steps) + "\n";
    made.text += chance(50) ? "Seed: " + std::to_string(1 + below(60000)) + "\n" : "";
    made.text += chance(20) ? "ignore: +-&/F\n" : "";
    made.text += "Start: {g = " + number() + ";}\n";
    made.text += isBig ? "Axiom: S(13)\nS(n) : n > 0 --> S(n-1)[+(11)S(n-1)]\nS(n) : n <= 0 --> A(g,n)B(n)\n"
                       : joined({"Axiom: -(", number(), ")A(1,", number(), ")B(", number(), ")C\n"});
    const std::uint32_t count = 3 + below(5);
    for (std::uint32_t i = 0; i < count; ++i) {
      made.text += production(isBig);
    }
    made.text += chance(30) ? "decomposition\nmaximum depth: 2\nD(x) --> F(" + expression("x", 1) + ")\n" : "";
    made.text += chance(30) ? "homomorphism\nB(x) --> [+(x*7)F(0.3)]\n" : "";
    made.text += "endlsystem\n";
    return made;
  }

 private:
  std::uint32_t below(std::size_t count) { return static_cast<std::uint32_t>(random_() % count); }
  bool chance(std::uint32_t percent) { return below(100) < percent; }

  std::string number() { return joined({std::to_string(below(9)), ".", std::to_string(100 + below(900))}); }

  /// An expression whose values are finite for finite values of the names.
  std::string expression(std::string_view names, int depth) {
    if (depth == 0 || chance(15)) {
      return chance(70) ? std::string(1, names[below(names.size())]) : number();
    }
    const std::string a = expression(names, depth - 1);
    const std::string b = expression(names, depth - 1);
    switch (below(20)) {
      case 0:
        return "sin(" + a + "*57)";
      case 1:
        return "cos(" + a + "*31+" + b + ")";
      case 2:
        return "tan(40*sin(" + a + "))";
      case 3:
        return "asin(cos(" + a + "*13))";
      case 4:
        return "acos(sin(" + a + "+" + b + "))";
      case 5:
        return "atan(" + a + ")";
      case 6:
        return "atan2(" + a + "," + b + ")";
      case 7:
        return "exp(0-fabs(" + a + ")/9)";
      case 8:
        return "log(fabs(" + a + ")+0.1)";
      case 9:
        return "sqrt(fabs(" + a + "))";
      case 10:
        return "(fabs(" + a + ")+0.3)^(0.3*sin(" + b + "))";
      case 11:
        return "hypot(" + a + "," + b + ")";
      case 12:
        return "mod(" + a + "," + number() + ")";
      case 13:
        return "clamp(" + a + "," + "0-9," + number() + ")";
      case 14:
        return "ran(" + a + ")";
      case 15:
        return "nran(" + a + ",0.4)";
      case 16:
        return "bran(1.5,2.5)*" + a;
      case 17:
        return "(" + a + "+" + b + ")*0.47";
      case 18:
        return "(" + a + "-" + b + ")";
      default:
        return "(" + a + "/(fabs(" + b + ")+0.7))";
    }
  }

  std::string condition(std::string_view names) {
    return joined({expression(names, 1), chance(50) ? " > " : " < ", expression(names, 1)});
  }

  std::string production(bool isBig) {
    // predecessor
    std::string names = "g";
    std::string text;
    if (chance(25)) {
      text += "A(v,w) < ";
      names += "vw";
    }
    const std::uint32_t kind = below(4);
    text += kind == 0 ? "A(x,y)" : kind == 1 ? "B(x)" : kind == 2 ? "C" : "D(x)";
    names += kind == 0 ? "xy" : kind == 2 ? "" : "x";
    if (chance(20)) {
      text += " > B(u)";
      names += "u";
    }
    text += chance(50) ? " : " + condition(names) : "";
    text += " --> ";

    // successor
    text += chance(70) ? joined({std::string(1, "+-&^/\\"[below(6)]), "(", expression(names, 2), ")"}) : "";
    text += "F(" + expression(names, 1) + ")";
    text += chance(30) && !isBig ? joined({"[+(", expression(names, 1), ")B(", expression(names, 2), ")]"}) : "";
    switch (below(4)) {
      case 0:
        text += joined({"A(", expression(names, 3), ",", expression(names, 2), ")"});
        break;
      case 1:
        text += "B(" + expression(names, 3) + ")";
        break;
      case 2:
        text += "D(" + expression(names, 2) + ")";
        break;
      default:
        text += "C";
        break;
    }
    if (chance(25) && !isBig) {
      text += "?P(" + expression(names, 1) + ",0,0)";
    }
    if (asks_ && chance(60)) {
      const std::uint32_t arity = 1 + below(6);
      text += "?E(0.6";
      for (std::uint32_t i = 1; i < arity; ++i) {
        text += ",fabs(" + expression(names, 1) + ")";
      }
      text += ")";
    }
    return text + (chance(30) ? " : " + number() : "") + "\n";
  }

  std::string view() {
    std::string text = "angle increment: " + number() + "\n";
    text += chance(30) ? "tropism: T: 0.1,-1,0.2 A: 30 I: 1 E: 0.2 S: 0.05\n" : "";
    text += chance(15) ? "torque: T: 0.3,-1,0 I: 1 E: 0.2 S: 0.05\n" : "";
    return text;
  }

  std::uint32_t number_;
  std::mt19937 random_;  // its words are the same everywhere; the standard's distributions are not
  bool asks_ = false;
};

}  // namespace

RandomModel randomModel(std::uint32_t number) {
  return ModelMaker(number).model();
}

}  // namespace espalier::test
