#pragma once

#include "engine/core/streams.h"
#include "engine/files/view_settings.h"
#include "engine/language/checks/model_checks.h"
#include "engine/language/message_list.h"
#include "engine/language/parse/syntax.h"
#include "engine/language/preprocess/preprocessor.h"
#include "engine/language/program.h"

namespace espalier::language {

/// A model between its text and its Program.
struct ParsedModel {
  PreprocessResult source;
  ModelSyntax syntax;                         // analysed, unless the source has errors; without the parts with mistakes
  MessageList messages;                       // about source.text: of the parser, the analyser and the checks
  std::vector<std::string> reportedCommands;  // symbols behind a `@` about which there is a warning
};

/// Preprocesses, parses and analyses the model file of `input`, which must be a cpfg model, and checks it for probable
/// mistakes. `view` may define macros.
[[nodiscard]] ParsedModel parseModel(const CompileInput& input, const files::ViewSettings& view, ModelOrigin origin,
                                     core::FileProvider& files);

}  // namespace espalier::language
