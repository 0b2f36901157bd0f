#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/limits.h"
#include "engine/language/message_list.h"
#include "engine/language/parse/foreign_lines.h"
#include "engine/language/parse/lexer.h"
#include "engine/language/parse/syntax.h"

namespace espalier::language {

/// Reads preprocessed text into a syntax tree by recursive descent. After a mistake the parser continues at the next
/// statement or production, so that it finds all mistakes of a file. The tree lacks the parts with mistakes.
class Parser {
 public:
  /// All references must outlive the parser.
  Parser(std::string_view text, const core::Limits& limits, ModelSyntax& model, MessageList& messages)
      : limits_(limits), model_(model), messages_(messages), lexer_(text, model.symbols) {}

  /// The offsets of newlines inside comments, ascending: messages explain that these end a production. Must outlive the
  /// parser.
  void setCommentNewlines(std::span<const std::uint32_t> offsets) { commentNewlines_ = offsets; }

  /// The whole file: file := lsystem+ (parser.cpp).
  void parseFile();

 private:
  // parser.cpp: L-systems and their sections
  void parseLSystem();
  void parseItems(LSystemSyntax& system);
  bool reportsLabelOfLines(const LSystemSyntax& system);
  void parseAxiom(LSystemSyntax& system);
  void parseProductions(LSystemSyntax& system, ProductionListSyntax& list, std::string_view name);
  void parseSectionHead(ProductionListSyntax& list);

  // parser_items.cpp: the items before the axiom
  void parseItem(LSystemSyntax& system);
  void parseValueItem(ExpressionIndex& value, std::string_view name);
  void parseSymbolList(std::vector<core::SymbolId>& symbols, std::string_view name);
  void parseItemBlock(Block& block, std::string_view name);
  void parseSyntaxItem();
  void parseModuleItem();
  bool parseModuleDeclaration();
  void parseDefine(LSystemSyntax& system);
  bool parseArrays(LSystemSyntax& system);
  bool parseInitialValues(std::vector<ExpressionIndex>& values);
  bool parseExternals(LSystemSyntax& system);

  // parser_productions.cpp: productions and modules
  struct Segment;
  void parseProduction(ProductionListSyntax& list);
  bool parseHead(ProductionSyntax& production);
  bool parseSegments(std::vector<Segment>& segments, std::vector<Token>& separators);
  bool assignSegments(std::vector<Segment>& segments, const std::vector<Token>& separators,
                      ProductionSyntax& production);
  bool checkContext(const Segment& segment, bool isRight);
  bool parseGuard(ProductionSyntax& production);
  bool parseSuccessor(ProductionSyntax& production);
  bool parseFormalModule(FormalModuleSyntax& module);
  bool parseModules(std::vector<ModuleSyntax>& modules);
  bool parseModule(std::vector<ModuleSyntax>& modules);
  bool internModule(core::SymbolId symbol, std::size_t arity, core::SourceRange range, core::ModuleTypeId& type);
  bool expectedArrow(std::string_view what, const Token& token, std::uint32_t begin, std::string hint = {});
  [[nodiscard]] std::string productionHint(std::uint32_t begin) const;
  bool skipsNoProduction(std::string_view name);

  // parser_hints.cpp: advice for frequent mistakes
  [[nodiscard]] std::string adviceFor(const Token& token) const;
  [[nodiscard]] std::string colonAdvice(const Token& token) const;
  ForeignLine skipForeignLine(std::string_view what, const Token& token);
  [[nodiscard]] std::string unclosedHint(core::SourceRange open, const Token& found) const;
  void reportSkippedCharacters();
  void warnAboutLatex(std::uint32_t begin);
  [[nodiscard]] std::string_view lineAt(std::uint32_t position) const;
  [[nodiscard]] std::string continuationHint(std::uint32_t position) const;
  [[nodiscard]] bool startsInComment(std::uint32_t position) const;

  // parser_statements.cpp: blocks
  bool parseBlock(Block& block);
  bool parseStatements(std::vector<Statement>& statements);
  bool parseBody(std::vector<Statement>& statements, const std::string& example);
  bool isTooDeep();
  bool parseStatement(Statement& statement);
  bool parseSimpleStatement(Statement& statement);
  bool expectSemicolon();
  bool parseIf(Statement& statement);
  bool parseLoop(Statement& statement, bool isDo);
  bool parseStatementCondition(ExpressionIndex& condition, std::string_view name);
  void skipStatement(bool passesParentheses = false);

  // parser_expressions.cpp
  ExpressionIndex parseExpression();
  ExpressionIndex parseBinary(int least);
  ExpressionIndex parseUnary();
  ExpressionIndex parsePrimary();
  ExpressionIndex parseName();
  ExpressionIndex parseParentheses();
  bool parseArguments(std::vector<ExpressionIndex>& arguments, core::SourceRange open);
  ExpressionIndex makeNode(ExpressionNode node);
  [[nodiscard]] core::SourceRange rangeOf(ExpressionIndex index) const { return model_.expressions[index].range; }

  // messages and recovery
  /// Reports `token` where something else was expected. Always false, for `return`.
  bool expected(std::string_view what, const Token& token, std::string hint = {});
  [[nodiscard]] std::string describeReading() const;
  bool expectExpressionToken(TokenKind kind, std::string_view what);
  /// Consumes the end of an item or production; a file may also end.
  bool expectLineEnd(const Token& token);
  void recover();

  const core::Limits& limits_;
  std::span<const std::uint32_t> commentNewlines_;
  ModelSyntax& model_;
  MessageList& messages_;
  Lexer lexer_;
  std::string reading_ = "the model";  // the part that is being read, for messages
  core::SourceRange predecessor_;      // of the production being read; empty: none
  std::uint32_t expressionDepth_ = 0;  // recursion of the parser itself
  std::uint32_t productionBegin_ = 0;  // of the production being read
  bool skipsIndentedLines_ = false;    // the last message was about lines that start with blanks
  bool missesBraces_ = false;          // of the current statement of a block: one message is enough
  bool hasReportedEnd_ = false;        // an early end of the file was reported: one message is enough
};

}  // namespace espalier::language
