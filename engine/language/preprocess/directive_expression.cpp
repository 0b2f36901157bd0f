#include "engine/language/preprocess/directive_expression.h"

#include <algorithm>
#include <array>
#include <charconv>

#include "engine/language/preprocess/macro_table.h"

namespace espalier::language {
namespace {

struct DirectiveOperator {
  std::string_view text;
  int precedence;
};

// longer spellings first
constexpr std::array<DirectiveOperator, 18> kOperators{{{"||", 1},
                                                        {"&&", 2},
                                                        {"==", 6},
                                                        {"!=", 6},
                                                        {"<=", 7},
                                                        {">=", 7},
                                                        {"<<", 8},
                                                        {">>", 8},
                                                        {"|", 3},
                                                        {"^", 4},
                                                        {"&", 5},
                                                        {"<", 7},
                                                        {">", 7},
                                                        {"+", 9},
                                                        {"-", 9},
                                                        {"*", 10},
                                                        {"/", 10},
                                                        {"%", 10}}};

// two's complement arithmetic that cannot overflow
std::int64_t wrap(std::uint64_t value) {
  return static_cast<std::int64_t>(value);
}

class Evaluator {
 public:
  Evaluator(std::string_view text, std::uint32_t maximumDepth, DirectiveProblem& problem)
      : text_(text), maximumDepth_(maximumDepth), problem_(problem) {}

  std::optional<std::int64_t> run() {
    const auto value = conditional();
    skipBlanks();
    if (value.has_value() && position_ < text_.size()) {
      return fail("an operator");
    }
    return value;
  }

 private:
  std::nullopt_t failAt(std::size_t begin, std::size_t end, std::string message) {
    if (problem_.message.empty()) {
      problem_ = {begin, end, std::move(message)};
    }
    return std::nullopt;
  }

  std::nullopt_t fail(std::string_view expected) {
    skipBlanks();
    const std::size_t end = std::max(wordEnd(text_, position_), std::min(position_ + 1, text_.size()));
    const std::string found = position_ == text_.size()
                                  ? "the end of the line"
                                  : "'" + std::string(text_.substr(position_, end - position_)) + "'";
    return failAt(position_, end,
                  "expected " + std::string(expected) + " while reading the condition of a directive, found " + found);
  }

  void skipBlanks() {
    while (position_ < text_.size() && isBlank(text_[position_])) {
      ++position_;
    }
  }

  bool accept(std::string_view token) {
    skipBlanks();
    if (text_.substr(position_, token.size()) != token) {
      return false;
    }
    position_ += token.size();
    return true;
  }

  std::nullopt_t failNesting() {
    return failAt(
        position_, position_ + 1,
        "the condition is nested deeper than the limit expressionDepth (" + std::to_string(maximumDepth_) + ")");
  }

  // both arms recurse, so each conditional counts as a level of nesting
  std::optional<std::int64_t> conditional() {
    if (++depth_ > maximumDepth_) {
      return failNesting();
    }
    std::optional<std::int64_t> value = binary(1);
    if (value.has_value() && accept("?")) {
      value = arms(*value != 0);
    }
    --depth_;
    return value;
  }

  std::optional<std::int64_t> arms(bool takesFirst) {
    const auto first = conditional();
    if (!first.has_value()) {
      return std::nullopt;
    }
    if (!accept(":")) {
      return fail("':'");
    }
    const auto second = conditional();
    if (!second.has_value()) {
      return std::nullopt;
    }
    return takesFirst ? first : second;
  }

  const DirectiveOperator* peekOperator() {
    skipBlanks();
    const std::string_view rest = text_.substr(position_);
    const auto found = std::find_if(kOperators.begin(), kOperators.end(), [&](const DirectiveOperator& candidate) {
      return rest.starts_with(candidate.text);
    });
    return found == kOperators.end() ? nullptr : &*found;
  }

  std::optional<std::int64_t> binary(int least) {
    auto left = unary();
    while (left.has_value()) {
      const DirectiveOperator* next = peekOperator();
      if (next == nullptr || next->precedence < least) {
        return left;
      }
      const std::size_t begin = position_;
      position_ += next->text.size();
      const auto right = binary(next->precedence + 1);
      if (!right.has_value()) {
        return std::nullopt;
      }
      if (*right == 0 && (next->text == "/" || next->text == "%")) {
        return failAt(begin, begin + 1, "division by zero in the condition of a directive");
      }
      left = apply(next->text, *left, *right);
    }
    return left;
  }

  static std::int64_t apply(std::string_view operation, std::int64_t a, std::int64_t b) {
    const auto x = static_cast<std::uint64_t>(a);
    const auto y = static_cast<std::uint64_t>(b);
    if (operation == "||") return (a != 0 || b != 0) ? 1 : 0;
    if (operation == "&&") return (a != 0 && b != 0) ? 1 : 0;
    if (operation == "==") return a == b ? 1 : 0;
    if (operation == "!=") return a != b ? 1 : 0;
    if (operation == "<=") return a <= b ? 1 : 0;
    if (operation == ">=") return a >= b ? 1 : 0;
    if (operation == "<") return a < b ? 1 : 0;
    if (operation == ">") return a > b ? 1 : 0;
    if (operation == "<<") return wrap(x << (y & 63U));
    if (operation == ">>") return a >> (y & 63U);
    if (operation == "|") return wrap(x | y);
    if (operation == "^") return wrap(x ^ y);
    if (operation == "&") return wrap(x & y);
    if (operation == "+") return wrap(x + y);
    if (operation == "-") return wrap(x - y);
    if (operation == "*") return wrap(x * y);
    // the smallest integer divided by -1 wraps like the other operators
    if (operation == "/") return b == -1 ? wrap(0 - x) : a / b;
    return b == -1 ? 0 : a % b;
  }

  std::optional<std::int64_t> unary() {
    if (++depth_ > maximumDepth_) {
      return failNesting();
    }
    std::optional<std::int64_t> value;
    skipBlanks();
    const char next = position_ < text_.size() ? text_[position_] : '\0';
    if (next == '!' || next == '~' || next == '-' || next == '+') {
      ++position_;
      value = unary();
      if (value.has_value()) {
        const auto bits = static_cast<std::uint64_t>(*value);
        value = next == '!' ? (*value == 0 ? 1 : 0) : next == '~' ? wrap(~bits) : next == '-' ? wrap(0 - bits) : *value;
      }
    } else if (next == '(') {
      ++position_;
      value = conditional();
      if (value.has_value() && !accept(")")) {
        value = fail("')'");
      }
    } else {
      value = primary();
    }
    --depth_;
    return value;
  }

  std::optional<std::int64_t> primary() {
    const std::size_t end = wordEnd(text_, position_);
    if (end == position_) {
      return fail("an integer");
    }
    const std::string_view word = text_.substr(position_, end - position_);
    if (isWordStart(word.front())) {
      position_ = end;
      return 0;
    }
    // decimal, octal or hexadecimal with C's suffixes
    std::string_view digits = word;
    while (!digits.empty() && std::string_view("uUlL").find(digits.back()) != std::string_view::npos) {
      digits.remove_suffix(1);
    }
    int base = 10;
    if (digits.starts_with("0x") || digits.starts_with("0X")) {
      base = 16;
      digits.remove_prefix(2);
    } else if (digits.size() > 1 && digits.front() == '0') {
      base = 8;
    }
    std::int64_t value = 0;
    const auto [stop, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value, base);
    if (error != std::errc() || stop != digits.data() + digits.size()) {
      return fail("an integer");
    }
    position_ = end;
    return value;
  }

  std::string_view text_;
  std::uint32_t maximumDepth_;
  DirectiveProblem& problem_;
  std::size_t position_ = 0;
  std::uint32_t depth_ = 0;
};

}  // namespace

std::optional<std::int64_t> evaluateDirective(std::string_view text, std::uint32_t maximumDepth,
                                              DirectiveProblem& problem) {
  return Evaluator(text, maximumDepth, problem).run();
}

}  // namespace espalier::language
