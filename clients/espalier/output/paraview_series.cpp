#include "clients/espalier/output/paraview_series.h"

#include <filesystem>
#include <map>
#include <string_view>
#include <vector>

#include "clients/espalier/messages.h"
#include "clients/espalier/output/outputs.h"
#include "server/remote/disk_files.h"

namespace espalier::command {
namespace {

namespace fs = std::filesystem;

// a text as an attribute of XML
std::string seriesAttribute(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '&') {
      escaped += "&amp;";
    } else if (c == '<') {
      escaped += "&lt;";
    } else if (c == '"') {
      escaped += "&quot;";
    } else {
      escaped += c;
    }
  }
  return escaped;
}

// growth.vtp and growth%04d.vtp: growth.pvd
std::string seriesName(std::string file) {
  const std::size_t percent = file.find('%');
  const std::size_t end = percent == std::string::npos ? percent : file.find_first_not_of("0123456789", percent + 1);
  if (end != std::string::npos && file[end] == 'd') {
    file.erase(percent, end + 1 - percent);
  }
  return fs::path(file).replace_extension(".pvd").string();
}

}  // namespace

bool writeParaviewSeries(std::span<const std::string> files, std::span<const std::uint64_t> steps, bool isQuiet) {
  std::map<std::string, std::vector<std::string>> series;  // names of files by .pvd
  for (const std::string& file : files) {
    if (file.ends_with(".vtp") || file.ends_with(".vtu") || file.ends_with(".vti")) {
      series[seriesName(file)].push_back(file);
    }
  }
  for (const auto& [name, parts] : series) {
    std::string text = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n";
    for (const std::uint64_t step : steps) {
      for (std::size_t part = 0; part < parts.size(); ++part) {
        text += "<DataSet timestep=\"" + std::to_string(step) + "\" part=\"" + std::to_string(part) + "\" file=\"" +
                seriesAttribute(fs::path(numberedName(parts[part], step, 4)).filename().string()) + "\"/>\n";
      }
    }
    text += "</Collection>\n</VTKFile>\n";
    if (const auto problem = server::writeFileAtomically(name, text)) {
      printError(*problem);
      return false;
    }
    if (!isQuiet) {
      printNote("wrote " + name + " (" + std::to_string(steps.size()) + " steps)");
    }
  }
  return true;
}

}  // namespace espalier::command
