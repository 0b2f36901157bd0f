#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/validation/built_in_tables.h"
#include "clients/espalier/validation/case_runs.h"
#include "clients/espalier/validation/result_plot.h"
#include "clients/espalier/validation/validation.h"
#include "server/remote/control_group.h"
#include "server/remote/disk_files.h"

namespace espalier::command {
namespace {

struct ValidateOptions {
  std::vector<std::string> names;
  std::string data;
  std::string plots;  // folder; empty: none
  std::string page;   // file; empty: none
  bool isQuick = false;
  bool isList = false;
};

std::string shortNumber(double value) {
  if (std::isnan(value)) {
    return "none";
  }
  char text[40];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

std::string namesOfCases() {
  std::string names;
  for (const validation::Case& one : validation::cases()) {
    names += (names.empty() ? "" : ", ") + std::string(one.name);
  }
  return names;
}

/// The cases that the options choose; empty after an error.
std::vector<const validation::Case*> chosenCases(const ValidateOptions& options) {
  std::vector<const validation::Case*> chosen;
  for (const std::string& name : options.names) {
    const auto& all = validation::cases();
    const auto found = std::find_if(all.begin(), all.end(), [&](const auto& one) { return one.name == name; });
    if (found == all.end()) {
      printError("there is no benchmark '" + name + "': choose from " + namesOfCases());
      return {};
    }
    chosen.push_back(&*found);
  }
  for (const validation::Case& one : validation::cases()) {
    if (options.names.empty() && (one.isQuick || !options.isQuick)) {
      chosen.push_back(&one);
    }
  }
  return chosen;
}

/// Where the part of a page about a case begins.
constexpr const char* kPageTitle = "# Results of validation\n";
constexpr const char* kPartBegin = "\n## ";

const char* verdictOf(const validation::Row& row) {
  return !row.tolerance ? "reported" : row.isMet() ? "met" : "NOT MET";
}

/// Whether something that is missing is a file of the data; else it is a part of one, in words.
bool isFile(const std::string& missing) {
  return missing.find("the function") == std::string::npos;
}

/// The part that a case leaves out without a file, and where the file is published: a sentence.
std::string leftOut(const validation::CaseResult& result, const std::string& missing, const std::string& file) {
  if (!isFile(missing)) {
    return (result.rows.empty() ? "It needs " : "A part of it needs ") + missing;
  }
  const std::string_view source = validation::sourceOfTable(missing);
  return (result.rows.empty() ? "It needs " : "A part of it needs ") + file + ", which is not ours to publish" +
         (source.empty() ? std::string() : ". " + std::string(source));
}

/// The part of a page about one case with the addresses of its pictures.
std::string pagePart(const validation::Case& one, const validation::CaseResult& result,
                     const validation::Duration& took, const std::vector<std::string>& pictures) {
  const auto secondsOf = [](double seconds) {
    char text[40];
    std::snprintf(text, sizeof text, "%.*f s", seconds < 10.0 ? 1 : 0, seconds);
    return std::string(text);
  };
  std::string part = kPartBegin + std::string(one.name) + "\n\n" + std::string(one.title) + ".";
  if (!result.rows.empty()) {
    part += " Took " + secondsOf(took.seconds) + ", " + secondsOf(took.processorSeconds) + " of the processor.\n\n" +
            "| compared | error | tolerance | result | published programs |\n|---|---:|---:|---|---|";
  }
  part += "\n";
  for (const validation::Row& row : result.rows) {
    part += "| " + row.what + " | " + shortNumber(row.error) + " | " +
            (row.tolerance ? shortNumber(*row.tolerance) : std::string()) + " | " + verdictOf(row) + " | " +
            row.published + " |\n";
  }
  for (const std::string& name : result.missing) {
    part += "\nLeft out. " + leftOut(result, name, "`" + name + "`") + ".\n";
  }
  for (const std::string& picture : pictures) {
    part += "\n![" + std::filesystem::path(picture).stem().string() + "](" + picture + ")\n";
  }
  return part;
}

/// The parts of a page that was written before, by case.
std::map<std::string, std::string> partsOfPage(const std::string& page) {
  std::map<std::string, std::string> parts;
  for (std::size_t begin = page.find(kPartBegin); begin != std::string::npos;) {
    const std::size_t end = page.find(kPartBegin, begin + 1);
    const std::string part = page.substr(begin, end == std::string::npos ? end : end - begin);
    const std::size_t name = std::string(kPartBegin).size();
    parts[part.substr(name, part.find('\n', name) - name)] = part;
    begin = end;
  }
  return parts;
}

std::size_t countOf(const std::string& text, const std::string& word) {
  std::size_t count = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + word.size())) {
    ++count;
  }
  return count;
}

std::string pageOf(const std::map<std::string, std::string>& parts) {
  std::string body;
  for (const validation::Case& one : validation::cases()) {
    const auto part = parts.find(std::string(one.name));
    body += part == parts.end() ? "" : part->second;
  }
  const std::size_t missed = countOf(body, "| NOT MET |");
  return std::string(kPageTitle) +
         "\nWritten by `espalier validate --data FOLDER --plot FOLDER --page FILE`, which "
         "replaces the parts of the cases that it runs. [validation.md](validation.md) explains the benchmarks. Errors "
         "are in the sense of the first column; times are those of one run, which may have shared the machine with "
         "others. In pictures references are dashed.\n\n" +
         std::to_string(countOf(body, "| met |")) + " comparisons met their tolerance, " + std::to_string(missed) +
         " did not. Others are reported without one.\n" + body;
}

/// Prints the rows of a case; false when one is beyond its tolerance.
bool printRows(const validation::Case& one, const validation::CaseResult& result, double seconds) {
  bool isMet = true;
  for (const validation::Row& row : result.rows) {
    isMet = isMet && row.isMet();
    std::printf("%s\t%s\t%s\t%s\t%s\t%s\t%.1f\n", std::string(one.name).c_str(), row.what.c_str(),
                shortNumber(row.error).c_str(), row.tolerance ? shortNumber(*row.tolerance).c_str() : "",
                verdictOf(row), row.published.c_str(), seconds);
  }
  std::fflush(stdout);
  for (const std::string& name : result.missing) {
    printNote(std::string(one.name) + " is left out" + (result.rows.empty() ? "" : " in part") + ". " +
              leftOut(result, name, name) + (isFile(name) ? ". Give the folder that has it with --data" : ""));
  }
  return isMet;
}

/// Says at the end which cases are left out, and which in part.
void printLeftOut(const std::vector<std::string>& whole, const std::vector<std::string>& inPart) {
  const auto listed = [](const std::vector<std::string>& names) {
    std::string list;
    for (const std::string& name : names) {
      list += (list.empty() ? "" : ", ") + name;
    }
    return list;
  };
  if (!whole.empty() || !inPart.empty()) {
    printNote("left out for want of tables of other authors: " + (whole.empty() ? "none" : listed(whole)) +
              (inPart.empty() ? std::string() : "; in part: " + listed(inPart)));
  }
}

/// Writes the pictures of a case and returns their addresses on the page; nothing after an error.
std::optional<std::vector<std::string>> writePictures(const validation::Case& one, const validation::CaseResult& result,
                                                      const ValidateOptions& options) {
  namespace fs = std::filesystem;
  std::vector<std::string> addresses;
  const auto pictures = options.plots.empty() ? std::vector<validation::Picture>() : result.allPictures();
  for (const validation::Picture& picture : pictures) {
    std::error_code ignored;
    fs::create_directories(options.plots, ignored);
    const std::string file = options.plots + "/" + std::string(one.name) +
                             (picture.name.empty() ? std::string() : "-" + picture.name) + ".svg";
    if (const auto problem =
            server::writeFileAtomically(file, validation::resultPlot(std::string(one.title), picture))) {
      printError(*problem);
      return std::nullopt;
    }
    printNote("wrote " + file);
    addresses.push_back(fs::path(file).lexically_proximate(fs::path(options.page).parent_path()).generic_string());
  }
  return addresses;
}

/// The printed and written report of the cases.
class Report {
 public:
  /// `parts` are those of the page, by case.
  Report(const ValidateOptions& options, std::map<std::string, std::string>& parts)
      : options_(options), parts_(parts) {}

  /// Prints a case and writes its pictures and its part of the page; false after an error.
  bool add(const validation::Run& run) {
    if (!run.tableError.empty()) {
      printError(options_.data + ": " + run.tableError);
      return false;
    }
    const std::string name(run.one->name);
    isMet_ = printRows(*run.one, run.result, run.took.seconds) && isMet_;
    if (!run.result.missing.empty()) {
      (run.result.rows.empty() ? leftOutWhole_ : leftOutInPart_).push_back(name);
    }
    const auto pictures = writePictures(*run.one, run.result, options_);
    if (!pictures) {
      return false;
    }
    if (run.result.rows.empty() && parts_.contains(name)) {
      printNote("the part '" + name + "' of '" + options_.page +
                "' stays: without the missing tables it has no results");
    } else {
      parts_[name] = pagePart(*run.one, run.result, run.took, *pictures);
    }
    return true;
  }

  /// Says what was left out; false when a result was beyond its tolerance.
  [[nodiscard]] bool end() const {
    printLeftOut(leftOutWhole_, leftOutInPart_);
    if (!isMet_) {
      printError("at least one result is beyond its tolerance: look for NOT MET above");
    }
    return isMet_;
  }

 private:
  const ValidateOptions& options_;
  std::map<std::string, std::string>& parts_;
  std::vector<std::string> leftOutWhole_;
  std::vector<std::string> leftOutInPart_;
  bool isMet_ = true;
};

int validate(const ValidateOptions& options) {
  if (options.isList) {
    for (const validation::Case& one : validation::cases()) {
      std::printf("%s\t%s\t%s\n", std::string(one.name).c_str(), one.isQuick ? "quick" : "long",
                  std::string(one.title).c_str());
    }
    return kSuccess;
  }
  if (!options.data.empty() && !std::filesystem::is_directory(options.data)) {
    printError("there is no folder '" + options.data + "' of published data: check the name given with --data");
    return kFailure;
  }
  const auto data = [&](const std::string& name) -> std::optional<std::string> {
    server::DiskFileProvider files;
    const auto own = options.data.empty() ? std::nullopt : files.read(options.data + "/" + name);
    return own ? std::optional<std::string>(*own) : validation::builtInTable(name);
  };
  const auto chosen = chosenCases(options);
  if (chosen.empty()) {
    return kUsage;
  }
  std::map<std::string, std::string> parts;
  if (!options.page.empty()) {
    server::DiskFileProvider files;
    const std::string page = files.read(options.page).value_or("");
    if (!page.empty() && !page.starts_with(kPageTitle)) {
      printError("'" + options.page + "' (--page) is not a page of espalier validate: give another name, or remove it");
      return kUsage;
    }
    parts = partsOfPage(page);
  }
  std::printf("case\twhat\terror\ttolerance\tresult\tpublished programs\tseconds of the case\n");
  Report report(options, parts);
  if (!validation::runCases(chosen, data, server::processorCount(),
                            [&](const validation::Run& run) { return report.add(run); })) {
    return kFailure;
  }
  if (!options.page.empty()) {
    if (const auto problem = server::writeFileAtomically(options.page, pageOf(parts))) {
      printError(*problem);
      return kFailure;
    }
    printNote("wrote " + options.page);
  }
  return report.end() ? kSuccess : kFailure;
}

}  // namespace

void addValidate(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand(
      "validate", "Compare soil, roots, light and stands with published benchmarks and exact solutions");
  command->footer(
      "Prints a table: case, what is compared, error, tolerance, errors of published programs, time.\n"
      "Examples:\n"
      "  espalier validate --list\n"
      "  espalier validate m3.1 steady\n"
      "  espalier validate --data validation --plot plots");
  auto options = std::make_shared<ValidateOptions>();
  command->add_option("CASE", options->names, "Benchmarks by name (default: all)");
  command->add_option(
      "--data", options->data,
      "Folder with tables of other authors, which the program does not carry (docs/validation.md); a file "
      "with the name of a table of the program takes its place");
  command->add_option("--plot", options->plots, "Folder for a picture (SVG) of each benchmark that has curves");
  command->add_option("--page", options->page,
                      "File for a page (Markdown) with the results and their pictures; parts of other cases stay");
  command->add_flag("--quick", options->isQuick, "Only the benchmarks of the ordinary tests");
  command->add_flag("--list", options->isList, "Print the benchmarks with what they compare, and run none");
  command->callback([options, &status] { status = validate(*options); });
}

}  // namespace espalier::command
