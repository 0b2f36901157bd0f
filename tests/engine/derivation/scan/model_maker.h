#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/derived_model.h"

namespace espalier::test {

/// Makes models of productions: letters A to E with up to two parameters, G with seven, brackets, contexts, conditions,
/// weights, draws in all of these, functions, divisions by what may be 0, blocks with local and shared variables,
/// loops, arrays, decomposition, cuts.
class ModelMaker {
 public:
  explicit ModelMaker(unsigned seed) : random_(seed) {}

  /// `settings`: lines behind the derivation length.
  std::string model(const std::string& settings = "") {
    std::string text = "Lsystem: 1\nderivation length: 50\n" + settings;
    letters_ = chance(20) ? "AABBCDE+G" : "AABBCDE+";
    isStochastic_ = chance(40);
    hasContexts_ = chance(60);
    hasVariables_ = chance(50);
    hasBlocks_ = chance(50);
    cutPercent_ = chance(15) ? 12 : 2;
    const bool hasDecomposition = chance(25);
    if (isStochastic_) {
      text += "Seed: " + std::to_string(number(1, 60000)) + "\n";
    }
    if (hasContexts_ && chance(30)) {
      text += chance(50) ? "ignore: +E\n" : "consider: ABC[]\n";
    } else if (hasContexts_ && chance(20)) {
      text += "ignore: []+\n";
    }
    if (hasVariables_) {
      text += "define: {array gt[3]={0.5,2,1}; array gm[2][2]={1,0.25,3,0.75};}\n";
      text += "Start: {ga=1; gb=0.5;}\nStartEach: {ga=ga+0.5; if (ga>3) {ga=0; gm[1][0]=Q;} gb=gb*0.9;}\n";
    }
    // batches begin at a certain length
    text += "Axiom: " + modules(chance(50) ? number(8, 16) : number(60, 400), "", 2) + "\n";
    const int count = number(2, 9);
    for (int i = 0; i < count; ++i) {
      text += production();
    }
    if (hasDecomposition) {
      text += "decomposition no warnings\nmaximum depth: " + std::to_string(number(1, 4)) + "\n";
      for (int i = number(1, 3); i > 0; --i) {
        text += decomposition();
      }
    }
    return text + "endlsystem\n";
  }

 private:
  int number(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }
  bool chance(int percent) { return number(1, 100) <= percent; }
  std::string oneOf(const std::string& set) {
    return set.substr(static_cast<std::size_t>(number(0, static_cast<int>(set.size()) - 1)), 1);
  }

  /// A letter always has the same choice of arities: A and B none or one, C one, D none or two, G seven, others none.
  int arityOf(char letter) {
    switch (letter) {
      case 'A':
      case 'B':
        return chance(70) ? 1 : 0;
      case 'C':
        return 1;
      case 'D':
        return chance(50) ? 2 : 0;
      case 'G':
        return 7;
      default:
        return 0;
    }
  }

  std::string formal(std::string& names) {
    static const std::string kLetters = "abcdefghijklmnoprstuvwxyzHIJKLMNOPRSTXY";
    const std::string letter = oneOf(letters_);
    const int arity = arityOf(letter[0]);
    std::string text = letter;
    for (int i = 0; i < arity; ++i) {
      const std::string name(1, kLetters.at(names.size()));
      text += (i == 0 ? "(" : ",") + name;
      names += name;
    }
    return arity > 0 ? text + ")" : text;
  }

  std::string expression(const std::string& names) {
    static const std::string kConstants[] = {"0.5", "2", "1", "0.25", "3"};
    const std::string constant = kConstants[number(0, 4)];
    if (names.empty() || chance(15)) {
      return constant;
    }
    // the last names are those of the right context
    const std::string x = chance(50) ? oneOf(names) : names.substr(names.size() - 1);
    if (hasVariables_ && chance(25)) {
      switch (number(0, 4)) {
        case 0:
          return x + "*gb";
        case 1:
          return "gt[" + x + "]";
        case 2:
          return "(" + x + ">0.5 ? gt[Q%3] : gm[" + x + "][1])";
        case 3:
          return "gm[1][" + oneOf(names) + "]*0.5+gb";
        default:
          return "ga";
      }
    }
    if (hasBlocks_ && chance(10)) {
      return "(" + x + "*" + x + "+1)^0.5*0.5";
    }
    switch (number(0, 13)) {
      case 8:
        return "(" + x + ">1 ? " + constant + " : " + oneOf(names) + ")";
      case 9:
        return "(" + x + "!=0 && 1/" + x + ">0.5 ? " + oneOf(names) + "/2 : -" + x + ")";
      case 10:
        return "max(" + x + "," + oneOf(names) + ")*0.5";
      case 11:
        return "sin(" + x + ")+floor(" + oneOf(names) + ")*0.1";
      case 12:
        return "1/(" + x + "*" + x + "-1)*0.001";
      case 13:
        return oneOf(names) + "%3+Z/50";
      case 0:
        return x;
      case 1:
        return x + "+" + constant;
      case 2:
        return x + "*0.5";
      case 3:
        return constant + "-" + x;
      case 4:
        return x + "/3";
      case 5:
        return "(" + x + "+" + oneOf(names) + ")/2";
      case 6:
        return x + "-" + oneOf(names);
      default:
        return x + "*0.9+Q";
    }
  }

  std::string condition(const std::string& names) {
    if (names.empty()) {
      return chance(50) ? "Q<3" : "*";
    }
    static const std::string kOperators[] = {"<", ">", "<=", ">=", "!=", "=="};
    std::string text = oneOf(names) + kOperators[number(0, 5)] + expression(names);
    if (chance(30)) {
      text += (chance(50) ? " && " : " || ") + oneOf(names) + (chance(70) ? "<2" : "/" + oneOf(names) + "<2");
    }
    if (mayDraw_ && chance(8)) {
      text += chance(50) ? " && ran(1)<0.7" : " || nran(0," + oneOf(names) + ")>0.5";
    }
    return chance(10) ? "!(" + text + ")" : text;
  }

  /// A block that assigns the local variables U, V and W, and what a model may do beside it.
  std::string block(std::string& names, bool isBehind) {
    const std::string local = isBehind ? "V" : "U";
    std::string text = "{";
    switch (names.empty() ? 0 : number(0, 6)) {
      case 0:
        text += local + "=" + value(names) + ";";
        break;
      case 1:
        text += "if (" + condition(names) + ") {" + local + "=" + expression(names) + ";} else {" + local + "=" +
                expression(names) + ";}";
        break;
      case 2:
        text +=
            local + "=" + expression(names) + "; if (" + condition(names) + ") {" + local + "=" + local + "*0.5; W=Q;}";
        break;
      case 3:
        text += local + "=0; W=0; while (W<" + oneOf(names) + " && W<4) {" + local + "=" + local + "*0.5+" +
                oneOf(names) + "; W=W+1;}";
        break;
      case 4:
        // the value of the module before
        text += chance(50) ? local + "=" + local + "*0.5+1;" : "if (" + condition(names) + ") {" + local + "=1;}";
        break;
      case 5:
        text += "W=" + expression(names) + "; " + local + "=(W*W+1)^0.5*0.25;";
        break;
      default:
        text += local + "=" + expression(names) + "; " + local + "=" + local + "/2+1;";
    }
    if (hasVariables_ && chance(8)) {
      text += sharedAssignment(names);
    }
    // formal parameters, or local variables
    if (!names.empty() && chance(25)) {
      const std::string x = oneOf(names);
      text += chance(50) ? " " + x + "=" + x + "*0.5+1;"
                         : " if (" + condition(names) + ") {" + x + "=" + expression(names) + ";}";
    }
    names += local;
    return text + "}";
  }

  /// An assignment to what all modules share: counters, and tables by what a module brings.
  std::string sharedAssignment(const std::string& names) {
    const std::string x = names.empty() ? "Q" : oneOf(names);
    switch (number(0, 5)) {
      case 0:
        return " gt[1]=gt[1]*0.5+1;";
      case 1:
        return " gt[" + x + "]=gt[" + x + "]*0.5+1;";
      case 2:
        return " gm[" + x + "/2][" + x + "-floor(" + x + ")]=gm[1][" + x + "]*0.5+ga;";
      case 3:
        return " if (ga>" + x + ") {gb=gb*0.5+0.5;}";
      default:
        return " ga=ga+0.25;";
    }
  }

  /// A parameter of a successor or of an assignment, which may draw.
  std::string value(const std::string& names) {
    const std::string text = expression(names);
    // the axiom's draws are of another kind
    switch (mayDraw_ ? number(0, 9) : 9) {
      case 0:
        return text + "+ran(2)*ran(1)";
      case 1:
        return "ran(" + text + ")";
      case 2:
        return chance(50) && !names.empty() ? oneOf(names) + ">1 ? ran(1) : nran(" + text + ",0.5)" : text;
      case 3:
        return "nran(" + text + ",0.1)*ran(1)";
      default:
        return text;
    }
  }

  std::string modules(int count, const std::string& names, int depth) {
    std::string text;
    for (int i = 0; i < count; ++i) {
      if (depth > 0 && chance(15)) {
        text += "[" + modules(number(1, 3), names, depth - 1) + "]";
        continue;
      }
      if (chance(cutPercent_)) {
        text += "%";
        continue;
      }
      const std::string letter = oneOf(letters_ + "F");
      text += letter;
      const int arity = arityOf(letter[0]);
      for (int k = 0; k < arity; ++k) {
        text += (k == 0 ? "(" : ",") + value(names);
      }
      text += arity > 0 ? ")" : "";
    }
    return text;
  }

  std::string rightContext(std::string& names) {
    switch (number(0, 5)) {
      case 0:
        return "[" + formal(names);
      case 1:
        return "[" + formal(names) + "=]" + formal(names);
      case 2:
        return formal(names) + "]";
      case 3:
        return formal(names) + formal(names);
      default:
        return formal(names);
    }
  }

  /// The part before the condition: contexts and predecessor. Several productions may have the same.
  std::string head(std::string& names) {
    if (!lastHead_.empty() && chance(30)) {
      names = lastNames_;
      return lastHead_;
    }
    std::string left;
    if (hasContexts_ && chance(40)) {
      left = formal(names) + (chance(25) ? formal(names) : "") + " < ";
    }
    std::string predecessor = formal(names);
    if (chance(15)) {
      predecessor += formal(names);
    }
    std::string right;
    if (hasContexts_ && chance(40)) {
      right = " > " + rightContext(names);
    }
    lastHead_ = left + predecessor + right;
    lastNames_ = names;
    return lastHead_;
  }

  std::string production() {
    std::string names;
    mayDraw_ = true;
    std::string text = head(names);
    if (hasBlocks_ && chance(50)) {
      const bool hasBefore = chance(60);
      text += " : " + (hasBefore ? block(names, false) + " " : std::string()) + (chance(70) ? condition(names) : "1");
      text += chance(60) || !hasBefore ? " " + block(names, true) : std::string();
    } else if (chance(40)) {
      text += " : " + condition(names);
    }
    // branches and what follows them are what contexts look over
    if (chance(5)) {
      text += " --> *";
    } else {
      text += " --> " + modules(number(1, 4), names, 1);
      text += chance(60) ? "[" + modules(2, names, 0) + "]" + modules(1, names, 0) : std::string();
    }
    if (isStochastic_ && chance(70)) {
      text += " : " + (chance(20) && !names.empty() ? oneOf(names) + "*" + oneOf(names) + (chance(20) ? "*ran(1)" : "")
                                                    : std::to_string(number(0, 4)));
    }
    return text + "\n";
  }

  std::string decomposition() {
    std::string names;
    mayDraw_ = false;
    std::string text = formal(names);
    text += hasBlocks_ && chance(25) ? " : " + block(names, false) + " " + condition(names) : " : " + condition(names);
    text += hasBlocks_ && chance(25) ? " " + block(names, true) : "";
    return text + " --> " + modules(number(1, 2), names, 0) + "\n";
  }

  std::mt19937 random_;
  std::string letters_;
  std::string lastHead_;
  std::string lastNames_;
  int cutPercent_ = 2;
  bool hasVariables_ = false;
  bool hasBlocks_ = false;
  bool isStochastic_ = false;
  bool mayDraw_ = false;
  bool hasContexts_ = false;
};

}  // namespace espalier::test
