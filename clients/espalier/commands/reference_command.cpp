#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/messages.h"
#include "engine/language/arithmetic.h"
#include "engine/turtle/interpretation/symbol_list.h"
#include "protocol/errors.h"
#include "protocol/json_writer.h"
#include "protocol/methods.h"
#include "protocol/roles.h"

namespace espalier::command {
namespace {

using protocol::JsonWriter;

/// A row for people, as two columns, and as an object for programs.
struct Row {
  std::string name;
  std::string meaning;
  std::string json;
};

std::vector<Row> functions() {
  std::vector<Row> rows;
  for (const language::FunctionInfo& each : language::allFunctions()) {
    JsonWriter json;
    json.beginObject().key("name").text(each.name).key("usage").text(each.usage).key("meaning").text(each.meaning);
    json.key("least").integer(std::uint32_t{each.least}).key("most").integer(std::uint32_t{each.most});
    json.key("isPure").boolean(each.isPure).endObject();
    rows.push_back({each.usage, each.meaning, json.take()});
  }
  for (const language::SpecialFunctionInfo& each : language::specialFunctions()) {
    JsonWriter json;
    json.beginObject().key("name").text(each.name).key("usage").text(each.usage).key("meaning").text(each.meaning);
    json.key("isPure").boolean(false).endObject();
    rows.push_back({each.usage, each.meaning, json.take()});
  }
  return rows;
}

std::vector<Row> symbols() {
  std::vector<Row> rows;
  for (const turtle::SymbolInfo& each : turtle::allSymbols()) {
    JsonWriter json;
    json.beginObject().key("name").text(each.text).key("usage").text(each.usage);
    json.key("meaning").text(each.meaning).endObject();
    rows.push_back({each.usage, each.meaning, json.take()});
  }
  return rows;
}

std::string_view answererOf(protocol::Answerer answerer) {
  switch (answerer) {
    case protocol::Answerer::Both:
      return "both sides";
    case protocol::Answerer::Server:
      return "the server";
    case protocol::Answerer::Environment:
      return "an environment";
    case protocol::Answerer::Nobody:
      return "(notification of the server)";
  }
  return "";
}

std::vector<Row> methods() {
  std::vector<Row> rows;
  for (const protocol::Method& each : protocol::methods()) {
    JsonWriter json;
    json.beginObject().key("name").text(each.name).key("answeredBy").text(answererOf(each.answerer));
    json.key("role").text(each.role == protocol::Role::Anyone ? "" : protocol::nameOf(each.role));
    json.key("meaning").text(each.summary).endObject();
    rows.push_back({std::string(each.name), std::string(each.summary), json.take()});
  }
  return rows;
}

std::vector<Row> errors() {
  std::vector<Row> rows;
  for (const protocol::ErrorInfo& each : protocol::allErrors()) {
    JsonWriter json;
    json.beginObject().key("code").integer(static_cast<std::int32_t>(each.code)).key("name").text(each.name);
    json.key("meaning").text(each.meaning).key("data").text(each.data).key("remedy").text(each.remedy).endObject();
    rows.push_back({std::to_string(static_cast<std::int32_t>(each.code)) + " " + std::string(each.name),
                    std::string(each.meaning) + ". Do: " + std::string(each.remedy), json.take()});
  }
  return rows;
}

struct Table {
  const char* name;
  std::vector<Row> (*rows)();
};

constexpr std::array kTables{Table{"functions", functions}, Table{"symbols", symbols}, Table{"methods", methods},
                             Table{"errors", errors}};

int reference(const std::string& name, bool isJson) {
  const auto* table = std::ranges::find(kTables, std::string_view(name), &Table::name);
  const std::vector<Row> rows = table->rows();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (isJson) {
      std::printf("%s%s%s", i == 0 ? "[" : ",\n ", rows[i].json.c_str(), i + 1 == rows.size() ? "]\n" : "");
    } else {
      std::printf("%s\t%s\n", rows[i].name.c_str(), rows[i].meaning.c_str());
    }
  }
  return kSuccess;
}

}  // namespace

void addReference(CLI::App& program, int& status) {
  struct Options {
    std::string table;
    bool isJson = false;
  };
  CLI::App* command = program.add_subcommand("reference", "Print a table: functions, turtle symbols, methods, errors");
  const auto options = std::make_shared<Options>();
  std::vector<std::string> names;
  for (const Table& table : kTables) {
    names.emplace_back(table.name);
  }
  command->add_option("table", options->table, "What to print")->required()->check(CLI::IsMember(names));
  command->add_flag("--json", options->isJson, "Print JSON, for programs");
  command->footer(
      "The tables that the program itself works with; the pages of the handbook are made from them. A tab stands "
      "between the columns, and `[!]` marks what surprises.\n"
      "Built-in environments: espalier environment --list. Formats: espalier run --help.");
  command->callback([options, &status] { status = reference(options->table, options->isJson); });
}

}  // namespace espalier::command
