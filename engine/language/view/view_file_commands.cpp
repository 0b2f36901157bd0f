#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/files/curves/blob_file.h"
#include "engine/files/curves/contour_file.h"
#include "engine/files/curves/curve_file.h"
#include "engine/files/curves/function_file.h"
#include "engine/files/data_file.h"
#include "engine/files/file_name.h"
#include "engine/files/surfaces/mesh_file.h"
#include "engine/files/surfaces/surface_file.h"
#include "engine/language/view/view_commands.h"

namespace espalier::language {
namespace {

using Context = ViewCommandContext;

// table sizes of the reference program; in its modes the entries beyond them change strings
constexpr std::size_t kReferenceSurfaces = 14;
constexpr std::size_t kReferenceTriangleSurfaces = 20;
constexpr std::size_t kReferenceBlobs = 10;
// a short file must not ask for unlimited tables
constexpr int kMostFiles = 1000;
constexpr int kLastContour = 31;

/// The id, file and scale with which `surface:` and `tsurface:` begin.
struct SurfaceArguments {
  char id = 0;
  std::string file;
  double scale = 1.0;
};

/// Nothing when an argument is missing. An id of 0: the command is ignored, and its warning is written.
std::optional<SurfaceArguments> readSurfaceArguments(Context& c) {
  const std::optional<std::string_view> id = c.lexer.word();
  const std::optional<std::string_view> file = id ? c.lexer.word() : std::nullopt;
  const std::optional<double> scale = file ? c.lexer.number() : std::nullopt;
  if (!scale) {
    return std::nullopt;
  }
  SurfaceArguments arguments{id->front(), std::string(*file), *scale > 0.0 ? *scale : 1.0};
  if (!(*scale > 0.0)) {
    c.warn("a surface scale that is not positive is taken as 1");
  }
  const auto hasId = [&](const auto& surface) { return surface.id == arguments.id; };
  const files::ViewSettings& settings = c.settings();
  if (id->size() > 1) {
    c.warn("the name of a surface is one character, found '" + std::string(id->substr(0, 40)) +
               "'; the surface is ignored",
           std::string("~") + arguments.id + " is written for the surface '" + arguments.id + "'");
    arguments.id = 0;
  } else if (std::any_of(settings.surfaces.begin(), settings.surfaces.end(), hasId) ||
             std::any_of(settings.triangleSurfaces.begin(), settings.triangleSurfaces.end(), hasId)) {
    c.warn(std::string("the surface '") + arguments.id + "' is defined already; this one is ignored");
    arguments.id = 0;
  }
  return arguments;
}

void addUnusableSurface(Context& c, const SurfaceArguments& arguments) {
  c.addUnusable(UnusableFile::Kind::Surface, arguments.id, c.lexer.commandRange(), arguments.file);
}

/// Adds a surface from a mesh file, for `surface:` and `tsurface:`.
void addMeshSurface(Context& c, const SurfaceArguments& arguments, int texture) {
  const std::string name = std::string("~") + arguments.id;
  const std::string consequence = name + " draws nothing";
  const core::SourceRange range = c.lexer.commandRange();
  const std::optional<files::SourceMap::File> file = openBytes(c, range, arguments.file, consequence);
  if (!file) {
    return addUnusableSurface(c, arguments);
  }
  auto read = files::readMeshFile(file->name, file->text);
  if (!read) {
    c.report.warn(range, "the mesh '" + file->name + "' cannot be used: " + read.error() + "; " + consequence);
    return addUnusableSurface(c, arguments);
  }
  files::TriangleSurface surface{arguments.id, file->name, std::move(*read), texture};
  for (files::SurfaceTriangle& triangle : surface.triangles) {
    for (core::Vec3& point : triangle.points) {
      point = point * arguments.scale;
    }
  }
  c.settings().triangleSurfaces.push_back(std::move(surface));
}

bool surface(Context& c) {
  const std::optional<SurfaceArguments> arguments = readSurfaceArguments(c);
  if (!arguments) {
    return false;
  }
  // one number more is the texture; two are the subdivisions; three are both
  std::array<std::optional<int>, 3> extra;
  for (std::size_t i = 0; i < extra.size() && (i == 0 || extra[i - 1]); ++i) {
    extra[i] = c.lexer.optionalInteger();
  }
  const bool hasSubdivisions = extra[1].has_value();
  const std::optional<int> texture = hasSubdivisions ? extra[2] : extra[0];
  if (arguments->id == 0) {
    return true;
  }
  if (files::isMeshFile(arguments->file)) {
    addMeshSurface(c, *arguments, texture.value_or(-1));
    return true;
  }
  const std::string name = std::string("~") + arguments->id;
  if (arguments->id == '~' && !c.settings().surfaces.empty()) {
    c.warn("only the first surface can be named '~'; this one is ignored");
    return true;
  }
  if (c.isCompatible() && c.settings().surfaces.size() >= kReferenceSurfaces) {
    c.warn("the reference program has at most 14 surfaces; " + name + " is ignored");
    return true;
  }
  const std::optional<files::DataFile> file =
      openFile(c, c.lexer.commandRange(), arguments->file, name + " draws nothing and the turtle stays");
  std::optional<files::Surface> read;
  if (file) {
    read = files::readSurfaceFile(*file, arguments->id, arguments->scale, hasSubdivisions ? *extra[0] : 0,
                                  hasSubdivisions ? *extra[1] : 0);
  }
  if (read) {
    read->texture = texture.value_or(-1);
    c.settings().surfaces.push_back(std::move(*read));
  } else {
    addUnusableSurface(c, *arguments);
  }
  return true;
}

bool triangleSurface(Context& c) {
  const std::optional<SurfaceArguments> arguments = readSurfaceArguments(c);
  if (!arguments || arguments->id == 0) {
    return arguments.has_value();
  }
  if (files::isMeshFile(arguments->file)) {
    addMeshSurface(c, *arguments, -1);
    return true;
  }
  const std::string name = std::string("~") + arguments->id;
  if (c.isCompatible() && c.settings().triangleSurfaces.size() >= kReferenceTriangleSurfaces) {
    c.warn("the reference program has at most 20 triangle surfaces; " + name + " is ignored");
    return true;
  }
  const std::optional<files::DataFile> file =
      openFile(c, c.lexer.commandRange(), arguments->file, name + " draws nothing and the turtle stays");
  std::optional<files::TriangleSurface> read;
  if (file) {
    read = files::readTriangleSurfaceFile(*file, arguments->id, arguments->scale);
  }
  if (read) {
    c.settings().triangleSurfaces.push_back(std::move(*read));
  } else {
    addUnusableSurface(c, *arguments);
  }
  return true;
}

bool function(Context& c) {
  const std::optional<std::string_view> name = c.lexer.word();
  if (!name) {
    return false;
  }
  const std::string fileName(*name);
  const std::optional<int> samples = c.lexer.optionalInteger();
  std::vector<files::SplineFunction>& functions = c.settings().functions;
  const std::optional<files::DataFile> file = openFile(
      c, c.lexer.commandRange(), fileName, "function " + std::to_string(functions.size() + 1) + " is 0 everywhere");
  functions.push_back(file ? files::readFunctionFile(*file, samples) : files::zeroFunction());
  c.settings().functionSetDefinesMacros = false;
  return true;
}

bool functionSet(Context& c) {
  const std::optional<std::string_view> name = c.lexer.word();
  if (!name) {
    return false;
  }
  const std::optional<files::DataFile> file =
      openFile(c, c.lexer.commandRange(), std::string(*name), "it defines no functions");
  // a set discards the functions before it
  c.settings().functions = file ? files::readFunctionSet(*file, c.compatibility) : std::vector<files::SplineFunction>{};
  c.settings().functionSetDefinesMacros = c.compatibility != core::Compatibility::CpfgBatch;
  return true;
}

bool curve(Context& c) {
  const std::optional<std::string_view> name = c.lexer.word();
  if (!name) {
    return false;
  }
  const std::string fileName(*name);
  const int samples = c.lexer.optionalInteger().value_or(files::kDefaultCurveSamples);
  std::vector<files::ParametricCurve>& curves = c.settings().curves;
  const std::optional<files::DataFile> file = openFile(
      c, c.lexer.commandRange(), fileName, "curve " + std::to_string(curves.size() + 1) + " is the origin everywhere");
  curves.push_back(file ? files::readCurveFile(*file, files::boundedSampleCount(*file, {0, 1}, samples))
                        : files::zeroCurve());
  return true;
}

bool contour(Context& c) {
  const std::optional<int> id = c.lexer.integer();
  const std::optional<std::string_view> name = id ? c.lexer.word() : std::nullopt;
  if (!name) {
    return false;
  }
  if (*id < 0 || *id > kLastContour) {
    c.warn("contour " + std::to_string(*id) + " is ignored", "the number of a contour is 0 to 31");
    return true;
  }
  c.contours.push_back({*id, std::string(*name), c.lexer.commandRange()});
  return true;
}

bool blob(Context& c) {
  const std::optional<std::string_view> name = c.lexer.word();
  if (!name) {
    return false;
  }
  const std::string fileName(*name);
  const core::SourceRange range = c.lexer.commandRange();
  if (!fileName.ends_with(".sdat") || fileName.find('.') != fileName.size() - 5) {
    c.warn("the name of a blob field ends in .sdat and has no other point; '" + fileName.substr(0, 40) +
           "' is ignored");
    return true;
  }
  if (c.isCompatible() && c.settings().blobFields.size() >= kReferenceBlobs) {
    c.warn("the reference program has at most 10 blob fields; '" + fileName.substr(0, 40) + "' is ignored");
    return true;
  }
  const std::optional<files::DataFile> file = openFile(c, range, fileName, "the field is 0 everywhere");
  c.settings().blobFields.push_back(file ? files::readBlobFile(*file) : files::BlobField{});
  return true;
}

bool texture(Context& c) {
  readTexture(c);
  return true;
}

bool backgroundScene(Context& c) {
  readBackground(c);
  return true;
}

constexpr std::array kFileCommands = {
    ViewCommand{"contour:", contour},   ViewCommand{"surface:", surface},
    ViewCommand{"line:", surface},      ViewCommand{"tsurface:", triangleSurface},
    ViewCommand{"function:", function}, ViewCommand{"function set:", functionSet},
    ViewCommand{"curve:", curve},       ViewCommand{"blob:", blob},
    ViewCommand{"texture:", texture},   ViewCommand{"background scene:", backgroundScene},
};

}  // namespace

std::optional<files::SourceMap::File> openBytes(ViewCommandContext& c, core::SourceRange range, const std::string& name,
                                                const std::string& consequence) {
  if (++c.openedFileCount > kMostFiles) {
    c.report.warn(range, "more than " + std::to_string(kMostFiles) + " files in one view file; " + consequence);
    return std::nullopt;
  }
  const std::string file = files::nameBeside(c.viewFile, name);
  std::optional<std::string> text = c.files.read(file);
  if (!text) {
    c.report.warn(range, "the file '" + file + "' cannot be read; " + consequence,
                  "the file is looked for beside the view file");
    return std::nullopt;
  }
  if (text->size() > c.remainingBytes) {
    c.report.warn(range, "the files of the view file have more bytes than the limit of a model's source allows: '" +
                             file + "' is not read; " + consequence);
    return std::nullopt;
  }
  c.remainingBytes -= text->size();
  const bool isNew = std::none_of(c.result.sources.begin(), c.result.sources.end(),
                                  [&](const files::SourceMap::File& source) { return source.name == file; });
  if (isNew) {
    c.result.sources.push_back({file, *text});
  }
  return files::SourceMap::File{file, std::move(*text)};
}

std::optional<files::DataFile> openFile(ViewCommandContext& c, core::SourceRange range, const std::string& name,
                                        const std::string& consequence) {
  std::optional<files::SourceMap::File> file = openBytes(c, range, name, consequence);
  if (!file) {
    return std::nullopt;
  }
  return files::DataFile(std::move(file->name), file->text, c.result.diagnostics, &c.budget);
}

std::span<const ViewCommand> fileCommands() {
  return kFileCommands;
}

void readNamedContours(ViewCommandContext& context) {
  for (const ViewCommandContext::NamedContour& named : context.contours) {
    const std::optional<files::DataFile> file =
        openFile(context, named.range, named.file, "contour " + std::to_string(named.id) + " is the circle");
    std::optional<files::Contour> read = file ? files::readContourFile(*file, named.id) : std::nullopt;
    if (!read) {
      context.addUnusable(UnusableFile::Kind::Contour, named.id, named.range, named.file);
      continue;
    }
    // a later contour of the same number replaces the earlier one
    std::erase_if(context.settings().contours, [&](const files::Contour& other) { return other.id == named.id; });
    context.settings().contours.push_back(std::move(*read));
  }
}

}  // namespace espalier::language
