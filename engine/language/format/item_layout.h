#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "engine/language/parse/lexer.h"
#include "engine/language/parse/symbol_table.h"

namespace espalier::language {

/// A model file cut into logical lines, and its code: the active lines without directives and comments, with macros not
/// expanded. Every byte of the code has its place in the file.
struct CodeOfFile {
  struct Line {
    std::uint32_t begin = 0;  // in the file
    std::uint32_t end = 0;    // behind its newline
    bool isCode = true;       // false: a directive, or excluded by #if
    bool startsInComment = false;
    bool hasSplice = false;  // `\` joins physical lines
  };
  std::string_view file;
  std::vector<Line> lines;
  std::string code;
  std::vector<std::uint32_t> offsets;  // of each byte of `code` in the file

  /// The line that holds a byte of the file. O(log lines).
  [[nodiscard]] std::size_t lineAt(std::uint32_t offset) const;
};

/// `activeLineEnds` are the file offsets of the newlines that reached the compiler; a final line without one counts.
/// `file` must outlive the result.
[[nodiscard]] CodeOfFile readCode(std::string_view file, const std::unordered_set<std::uint32_t>& activeLineEnds);

/// An item, production or section line in a new layout.
struct LaidOutItem {
  std::size_t firstLine = 0;  // of CodeOfFile::lines
  std::size_t lastLine = 0;
  std::string text;  // without a final newline
};

/// Cuts code into items with the real Lexer, in the modes that the parser would choose, and gives each a new layout.
/// The result lacks items that cannot be read so, or that hold directives or joined lines.
class ItemLayout {
 public:
  /// `code` must outlive the object. `declared` are the named modules that the whole model knows.
  ItemLayout(const CodeOfFile& code, const std::vector<Symbol>& declared);
  [[nodiscard]] std::vector<LaidOutItem> run(std::uint32_t& untouched);

 private:
  enum class Phase : std::uint8_t { Start, Head, Guard, Successor, Expression, Modules, Plain };
  struct Placed {
    Token token;
    std::uint32_t begin = 0, end = 0;  // in the file
    std::uint32_t blockDepth = 0;      // of a line that begins with it
    bool isInString = false;           // a module's name or a bracket of a string
    bool isCompact = false;            // inside parentheses or subscripts
    bool isOperand = false;            // a value ends here
    bool isPrefix = false;             // unary operator
    bool isWildcard = false;           // `*` for a context, condition or successor
    bool joinsLine = false;            // a `{` that may stand on the line of its keyword
  };

  bool readItem();
  void readKeyword(const Token& token);
  bool place(const Token& token, bool isInString);
  [[nodiscard]] bool layOut(LaidOutItem& item) const;
  [[nodiscard]] bool isUntouchable(std::size_t firstLine, std::size_t lastLine) const;
  [[nodiscard]] std::string blankBetween(const Placed& left, const Placed& right) const;
  [[nodiscard]] bool appendGap(std::string& text, const Placed& left, const Placed& right) const;
  [[nodiscard]] std::string lineStart(std::uint32_t depth, char original) const;

  const CodeOfFile& code_;
  SymbolTable symbols_;
  Lexer lexer_;
  std::vector<Placed> tokens_;
  Phase phase_ = Phase::Start;
  std::uint32_t parentheses_ = 0;
  std::uint32_t subscripts_ = 0;
  std::uint32_t branches_ = 0;  // open `[` of a string
  std::uint32_t blocks_ = 0;
  bool expectsBlock_ = false;  // behind Start:, StartEach:, EndEach: or End:
  bool isFinished_ = false;
};

}  // namespace espalier::language
