#include "clients/espalier/installation/handbook_files.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string_view>
#include <utility>

namespace espalier::command {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kWayIn =
    "<!DOCTYPE html><html><head><meta http-equiv=\"refresh\" content=\"0; url=/handbook/\"></head>"
    "<body><a href=\"/handbook/\">Handbook</a></body></html>\n";

std::string typeOf(std::string_view path) {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 11> kTypes{{
      {".html", "text/html; charset=utf-8"},
      {".js", "text/javascript; charset=utf-8"},
      {".css", "text/css; charset=utf-8"},
      {".json", "application/json"},
      {".png", "image/png"},
      {".svg", "image/svg+xml"},
      {".ico", "image/x-icon"},
      {".woff", "font/woff"},
      {".woff2", "font/woff2"},
      {".ttf", "font/ttf"},
      {".otf", "font/otf"},
  }};
  const auto* const found = std::ranges::find_if(kTypes, [&](const auto& type) { return path.ends_with(type.first); });
  return std::string(found == kTypes.end() ? "text/plain; charset=utf-8" : found->second);
}

}  // namespace

Result<HandbookFiles> HandbookFiles::read(const std::string& folder) {
  std::error_code error;
  if (folder.empty() || !fs::is_regular_file(fs::path(folder) / "index.html", error)) {
    return problem("there is no handbook in '" + folder + "': build it with ./dev docs, or leave out --handbook");
  }
  HandbookFiles handbook;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder, error)) {
    if (entry.is_regular_file(error)) {
      std::ifstream file(entry.path(), std::ios::binary);
      std::ostringstream content;
      content << file.rdbuf();
      handbook.files_.push_back({entry.path().lexically_relative(folder).generic_string(), std::move(content).str()});
    }
  }
  return handbook;
}

void HandbookFiles::addTo(std::vector<server::WebFile>& pages) const {
  for (const File& file : files_) {
    const std::string type = typeOf(file.path);
    const std::string inPage = type.starts_with("text/html") ? policyInPage(file.content) : std::string();
    const std::string policy = inPage.empty() ? std::string() : inPage + "; frame-ancestors 'none'";
    pages.push_back({"/handbook/" + file.path, type, file.content, {}, policy});
    if (file.path == "index.html") {
      pages.push_back({"/handbook/", type, file.content, {}, policy});
      pages.push_back({"/handbook", type, kWayIn});
    }
  }
}

std::string policyInPage(const std::string& html) {
  constexpr std::string_view kBegin = "http-equiv=\"Content-Security-Policy\" content=\"";
  const std::size_t begin = html.find(kBegin);
  const std::size_t end = begin == std::string::npos ? begin : html.find('"', begin + kBegin.size());
  return end == std::string::npos ? std::string() : html.substr(begin + kBegin.size(), end - begin - kBegin.size());
}

}  // namespace espalier::command
