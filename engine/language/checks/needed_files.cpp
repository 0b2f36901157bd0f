#include "engine/language/checks/needed_files.h"

#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "engine/core/message_text.h"

namespace espalier::language {
namespace {

/// A place of the model that draws with a surface, a contour or a texture.
struct Need {
  UnusableFile::Kind kind = UnusableFile::Kind::Surface;
  std::optional<int> id;  // nothing: computed while the model runs
  core::SourceRange range;
};

/// Collects the needs of the axioms and successors of a model.
class NeedCollector {
 public:
  explicit NeedCollector(const Program& program) : program_(program) {}

  void add(const std::vector<SuccessorModule>& modules, const std::vector<Expression>& expressions);
  [[nodiscard]] std::vector<Need> take() { return std::move(needs_); }

 private:
  [[nodiscard]] char characterOf(const SuccessorModule& module) const {
    return program_.symbols[program_.symbolOf[module.type]].character();
  }
  void addNumber(UnusableFile::Kind kind, const SuccessorModule& module, const std::vector<Expression>& expressions);

  const Program& program_;
  std::vector<Need> needs_;
};

void NeedCollector::addNumber(UnusableFile::Kind kind, const SuccessorModule& module,
                              const std::vector<Expression>& expressions) {
  if (program_.arity[module.type] == 0) {
    return;  // contour 0 is the circle, texture 0 is no texture
  }
  const Expression& number = expressions[module.firstExpression];
  const bool isKnown = number.kind == Expression::Kind::Constant;
  needs_.push_back({kind, isKnown ? std::optional(static_cast<int>(number.constant)) : std::nullopt, module.range});
}

void NeedCollector::add(const std::vector<SuccessorModule>& modules, const std::vector<Expression>& expressions) {
  for (std::size_t i = 0; i + 1 < modules.size(); ++i) {
    const char first = characterOf(modules[i]);
    const char second = characterOf(modules[i + 1]);
    if (program_.arity[modules[i].type] > 0) {
      continue;
    }
    if (first == '~') {
      needs_.push_back({UnusableFile::Kind::Surface, second, modules[i + 1].range});
    } else if (first == '@' && second == '#') {
      addNumber(UnusableFile::Kind::Contour, modules[i + 1], expressions);
    } else if (first == '@' && second == 'T' && i + 2 < modules.size() && characterOf(modules[i + 2]) == 'x' &&
               program_.arity[modules[i + 1].type] == 0) {
      addNumber(UnusableFile::Kind::Texture, modules[i + 2], expressions);
    }
  }
}

std::vector<Need> needsOf(const Program& program) {
  NeedCollector collector(program);
  for (const LSystem& system : program.systems) {
    collector.add(system.axiom, system.axiomExpressions);
    for (const ProductionList* list : {&system.productions, &system.decomposition, &system.homomorphism}) {
      for (const Production& production : list->productions) {
        collector.add(production.successor, production.expressions);
      }
    }
  }
  std::vector<Need> needs = collector.take();
  // the texture of a surface in use
  const std::size_t count = needs.size();
  for (std::size_t i = 0; i < count; ++i) {
    const auto addTexture = [&](const auto& surface) {
      if (needs[i].kind == UnusableFile::Kind::Surface && needs[i].id == surface.id && surface.texture > 0) {
        needs.push_back({UnusableFile::Kind::Texture, surface.texture, needs[i].range});
      }
    };
    std::ranges::for_each(program.view.surfaces, addTexture);
    std::ranges::for_each(program.view.triangleSurfaces, addTexture);
  }
  return needs;
}

std::string nameOf(const UnusableFile& file) {
  switch (file.kind) {
    case UnusableFile::Kind::Surface:
      return std::string("~") + static_cast<char>(file.id);
    case UnusableFile::Kind::Contour:
      return "contour " + std::to_string(file.id);
    case UnusableFile::Kind::Texture:
      break;
  }
  return "texture " + std::to_string(file.id);
}

}  // namespace

std::vector<core::Diagnostic> neededFiles(const Program& program, const std::vector<UnusableFile>& unusable) {
  std::vector<core::Diagnostic> errors;
  if (unusable.empty()) {
    return errors;
  }
  const std::vector<Need> needs = needsOf(program);
  for (const UnusableFile& file : unusable) {
    // a later command may have given another file
    const auto isThis = [&file](const auto& item) { return item.id == file.id; };
    const files::ViewSettings& view = program.view;
    if ((file.kind == UnusableFile::Kind::Surface &&
         (std::ranges::any_of(view.surfaces, isThis) || std::ranges::any_of(view.triangleSurfaces, isThis))) ||
        (file.kind == UnusableFile::Kind::Contour && std::ranges::any_of(view.contours, isThis))) {
      continue;
    }
    const auto need = std::ranges::find_if(needs, [&](const Need& candidate) {
      return candidate.kind == file.kind && candidate.id.value_or(file.id) == file.id;
    });
    if (need == needs.end()) {
      continue;
    }
    const core::SourceLocation place = program.sourceMap.locate(need->range);
    core::Diagnostic& error = errors.emplace_back();
    error.location = file.location;
    const std::string needed =
        "needed at " + core::placeText(place) + "; repair or add the file, or remove this from the model";
    if (file.kind == UnusableFile::Kind::Texture) {
      // only pictures and meshes need a texture, and they show plain parts without it
      error.severity = core::Severity::Warning;
      error.message = "parts with " + nameOf(file) + " are drawn plain: its file '" + file.file + "' cannot be used";
    } else {
      error.message =
          "the model draws with " + nameOf(file) + ", whose file '" + file.file + "' cannot be used (warning above)";
    }
    error.hint = needed;
  }
  return errors;
}

std::vector<core::Diagnostic> undefinedSurfaces(const Program& program, const std::vector<UnusableFile>& unusable) {
  std::set<int> known;
  const auto add = [&known](const auto& surface) { known.insert(surface.id); };
  std::ranges::for_each(program.view.surfaces, add);
  std::ranges::for_each(program.view.triangleSurfaces, add);
  for (const UnusableFile& file : unusable) {
    if (file.kind == UnusableFile::Kind::Surface) {
      known.insert(file.id);
    }
  }
  std::vector<core::Diagnostic> warnings;
  for (const Need& need : needsOf(program)) {
    if (need.kind == UnusableFile::Kind::Surface && known.insert(*need.id).second) {
      const std::string name(1, static_cast<char>(*need.id));
      core::Diagnostic& warning = warnings.emplace_back();
      warning.severity = core::Severity::Warning;
      warning.location = program.sourceMap.locate(need.range);
      warning.message = "the surface '~" + name + "' is not defined and is not drawn";
      warning.hint =
          "write 'surface: " + name + " FILE.s' into the view file, which has the model's name and the suffix .v";
    }
  }
  return warnings;
}

}  // namespace espalier::language
