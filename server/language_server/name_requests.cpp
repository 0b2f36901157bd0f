// The requests about the name at a place: hover, definition, references, highlights, rename.

#include <algorithm>
#include <string_view>
#include <utility>

#include "engine/core/work_meter.h"
#include "server/language_server/handbook_rows.h"
#include "server/language_server/language_session.h"
#include "server/language_server/rename.h"

namespace espalier::server {
namespace {

using Json = nlohmann::json;
using language::NameKind;
using language::NameUse;

constexpr int kRenameRefused = -32803;  // RequestFailed of the protocol

std::string_view lineAt(std::string_view text, std::size_t offset) {
  const std::size_t newline = offset == 0 ? std::string_view::npos : text.rfind('\n', offset - 1);
  const std::size_t begin = newline == std::string_view::npos ? 0 : newline + 1;
  return text.substr(begin, std::min(text.find('\n', offset), text.size()) - begin);
}

/// The turtle's action for a module: also for the letters after `@`.
std::optional<std::string> turtleMeaning(std::string_view text, const NameUse& name) {
  std::size_t at = name.offset;
  // `@M` and `@Gs` are modules one by one; the row is that of the whole
  for (std::size_t back = 0; back <= 2 && back <= name.offset; ++back) {
    if (text[name.offset - back] == '@') {
      at = name.offset - back;
      break;
    }
  }
  for (const std::size_t length : {3U, 2U}) {
    if (text[at] == '@' && at + length > name.offset) {
      if (auto row = handbookSymbol(text.substr(at, length))) {
        return row;
      }
    }
  }
  return handbookSymbol(name.name);
}

std::string moduleHover(const ModelAnalysis& analysis, std::string_view text, const NameUse& name) {
  std::string hover;
  if (const auto row = turtleMeaning(text, name)) {
    hover = *row + "\n\n";
  }
  std::string productions;
  std::size_t count = 0;
  for (const NameUse& use : analysis.names) {
    core::pollWork();
    if (use.meansTheSameAs(name) && use.isDefinition && use.arity == name.arity && !use.isExpanded) {
      ++count;
      productions += std::string(lineAt(analysis.map.files[use.file].text, use.offset)) + "\n";
    }
  }
  const std::string module =
      "`" + name.name + "` with " + std::to_string(name.arity) + (name.arity == 1 ? " parameter" : " parameters");
  if (count == 0) {
    return hover + module + ": no production rewrites it.";
  }
  return hover + module + ", rewritten by " + std::to_string(count) + (count == 1 ? " line" : " lines") + ":\n```\n" +
         productions + "```";
}

std::string macroHover(const ModelAnalysis& analysis, const NameUse& name) {
  std::string hover;
  for (const language::MacroDefinition& macro : analysis.macros) {
    core::pollWork();
    if (macro.name == name.name) {
      const files::SourceMap::File& file = analysis.map.files[macro.file];
      const std::uint32_t line = analysis.lines[macro.file].positionAt(macro.offset, ColumnUnit::Bytes).line + 1;
      hover += "```\n" + std::string(lineAt(file.text, macro.offset)) + "\n```\nmacro, defined at " + file.name + ":" +
               std::to_string(line) + "\n\n";
    }
  }
  return hover;
}

std::string hoverText(const ModelAnalysis& analysis, std::string_view text, const NameUse& name) {
  const std::string quoted = "`" + name.name + "`";
  switch (name.kind) {
    case NameKind::Macro:
      return macroHover(analysis, name);
    case NameKind::Module:
      return moduleHover(analysis, text, name);
    case NameKind::Function:
      return handbookFunction(name.name).value_or(quoted + ": a function of the language");
    case NameKind::Parameter:
      return quoted + ": a parameter of this production";
    case NameKind::LocalVariable:
      return quoted + ": a variable of this production. It keeps its value until the next use.";
    case NameKind::Variable:
      return quoted + ": a variable of the L-system";
    case NameKind::Array:
      return quoted + ": an array of the L-system";
    case NameKind::Unknown:
      return quoted + ": not defined; its value is 0";
  }
  return {};
}

}  // namespace

Json LanguageSession::hover(const Json& parameters) {
  const auto place = placeOf(parameters);
  if (!place || place->name == nullptr) {
    return nullptr;
  }
  const NameUse& name = *place->name;
  return {{"contents", {{"kind", "markdown"}, {"value", hoverText(*place->analysis, place->text(), name)}}},
          {"range", rangeOf(place->lines(), name.offset, name.length)}};
}

Json LanguageSession::definition(const Json& parameters) {
  const auto place = placeOf(parameters);
  Json locations = Json::array();
  if (!place || place->name == nullptr) {
    return locations;
  }
  for (const NameUse& use : place->analysis->names) {
    const bool isOther = use.kind == NameKind::Module && use.arity != place->name->arity && !use.isDeclared;
    if (use.isDefinition && use.meansTheSameAs(*place->name) && !isOther) {
      locations.push_back(locationOf(*place->analysis, use));
    }
  }
  return locations;
}

Json LanguageSession::references(const Json& parameters) {
  const auto place = placeOf(parameters);
  Json locations = Json::array();
  if (!place || place->name == nullptr) {
    return locations;
  }
  const bool hasDeclarations = parameters.value(Json::json_pointer("/context/includeDeclaration"), true);
  for (const NameUse& use : place->analysis->names) {
    if (use.meansTheSameAs(*place->name) && (hasDeclarations || !use.isDefinition)) {
      Json location = locationOf(*place->analysis, use);
      if (locations.empty() || locations.back() != location) {
        locations.push_back(std::move(location));
      }
    }
  }
  return locations;
}

Json LanguageSession::highlights(const Json& parameters) {
  const auto place = placeOf(parameters);
  Json marks = Json::array();
  if (!place || place->name == nullptr) {
    return marks;
  }
  for (const NameUse& use : place->analysis->names) {
    if (use.file == place->file && use.meansTheSameAs(*place->name)) {
      marks.push_back({{"range", rangeOf(place->lines(), use.offset, use.length)}, {"kind", 1}});
    }
  }
  return marks;
}

Json LanguageSession::prepareRename(const Json& parameters, std::optional<Failure>& failure) {
  const auto place = placeOf(parameters);
  if (!place || place->name == nullptr) {
    failure = Failure{kRenameRefused, "there is no name here: place the caret on a name of the model"};
    return nullptr;
  }
  const NameUse& name = *place->name;
  return {{"range", rangeOf(place->lines(), name.offset, name.length)}, {"placeholder", name.name}};
}

Json LanguageSession::rename(const Json& parameters, std::optional<Failure>& failure) {
  const auto place = placeOf(parameters);
  if (!place || place->name == nullptr) {
    failure = Failure{kRenameRefused, "there is no name here: place the caret on a name of the model"};
    return nullptr;
  }
  const auto newName = parameters.at("newName").get<std::string>();
  const auto edits = renameEdits(*place->analysis, *place->name, newName, documents_);
  if (!edits) {
    failure = Failure{kRenameRefused, edits.error()};
    return nullptr;
  }
  Json changes = Json::object();
  for (const TextEdit& edit : *edits) {
    const files::SourceMap::File& file = place->analysis->map.files[edit.file];
    changes[documents_.uriOf(file.name)].push_back(
        {{"range", rangeOf(place->analysis->lines[edit.file], edit.offset, edit.length)}, {"newText", newName}});
  }
  return {{"changes", std::move(changes)}};
}

}  // namespace espalier::server
