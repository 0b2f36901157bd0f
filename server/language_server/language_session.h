#pragma once

#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "server/language_server/model_analysis.h"
#include "server/language_server/open_documents.h"
#include "server/language_server/run_counts.h"
#include "server/language_server/text_positions.h"

namespace espalier::server {

/// The work of a LanguageServer, on messages that are parsed. It gives diagnostics, hover, completion, definition,
/// references, highlights, rename, formatting, document symbols, semantic tokens and code lenses. Everything but the
/// lenses comes from the program's own compiler, which reads the whole model after each change.
class LanguageSession {
 public:
  /// `files` gives the files that the editor has not open; it must outlive the object.
  explicit LanguageSession(core::FileProvider& files) : documents_(files) {}

  /// Takes a message and returns the messages to be sent. A message that is no request of JSON-RPC 2.0 gets an error.
  /// `run`: LanguageServer::receive.
  [[nodiscard]] std::vector<nlohmann::json> receive(const nlohmann::json& message, const OpenRun& run);

  /// Whether the editor has said `exit`, and whether it had said `shutdown` before.
  [[nodiscard]] bool hasEnded() const { return hasEnded_; }
  [[nodiscard]] bool isShutDown() const { return isShutDown_; }

 private:
  using Json = nlohmann::json;
  struct Failure {
    int code = 0;
    std::string message;
  };
  struct Place;

  // language_server.cpp
  [[nodiscard]] Json call(const std::string& method, const Json& parameters, const OpenRun& run,
                          std::optional<Failure>& failure);
  void notify(const std::string& method, const Json& parameters, std::vector<Json>& sent);
  [[nodiscard]] Json initialize(const Json& parameters);
  void publish(std::vector<Json>& sent);
  [[nodiscard]] std::shared_ptr<const ModelAnalysis> analysisOf(const std::string& path);
  [[nodiscard]] std::optional<Place> placeOf(const Json& parameters);
  [[nodiscard]] Json rangeOf(const LineIndex& lines, std::size_t offset, std::size_t length) const;
  [[nodiscard]] Json locationOf(const ModelAnalysis& analysis, const language::NameUse& use) const;
  [[nodiscard]] Json diagnosticOf(const core::Diagnostic& diagnostic) const;

  // name_requests.cpp
  [[nodiscard]] Json hover(const Json& parameters);
  [[nodiscard]] Json definition(const Json& parameters);
  [[nodiscard]] Json references(const Json& parameters);
  [[nodiscard]] Json highlights(const Json& parameters);
  [[nodiscard]] Json prepareRename(const Json& parameters, std::optional<Failure>& failure);
  [[nodiscard]] Json rename(const Json& parameters, std::optional<Failure>& failure);

  // text_requests.cpp
  [[nodiscard]] Json completion(const Json& parameters);
  [[nodiscard]] Json formatting(const Json& parameters, std::optional<Failure>& failure);
  [[nodiscard]] Json symbols(const Json& parameters);
  [[nodiscard]] Json semanticTokens(const Json& parameters);
  [[nodiscard]] Json codeLenses(const Json& parameters, const OpenRun& openRun);

  OpenDocuments documents_;
  ColumnUnit unit_ = ColumnUnit::Utf16;
  bool isInitialized_ = false;
  bool isShutDown_ = false;
  bool hasEnded_ = false;
  std::map<std::string, std::shared_ptr<const ModelAnalysis>> analyses_;  // by model file, of the texts as they are
  std::map<std::string, Json> published_;                                 // the messages sent last, by URI
};

/// A place in a document that a request asks about.
struct LanguageSession::Place {
  std::shared_ptr<const ModelAnalysis> analysis;
  std::uint32_t file = 0;  // index into the analysis' files
  std::uint32_t offset = 0;
  const language::NameUse* name = nullptr;  // null: there is no name

  [[nodiscard]] const std::string& text() const { return analysis->map.files[file].text; }
  [[nodiscard]] const LineIndex& lines() const { return analysis->lines[file]; }
};

/// The names of the token types, in the order of their numbers in `textDocument/semanticTokens`.
[[nodiscard]] nlohmann::json semanticTokenTypes();

}  // namespace espalier::server
