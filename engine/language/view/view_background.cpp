#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/files/surfaces/background_scene.h"
#include "engine/language/preprocess/preprocessor.h"
#include "engine/language/view/view_commands.h"

namespace espalier::language {
namespace {

// the file as preprocessed text, with its problems as warnings of the view file; its sources are kept
void readSceneFile(ViewCommandContext& c, const std::string& file, files::BackgroundScene& whole) {
  PreprocessInput input;
  input.file = file;
  input.limits.maximumSourceBytes = c.remainingBytes;
  PreprocessResult text = preprocess(input, c.files);
  for (core::Diagnostic diagnostic : text.diagnostics.entries()) {
    diagnostic.severity = core::Severity::Warning;
    c.result.diagnostics.add(std::move(diagnostic));
  }
  std::vector<files::BackgroundProblem> problems;
  files::BackgroundScene scene = files::readBackgroundScene(text.text, problems);
  const files::TextReport report(text.sourceMap, c.result.diagnostics);
  for (files::BackgroundProblem& problem : problems) {
    report.warn(problem.range, problem.message + ": it is skipped");
  }
  for (files::SourceMap::File& source : text.sourceMap.files) {
    if (std::ranges::none_of(c.result.sources, [&](const auto& other) { return other.name == source.name; })) {
      c.result.sources.push_back(std::move(source));
    }
  }
  // the materials of a file hold for its shapes only
  const auto firstMaterial = static_cast<std::uint32_t>(whole.materials.size());
  if (whole.materials.size() + scene.materials.size() > files::kMostBackgroundMaterials) {
    return c.warn("the files have more than " + std::to_string(files::kMostBackgroundMaterials) + " materials; '" +
                  file + "' is not drawn");
  }
  for (files::BackgroundShape& shape : scene.shapes) {
    shape.material += firstMaterial;
    whole.shapes.push_back(std::move(shape));
  }
  whole.materials.insert(whole.materials.end(), scene.materials.begin(), scene.materials.end());
}

}  // namespace

void readBackground(ViewCommandContext& c) {
  const core::SourceRange range = c.lexer.commandRange();
  files::TextCursor line = c.lexer.line();
  std::string names(line.rest());
  std::ranges::replace_if(
      names, [](char character) { return character == ',' || character == ';' || character == '\r'; }, ' ');
  auto scene = std::make_shared<files::BackgroundScene>();
  files::TextCursor cursor(names);
  for (cursor.skipBlanks(); !cursor.atEnd(); cursor.skipBlanks()) {
    const auto file = openBytes(c, range, std::string(cursor.word()), "this part of the background is not drawn");
    if (file) {
      readSceneFile(c, file->name, *scene);
    }
  }
  c.settings().background = scene->shapes.empty() ? nullptr : std::move(scene);
}

}  // namespace espalier::language
