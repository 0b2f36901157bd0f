#include "clients/espalier/sweep/run_table.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <unordered_map>

#include "clients/espalier/sweep/designs.h"
#include "engine/core/diagnostic.h"
#include "engine/core/number_text.h"

namespace espalier::command {
namespace {

constexpr std::string_view kSeed = "seed";
constexpr std::uint64_t kLastSeed = (std::uint64_t{1} << 53U) - 1;

/// Rows as a table or a plan gives them: values in the order of `names`, among them perhaps the seed.
struct GivenRows {
  std::vector<std::string> names;
  std::vector<std::vector<double>> rows;
  std::vector<std::string> places;  // of each row, for messages
};

std::vector<std::string_view> cellsOf(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  while (true) {
    const std::size_t end = line.find(separator);
    std::string_view cell = line.substr(0, end);
    const auto isEdge = [](char c) { return c == ' ' || c == '\r' || c == '\t' || c == '"'; };
    while (!cell.empty() && isEdge(cell.front())) {
      cell.remove_prefix(1);
    }
    while (!cell.empty() && isEdge(cell.back())) {
      cell.remove_suffix(1);
    }
    cells.push_back(cell);
    if (end == std::string_view::npos) {
      return cells;
    }
    line.remove_prefix(end + 1);
  }
}

Result<GivenRows> readTable(const std::string& file, std::string_view text) {
  if (text.substr(0, 3) == "\xEF\xBB\xBF") {
    text.remove_prefix(3);
  }
  GivenRows given;
  char separator = ',';
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    const std::string place = file + ":" + std::to_string(number);
    if (line.find_first_not_of(" \t\r") == std::string_view::npos || line.front() == '#') {
      continue;
    }
    if (given.names.empty()) {
      separator = line.find('\t') != std::string_view::npos  ? '\t'
                  : line.find(';') != std::string_view::npos ? ';'
                                                             : ',';
      for (const std::string_view cell : cellsOf(line, separator)) {
        given.names.emplace_back(cell);
        if (cell.empty() || std::count(given.names.begin(), given.names.end(), cell) > 1) {
          return problem(place + ": the column '" + std::string(cell) + "' has no name, or its name twice");
        }
      }
      continue;
    }
    const std::vector<std::string_view> cells = cellsOf(line, separator);
    if (cells.size() != given.names.size()) {
      return problem(place + ": the line has " + std::to_string(cells.size()) + " values, and the first line " +
                     std::to_string(given.names.size()) + " names: give a value for each name");
    }
    std::vector<double>& row = given.rows.emplace_back();
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const std::optional<double> value = core::parseNumber(cells[i]);
      if (!value || !std::isfinite(*value)) {
        return problem(place + ": '" + std::string(cells[i]) + "' in the column '" + given.names[i] +
                       "' is not a number: give a finite number in every cell" +
                       (cells[i].find(',') == std::string_view::npos ? "" : ", with a point and no comma"));
      }
      row.push_back(*value);
    }
    given.places.push_back(place);
  }
  if (given.rows.empty()) {
    return problem(file + ": the table has no rows: give a line of names, and a line of numbers for each run");
  }
  return given;
}

Result<GivenRows> rowsOfPlan(const Plan& plan) {
  GivenRows given;
  for (const auto& [name, value] : plan.design.rows.front()) {
    given.names.push_back(name);
  }
  for (std::size_t i = 0; i < plan.design.rows.size(); ++i) {
    const auto& row = plan.design.rows[i];
    const std::string place = "runs.rows[" + std::to_string(i) + "]";
    std::vector<double>& values = given.rows.emplace_back();
    for (const std::string& name : given.names) {
      const auto found = std::find_if(row.begin(), row.end(), [&](const auto& item) { return item.first == name; });
      if (found == row.end()) {
        return problem(place + ": the value of '" + name + "' is missing, which the first row has");
      }
      values.push_back(found->second);
    }
    if (row.size() != given.names.size()) {
      return problem(place + ": the row has other members than the first row");
    }
    given.places.push_back(place);
  }
  return given;
}

// the parameters of a plan that names none are the columns of its table
std::optional<std::string> matchColumns(Plan& plan, const GivenRows& given, const std::string& what) {
  std::vector<std::string_view> names{kSeed};
  if (plan.parameters.empty()) {
    for (const std::string& name : given.names) {
      if (name != kSeed) {
        plan.parameters.push_back({.name = name, .target = name});
      }
    }
  }
  for (const SweepParameter& parameter : plan.parameters) {
    names.push_back(parameter.name);
    if (std::find(given.names.begin(), given.names.end(), parameter.name) == given.names.end()) {
      return what + ": there is no column for the parameter '" + parameter.name +
             "'. Add it, or leave the parameter out";
    }
  }
  for (const std::string& name : given.names) {
    if (std::find(names.begin(), names.end(), name) == names.end()) {
      return what + ": there is no parameter '" + name + "'. " + core::suggestName(name, names);
    }
  }
  return std::nullopt;
}

// two rows with the same values: the second would only repeat the first
std::optional<std::string> whereRepeated(const RunTable& table, const std::vector<std::string>& places) {
  std::unordered_map<std::string, std::size_t> seen;
  for (std::size_t i = 0; i < table.count(); ++i) {
    const auto row = table.row(i);
    std::string key(reinterpret_cast<const char*>(row.data()), row.size() * sizeof(double));
    key += std::to_string(table.seeds[i]);
    const auto [place, isNew] = seen.emplace(std::move(key), i);
    if (!isNew) {
      return places[i] + ": the row repeats " + places[place->second] +
             ". Remove it, give it another seed, or ask for 'replicates'";
    }
  }
  return std::nullopt;
}

Result<RunTable> tableOf(Plan& plan, const GivenRows& given, const std::string& what) {
  if (const auto mistake = matchColumns(plan, given, what)) {
    return problem(*mistake);
  }
  const auto columnOf = [&](std::string_view name) {
    return static_cast<std::size_t>(std::find(given.names.begin(), given.names.end(), name) - given.names.begin());
  };
  const std::size_t seedColumn = columnOf(kSeed);
  const bool hasSeeds = seedColumn < given.names.size();
  if (hasSeeds && plan.replicates > 1) {
    return problem(what + ": the rows have seeds of their own: leave out the column 'seed' or the member 'replicates'");
  }
  RunTable table{.values = {}, .seeds = {}, .columns = plan.parameters.size()};
  std::vector<std::size_t> columns;
  for (const SweepParameter& parameter : plan.parameters) {
    columns.push_back(columnOf(parameter.name));
  }
  for (std::size_t i = 0; i < given.rows.size(); ++i) {
    for (const std::size_t column : columns) {
      table.values.push_back(given.rows[i][column]);
    }
    const double seed = hasSeeds ? given.rows[i][seedColumn] : static_cast<double>(plan.seed);
    if (!(seed >= 0.0 && seed <= static_cast<double>(kLastSeed)) || std::floor(seed) != seed) {
      return problem(given.places[i] + ": a seed is a whole number from 0 to 2^53 - 1");
    }
    table.seeds.push_back(static_cast<std::uint64_t>(seed));
  }
  if (const auto mistake = whereRepeated(table, given.places)) {
    return problem(*mistake);
  }
  return table;
}

RunTable replicated(const RunTable& sets, const Plan& plan) {
  RunTable table{.values = {}, .seeds = {}, .columns = sets.columns};
  for (std::size_t set = 0; set < sets.count(); ++set) {
    for (std::uint64_t replicate = 0; replicate < plan.replicates; ++replicate) {
      const auto row = sets.row(set);
      table.values.insert(table.values.end(), row.begin(), row.end());
      const std::uint64_t run = set * plan.replicates + replicate;
      table.seeds.push_back((plan.firstSeed + (plan.haveCommonSeeds ? replicate : run)) & kLastSeed);
    }
  }
  return table;
}

}  // namespace

Result<Slice> readSlice(std::string_view text) {
  Slice slice;
  const char* const end = text.data() + text.size();
  const auto [slash, error] = std::from_chars(text.data(), end, slice.index);
  if (error == std::errc() && slash != end && *slash == '/') {
    const auto [last, second] = std::from_chars(slash + 1, end, slice.count);
    if (second == std::errc() && last == end && slice.index >= 1 && slice.index <= slice.count) {
      slice.index %= slice.count;
      return slice;
    }
  }
  return problem("'" + std::string(text) + "' is not a slice: give k/n, as 3/64, with k from 1 to n");
}

Result<RunTable> makeRuns(Plan& plan, const std::string& folder, core::FileProvider& files) {
  using Kind = Design::Kind;
  Result<RunTable> table;
  if (plan.design.kind == Kind::Table || plan.design.kind == Kind::Rows) {
    const bool isFile = plan.design.kind == Kind::Table;
    std::string name = plan.design.file;
    if (isFile && !name.starts_with('/') && !folder.empty()) {
      name = folder + "/" + name;
    }
    Result<GivenRows> given;
    if (isFile) {
      const std::optional<std::string> text = files.read(name);
      if (!text) {
        return problem("runs.table: there is no file '" + name + "': check the name; it is relative to the plan");
      }
      given = readTable(name, *text);
    } else {
      given = rowsOfPlan(plan);
    }
    if (!given) {
      return problem(given.error());
    }
    table = tableOf(plan, *given, isFile ? name : "runs.rows");
    if (!table) {
      return table;
    }
  } else {
    if (plan.design.kind == Kind::Single && !plan.parameters.empty()) {
      return problem("runs: missing: give a table, rows or a design for the parameters");
    }
    Result<DesignPoints> points = designValues(plan.design, plan.parameters);
    if (!points) {
      return problem(points.error());
    }
    table->columns = plan.parameters.size();
    const std::size_t count = plan.design.kind == Kind::Single ? 1 : points->count();
    table->values = std::move(points->values);
    table->seeds.assign(count, plan.seed);
    if (plan.replicates == 1 && !plan.haveCommonSeeds) {
      return replicated(*table, plan);
    }
  }
  return plan.replicates > 1 ? replicated(*table, plan) : table;
}

}  // namespace espalier::command
