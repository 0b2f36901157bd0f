#include "server/language_server/language_server.h"

#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "engine/core/streams.h"
#include "engine/core/work_meter.h"

namespace espalier::server::language_server_test {
namespace {

using Json = nlohmann::json;

const std::string kTree =
    "#define R 0.7\n"                                             // line 0
    "#define GROW(x) (x * R)\n"                                   // 1
    "Lsystem: 1\n"                                                // 2
    "derivation length: 3\n"                                      // 3
    "Start: { age = 0; }\n"                                       // 4
    "StartEach: { age = age + 1; }\n"                             // 5
    "Axiom: A(1)\n"                                               // 6
    "A(len) : len > R --> F(len)[+(30)A(GROW(len))]A(len * R)\n"  // 7
    "F(l) --> F(l + age)\n"                                       // 8
    "endlsystem\n";

/// A language server with the files of a map, and an editor that talks to it.
class Editor {
 public:
  explicit Editor(const std::map<std::string, std::string>& files = {}) : files_(files), server_(files_) {
    ask("initialize", {{"capabilities", Json::object()}});
  }
  Editor(const Editor&) = delete;

  /// The result of a request; a failure is an object with `code` and `message`.
  Json ask(const std::string& method, const Json& parameters) {
    const Json request{{"jsonrpc", "2.0"}, {"id", ++id_}, {"method", method}, {"params", parameters}};
    Json result;
    for (const std::string& text : server_.receive(request.dump())) {
      const Json message = Json::parse(text);
      if (message.contains("id")) {
        EXPECT_EQ(message["id"], id_);
        result = message.contains("error") ? message["error"] : message["result"];
      }
    }
    return result;
  }

  void tell(const std::string& method, const Json& parameters) {
    const Json notification{{"jsonrpc", "2.0"}, {"method", method}, {"params", parameters}};
    for (const std::string& text : server_.receive(notification.dump())) {
      const Json message = Json::parse(text);
      if (message["method"] == "textDocument/publishDiagnostics") {
        diagnostics_[message["params"]["uri"]] = message["params"]["diagnostics"];
      }
    }
  }

  void open(const std::string& uri, const std::string& text) {
    tell("textDocument/didOpen",
         {{"textDocument", {{"uri", uri}, {"languageId", "espalier"}, {"version", 1}, {"text", text}}}});
  }

  /// Replaces the characters from one place to another of a line.
  void change(const std::string& uri, int line, int from, int to, const std::string& text) {
    tell(
        "textDocument/didChange",
        {{"textDocument", {{"uri", uri}, {"version", ++version_}}},
         {"contentChanges",
          {{{"range", {{"start", {{"line", line}, {"character", from}}}, {"end", {{"line", line}, {"character", to}}}}},
            {"text", text}}}}});
  }

  Json at(const std::string& method, int line, int column, Json more = Json::object(),
          const std::string& uri = "file:///tree.l") {
    more["textDocument"]["uri"] = uri;
    more["position"] = {{"line", line}, {"character", column}};
    return ask("textDocument/" + method, more);
  }

  std::string hover(int line, int column) {
    const Json result = at("hover", line, column);
    return result.is_null() ? "" : result["contents"]["value"].get<std::string>();
  }

  const Json& diagnostics(const std::string& uri = "file:///tree.l") { return diagnostics_[uri]; }
  LanguageServer& server() { return server_; }

 private:
  core::MemoryFileProvider files_;
  LanguageServer server_;
  int id_ = 0;
  int version_ = 1;
  std::map<std::string, Json> diagnostics_;
};

struct TreeEditor : Editor {
  TreeEditor() { open("file:///tree.l", kTree); }
};

/// "line:column" of the beginnings of some locations or ranges.
std::vector<std::string> placesOf(const Json& locations) {
  std::vector<std::string> places;
  for (const Json& location : locations) {
    const Json& start = location["range"]["start"];
    places.push_back(start["line"].dump() + ":" + start["character"].dump());
  }
  return places;
}

TEST(LanguageServer, AMistakeIsMarkedWhereItIsAndVanishesWhenItIsMended) {
  TreeEditor editor;
  EXPECT_TRUE(editor.diagnostics().empty()) << editor.diagnostics();
  editor.change("file:///tree.l", 8, 15, 18, "aeg");
  ASSERT_EQ(editor.diagnostics().size(), 1U);
  const Json& mistake = editor.diagnostics()[0];
  EXPECT_EQ(mistake["severity"], 2);
  EXPECT_EQ(mistake["range"]["start"], Json({{"line", 8}, {"character", 15}}));
  EXPECT_EQ(mistake["range"]["end"], Json({{"line", 8}, {"character", 18}}));
  EXPECT_NE(mistake["message"].get<std::string>().find("did you mean 'age'?"), std::string::npos);
  editor.change("file:///tree.l", 8, 15, 18, "age");
  EXPECT_TRUE(editor.diagnostics().empty());
}

TEST(LanguageServer, ColumnsAreCountedAsTheEditorCounts) {
  Editor editor;
  // the comment has a character of two units (🌱) and one of two bytes (é)
  editor.open("file:///a.l",
              "Lsystem: 1\nderivation length: 1\nAxiom: F(1)\n/* \U0001F331é */ F(x) --> F(y)\nendlsystem\n");
  ASSERT_EQ(editor.diagnostics("file:///a.l").size(), 1U);
  EXPECT_EQ(editor.diagnostics("file:///a.l")[0]["range"]["start"]["character"], 21);
}

TEST(LanguageServer, AMistakeOfAnIncludedFileIsShownThere) {
  Editor editor(std::map<std::string, std::string>{{"/lib/rules.h", "A --> B(\n"}});
  editor.open("file:///lib/tree.l", "Lsystem: 1\nderivation length: 1\nAxiom: A\n#include \"rules.h\"\nendlsystem\n");
  EXPECT_TRUE(editor.diagnostics("file:///lib/tree.l").empty());
  ASSERT_EQ(editor.diagnostics("file:///lib/rules.h").size(), 1U);
  // the open text stands in for the file
  editor.open("file:///lib/rules.h", "A --> B\n");
  EXPECT_TRUE(editor.diagnostics("file:///lib/rules.h").empty());
}

TEST(LanguageServer, HoverExplainsSymbolsFunctionsMacrosAndNames) {
  TreeEditor editor;
  EXPECT_NE(editor.hover(7, 22).find("the turtle advances"), std::string::npos) << editor.hover(7, 22);
  EXPECT_NE(editor.hover(7, 28).find("turn left"), std::string::npos) << editor.hover(7, 28);
  EXPECT_NE(editor.hover(7, 16).find("#define R 0.7"), std::string::npos) << editor.hover(7, 16);
  EXPECT_NE(editor.hover(7, 34).find("A(len) : len > R"), std::string::npos) << editor.hover(7, 34);
  EXPECT_NE(editor.hover(8, 15).find("variable of the L-system"), std::string::npos);
  EXPECT_NE(editor.hover(8, 12).find("parameter"), std::string::npos);
  EXPECT_EQ(editor.hover(9, 0), "");
  editor.open("file:///tree.l", "Lsystem: 1\nderivation length: 1\nAxiom: @Gs(1)F(sqrt(4))@M(1,2)\nendlsystem\n");
  EXPECT_NE(editor.hover(2, 8).find("Hermite"), std::string::npos) << editor.hover(2, 8);
  EXPECT_NE(editor.hover(2, 24).find("set the position"), std::string::npos) << editor.hover(2, 24);
  EXPECT_NE(editor.hover(2, 16).find("sqrt"), std::string::npos);
}

TEST(LanguageServer, DefinitionsAndReferencesAreFound) {
  TreeEditor editor;
  EXPECT_EQ(placesOf(editor.at("definition", 7, 16)), (std::vector<std::string>{"0:8"}));
  EXPECT_EQ(placesOf(editor.at("definition", 8, 15)), (std::vector<std::string>{"4:9"}));
  EXPECT_EQ(placesOf(editor.at("definition", 6, 7)), (std::vector<std::string>{"7:0"}));
  EXPECT_EQ(placesOf(editor.at("definition", 8, 11)), (std::vector<std::string>{"8:2"}));
  EXPECT_EQ(placesOf(editor.at("references", 0, 8, {{"context", {{"includeDeclaration", true}}}})),
            (std::vector<std::string>{"0:8", "1:21", "7:15", "7:54"}));
  EXPECT_EQ(placesOf(editor.at("documentHighlight", 4, 9)), (std::vector<std::string>{"4:9", "5:13", "5:19", "8:15"}));
}

TEST(LanguageServer, RenamesWhatMeansTheSame) {
  TreeEditor editor;
  const auto edits = [&](int line, int column, const char* name) {
    return placesOf(editor.at("rename", line, column, {{"newName", name}})["changes"]["file:///tree.l"]);
  };
  EXPECT_EQ(edits(4, 9, "time"), (std::vector<std::string>{"4:9", "5:13", "5:19", "8:15"}));
  EXPECT_EQ(edits(0, 8, "RATIO"), (std::vector<std::string>{"0:8", "1:21", "7:15", "7:54"}));
  EXPECT_EQ(edits(8, 2, "size"), (std::vector<std::string>{"8:2", "8:11"}));
  EXPECT_EQ(edits(6, 7, "B"), (std::vector<std::string>{"6:7", "7:0", "7:33", "7:46"}));
}

TEST(LanguageServer, RefusesARenameThatWouldChangeTheMeaning) {
  TreeEditor editor;
  const auto refusal = [&](int line, int column, const char* name) {
    return editor.at("rename", line, column, {{"newName", name}}).value("message", "");
  };
  EXPECT_NE(refusal(8, 2, "age").find("another meaning"), std::string::npos);
  EXPECT_NE(refusal(4, 9, "R").find("another meaning"), std::string::npos);
  EXPECT_NE(refusal(4, 9, "2x").find("begins with no digit"), std::string::npos);
  EXPECT_NE(refusal(6, 7, "F").find("symbol of the turtle"), std::string::npos);
  EXPECT_NE(refusal(7, 21, "B").find("symbol of the turtle"), std::string::npos);
  EXPECT_NE(refusal(6, 7, "Apex").find("one letter"), std::string::npos);
  EXPECT_NE(refusal(9, 0, "x").find("no name here"), std::string::npos);
  // a macro brings the name: nobody can say what the reader means
  editor.open(
      "file:///tree.l",
      "#define TWICE len * 2\nLsystem: 1\nderivation length: 1\nAxiom: A(1)\nA(len) --> A(TWICE)\nendlsystem\n");
  EXPECT_NE(refusal(4, 2, "size").find("the macro 'TWICE' brings the name"), std::string::npos);
}

TEST(LanguageServer, CompletesNamesFunctionsAndSections) {
  TreeEditor editor;
  std::set<std::string> labels;
  for (const Json& item : editor.at("completion", 8, 14)) {
    labels.insert(item["label"]);
  }
  for (const char* wanted : {"R", "GROW", "age", "l", "sqrt", "StartEach:"}) {
    EXPECT_TRUE(labels.contains(wanted)) << wanted;
  }
  EXPECT_FALSE(labels.contains("len")) << "the parameter of another production";
}

TEST(LanguageServer, LaysOutAModel) {
  Editor editor;
  editor.open("file:///a.l", "Lsystem: 1\nderivation length: 1\nAxiom: A(1)\nA(x):x>1-->F( x )A(x)\nendlsystem\n");
  const Json edits = editor.ask("textDocument/formatting", {{"textDocument", {{"uri", "file:///a.l"}}}});
  ASSERT_EQ(edits.size(), 1U);
  EXPECT_NE(edits[0]["newText"].get<std::string>().find("A(x) : x > 1 --> F(x)A(x)"), std::string::npos);
  editor.open("file:///a.l", "Lsystem: 1\nAxiom: A(\nendlsystem\n");
  EXPECT_NE(editor.ask("textDocument/formatting", {{"textDocument", {{"uri", "file:///a.l"}}}})
                .value("message", "")
                .find("correct them"),
            std::string::npos);
}

TEST(LanguageServer, ListsMacrosAndProductions) {
  TreeEditor editor;
  std::vector<std::string> names;
  for (const Json& symbol :
       editor.ask("textDocument/documentSymbol", {{"textDocument", {{"uri", "file:///tree.l"}}}})) {
    names.push_back(symbol["name"]);
  }
  EXPECT_EQ(names, (std::vector<std::string>{"R", "GROW", "A(len) : len > R", "F(l)"}));
}

TEST(LanguageServer, ColoursTokensInTheOrderOfTheText) {
  Editor editor;
  editor.open("file:///a.l", "/* a\nb */\nLsystem: 1\nderivation length: 1\nAxiom: F(2)\nendlsystem\n");
  const Json data =
      editor.ask("textDocument/semanticTokens/full", {{"textDocument", {{"uri", "file:///a.l"}}}})["data"];
  // line, column (both from the token before), length, type: two lines of a comment, then Lsystem: and 1, ...
  EXPECT_EQ(data, Json({0, 0,  4, 0, 0, 1, 0, 4, 0, 0, 1, 0, 8, 3, 0, 0, 9, 1, 2, 0, 1, 0, 18, 3, 0,
                        0, 19, 1, 2, 0, 1, 0, 6, 3, 0, 0, 7, 1, 8, 0, 0, 2, 1, 2, 0, 1, 0, 10, 3, 0}));
}

TEST(LanguageServer, ForeignModelsAreChecked) {
  Editor editor;
  editor.open("file:///koch.l", "axiom: F\nF -> F+F--F+F\nangle: sixty\n");
  EXPECT_FALSE(editor.diagnostics("file:///koch.l").empty());
  EXPECT_EQ(editor.at("hover", 1, 0, Json::object(), "file:///koch.l"), Json());
}

TEST(LanguageServer, WrongMessagesGetAnErrorAndDoNoHarm) {
  TreeEditor editor;
  EXPECT_EQ(editor.ask("textDocument/hover", Json::array())["code"], -32602);
  EXPECT_EQ(editor.ask("textDocument/hover", {{"textDocument", 3}})["code"], -32602);
  EXPECT_EQ(editor.ask("no/such", Json::object())["code"], -32601);
  EXPECT_EQ(editor.at("hover", 4000000, 4000000), Json());
  EXPECT_EQ(editor.at("hover", 0, 0, Json::object(), "file:///unknown.l"), Json());
  EXPECT_EQ(Json::parse(editor.server().receive("{").at(0))["error"]["code"], -32700);
  EXPECT_EQ(Json::parse(editor.server().receive("[1]").at(0))["error"]["code"], -32600);
  editor.tell("textDocument/didChange", {{"textDocument", {{"uri", "file:///unknown.l"}}}});
  editor.tell("textDocument/didOpen", {{"textDocument", 1}});
  EXPECT_EQ(placesOf(editor.at("definition", 7, 16)), (std::vector<std::string>{"0:8"}));
}

TEST(LanguageServer, AMessageThatIsNestedDeeplyGetsAnError) {
  TreeEditor editor;
  constexpr std::size_t kDepth = 500'000;  // recursion over it would overflow the stack
  const std::string deep = std::string(kDepth, '[') + std::string(kDepth, ']');
  for (const std::string& text :
       {R"({"id":)" + deep + "}", R"({"id":1,"method":"shutdown","params":)" + deep + "}", deep}) {
    const Json answer = Json::parse(editor.server().receive(text).at(0));
    EXPECT_EQ(answer["error"]["code"], -32700);
    EXPECT_NE(answer["error"]["message"].get<std::string>().find("nested more than 100 deep"), std::string::npos);
  }
  EXPECT_EQ(placesOf(editor.at("definition", 7, 16)), (std::vector<std::string>{"0:8"}));
}

/// Work that is to stop after so many looks.
class BoundedWork final : public core::WorkMeter {
 public:
  explicit BoundedWork(std::size_t bound) : bound_(bound) {}
  [[nodiscard]] bool take(std::int64_t) noexcept override { return true; }
  [[nodiscard]] bool isStopped() const noexcept override { return ++looks_ > bound_; }
  [[nodiscard]] std::size_t looks() const { return looks_; }

 private:
  std::size_t bound_;
  mutable std::size_t looks_ = 0;
};

TEST(LanguageServer, EveryRequestCanBeStoppedAndTheNextOneIsAnswered) {
  TreeEditor editor;
  const Json place{{"textDocument", {{"uri", "file:///tree.l"}}},
                   {"position", {{"line", 7}, {"character", 0}}},
                   {"newName", "Q"},
                   {"contentChanges", {{{"text", "Axiom: B\n"}}}}};
  // reading a message looks too
  BoundedWork reading(SIZE_MAX);
  {
    const core::WorkMeter::Scope scope(&reading);
    EXPECT_EQ(editor.ask("textDocument/none", place)["code"], -32601);
  }
  for (const char* method : {"hover", "definition", "references", "documentHighlight", "rename", "completion",
                             "formatting", "documentSymbol", "semanticTokens/full"}) {
    BoundedWork work(reading.looks());
    const core::WorkMeter::Scope scope(&work);
    EXPECT_THROW((void)editor.ask("textDocument/" + std::string(method), place), core::WorkStopped) << method;
  }
  {
    BoundedWork work(reading.looks());
    const core::WorkMeter::Scope scope(&work);
    EXPECT_THROW(editor.tell("textDocument/didChange", place), core::WorkStopped);
  }
  EXPECT_EQ(placesOf(editor.at("definition", 7, 16)), (std::vector<std::string>{"0:8"}));
}

TEST(LanguageServer, EndsWhenTheEditorSaysSo) {
  Editor editor;
  EXPECT_EQ(editor.ask("shutdown", nullptr), Json());
  EXPECT_TRUE(editor.server().isShutDown());
  EXPECT_FALSE(editor.server().hasEnded());
  editor.tell("exit", nullptr);
  EXPECT_TRUE(editor.server().hasEnded());
}

TEST(LanguageServer, EditsAtRandomEndInTheMessagesOfAFreshReading) {
  std::mt19937 random(5);  // NOLINT: the same edits in every run
  const std::string pieces[] = {
      "A", "(",  ")",   "[", "]", " ",   "\n",           "-->", ":", "{", "}", "/*", "*/", "#define Q 1\n",
      "é", "\"", "age", "2", ";", "F(l", "endlsystem\n", "\\"};
  TreeEditor editor;
  std::string text = kTree;
  for (int i = 0; i < 300; ++i) {
    // whole lines of bytes: the editor's copy must follow ours
    std::vector<std::string> lines{""};
    for (const char c : text) {
      if (c == '\n') {
        lines.emplace_back();
      } else {
        lines.back().push_back(c);
      }
    }
    const std::size_t line = random() % lines.size();
    std::size_t column = random() % (lines[line].size() + 1);
    while (column < lines[line].size() && (static_cast<unsigned char>(lines[line][column]) & 0xC0U) == 0x80U) {
      ++column;
    }
    std::size_t units = 0;
    for (std::size_t k = 0; k < column; ++k) {
      units += (static_cast<unsigned char>(lines[line][k]) & 0xC0U) != 0x80U ? 1 : 0;
    }
    const std::string& piece = pieces[random() % std::size(pieces)];
    std::size_t offset = column;
    for (std::size_t k = 0; k < line; ++k) {
      offset += lines[k].size() + 1;
    }
    text.insert(offset, piece);
    editor.change("file:///tree.l", static_cast<int>(line), static_cast<int>(units), static_cast<int>(units), piece);
    if (i % 25 == 24) {
      Editor fresh;
      fresh.open("file:///tree.l", text);
      ASSERT_EQ(editor.diagnostics(), fresh.diagnostics()) << text;
      static_cast<void>(editor.at("hover", static_cast<int>(line), 0));
      static_cast<void>(
          editor.ask("textDocument/semanticTokens/full", {{"textDocument", {{"uri", "file:///tree.l"}}}}));
      text = i % 75 == 74 ? kTree : text;
      editor.open("file:///tree.l", text);
    }
  }
}

/// A run of kTree with counts of its two productions.
RunCounts runOfTree() {
  const auto place = [](std::uint32_t line, const std::string& text) {
    core::SourceLocation location;
    location.file = "sources/tree.l";
    location.line = line;
    location.column = 1;
    location.lineText = text;
    return location;
  };
  return {.since = 0,
          .step = 3,
          .productions = {{"A", place(8, "A(len) : len > R --> F(len)[+(30)A(GROW(len))]A(len * R)"), 4, 7},
                          {"F", place(9, "F(l) --> F(l + age)"), 0, 0}}};
}

/// `line: title` of the lenses of a text in an open run.
std::vector<std::string> lensesOf(const std::string& text, const OpenRun& run,
                                  const std::string& uri = "file:///a/tree.l") {
  core::MemoryFileProvider files;
  LanguageServer server(files);
  const auto ask = [&](Json message) {
    message["jsonrpc"] = "2.0";
    const std::vector<std::string> sent = server.receive(message.dump(), run);
    return sent.empty() ? Json() : Json::parse(sent.front());
  };
  const Json opened = ask({{"id", 1}, {"method", "initialize"}, {"params", {{"capabilities", Json::object()}}}});
  EXPECT_TRUE(opened["result"]["capabilities"].contains("codeLensProvider"));
  static_cast<void>(ask({{"method", "textDocument/didOpen"},
                         {"params", {{"textDocument", {{"uri", uri}, {"text", text}, {"version", 1}}}}}}));
  const Json answer =
      ask({{"id", 2}, {"method", "textDocument/codeLens"}, {"params", {{"textDocument", {{"uri", uri}}}}}});
  std::vector<std::string> lenses;
  for (const Json& lens : answer["result"]) {
    EXPECT_EQ(lens["range"]["start"]["line"], lens["range"]["end"]["line"]);
    lenses.push_back(std::to_string(lens["range"]["start"]["line"].get<int>()) + ": " +
                     lens["command"]["title"].get<std::string>());
  }
  return lenses;
}

TEST(LanguageServer, LensesSayHowOftenTheOpenRunAppliedAProduction) {
  const OpenRun run = [] { return runOfTree(); };
  const std::vector<std::string> expected{"7: applied 7 times, 4 in step 3", "8: never applied in 3 steps"};
  EXPECT_EQ(lensesOf(kTree, run), expected);
  // lines that move keep their lens, an edited production has none until it has run
  EXPECT_EQ(lensesOf("// one\n// two\n" + kTree, run),
            (std::vector<std::string>{"9: applied 7 times, 4 in step 3", "10: never applied in 3 steps"}));
  EXPECT_EQ(lensesOf(std::string(kTree).replace(kTree.find("F(l) -->"), 8, "F(m) -->"), run),
            std::vector<std::string>{expected[0]});
  // another file, no run, a run that has made no step
  EXPECT_TRUE(lensesOf(kTree, run, "file:///a/bush.l").empty());
  EXPECT_TRUE(lensesOf(kTree, {}).empty());
  EXPECT_TRUE(lensesOf(kTree, [] { return std::nullopt; }).empty());
  EXPECT_TRUE(lensesOf(kTree, [] {
                RunCounts early = runOfTree();
                early.since = early.step;
                return early;
              }).empty());
  // a run whose first steps were not counted says so
  EXPECT_EQ(lensesOf(kTree,
                     [] {
                       RunCounts late = runOfTree();
                       late.since = 2;
                       return late;
                     })[1],
            "8: never applied in 1 step, counted since step 2");
}

TEST(MessageCutter, CutsMessagesThatComeInPieces) {
  MessageCutter cutter;
  const std::string bytes = framed("{\"a\":1}") + "content-type: x\r\nCONTENT-LENGTH:2\r\n\r\n{}";
  std::vector<std::string> messages;
  for (const char c : bytes) {
    cutter.add(std::string(1, c));
    while (auto message = cutter.next()) {
      messages.push_back(*message);
    }
  }
  EXPECT_EQ(messages, (std::vector<std::string>{"{\"a\":1}", "{}"}));
  EXPECT_FALSE(cutter.isBroken());
}

TEST(MessageCutter, RefusesWhatIsNoHead) {
  for (const std::string& bytes : {std::string("Content-Length: many\r\n\r\n"), std::string("hello\r\n\r\n"),
                                   std::string("Content-Length: 99999999999\r\n\r\n"), std::string(5000, 'x')}) {
    MessageCutter cutter;
    cutter.add(bytes);
    EXPECT_FALSE(cutter.next().has_value());
    EXPECT_TRUE(cutter.isBroken()) << bytes.substr(0, 30);
  }
}

}  // namespace
}  // namespace espalier::server::language_server_test
