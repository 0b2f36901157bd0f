#include "engine/language/parsed_model.h"

#include <string>
#include <utility>
#include <vector>

#include "engine/language/analyser.h"
#include "engine/language/parse/parser.h"

namespace espalier::language {
namespace {

// every function of a function set becomes a macro with its number; the preprocessor refuses a name with a '.'
std::vector<std::pair<std::string, std::string>> functionMacros(const files::ViewSettings& view) {
  std::vector<std::pair<std::string, std::string>> macros;
  for (std::size_t i = 0; i < view.functions.size(); ++i) {
    macros.emplace_back(view.functions[i].name(), std::to_string(i + 1));
  }
  return macros;
}

}  // namespace

ParsedModel parseModel(const CompileInput& input, const files::ViewSettings& view, ModelOrigin origin,
                       core::FileProvider& files) {
  ParsedModel parsed;
  PreprocessInput preprocessInput;
  preprocessInput.file = input.modelFile;
  preprocessInput.overrides = input.defines;
  preprocessInput.limits = input.limits;
  if (view.functionSetDefinesMacros && input.compatibility != core::Compatibility::CpfgBatch) {
    preprocessInput.macros = functionMacros(view);
  }
  parsed.source = preprocess(preprocessInput, files);
  const PreprocessResult& source = parsed.source;
  if (!source.isComplete) {
    return parsed;
  }
  MessageList& messages = parsed.messages;
  Parser parser(source.text, input.limits, parsed.syntax, messages);
  parser.setCommentNewlines(source.commentNewlines);
  parser.parseFile();
  if (!source.diagnostics.hasErrors()) {
    const bool hasSyntaxErrors = messages.errorCount() > 0;
    Analyser analyser(source.text, input.compatibility, input.limits, parsed.syntax, messages);
    analyser.setMacros(source.macros);
    analyser.analyse();
    if (hasSyntaxErrors) {
      messages.dropWarnings();
    } else if (messages.errorCount() == 0) {
      const CheckedModel checked{input.compatibility, origin, input.beginsElsewhere};
      parsed.reportedCommands = checkModel(source.text, checked, parsed.syntax, messages);
    }
  }
  if (source.hasLostText) {
    // the rest of the model is inside the open comment, which was reported
    messages.dropFrom(static_cast<std::uint32_t>(source.text.find_last_not_of(" \t\n") + 1));
  }
  return parsed;
}

}  // namespace espalier::language
