#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/identifiers.h"
#include "engine/core/streams.h"
#include "engine/files/data_file.h"
#include "engine/files/source_map.h"
#include "engine/files/text_cursor.h"
#include "engine/files/view_settings.h"
#include "engine/language/view/view_file.h"
#include "engine/language/view/view_lexer.h"

namespace espalier::language {

/// The characters between the numbers of a command.
inline constexpr std::string_view kNumberSeparators = " \t\r,:";

/// The input and output of the commands of a view file.
struct ViewCommandContext {
  ViewLexer& lexer;
  files::TextReport& report;
  ViewFileResult& result;
  core::FileProvider& files;
  const std::string& viewFile;
  core::Compatibility compatibility;

  /// `contour:` commands, read after the whole view file.
  struct NamedContour {
    int id = 0;
    std::string file;
    core::SourceRange range;
  };
  std::vector<NamedContour> contours{};

  // the amounts that the named files may still use
  std::uint64_t remainingBytes = 0;
  int openedFileCount = 0;
  files::ReadingBudget budget{};
  std::size_t remainingTexturePixels = files::kMostImagePixels;

  [[nodiscard]] files::ViewSettings& settings() const { return result.settings; }
  [[nodiscard]] bool isCompatible() const { return compatibility != core::Compatibility::Espalier; }
  /// Records that a file of the current command cannot be used: an error if the model needs it.
  void addUnusable(UnusableFile::Kind kind, int id, core::SourceRange range, std::string file) const {
    result.unusable.push_back({kind, id, report.locate(range), std::move(file)});
  }
  void warn(std::string message, std::string hint = {}) const {
    report.warn(lexer.commandRange(), std::move(message), std::move(hint));
  }
};

/// One command of a view file.
struct ViewCommand {
  std::string_view label;  // with its colon
  /// Reads the arguments and executes the command; false when an argument is missing (ViewLexer::expected()).
  bool (*execute)(ViewCommandContext& context);
};

/// The commands that set numbers, flags, styles and the camera, and the commands that only a picture needs.
[[nodiscard]] std::span<const ViewCommand> valueCommands();
/// The commands that name files of the model folder.
[[nodiscard]] std::span<const ViewCommand> fileCommands();

/// Reads the contours that the view file named.
void readNamedContours(ViewCommandContext& context);

/// Reads the line of a `tropism:` or `torque:` (docs/model-files.md, 4.3). A wrong line gives a
/// warning and has no effect.
void readMovement(ViewCommandContext& context, files::Movement::Kind kind);

/// A text file beside the view file. When it cannot be read: nothing, and a warning with the consequence.
[[nodiscard]] std::optional<files::DataFile> openFile(ViewCommandContext& context, core::SourceRange range,
                                                      const std::string& name, const std::string& consequence);

/// The same for a file that is no text: its name and its bytes.
[[nodiscard]] std::optional<files::SourceMap::File> openBytes(ViewCommandContext& context, core::SourceRange range,
                                                              const std::string& name, const std::string& consequence);

/// Reads the line of a `texture:` (docs/model-files.md, 11.3) and its picture.
void readTexture(ViewCommandContext& context);

/// Reads the line of a `background scene:` (docs/model-files.md, 11.4) and its files, which replace those of an earlier
/// command.
void readBackground(ViewCommandContext& context);

/// Reads the line of a `light:` (docs/model-files.md, 4.4). A wrong line gives a warning and no
/// light.
void readLight(ViewCommandContext& context);

}  // namespace espalier::language
