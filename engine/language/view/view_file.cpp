#include "engine/language/view/view_file.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "engine/files/text_cursor.h"
#include "engine/language/decimal_comma.h"
#include "engine/language/hexadecimal.h"
#include "engine/language/preprocess/preprocessor.h"
#include "engine/language/view/view_commands.h"
#include "engine/language/view/view_lexer.h"

namespace espalier::language {
namespace {

const ViewCommand* findCommand(std::string_view label) {
  for (const std::span<const ViewCommand> commands : {valueCommands(), fileCommands()}) {
    for (const ViewCommand& command : commands) {
      if (command.label == label) {
        return &command;
      }
    }
  }
  return nullptr;
}

/// The label without its colon, for messages and for the nearest name.
std::string_view withoutColon(std::string_view label) {
  return label.ends_with(':') ? label.substr(0, label.size() - 1) : label;
}

/// A name without blanks at its end and with one blank between its words.
std::string withSingleBlanks(std::string_view name) {
  std::string result;
  for (const char c : name) {
    const bool isBlank = c == ' ' || c == '\t';
    if (!isBlank || !result.ends_with(' ')) {
      result += isBlank ? ' ' : c;
    }
  }
  return result.ends_with(' ') ? result.substr(0, result.size() - 1) : result;
}

void warnUnknown(const ViewCommandContext& context, const ViewLexer::Label& label) {
  const files::TextReport& report = context.report;
  constexpr std::size_t kLongest = 40;
  if (report.isFull()) {
    return report.warn(label.range, {});
  }
  std::string_view name = withoutColon(label.text);
  if (name.starts_with('\t') && findCommand(label.text.substr(label.text.find_first_not_of(" \t"))) != nullptr) {
    report.warn(label.range, "the line is skipped because a TAB stands before its label",
                "use blanks instead of the TAB");
    return;
  }
  while (!name.empty() && (name.back() == ' ' || name.back() == '\t' || name.back() == '\r')) {
    name.remove_suffix(1);
  }
  std::string shown(name.substr(0, kLongest));
  shown += name.size() > kLongest ? "..." : "";
  if (!label.text.ends_with(':')) {
    const std::string_view text = context.lexer.cursor().textBetween(0, label.range.end);
    std::string hint = hexadecimalHint(text, label.range.begin);
    if (const std::size_t equals = name.find('='); hint.empty() && equals != std::string_view::npos && equals > 0) {
      hint = "write ':' in place of '='";
    }
    report.warn(label.range, "expected a view command while reading a view file, found '" + shown + "'",
                hint.empty() ? decimalCommaHint(text, label.range.begin) : std::move(hint));
    return;
  }
  std::string hint;
  if (name.size() <= kLongest) {
    std::vector<std::string_view> candidates;
    for (const std::span<const ViewCommand> commands : {valueCommands(), fileCommands()}) {
      for (const ViewCommand& command : commands) {
        candidates.push_back(withoutColon(command.label));
      }
    }
    const std::string_view nearest = core::nearestName(name, candidates);
    if (std::ranges::find(candidates, withSingleBlanks(name)) != candidates.end()) {
      hint = "write '" + withSingleBlanks(name) + ":', with single blanks and no blank before the colon";
    } else if (!nearest.empty()) {
      hint = "did you mean '" + std::string(nearest) + ":'?";
    }
  }
  report.warn(label.range, "unknown view command '" + shown + "'", std::move(hint));
}

void warnMissing(const ViewCommandContext& context, const ViewLexer::Label& label) {
  const files::TextCursor& at = context.lexer.cursor();
  files::TextCursor next = at;
  const std::string found = next.found();
  const bool isLost = context.isCompatible();
  context.report.warn(
      label.range,
      "expected " + context.lexer.expected() + " while reading '" + std::string(label.text) + "', found " + found,
      isLost ? "the command is ignored, and the text in the place of its argument is skipped"
             : "the command is ignored");
}

/// Executes the commands in file order.
void executeCommands(ViewCommandContext& context) {
  while (const std::optional<ViewLexer::Label> label = context.lexer.nextLabel()) {
    const ViewCommand* const command = findCommand(label->text);
    if (command == nullptr) {
      warnUnknown(context, *label);
      context.lexer.skipLine();
    } else if (!command->execute(context)) {
      warnMissing(context, *label);
      context.lexer.recover();
    }
  }
}

}  // namespace

ViewFileResult readViewFile(const std::string& file, core::FileProvider& files, core::Compatibility compatibility,
                            const core::Limits& limits) {
  ViewFileResult result;
  if (!files.read(file)) {
    core::Diagnostic diagnostic;
    diagnostic.severity = core::Severity::Warning;
    diagnostic.message = "the view file cannot be read; every view setting has its default";
    diagnostic.location.file = file;
    result.diagnostics.add(std::move(diagnostic));
    return result;
  }
  PreprocessInput input;
  input.file = file;
  input.limits = limits;
  PreprocessResult text = preprocess(input, files);
  // a view file never stops a run
  for (core::Diagnostic diagnostic : text.diagnostics.entries()) {
    if (diagnostic.severity == core::Severity::Error) {
      diagnostic.severity = core::Severity::Warning;
    }
    result.diagnostics.add(std::move(diagnostic));
  }
  result.sources = text.sourceMap.files;

  ViewLexer lexer(text.text, compatibility);
  files::TextReport report(text.sourceMap, result.diagnostics);
  ViewCommandContext context{lexer, report, result, files, file, compatibility};
  // places in a file are 32-bit numbers
  context.remainingBytes =
      std::min<std::uint64_t>(limits.maximumSourceBytes, std::numeric_limits<std::uint32_t>::max());
  executeCommands(context);
  readNamedContours(context);

  files::ViewSettings& settings = result.settings;
  if (settings.viewpoint == settings.viewReferencePoint) {
    report.warn({0, 1}, "viewpoint and view reference point are equal; the view is from 0,0,-1 to 0,0,0");
    settings.viewpoint = {0.0, 0.0, -1.0};
    settings.viewReferencePoint = {};
  }
  return result;
}

}  // namespace espalier::language
