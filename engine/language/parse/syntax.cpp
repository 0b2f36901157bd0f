#include "engine/language/parse/syntax.h"

namespace espalier::language {

std::vector<ExpressionIndex> operatorChain(const ModelSyntax& model, ExpressionIndex top) {
  std::vector<ExpressionIndex> chain;
  for (; model.expressions[top].kind == ExpressionKind::Binary; top = model.expressions[top].children.front()) {
    chain.push_back(top);
  }
  return chain;
}

ExpressionIndex firstNode(const ModelSyntax& model, ExpressionIndex top) {
  while (!model.expressions[top].children.empty()) {
    top = model.expressions[top].children.front();
  }
  return top;
}

std::string foldBlanks(std::string_view text) {
  std::string folded;
  for (const char c : text) {
    const bool isSpace = c == ' ' || c == '\t' || c == '\n' || c == '\r';
    if (!isSpace) {
      folded.push_back(c);
    } else if (!folded.empty() && folded.back() != ' ') {
      folded.push_back(' ');
    }
  }
  if (!folded.empty() && folded.back() == ' ') {
    folded.pop_back();
  }
  return folded;
}

}  // namespace espalier::language
