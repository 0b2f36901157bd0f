#include "engine/language/dialects/lpy_expression.h"

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "engine/core/diagnostic.h"
#include "engine/core/elementary.h"
#include "engine/core/number_text.h"

namespace espalier::language {
namespace {

constexpr std::string_view kDegrees = "57.295779513082323";  // of a radian

bool isNameStart(char c) {
  return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_';
}
bool isNamePart(char c) {
  return isNameStart(c) || std::isdigit(static_cast<unsigned char>(c)) != 0;
}

double pythonModulo(double x, double y) {
  const double rest = std::fmod(x, y);
  return rest != 0.0 && (rest < 0.0) != (y < 0.0) ? rest + y : rest;
}

/// A recursive descent through the grammar of Python's expressions, lowest precedence first.
class ExpressionReader {
 public:
  ExpressionReader(const TextPiece& text, const LpyScope& scope, LpyDraws& draws, DialectReport& report)
      : text_(text.text), offset_(text.offset), scope_(scope), draws_(draws), report_(report) {}

  std::optional<LpyValue> read() {
    LpyValue value = conditional();
    if (!hasFailed_ && next() != '\0') {
      fail(at_, "expected an operator, found '" + std::string(text_.substr(at_, 20)) + "'");
    }
    return hasFailed_ ? std::nullopt : std::optional(std::move(value));
  }

 private:
  // ---- characters and words

  char next() {
    while (at_ < text_.size() && std::string_view(" \t\r\n\\").find(text_[at_]) != std::string_view::npos) {
      ++at_;
    }
    return at_ < text_.size() ? text_[at_] : '\0';
  }
  bool takes(std::string_view sign) {
    next();
    if (!text_.substr(at_).starts_with(sign)) {
      return false;
    }
    const bool isWord = isNameStart(sign.front());
    if (isWord && at_ + sign.size() < text_.size() && isNamePart(text_[at_ + sign.size()])) {
      return false;
    }
    at_ += sign.size();
    return true;
  }
  bool looksAt(std::string_view sign) {
    next();
    return text_.substr(at_).starts_with(sign);
  }
  LpyValue fail(std::size_t at, std::string message, std::string hint = std::string(kNeedsPython)) {
    if (!hasFailed_) {
      report_.error(offset_ + std::min(at, text_.size()), 1, std::move(message), std::move(hint));
    }
    hasFailed_ = true;
    at_ = text_.size();
    return lpyConstant(0.0);
  }

  // ---- values

  static LpyValue made(std::string text, std::optional<double> number) {
    if (number && std::isfinite(*number)) {
      return lpyConstant(*number);
    }
    return {"(" + std::move(text) + ")", std::nullopt};
  }
  template <typename Operation>
  static LpyValue binary(const LpyValue& a, std::string_view sign, const LpyValue& b, Operation operation) {
    const bool isConstant = a.number && b.number;
    return made(a.text + std::string(sign) + b.text,
                isConstant ? std::optional<double>(operation(*a.number, *b.number)) : std::nullopt);
  }

  // ---- precedence

  LpyValue conditional() {
    LpyValue value = disjunction();
    if (!takes("if")) {
      return value;
    }
    const LpyValue condition = disjunction();
    if (!takes("else")) {
      return fail(at_, "expected 'else' while reading 'x if condition else y'", "write both values");
    }
    const LpyValue otherwise = conditional();
    if (condition.number) {
      return *condition.number != 0.0 ? value : otherwise;
    }
    return {"(" + condition.text + " ? " + value.text + " : " + otherwise.text + ")", std::nullopt};
  }

  LpyValue disjunction() {
    LpyValue value = conjunction();
    while (takes("or")) {
      // Python's value is one of the operands
      const LpyValue other = conjunction();
      value = value.number ? (*value.number != 0.0 ? value : other)
                           : LpyValue{"(" + value.text + " || " + other.text + ")", std::nullopt};
    }
    return value;
  }

  LpyValue conjunction() {
    LpyValue value = negation();
    while (takes("and")) {
      const LpyValue other = negation();
      value = value.number ? (*value.number != 0.0 ? other : value)
                           : LpyValue{"(" + value.text + " && " + other.text + ")", std::nullopt};
    }
    return value;
  }

  LpyValue negation() {
    if (takes("not")) {
      const LpyValue value = negation();
      return made("!" + value.text, value.number ? std::optional(*value.number == 0.0 ? 1.0 : 0.0) : std::nullopt);
    }
    return comparison();
  }

  LpyValue comparison() {
    LpyValue left = sum();
    std::optional<LpyValue> result;
    for (bool isFound = true; isFound && !hasFailed_;) {
      isFound = false;
      for (const std::string_view sign : {"==", "!=", "<=", ">=", "<", ">"}) {
        if (!looksAt(sign)) {
          continue;
        }
        takes(sign);
        LpyValue right = sum();
        const LpyValue part = binary(left, sign, right, [&](double a, double b) {
          const bool isTrue = sign == "=="   ? a == b
                              : sign == "!=" ? a != b
                              : sign == "<=" ? a <= b
                              : sign == ">=" ? a >= b
                              : sign == "<"  ? a < b
                                             : a > b;
          return isTrue ? 1.0 : 0.0;
        });
        // `0 < x < 5` is two comparisons
        result = !result ? part
                 : result->number && part.number
                     ? lpyConstant(*result->number * *part.number)
                     : LpyValue{"(" + result->text + " && " + part.text + ")", std::nullopt};
        left = std::move(right);
        isFound = true;
        break;
      }
    }
    if (takes("in") || takes("is")) {
      return fail(at_, "'in' and 'is' need Python");
    }
    return result ? std::move(*result) : left;
  }

  LpyValue sum() {
    LpyValue value = product();
    for (;;) {
      if (takes("+")) {
        value = binary(value, "+", product(), [](double a, double b) { return a + b; });
      } else if (takes("-")) {
        value = binary(value, "-", product(), [](double a, double b) { return a - b; });
      } else {
        return value;
      }
    }
  }

  LpyValue product() {
    LpyValue value = unary();
    while (!hasFailed_) {
      if (looksAt("**")) {
        return fail(at_, "expected an operand before '**'");
      }
      if (takes("//")) {
        value = floorQuotient(value, unary());
      } else if (takes("*")) {
        value = binary(value, "*", unary(), [](double a, double b) { return a * b; });
      } else if (takes("/")) {
        value = binary(value, "/", unary(), [](double a, double b) { return a / b; });
      } else if (takes("%")) {
        const LpyValue divisor = unary();
        value = value.number && divisor.number && *divisor.number != 0.0
                    ? lpyConstant(pythonModulo(*value.number, *divisor.number))
                    : LpyValue{"mod(" + value.text + "," + divisor.text + ")", std::nullopt};
      } else {
        break;
      }
    }
    return value;
  }

  // of the dividend without its remainder: the quotient alone may be rounded up to a whole number
  LpyValue floorQuotient(const LpyValue& value, const LpyValue& divisor) {
    if (value.number && divisor.number && *divisor.number != 0.0) {
      return lpyConstant(std::round((*value.number - pythonModulo(*value.number, *divisor.number)) / *divisor.number));
    }
    // a whole divisor needs no remainder, and a random number must not be drawn twice
    const bool isWhole = divisor.number && *divisor.number == std::floor(*divisor.number);
    const bool isDrawn = (value.text + divisor.text).find("ran(") != std::string::npos;
    if (isWhole || isDrawn) {
      return LpyValue{"floor(" + value.text + "/" + divisor.text + ")", std::nullopt};
    }
    const std::string remainder = "mod(" + value.text + "," + divisor.text + ")";
    return LpyValue{"floor((" + value.text + "-" + remainder + ")/" + divisor.text + "+0.5)", std::nullopt};
  }

  LpyValue unary() {
    if (takes("-")) {
      const LpyValue value = unary();
      return value.number ? lpyConstant(-*value.number) : LpyValue{"(-" + value.text + ")", std::nullopt};
    }
    if (takes("+")) {
      return unary();
    }
    LpyValue base = primary();
    if (takes("**")) {
      return binary(base, "^", unary(), [](double a, double b) { return core::pow(a, b); });
    }
    return base;
  }

  LpyValue primary() {
    const char c = next();
    const std::size_t begin = at_;
    LpyValue value;
    if (c == '(') {
      ++at_;
      value = conditional();
      if (looksAt(",")) {
        return fail(at_, "a tuple needs Python");
      }
      if (!hasFailed_ && !takes(")")) {
        return fail(begin, "the parenthesis '(' is never closed", "close it on the same line");
      }
    } else if (std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '.') {
      value = number();
    } else if (isNameStart(c)) {
      value = nameOrCall();
    } else if (c == '"' || c == '\'') {
      return fail(at_, "a string needs Python");
    } else if (c == '[' || c == '{') {
      return fail(at_, c == '[' ? "a list needs Python" : "a dictionary needs Python");
    } else {
      return fail(at_, c == '\0' ? "expected a value, found the end of the expression"
                                 : "expected a value, found '" + std::string(1, c) + "'");
    }
    if (looksAt("[")) {
      return fail(at_, "an element of a list needs Python");
    }
    if (looksAt(".")) {
      return fail(at_, "a member of an object needs Python");
    }
    return value;
  }

  LpyValue number() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && (isNamePart(text_[at_]) || text_[at_] == '.' ||
                                  ((text_[at_] == '-' || text_[at_] == '+') && at_ > begin &&
                                   (text_[at_ - 1] == 'e' || text_[at_ - 1] == 'E')))) {
      ++at_;
    }
    std::string digits(text_.substr(begin, at_ - begin));
    std::erase(digits, '_');
    if (digits.ends_with('.')) {
      digits += '0';
    }
    const auto value = core::parseNumber(digits);
    return value ? lpyConstant(*value) : fail(begin, "expected a number, found '" + digits.substr(0, 40) + "'");
  }

  std::string name() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && isNamePart(text_[at_])) {
      ++at_;
    }
    return std::string(text_.substr(begin, at_ - begin));
  }

  LpyValue nameOrCall() {
    const std::size_t begin = at_;
    std::string word = name();
    // `math.sin`, `random.random`
    if ((word == "math" || word == "random") && at_ < text_.size() && text_[at_] == '.') {
      ++at_;
      word = name();
    }
    if (looksAt("(")) {
      return call(word, begin);
    }
    const auto known = scope_.values.find(word);
    if (known != scope_.values.end()) {
      return known->second;
    }
    if (scope_.variables.contains(word)) {
      return {lpyName(word), std::nullopt};
    }
    if (word == "True" || word == "False") {
      return lpyConstant(word == "True" ? 1.0 : 0.0);
    }
    if (word == "pi" || word == "e") {
      return lpyConstant(word == "pi" ? std::numbers::pi : std::numbers::e);
    }
    if (word == "lambda" || word == "None") {
      return fail(begin, "'" + word + "' needs Python");
    }
    std::vector<std::string_view> names;
    for (const auto& [other, value] : scope_.values) {
      names.push_back(other);
    }
    const std::string_view near = core::nearestName(word, names);
    return fail(begin, "unknown name '" + word + "'",
                near.empty() ? "its value is no number that the file assigns: " + std::string(kNeedsPython)
                             : "did you mean '" + std::string(near) + "'?");
  }

  LpyValue call(const std::string& function, std::size_t begin) {
    takes("(");
    std::vector<LpyValue> arguments;
    while (!hasFailed_ && !looksAt(")")) {
      arguments.push_back(conditional());
      if (looksAt("=") && !looksAt("==")) {
        return fail(at_, "an argument with a name needs Python", "give the arguments in their order");
      }
      if (!takes(",")) {
        break;
      }
    }
    if (!hasFailed_ && !takes(")")) {
      return fail(begin, "the parenthesis '(' of " + function + " is never closed", "close it on the same line");
    }
    if (hasFailed_) {
      return lpyConstant(0.0);
    }
    if (auto value = draw(function, arguments)) {
      return *value;
    }
    if (auto value = mathematics(function, arguments)) {
      return *value;
    }
    const auto own = scope_.functions.find(function);
    return fail(begin, own != scope_.functions.end()
                           ? "the model's own function '" + function + "' needs Python"
                           : "the function '" + function + "' with " + std::to_string(arguments.size()) +
                                 (arguments.size() == 1 ? " argument" : " arguments") + " needs Python");
  }

  std::optional<LpyValue> draw(const std::string& function, const std::vector<LpyValue>& a) {
    std::string text;
    if (function == "random" && a.empty()) {
      text = "ran(1)";
    } else if (function == "uniform" && a.size() == 2) {
      text = "(" + a[0].text + "+ran(" + a[1].text + "-" + a[0].text + "))";
    } else if (function == "randint" && a.size() == 2) {
      text = "floor(" + a[0].text + "+ran(" + a[1].text + "-" + a[0].text + "+1))";
    } else if ((function == "gauss" || function == "normalvariate") && a.size() == 2) {
      text = "nran(" + a[0].text + "," + a[1].text + ")";
    } else {
      return std::nullopt;
    }
    if (draws_.areNamed) {
      const std::string name = "random" + std::to_string(++draws_.count);
      draws_.statements.push_back(name + " = " + text + ";");
      text = name;
    }
    return LpyValue{text, std::nullopt};
  }

  /// A function of one number: Python's name, cpfg's text around the argument, and the function.
  struct OneArgument {
    std::string_view name;
    std::string_view before;
    std::string_view behind;
    double (*function)(double);
  };

  std::optional<LpyValue> mathematics(const std::string& function, const std::vector<LpyValue>& a) {
    static const std::array kFunctions = {
        OneArgument{"sin", "sin(57.295779513082323*", ")", [](double x) { return core::sin(x); }},
        OneArgument{"cos", "cos(57.295779513082323*", ")", [](double x) { return core::cos(x); }},
        OneArgument{"tan", "tan(57.295779513082323*", ")", [](double x) { return core::tan(x); }},
        OneArgument{"asin", "(asin(", ")/57.295779513082323)", [](double x) { return core::asin(x); }},
        OneArgument{"acos", "(acos(", ")/57.295779513082323)", [](double x) { return core::acos(x); }},
        OneArgument{"atan", "(atan(", ")/57.295779513082323)", [](double x) { return core::atan(x); }},
        OneArgument{"exp", "exp(", ")", [](double x) { return core::exp(x); }},
        OneArgument{"log", "log(", ")", [](double x) { return core::log(x); }},
        OneArgument{"log10", "(log(", ")/log(10))", [](double x) { return core::log10(x); }},
        OneArgument{"sqrt", "sqrt(", ")", [](double x) { return std::sqrt(x); }},
        OneArgument{"abs", "fabs(", ")", [](double x) { return std::abs(x); }},
        OneArgument{"fabs", "fabs(", ")", [](double x) { return std::abs(x); }},
        OneArgument{"floor", "floor(", ")", [](double x) { return std::floor(x); }},
        OneArgument{"ceil", "ceil(", ")", [](double x) { return std::ceil(x); }},
        OneArgument{"radians", "(", "/57.295779513082323)", [](double x) { return x * std::numbers::pi / 180.0; }},
        OneArgument{"degrees", "(57.295779513082323*", ")", [](double x) { return x * 180.0 / std::numbers::pi; }},
        OneArgument{"float", "(", ")", [](double x) { return x; }},
    };
    const auto valueOf = [&](std::string text, auto operation) {
      const bool isConstant = a.size() == 1 ? a[0].number.has_value() : a[0].number && a[1].number;
      return made(std::move(text),
                  isConstant ? std::optional<double>(operation(*a[0].number, a.size() > 1 ? *a[1].number : 0.0))
                             : std::nullopt);
    };
    if (a.size() == 1) {
      for (const OneArgument& one : kFunctions) {
        if (one.name == function) {
          return valueOf(std::string(one.before) + a[0].text + std::string(one.behind),
                         [&](double x, double) { return one.function(x); });
        }
      }
      const std::string& x = a[0].text;
      if (function == "int") {
        return valueOf(x + " < 0 ? ceil(" + x + ") : floor(" + x + ")", [](double v, double) { return std::trunc(v); });
      }
      if (function == "round") {
        // halves go to the even number
        return valueOf("mod(" + x + ",2) == 0.5 ? floor(" + x + ") : floor(" + x + "+0.5)", [](double v, double) {
          const double low = std::floor(v);
          return v - low == 0.5 ? (pythonModulo(low, 2.0) == 0.0 ? low : low + 1.0) : std::floor(v + 0.5);
        });
      }
      return std::nullopt;
    }
    if ((function == "min" || function == "max") && a.size() >= 2) {
      LpyValue value = a[0];
      for (std::size_t i = 1; i < a.size(); ++i) {
        const bool isConstant = value.number && a[i].number;
        value = isConstant ? lpyConstant(function == "min" ? std::min(*value.number, *a[i].number)
                                                           : std::max(*value.number, *a[i].number))
                           : LpyValue{function + "(" + value.text + "," + a[i].text + ")", std::nullopt};
      }
      return value;
    }
    if (a.size() != 2) {
      return std::nullopt;
    }
    const std::string both = a[0].text + "," + a[1].text;
    if (function == "pow") {
      return binary(a[0], "^", a[1], [](double x, double y) { return core::pow(x, y); });
    }
    if (function == "atan2") {
      return valueOf("atan2(" + both + ")/" + std::string(kDegrees),
                     [](double y, double x) { return core::atan2(y, x); });
    }
    if (function == "hypot") {
      return valueOf("hypot(" + both + ")", [](double x, double y) { return core::hypot(x, y); });
    }
    if (function == "fmod") {
      return valueOf(a[0].text + " < 0 ? -mod(fabs(" + a[0].text + "),fabs(" + a[1].text + ")) : mod(" + a[0].text +
                         ",fabs(" + a[1].text + "))",
                     [](double x, double y) { return std::fmod(x, y); });
    }
    if (function == "log") {
      return valueOf("log(" + a[0].text + ")/log(" + a[1].text + ")",
                     [](double x, double y) { return core::log(x) / core::log(y); });
    }
    return std::nullopt;
  }

  std::string_view text_;
  std::size_t offset_;
  const LpyScope& scope_;
  LpyDraws& draws_;
  DialectReport& report_;
  std::size_t at_ = 0;
  bool hasFailed_ = false;
};

}  // namespace

std::optional<LpyValue> translateLpyExpression(const TextPiece& text, const LpyScope& scope, LpyDraws& draws,
                                               DialectReport& report) {
  return ExpressionReader(text, scope, draws, report).read();
}

std::string lpyName(const std::string& name) {
  const bool isOwn = name == "Q" || name == "Z" || name == "pi" || name.starts_with('_');
  return isOwn ? "v" + name : name;
}

LpyValue lpyConstant(double number) {
  std::string text;
  core::appendNumber(text, number, core::NumberStyle::Shortest);
  // cpfg's exponents follow a point
  const std::size_t exponent = text.find('e');
  if (exponent != std::string::npos && text.find('.') == std::string::npos) {
    text.insert(exponent, ".0");
  }
  return {number < 0.0 ? "(" + text + ")" : text, number};
}

std::vector<TextPiece> lpyArguments(const TextPiece& list) {
  std::vector<TextPiece> pieces;
  int depth = 0;
  char quote = '\0';
  std::size_t begin = 0;
  for (std::size_t at = 0; at <= list.text.size(); ++at) {
    const bool isEnd = at == list.text.size();
    const char c = isEnd ? ',' : list.text[at];
    if (quote != '\0' && !isEnd) {
      quote = c == quote ? '\0' : quote;
      continue;
    }
    quote = c == '"' || c == '\'' ? c : '\0';
    depth += c == '(' || c == '[' || c == '{' ? 1 : c == ')' || c == ']' || c == '}' ? -1 : 0;
    if (c == ',' && (depth == 0 || isEnd)) {
      pieces.push_back(TextPiece{list.text.substr(begin, at - begin), list.offset + begin}.trimmed());
      begin = at + 1;
    }
  }
  if (pieces.size() == 1 && pieces.front().empty()) {
    pieces.clear();
  }
  return pieces;
}

}  // namespace espalier::language
