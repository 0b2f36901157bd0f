#include "server/language_server/language_session.h"

#include <algorithm>
#include <utility>

#include "engine/core/work_meter.h"

namespace espalier::server {
namespace {

using Json = nlohmann::json;

constexpr int kInvalidRequest = -32600;
constexpr int kMethodNotFound = -32601;
constexpr int kInvalidParameters = -32602;
constexpr int kNotInitialized = -32002;

Json responseOf(const Json& id, Json result) {
  return {{"jsonrpc", "2.0"}, {"id", id}, {"result", std::move(result)}};
}

Json errorOf(const Json& id, int code, const std::string& message) {
  return {{"jsonrpc", "2.0"}, {"id", id}, {"error", {{"code", code}, {"message", message}}}};
}

Json notificationOf(const char* method, Json parameters) {
  return {{"jsonrpc", "2.0"}, {"method", method}, {"params", std::move(parameters)}};
}

}  // namespace

std::vector<Json> LanguageSession::receive(const Json& message, const OpenRun& run) {
  std::vector<Json> sent;
  const bool isCall = message.is_object() && message.contains("method") && message["method"].is_string();
  const Json id = message.is_object() && message.contains("id") ? message["id"] : Json();
  if (!isCall) {
    // the answer to a request of ours, of which there are none, or no message at all
    if (!message.is_object() || !(message.contains("result") || message.contains("error"))) {
      sent.push_back(errorOf(id, kInvalidRequest, "a message needs a 'method': send a request of JSON-RPC 2.0"));
    }
    return sent;
  }
  const auto method = message["method"].get<std::string>();
  const Json parameters = message.contains("params") ? message["params"] : Json::object();
  if (id.is_null()) {
    try {
      notify(method, parameters, sent);
    } catch (const Json::exception&) {
      // a notification has no answer: one with wrong members has no effect
      sent.push_back(notificationOf(
          "window/logMessage",
          {{"type", 1}, {"message", "the notification '" + method + "' has wrong parameters and had no effect"}}));
    }
    return sent;
  }
  if (!isInitialized_ && method != "initialize") {
    sent.push_back(errorOf(id, kNotInitialized, "send 'initialize' first"));
    return sent;
  }
  std::optional<Failure> failure;
  Json result;
  try {
    result = call(method, parameters, run, failure);
  } catch (const Json::exception&) {
    failure = Failure{kInvalidParameters, "the parameters of '" + method +
                                              "' have a wrong form: see the Language Server Protocol, version 3.17"};
  }
  sent.push_back(failure ? errorOf(id, failure->code, failure->message) : responseOf(id, std::move(result)));
  return sent;
}

Json LanguageSession::call(const std::string& method, const Json& parameters, const OpenRun& run,
                           std::optional<Failure>& failure) {
  if (method == "initialize") {
    return initialize(parameters);
  }
  if (method == "shutdown") {
    isShutDown_ = true;
    return nullptr;
  }
  if (method == "textDocument/hover") {
    return hover(parameters);
  }
  if (method == "textDocument/definition") {
    return definition(parameters);
  }
  if (method == "textDocument/references") {
    return references(parameters);
  }
  if (method == "textDocument/documentHighlight") {
    return highlights(parameters);
  }
  if (method == "textDocument/prepareRename") {
    return prepareRename(parameters, failure);
  }
  if (method == "textDocument/rename") {
    return rename(parameters, failure);
  }
  if (method == "textDocument/completion") {
    return completion(parameters);
  }
  if (method == "textDocument/formatting") {
    return formatting(parameters, failure);
  }
  if (method == "textDocument/documentSymbol") {
    return symbols(parameters);
  }
  if (method == "textDocument/semanticTokens/full") {
    return semanticTokens(parameters);
  }
  if (method == "textDocument/codeLens") {
    return codeLenses(parameters, run);
  }
  failure = Failure{kMethodNotFound, "there is no method '" + method + "'"};
  return nullptr;
}

Json LanguageSession::initialize(const Json& parameters) {
  isInitialized_ = true;
  const Json encodings = parameters.value(Json::json_pointer("/capabilities/general/positionEncodings"), Json::array());
  const bool knowsBytes = std::find(encodings.begin(), encodings.end(), Json("utf-8")) != encodings.end();
  unit_ = knowsBytes ? ColumnUnit::Bytes : ColumnUnit::Utf16;
  return {
      {"serverInfo", {{"name", "espalier"}}},
      {"capabilities",
       {{"positionEncoding", knowsBytes ? "utf-8" : "utf-16"},
        {"textDocumentSync", {{"openClose", true}, {"change", 2}}},
        {"hoverProvider", true},
        {"definitionProvider", true},
        {"referencesProvider", true},
        {"documentHighlightProvider", true},
        {"documentSymbolProvider", true},
        {"documentFormattingProvider", true},
        {"renameProvider", {{"prepareProvider", true}}},
        {"completionProvider", Json::object()},
        {"codeLensProvider", Json::object()},
        {"semanticTokensProvider",
         {{"legend", {{"tokenTypes", semanticTokenTypes()}, {"tokenModifiers", Json::array()}}}, {"full", true}}}}}};
}

void LanguageSession::notify(const std::string& method, const Json& parameters, std::vector<Json>& sent) {
  if (method == "exit") {
    hasEnded_ = true;
    return;
  }
  if (!isInitialized_) {
    return;
  }
  std::optional<std::string> problem;
  if (method == "textDocument/didOpen") {
    const Json& document = parameters.at("textDocument");
    problem = documents_.put(document.at("uri").get<std::string>(), document.at("text").get<std::string>(),
                             document.value("version", std::int64_t{0}));
  } else if (method == "textDocument/didChange") {
    const Json& named = parameters.at("textDocument");
    const auto uri = named.at("uri").get<std::string>();
    const OpenDocument* document = documents_.find(uri);
    if (document == nullptr) {
      return;
    }
    std::string text = document->text;
    for (const Json& change : parameters.at("contentChanges")) {
      core::pollWork();
      const auto replacement = change.at("text").get<std::string>();
      if (!change.contains("range")) {
        text = replacement;
        continue;
      }
      const auto at = [&](const char* side) {
        const Json& position = change.at("range").at(side);
        return offsetAt(text, {position.at("line").get<std::uint32_t>(), position.at("character").get<std::uint32_t>()},
                        unit_);
      };
      const std::size_t begin = at("start");
      text.replace(begin, std::max(at("end"), begin) - begin, replacement);
    }
    problem = documents_.put(uri, std::move(text), named.value("version", std::int64_t{0}));
  } else if (method == "textDocument/didClose") {
    documents_.close(parameters.at("textDocument").at("uri").get<std::string>());
  } else {
    return;
  }
  analyses_.clear();
  if (problem) {
    sent.push_back(notificationOf("window/showMessage", {{"type", 1}, {"message", *problem}}));
  }
  publish(sent);
}

std::shared_ptr<const ModelAnalysis> LanguageSession::analysisOf(const std::string& path) {
  auto& analysis = analyses_[path];
  if (analysis == nullptr) {
    analysis = analyseModel(path, documents_);
  }
  return analysis;
}

Json LanguageSession::rangeOf(const LineIndex& lines, std::size_t offset, std::size_t length) const {
  // every list of an answer comes by here
  core::pollWork();
  const EditorPosition begin = lines.positionAt(offset, unit_);
  const EditorPosition end = lines.positionAt(offset + length, unit_);
  return {{"start", {{"line", begin.line}, {"character", begin.column}}},
          {"end", {{"line", end.line}, {"character", end.column}}}};
}

Json LanguageSession::locationOf(const ModelAnalysis& analysis, const language::NameUse& use) const {
  const files::SourceMap::File& file = analysis.map.files[use.file];
  return {{"uri", documents_.uriOf(file.name)}, {"range", rangeOf(analysis.lines[use.file], use.offset, use.length)}};
}

Json LanguageSession::diagnosticOf(const core::Diagnostic& diagnostic) const {
  const core::SourceLocation& place = diagnostic.location;
  const std::uint32_t line = place.line == 0 ? 0 : place.line - 1;
  const std::uint32_t byte = place.column == 0 ? 0 : place.column - 1;
  std::string text = diagnostic.message;
  for (const std::string& more : {place.expansion, diagnostic.hint}) {
    text += more.empty() ? "" : "\n" + more;
  }
  const int severity =
      diagnostic.severity == core::Severity::Error ? 1 : (diagnostic.severity == core::Severity::Warning ? 2 : 3);
  return {{"range",
           {{"start", {{"line", line}, {"character", columnAt(place.lineText, byte, unit_)}}},
            {"end", {{"line", line}, {"character", columnAt(place.lineText, byte + place.length, unit_)}}}}},
          {"severity", severity},
          {"source", "espalier"},
          {"message", text}};
}

void LanguageSession::publish(std::vector<Json>& sent) {
  std::map<std::string, Json> current;
  for (const OpenDocument* document : documents_.all()) {
    current[document->uri] = Json::array();
  }
  const auto add = [&](const std::vector<core::Diagnostic>& diagnostics, const std::string& modelFile) {
    for (const core::Diagnostic& diagnostic : diagnostics) {
      const std::string& file = diagnostic.location.file.empty() ? modelFile : diagnostic.location.file;
      Json& list = current.try_emplace(documents_.uriOf(file), Json::array()).first->second;
      Json one = diagnosticOf(diagnostic);
      // a view file belongs to several models
      if (std::find(list.begin(), list.end(), one) == list.end()) {
        list.push_back(std::move(one));
      }
    }
  };
  for (const OpenDocument* document : documents_.all()) {
    if (isModelFile(document->path)) {
      add(analysisOf(document->path)->diagnostics, document->path);
    } else if (isViewFile(document->path)) {
      add(checkViewFile(document->path, documents_), document->path);
    }
  }
  // files whose messages are gone, too
  for (const auto& [uri, list] : published_) {
    current.try_emplace(uri, Json::array());
  }
  for (auto& [uri, list] : current) {
    const auto before = published_.find(uri);
    if (before != published_.end() && before->second == list) {
      continue;
    }
    Json parameters{{"uri", uri}, {"diagnostics", list}};
    if (const OpenDocument* document = documents_.find(uri)) {
      parameters["version"] = document->version;
    }
    sent.push_back(notificationOf("textDocument/publishDiagnostics", std::move(parameters)));
  }
  published_ = std::move(current);
  std::erase_if(published_, [&](const auto& entry) { return entry.second.empty() && !documents_.find(entry.first); });
}

std::optional<LanguageSession::Place> LanguageSession::placeOf(const Json& parameters) {
  const auto uri = parameters.at("textDocument").at("uri").get<std::string>();
  const std::string path = OpenDocuments::pathOf(uri);
  // the file itself, or a model that includes it
  std::vector<std::string> models;
  if (isModelFile(path)) {
    models.push_back(path);
  }
  for (const OpenDocument* document : documents_.all()) {
    if (document->path != path && isModelFile(document->path)) {
      models.push_back(document->path);
    }
  }
  for (const std::string& model : models) {
    Place place{analysisOf(model), 0, 0, nullptr};
    const std::optional<std::uint32_t> file = place.analysis->fileIndex(path);
    if (!file) {
      continue;
    }
    place.file = *file;
    if (parameters.contains("position")) {
      const Json& position = parameters.at("position");
      place.offset = static_cast<std::uint32_t>(
          offsetAt(place.text(),
                   {position.at("line").get<std::uint32_t>(), position.at("character").get<std::uint32_t>()}, unit_));
      place.name = place.analysis->nameAt(place.file, place.offset);
    }
    return place;
  }
  return std::nullopt;
}

}  // namespace espalier::server
