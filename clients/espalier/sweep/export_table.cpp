#include "clients/espalier/sweep/export_table.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <system_error>

#include "clients/espalier/sweep/results.h"
#include "engine/core/number_text.h"
#include "server/remote/disk_files.h"

namespace espalier::command {
namespace {

void addNumber(std::string& line, double value) {
  if (!std::isnan(value)) {
    core::appendNumber(line, value, core::NumberStyle::Shortest);
  }
}

// a text as a cell: in quotes when it has a separator, a quote or a line end
std::string cellOf(const std::string& text, char separator) {
  if (text.find_first_of(std::string("\"\r\n") + separator) == std::string::npos) {
    return text;
  }
  std::string cell = "\"";
  for (const char c : text) {
    cell += c == '"' ? "\"\"" : std::string(1, c);
  }
  return cell + "\"";
}

std::string headerOf(const SweepDescription& description, char separator) {
  std::string line = "run";
  line += separator;
  line += "seed";
  for (const auto* list : {&description.parameters, &description.measures}) {
    for (const std::string& name : *list) {
      line += separator + cellOf(name, separator);
    }
  }
  return line + separator + "error\n";
}

std::string lineOf(const ResultRow& row, char separator) {
  std::string line = std::to_string(row.run) + separator + std::to_string(row.seed);
  for (const auto* values : {&row.parameters, &row.outcome.values}) {
    for (const double value : *values) {
      line += separator;
      addNumber(line, value);
    }
  }
  return line + separator + cellOf(row.outcome.error, separator) + "\n";
}

bool isSame(const ResultRow& a, const ResultRow& b) {
  return lineOf(a, ',') == lineOf(b, ',');
}

std::string missingText(const SweepDescription& description, std::uint64_t count) {
  return std::to_string(description.runs - count) + " of " + std::to_string(description.runs) + " runs";
}

}  // namespace

std::optional<std::string> exportTable(const std::string& file, const std::string& output, bool isPartial) {
  Result<SweepResults> results = SweepResults::existing(file);
  if (!results) {
    return results.error();
  }
  std::error_code error;
  if (std::filesystem::equivalent(file, output, error)) {
    return "'" + output + "' holds the results: give the table another name, such as results.csv";
  }
  const Result<std::uint64_t> count = results->count();
  if (!count) {
    return count.error();
  }
  if (*count < results->description().runs && !isPartial) {
    return "'" + file + "' lacks " + missingText(results->description(), *count) +
           ": run the plan again, which makes them, merge the other slices, or export with --partial";
  }
  const char separator = output.ends_with(".tsv") ? '\t' : ',';
  std::unique_ptr<server::AtomicFile> target;
  if (!output.empty()) {
    target = std::make_unique<server::AtomicFile>(output);
  }
  const auto write = [&](const std::string& text) {
    if (target) {
      target->write(text);
      return true;
    }
    return std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
  };
  write(headerOf(results->description(), separator));
  bool isOpen = true;
  const auto problem = results->visit([&](const ResultRow& row) { return isOpen = write(lineOf(row, separator)); });
  if (problem) {
    return problem;
  }
  if (!isOpen) {
    return "the table could not be written to standard output";
  }
  return target ? target->commit() : std::nullopt;
}

std::optional<std::string> mergeResults(const std::vector<std::string>& files, const std::string& output) {
  std::optional<SweepResults> merged;
  for (const std::string& file : files) {
    if (file == output) {
      return "'" + file + "' is given twice, as a part and as the output: give another output";
    }
    Result<SweepResults> part = SweepResults::existing(file);
    if (!part) {
      return part.error();
    }
    if (!merged) {
      Result<SweepResults> made = SweepResults::continued(output, part->description());
      if (!made) {
        return made.error();
      }
      merged.emplace(std::move(*made));
    } else if (const auto difference = differenceOf(merged->description(), part->description()); !difference.empty()) {
      return "'" + file + "' is no part of the sweep of '" + files.front() + "': " + difference +
             ". Make it again with the plan, the model and the program of the others";
    }
    // rows that are there already are compared, the others are added
    const Result<std::vector<bool>> finished = merged->finishedRuns();
    if (!finished) {
      return finished.error();
    }
    std::vector<ResultRow> rows;
    std::vector<ResultRow> again;
    auto problem = part->visit([&](const ResultRow& row) {
      ((*finished)[row.run] ? again : rows).push_back(row);
      return true;
    });
    if (!problem && !again.empty()) {
      auto next = again.begin();
      std::string differs;
      problem = merged->visit([&](const ResultRow& row) {
        if (row.run == next->run) {
          if (!isSame(row, *next)) {
            differs = "run " + std::to_string(row.run) + " of '" + file +
                      "' differs from the same run of another part: one of them comes from another program or model";
          }
          ++next;
        }
        return next != again.end() && differs.empty();
      });
      problem = differs.empty() ? problem : std::optional(differs);
    }
    problem = problem ? problem : merged->add(rows);
    if (problem) {
      return problem;
    }
  }
  return std::nullopt;
}

bool printTable(const Plan& plan, const RunTable& table) {
  std::string text = "run,seed";
  for (const SweepParameter& parameter : plan.parameters) {
    text += "," + cellOf(parameter.name, ',');
  }
  text += "\n";
  for (std::size_t i = 0; i < table.count(); ++i) {
    text += std::to_string(i + 1) + "," + std::to_string(table.seeds[i]);
    for (const double value : table.row(i)) {
      text += ",";
      addNumber(text, value);
    }
    text += "\n";
    if (text.size() > 60'000 || i + 1 == table.count()) {
      if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size()) {
        return false;
      }
      text.clear();
    }
  }
  return true;
}

}  // namespace espalier::command
