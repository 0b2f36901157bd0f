#include "server/language_server/open_documents.h"

#include <charconv>
#include <string_view>
#include <utility>

namespace espalier::server {
namespace {

constexpr std::string_view kFileScheme = "file://";

std::string percentDecoded(std::string_view text) {
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    unsigned value = 0;
    if (text[i] == '%' && i + 2 < text.size() &&
        std::from_chars(text.data() + i + 1, text.data() + i + 3, value, 16).ptr == text.data() + i + 3) {
      decoded += static_cast<char>(value);
      i += 2;
    } else {
      decoded += text[i];
    }
  }
  return decoded;
}

std::string percentEncoded(std::string_view text) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  constexpr std::string_view kPlain = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~/";
  std::string encoded;
  for (const char c : text) {
    if (kPlain.find(c) != std::string_view::npos) {
      encoded += c;
    } else {
      const auto byte = static_cast<unsigned char>(c);
      encoded += {'%', kDigits[byte >> 4U], kDigits[byte & 15U]};
    }
  }
  return encoded;
}

}  // namespace

std::string OpenDocuments::pathOf(const std::string& uri) {
  return uri.starts_with(kFileScheme) ? percentDecoded(std::string_view(uri).substr(kFileScheme.size())) : uri;
}

std::string OpenDocuments::uriOf(const std::string& path) const {
  const auto found = documents_.find(path);
  if (found != documents_.end()) {
    return found->second.uri;
  }
  return path.starts_with('/') ? std::string(kFileScheme) + percentEncoded(path) : path;
}

std::optional<std::string> OpenDocuments::put(const std::string& uri, std::string text, std::int64_t version) {
  const std::string path = pathOf(uri);
  std::size_t bytes = text.size();
  std::size_t count = 1;
  for (const auto& [name, document] : documents_) {
    if (name != path) {
      bytes += document.text.size();
      ++count;
    }
  }
  if (count > kMostDocuments || bytes > kMostBytes) {
    return "at most " + std::to_string(kMostDocuments) + " documents with " + std::to_string(kMostBytes >> 20U) +
           " MB may be open: close some first";
  }
  documents_.insert_or_assign(path, OpenDocument{uri, path, std::move(text), version});
  return std::nullopt;
}

const OpenDocument* OpenDocuments::find(const std::string& uri) const {
  const auto found = documents_.find(pathOf(uri));
  return found == documents_.end() ? nullptr : &found->second;
}

std::vector<const OpenDocument*> OpenDocuments::all() const {
  std::vector<const OpenDocument*> documents;
  for (const auto& [path, document] : documents_) {
    documents.push_back(&document);
  }
  return documents;
}

std::optional<std::string> OpenDocuments::read(const std::string& name) {
  const auto found = documents_.find(name);
  return found == documents_.end() ? files_.read(name) : std::optional<std::string>(found->second.text);
}

std::optional<std::string> OpenDocuments::readInside(const std::string& folder, const std::string& name) {
  const auto found = documents_.find(name);
  return found == documents_.end() ? files_.readInside(folder, name) : std::optional<std::string>(found->second.text);
}

}  // namespace espalier::server
