#include "engine/language/compiler.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "engine/core/hash.h"
#include "engine/files/file_name.h"
#include "engine/language/checks/needed_files.h"
#include "engine/language/code_generator.h"
#include "engine/language/dialects/dialect.h"
#include "engine/language/message_list.h"
#include "engine/language/parsed_model.h"
#include "engine/language/view/view_file.h"

namespace espalier::language {
namespace {

void addAll(core::DiagnosticList& list, const core::DiagnosticList& others) {
  for (const core::Diagnostic& diagnostic : others.entries()) {
    list.add(diagnostic);
  }
}

void addSources(std::vector<files::SourceMap::File>& sources, const std::vector<files::SourceMap::File>& files) {
  for (const files::SourceMap::File& file : files) {
    const bool isKnown = std::any_of(sources.begin(), sources.end(),
                                     [&](const files::SourceMap::File& known) { return known.name == file.name; });
    if (!isKnown) {
      sources.push_back(file);
    }
  }
}

std::uint64_t hashOf(const Program& program) {
  core::Hasher hasher;
  hasher.integer(static_cast<std::uint64_t>(program.compatibility));
  for (const files::SourceMap::File& file : program.sources) {
    hasher.integer(file.text.size());
    hasher.bytes(file.text);
  }
  for (const auto& [name, value] : program.defines) {
    hasher.integer(name.size());
    hasher.bytes(name);
    hasher.integer(value.size());
    hasher.bytes(value);
  }
  return hasher.value();
}

/// Reads the files that the model reads with fscanf, so that the Program needs no file while it runs. A model must not
/// overwrite its own text.
void readModelFiles(Program& program, core::FileProvider& files) {
  const std::string folder = files::folderOf(program.modelFile);
  const std::size_t textCount = program.sources.size();
  for (ModelFile& file : program.files) {
    const std::string name = files::nameBeside(program.modelFile, file.name);
    const auto begin = program.sources.begin();
    const auto known = std::find_if(begin, program.sources.end(),
                                    [&](const files::SourceMap::File& source) { return source.name == name; });
    const auto index = static_cast<std::uint32_t>(known - begin);
    file.isRefused = file.isRefused || (file.isWritten && index < textCount);
    if (!file.isRead || file.isRefused) {
      continue;
    }
    if (known == program.sources.end()) {
      std::optional<std::string> text = files.readInside(folder, name);
      if (!text) {
        continue;
      }
      program.sources.push_back({name, std::move(*text)});
    }
    file.source = index;
  }
}

/// The files of a model; texts made by a translation come first.
class TranslatedFiles final : public core::FileProvider {
 public:
  explicit TranslatedFiles(core::FileProvider& files) : files_(files) {}
  void add(const std::string& name, std::string text) { made_.add(name, std::move(text)); }
  [[nodiscard]] std::optional<std::string> read(const std::string& name) override {
    std::optional<std::string> text = made_.read(name);
    return text ? text : files_.read(name);
  }
  [[nodiscard]] std::optional<std::string> readInside(const std::string& folder, const std::string& name) override {
    return files_.readInside(folder, name);
  }

 private:
  core::MemoryFileProvider made_;
  core::FileProvider& files_;
};

/// The view file of a translation: the settings of the dialect, then the caller's view file. Its name lies beside the
/// caller's file, so that the files which the caller's file names are found.
std::string addTranslatedView(const CompileInput& input, const TranslatedModel& translated, TranslatedFiles& files) {
  const std::string& beside = input.viewFile.empty() ? input.modelFile : input.viewFile;
  const std::string name = beside + " (" + std::string(translated.dialect->name) + ")";
  std::string text = viewText(translated.model);
  if (!input.viewFile.empty()) {
    text += "#include \"" + input.viewFile.substr(files::folderOf(input.viewFile).size()) + "\"\n";
  }
  files.add(name, std::move(text));
  return name;
}

}  // namespace

CompileResult compile(const CompileInput& original, core::FileProvider& originalFiles,
                      const std::function<void(const ParsedModel&)>& onParsed) {
  CompileResult result;
  CompileInput input = original;
  TranslatedFiles files(originalFiles);

  // a foreign dialect -> the text and view file of cpfg, under the model's name
  const std::optional<TranslatedModel> translated = translateForeign(input, originalFiles);
  MappedText translation;
  if (translated) {
    addAll(result.diagnostics, translated->diagnostics);
    if (result.diagnostics.hasErrors()) {
      return result;
    }
    translation = modelText(translated->model, false);
    files.add(input.modelFile, translation.text());
    input.viewFile = addTranslatedView(input, *translated, files);
  }

  auto program = std::make_shared<Program>();
  program->compatibility = input.compatibility;
  program->modelFile = input.modelFile;
  program->viewFile = input.viewFile;
  program->defines = input.defines;

  // view file, whose function set may define macros
  ViewFileResult view;
  if (!input.viewFile.empty()) {
    view = readViewFile(input.viewFile, files, input.compatibility, input.limits);
    addAll(result.diagnostics, view.diagnostics);
  }
  // source text -> preprocessed text -> analysed syntax tree
  ParsedModel parsed =
      parseModel(input, view.settings, translated ? ModelOrigin::Translation : ModelOrigin::Cpfg, files);
  if (onParsed && !translated) {
    onParsed(parsed);
  }
  PreprocessResult& source = parsed.source;
  MessageList& messages = parsed.messages;
  addAll(result.diagnostics, source.diagnostics);
  if (!source.isComplete) {
    return result;
  }
  const bool hasErrors = messages.errorCount() > 0 || source.diagnostics.hasErrors();
  // a Program holds the translated files; its messages name the foreign file
  addSources(program->sources, source.sourceMap.files);
  if (translated) {
    source.sourceMap = foreignSourceMap(source.sourceMap, translation, translated->foreign);
  }
  messages.moveTo(result.diagnostics, source.sourceMap);
  if (hasErrors) {
    return result;
  }

  // -> Program
  CodeGenerator(parsed.syntax, source.text, *program).generate();
  program->reportedCommands = std::move(parsed.reportedCommands);
  program->view = std::move(view.settings);
  program->text = std::move(source.text);
  program->sourceMap = std::move(source.sourceMap);
  addSources(program->sources, view.sources);
  readModelFiles(*program, files);
  // the reference program draws nothing for an unreadable file, so this is no error in its modes
  if (input.compatibility == core::Compatibility::Espalier) {
    for (core::Diagnostic& error : neededFiles(*program, view.unusable)) {
      result.diagnostics.add(std::move(error));
    }
    if (result.diagnostics.hasErrors()) {
      return result;
    }
  }
  for (core::Diagnostic& warning : undefinedSurfaces(*program, view.unusable)) {
    result.diagnostics.add(std::move(warning));
  }
  program->hash = hashOf(*program);
  result.program = std::move(program);
  return result;
}

}  // namespace espalier::language
