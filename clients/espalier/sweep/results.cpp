#include "clients/espalier/sweep/results.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "engine/core/hash.h"
#include "server/store/database.h"

namespace espalier::command {
namespace {

using server::Database;

constexpr const char* kVersion = "espalier sweep 1";
constexpr double kEmptyCell = std::numeric_limits<double>::quiet_NaN();

std::string quoted(const std::string& name) {
  std::string text = "\"";
  for (const char c : name) {
    text += c == '"' ? "\"\"" : std::string(1, c);
  }
  return text + "\"";
}

std::string textOf(const std::vector<std::string>& names) {
  return nlohmann::json(names).dump();
}

std::vector<std::string> namesOf(const std::string& text) {
  std::vector<std::string> names;
  for (const auto& name : nlohmann::json::parse(text, nullptr, false)) {
    names.push_back(name.is_string() ? name.get<std::string>() : "");
  }
  return names;
}

// SQLite's words for the two usual failures, in ours
std::string sentenceOf(const std::string& file, const std::string& problem) {
  if (problem.find("locked") != std::string::npos) {
    return "another program has '" + file + "' open: wait for its end, or give another file";
  }
  if (problem.find("disk is full") != std::string::npos) {
    return "the disk of '" + file + "' is full: make room, and the same command continues";
  }
  if (problem.find("disk I/O error") != std::string::npos) {
    return "'" + file + "' cannot be written further: check the disk and its limits, and the same command continues";
  }
  if (problem.find("unable to open") != std::string::npos) {
    return "'" + file + "' cannot be opened: give the name of a file in a folder that exists";
  }
  if (problem.find("not a database") != std::string::npos) {
    return "'" + file + "' is no file of results: give another name";
  }
  if (problem.find("malformed") != std::string::npos) {
    return "'" + file + "' is damaged, or was copied without '" + file +
           "-wal', which holds the last runs of a sweep that was stopped: copy both, or make the runs anew into "
           "another file";
  }
  return "'" + file + "': " + problem;
}

// a database cannot hold two columns whose names differ only in letter case
std::optional<std::string> whereNamesClash(const SweepDescription& description) {
  std::vector<std::string> names{"run", "seed", "error", "seconds"};
  for (const auto* list : {&description.parameters, &description.measures}) {
    for (const std::string& name : *list) {
      std::string small = name;
      std::transform(small.begin(), small.end(), small.begin(), [](unsigned char c) { return std::tolower(c); });
      if (std::find(names.begin(), names.end(), small) != names.end()) {
        return "the results have two columns '" + name +
               "' (letter case aside): give the measure or the parameter another name";
      }
      names.push_back(std::move(small));
    }
  }
  constexpr std::size_t kMostColumns = 1900;  // SQLite has 2000
  if (names.size() > kMostColumns) {
    return "the results have " + std::to_string(names.size()) + " columns, more than " + std::to_string(kMostColumns) +
           ": give fewer measures";
  }
  return std::nullopt;
}

}  // namespace

/// The open file.
struct SweepResults::State {
  std::string file;
  Database database;
  SweepDescription description;
  std::unique_ptr<Database::Statement> insert;

  [[nodiscard]] std::string problem() const { return sentenceOf(file, database.problem().value_or("")); }

  void make() {
    std::string columns;
    for (const auto* list : {&description.parameters, &description.measures}) {
      for (const std::string& name : *list) {
        columns += ", " + quoted(name) + " REAL";
      }
    }
    database.begin();
    database.execute("CREATE TABLE sweep(name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID");
    database.execute(("CREATE TABLE runs(run INTEGER PRIMARY KEY, seed INTEGER NOT NULL" + columns +
                      ", error TEXT, seconds REAL NOT NULL)")
                         .c_str());
    Database::Statement write(database, "INSERT INTO sweep(name, value) VALUES(?, ?)");
    const std::pair<const char*, std::string> rows[] = {{"format", kVersion},
                                                        {"plan", description.plan},
                                                        {"identity", description.identity},
                                                        {"parameters", textOf(description.parameters)},
                                                        {"measures", textOf(description.measures)},
                                                        {"runs", std::to_string(description.runs)},
                                                        {"table", description.table}};
    for (const auto& [name, value] : rows) {
      write.bind(1, std::string_view(name)).bind(2, std::string_view(value));
      write.run();
      write.reset();
    }
    static_cast<void>(database.commit());
  }

  // false: the file holds no sweep
  bool read() {
    Database::Statement find(database, "SELECT name, value FROM sweep");
    bool isOurs = false;
    while (find.next()) {
      const std::string name(find.text(0));
      const std::string value(find.text(1));
      isOurs = isOurs || (name == "format" && value == kVersion);
      if (name == "plan") {
        description.plan = value;
      } else if (name == "identity") {
        description.identity = value;
      } else if (name == "parameters") {
        description.parameters = namesOf(value);
      } else if (name == "measures") {
        description.measures = namesOf(value);
      } else if (name == "runs") {
        description.runs = std::strtoull(value.c_str(), nullptr, 10);
      } else if (name == "table") {
        description.table = value;
      }
    }
    return isOurs && !database.problem();
  }

  bool isEmpty() {
    Database::Statement find(database, "SELECT count(*) FROM sqlite_master");
    return find.next() && find.integer(0) == 0;
  }
};

SweepResults::SweepResults(std::unique_ptr<State> state) : state_(std::move(state)) {}
SweepResults::~SweepResults() = default;
SweepResults::SweepResults(SweepResults&&) noexcept = default;

Result<SweepResults> SweepResults::continued(const std::string& file, const SweepDescription& description) {
  if (const auto clash = whereNamesClash(description)) {
    return problem(*clash);
  }
  auto state = std::make_unique<State>();
  state->file = file;
  state->database.open(file, Database::Access::Exclusive);
  if (!state->database.problem() && state->isEmpty()) {
    state->description = description;
    state->make();
  }
  if (state->database.problem()) {
    return problem(state->problem());
  }
  if (!state->read()) {
    return problem("'" + file + "' is no file of results: give another name");
  }
  if (const std::string difference = differenceOf(state->description, description); !difference.empty()) {
    return problem("'" + file + "' holds the results of another sweep: " + difference +
                   ". Give another file, or remove this one");
  }
  return SweepResults(std::move(state));
}

Result<SweepResults> SweepResults::existing(const std::string& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    return problem("there is no file '" + file + "': give the results of `espalier sweep PLAN.json -o FILE`");
  }
  auto state = std::make_unique<State>();
  state->file = file;
  state->database.open(file, Database::Access::Exclusive);
  if (!state->database.problem() && (state->isEmpty() || !state->read()) && !state->database.problem()) {
    return problem("'" + file + "' is no file of results: give one that `espalier sweep` has written");
  }
  if (state->database.problem()) {
    const bool isForeign = state->database.problem()->find("no such table") != std::string::npos;
    return problem(isForeign ? "'" + file + "' is no file of results: give one that `espalier sweep` has written"
                             : state->problem());
  }
  return SweepResults(std::move(state));
}

const SweepDescription& SweepResults::description() const {
  return state_->description;
}

Result<std::vector<bool>> SweepResults::finishedRuns() {
  std::vector<bool> finished(state_->description.runs + 1);
  Database::Statement find(state_->database, "SELECT run FROM runs");
  while (find.next()) {
    const auto run = static_cast<std::uint64_t>(find.integer(0));
    if (run < finished.size()) {
      finished[run] = true;
    }
  }
  return state_->database.problem() ? Result<std::vector<bool>>(problem(state_->problem())) : finished;
}

Result<std::uint64_t> SweepResults::count() {
  Database::Statement find(state_->database, "SELECT count(*) FROM runs");
  const std::uint64_t count = find.next() ? static_cast<std::uint64_t>(find.integer(0)) : 0;
  return state_->database.problem() ? Result<std::uint64_t>(problem(state_->problem())) : count;
}

std::optional<std::string> SweepResults::add(const std::vector<ResultRow>& rows) {
  Database& database = state_->database;
  if (!state_->insert) {
    std::string marks = "?, ?";
    for (std::size_t i = 0; i < state_->description.parameters.size() + state_->description.measures.size(); ++i) {
      marks += ", ?";
    }
    state_->insert =
        std::make_unique<Database::Statement>(database, ("INSERT INTO runs VALUES(" + marks + ", ?, ?)").c_str());
  }
  database.begin();
  Database::Statement& insert = *state_->insert;
  for (const ResultRow& row : rows) {
    int column = 0;
    insert.bind(++column, static_cast<std::int64_t>(row.run));
    insert.bind(++column, static_cast<std::int64_t>(row.seed));
    for (const double value : row.parameters) {
      insert.bind(++column, value);
    }
    for (const double value : row.outcome.values) {
      ++column;
      std::isnan(value) ? insert.bindNull(column) : insert.bind(column, value);
    }
    ++column;
    row.outcome.error.empty() ? insert.bindNull(column) : insert.bind(column, std::string_view(row.outcome.error));
    insert.bind(++column, row.outcome.seconds);
    insert.run();
    insert.reset();
  }
  if (!database.commit()) {
    return state_->problem();
  }
  return std::nullopt;
}

std::optional<std::string> SweepResults::visit(const std::function<bool(const ResultRow&)>& visit) {
  Database::Statement find(state_->database, "SELECT * FROM runs ORDER BY run");
  const std::size_t parameterCount = state_->description.parameters.size();
  const std::size_t measureCount = state_->description.measures.size();
  ResultRow row;
  row.parameters.resize(parameterCount);
  row.outcome.values.resize(measureCount);
  while (find.next()) {
    int column = 0;
    row.run = static_cast<std::uint64_t>(find.integer(column++));
    row.seed = static_cast<std::uint64_t>(find.integer(column++));
    for (double& value : row.parameters) {
      value = find.real(column++);
    }
    for (double& value : row.outcome.values) {
      value = find.isNull(column) ? kEmptyCell : find.real(column);
      ++column;
    }
    row.outcome.error = find.isNull(column) ? std::string() : std::string(find.text(column));
    row.outcome.seconds = find.real(column + 1);
    if (!visit(row)) {
      break;
    }
  }
  return state_->database.problem() ? std::optional(state_->problem()) : std::nullopt;
}

std::string differenceOf(const SweepDescription& a, const SweepDescription& b) {
  if (a.plan != b.plan) {
    return "its plan differs";
  }
  if (a.identity != b.identity) {
    return "the model, its environment or the version of the program differs";
  }
  if (!(a == b)) {
    return "its table of runs differs";
  }
  return {};
}

SweepDescription describeSweep(const SweptModel& model, const RunTable& table) {
  SweepDescription description;
  description.plan = model.plan().text;
  description.identity = model.identity();
  for (const SweepParameter& parameter : model.plan().parameters) {
    description.parameters.push_back(parameter.name);
  }
  description.measures = model.measureColumns();
  description.runs = table.count();
  core::Hasher hash;
  for (const double value : table.values) {
    hash.number(value);
  }
  for (const std::uint64_t seed : table.seeds) {
    hash.integer(seed);
  }
  description.table = std::to_string(hash.value());
  return description;
}

}  // namespace espalier::command
