#include "clients/espalier/sweep/plan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "clients/espalier/sweep/shape_measures.h"
#include "clients/espalier/sweep/tree_measures.h"
#include "engine/core/diagnostic.h"
#include "protocol/codec.h"
#include "protocol/json_text.h"

namespace espalier::command {
namespace {

using nlohmann::ordered_json;
using Names = std::vector<std::string_view>;

constexpr std::uint64_t kMostRuns = 100'000'000;
constexpr std::uint64_t kLargestSeed = (std::uint64_t{1} << 53U) - 1;  // exact in every JSON reader

/// Reads the members of one JSON object and collects the mistakes.
class MemberReader {
 public:
  MemberReader(const ordered_json& object, std::string place, std::vector<std::string>& problems)
      : object_(object), place_(std::move(place)), problems_(problems) {
    if (!object_.is_object()) {
      complain("", "expected an object with members, found " + std::string(object_.type_name()));
    }
  }

  void complain(const std::string& member, const std::string& sentence) const {
    const std::string where = place_ + (place_.empty() || member.empty() ? "" : ".") + member;
    problems_.push_back((where.empty() ? std::string("the plan") : where) + ": " + sentence);
  }

  /// The member of that name, or null.
  const ordered_json* find(const char* name) {
    known_.push_back(name);
    if (!object_.is_object()) {
      return nullptr;
    }
    const auto found = object_.find(name);
    return found == object_.end() ? nullptr : &*found;
  }

  void text(const char* name, std::string& value) {
    if (const ordered_json* found = find(name)) {
      if (found->is_string()) {
        value = found->get<std::string>();
      } else {
        complain(name, "expected a text, found " + found->dump());
      }
    }
  }

  void number(const char* name, double& value) {
    if (const ordered_json* found = find(name)) {
      if (found->is_number() && std::isfinite(found->get<double>())) {
        value = found->get<double>();
      } else {
        complain(name, "expected a number, found " + found->dump());
      }
    }
  }

  void flag(const char* name, bool& value) {
    if (const ordered_json* found = find(name)) {
      if (found->is_boolean()) {
        value = found->get<bool>();
      } else {
        complain(name, "expected true or false, found " + found->dump());
      }
    }
  }

  std::optional<std::uint64_t> whole(const char* name, std::uint64_t least, std::uint64_t most) {
    const ordered_json* found = find(name);
    return found == nullptr ? std::nullopt : wholeOf(*found, name, least, most);
  }

  std::optional<std::uint64_t> wholeOf(const ordered_json& value, const std::string& name, std::uint64_t least,
                                       std::uint64_t most) const {
    if (value.is_number_unsigned() && value.get<std::uint64_t>() >= least && value.get<std::uint64_t>() <= most) {
      return value.get<std::uint64_t>();
    }
    complain(name, "expected a whole number from " + std::to_string(least) + " to " + std::to_string(most) +
                       ", found " + value.dump());
    return std::nullopt;
  }

  std::vector<double> numbers(const char* name) {
    std::vector<double> values;
    const ordered_json* found = find(name);
    if (found == nullptr) {
      return values;
    }
    if (found->is_array()) {
      for (const ordered_json& item : *found) {
        if (item.is_number() && std::isfinite(item.get<double>())) {
          values.push_back(item.get<double>());
        }
      }
    }
    if (!found->is_array() || values.size() != found->size() || values.empty()) {
      complain(name, "expected a list of numbers, found " + found->dump());
      values.clear();
    }
    return values;
  }

  [[nodiscard]] bool has(const char* name) const { return object_.is_object() && object_.contains(name); }

  /// Complains about the members that nothing has asked for.
  void refuseOthers() const {
    if (!object_.is_object()) {
      return;
    }
    for (const auto& [name, value] : object_.items()) {
      if (std::find(known_.begin(), known_.end(), name) == known_.end()) {
        complain(name, "there is no such member. " + core::suggestName(name, known_));
      }
    }
  }

 private:
  const ordered_json& object_;
  std::string place_;
  std::vector<std::string>& problems_;
  Names known_;
};

// the only member of the object among the names; complains when there are none or several
std::string_view onlyOne(const MemberReader& reader, const Names& names, const std::string& what) {
  std::string_view chosen;
  std::string list;
  for (const std::string_view name : names) {
    list += (list.empty() ? "" : ", ") + std::string(name);
    if (reader.has(std::string(name).c_str())) {
      if (!chosen.empty()) {
        reader.complain("", "'" + std::string(chosen) + "' and '" + std::string(name) + "' exclude each other");
        return {};
      }
      chosen = name;
    }
  }
  if (chosen.empty()) {
    reader.complain("", "expected " + what + ": one of " + list);
  }
  return chosen;
}

void readDistribution(MemberReader& reader, Distribution& distribution) {
  using Kind = Distribution::Kind;
  static constexpr std::pair<const char*, Kind> kPairs[] = {
      {"uniform", Kind::Uniform}, {"log", Kind::Log}, {"normal", Kind::Normal}, {"integer", Kind::Integer}};
  for (const auto& [name, kind] : kPairs) {
    const bool isThere = reader.has(name);
    const std::vector<double> values = reader.numbers(name);
    if (!isThere || values.empty()) {
      continue;
    }
    if (distribution.kind != Kind::None) {
      reader.complain(name, "a parameter has one distribution");
    } else if (values.size() != 2) {
      reader.complain(name, "expected two numbers");
    } else if (kind == Kind::Normal ? !(values[1] > 0.0) : !(values[0] < values[1])) {
      reader.complain(name, kind == Kind::Normal ? "the standard deviation must be above 0"
                                                 : "the first number must be below the second");
    } else if (kind == Kind::Log && !(values[0] > 0.0)) {
      reader.complain(name, "both numbers must be above 0");
    } else if (kind == Kind::Integer && (std::floor(values[0]) != values[0] || std::floor(values[1]) != values[1])) {
      reader.complain(name, "expected two whole numbers");
    } else {
      distribution = {.kind = kind, .first = values[0], .second = values[1]};
    }
  }
  const std::vector<double> values = reader.numbers("discrete");
  if (!values.empty()) {
    if (distribution.kind != Kind::None) {
      reader.complain("discrete", "a parameter has one distribution");
    }
    distribution.kind = Kind::Discrete;
    distribution.values = values;
  }
}

void readParameters(const ordered_json& list, std::vector<SweepParameter>& parameters,
                    std::vector<std::string>& problems) {
  if (!list.is_object()) {
    problems.emplace_back("parameters: expected an object with a member for each parameter");
    return;
  }
  for (const auto& [name, value] : list.items()) {
    MemberReader reader(value, "parameters." + name, problems);
    SweepParameter parameter{.name = name, .target = name};
    using Kind = SweepParameter::Kind;
    static constexpr std::pair<const char*, Kind> kTargets[] = {
        {"define", Kind::Define}, {"variable", Kind::Variable}, {"environment", Kind::Environment}};
    for (const auto& [word, kind] : kTargets) {
      if (reader.has(word)) {
        if (parameter.kind != Kind::Unknown) {
          reader.complain(word, "a parameter changes one thing");
        }
        parameter.kind = kind;
      }
      reader.text(word, parameter.target);
    }
    readDistribution(reader, parameter.distribution);
    reader.refuseOthers();
    parameters.push_back(std::move(parameter));
  }
}

void readRows(const ordered_json& list, Design& design, std::vector<std::string>& problems) {
  if (!list.is_array() || list.empty()) {
    problems.emplace_back("runs.rows: expected a list of objects with the values of parameters, with at least one");
    return;
  }
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string place = "runs.rows[" + std::to_string(i) + "]";
    if (!list[i].is_object()) {
      problems.push_back(place + ": expected an object, as {\"R\":1.5,\"seed\":3}");
      return;
    }
    auto& row = design.rows.emplace_back();
    for (const auto& [name, value] : list[i].items()) {
      if (!value.is_number() || !std::isfinite(value.get<double>())) {
        problems.push_back(place + "." + name + ": expected a number, found " + value.dump());
      } else {
        row.emplace_back(name, value.get<double>());
      }
    }
  }
}

void readDesign(const ordered_json& value, Design& design, std::vector<std::string>& problems) {
  MemberReader reader(value, "runs", problems);
  const std::string_view chosen = onlyOne(reader, {"table", "rows", "design"}, "the runs");
  reader.text("table", design.file);
  if (const ordered_json* rows = reader.find("rows"); rows != nullptr && chosen == "rows") {
    readRows(*rows, design, problems);
  }
  std::string name;
  reader.text("design", name);
  design.kind = chosen == "table" ? Design::Kind::Table : chosen == "rows" ? Design::Kind::Rows : Design::Kind::Single;
  if (chosen == "design") {
    static constexpr std::pair<std::string_view, Design::Kind> kDesigns[] = {
        {"grid", Design::Kind::Grid},
        {"random", Design::Kind::Random},
        {"latin-hypercube", Design::Kind::LatinHypercube},
        {"sobol", Design::Kind::Sobol},
        {"saltelli", Design::Kind::Saltelli},
        {"morris", Design::Kind::Morris}};
    const auto* found =
        std::find_if(std::begin(kDesigns), std::end(kDesigns), [&](const auto& entry) { return entry.first == name; });
    if (found == std::end(kDesigns)) {
      Names names;
      for (const auto& entry : kDesigns) {
        names.push_back(entry.first);
      }
      reader.complain("design", "there is no design '" + name + "'. " + core::suggestName(name, names));
      return;
    }
    design.kind = found->second;
    const bool isCounted = design.kind != Design::Kind::Grid && design.kind != Design::Kind::Morris;
    if (isCounted || design.kind == Design::Kind::Morris) {
      const char* count = isCounted ? "count" : "trajectories";
      const auto given = reader.whole(count, 1, kMostRuns);
      if (!given && !reader.has(count)) {
        reader.complain(count, "missing: give the number of " + std::string(isCounted ? "points" : "trajectories"));
      }
      design.count = given.value_or(1);
    }
    if (design.kind == Design::Kind::Grid || design.kind == Design::Kind::Morris) {
      design.levels = reader.whole("levels", 2, 1'000'000).value_or(design.levels);
      if (design.kind == Design::Kind::Morris && design.levels % 2 != 0) {
        reader.complain("levels", "expected an even number, as Morris 1991 has it");
      }
    }
    if (design.kind == Design::Kind::Sobol || design.kind == Design::Kind::Saltelli) {
      design.shift = reader.whole("shift", 0, kLargestSeed);
    } else if (design.kind != Design::Kind::Grid) {
      design.seed = reader.whole("seed", 0, kLargestSeed).value_or(design.seed);
    }
  }
  reader.refuseOthers();
}

void readReplicates(const ordered_json& value, Plan& plan, std::vector<std::string>& problems) {
  if (value.is_number()) {
    const ordered_json whole = {{"replicates", value}};
    plan.replicates = MemberReader(whole, "", problems).whole("replicates", 1, kMostRuns).value_or(1);
    return;
  }
  MemberReader reader(value, "replicates", problems);
  plan.replicates = reader.whole("count", 1, kMostRuns).value_or(1);
  if (const auto seed = reader.whole("seed", 0, kLargestSeed)) {
    plan.firstSeed = *seed;
  }
  reader.flag("common", plan.haveCommonSeeds);
  reader.refuseOthers();
}

template <typename List>
void requireName(MemberReader& reader, const char* member, const std::string& name, const List& names) {
  const Names list(std::begin(names), std::end(names));
  if (std::find(list.begin(), list.end(), name) == list.end()) {
    reader.complain(member, "there is no '" + name + "'. " + core::suggestName(name, list));
  }
}

void readSteps(MemberReader& reader, const std::optional<std::uint64_t>& last, MeasureDefinition& measure) {
  const ordered_json* at = reader.find("at");
  if (at == nullptr) {
    return;
  }
  constexpr std::uint64_t kMostSteps = 1'000'000'000;
  if (at->is_string() && at->get<std::string>() == "every") {
    if (!last || *last > 10'000) {
      reader.complain("at", "'every' needs the plan's member 'steps', at most 10000");
      return;
    }
    for (std::uint64_t step = 0; step <= *last; ++step) {
      measure.steps.push_back(step);
    }
  } else if (at->is_array() && !at->empty()) {
    for (const ordered_json& step : *at) {
      measure.steps.push_back(reader.wholeOf(step, "at", 0, last.value_or(kMostSteps)).value_or(0));
    }
  } else {
    measure.steps.push_back(reader.wholeOf(*at, "at", 0, last.value_or(kMostSteps)).value_or(0));
  }
}

void readMeasure(const std::string& name, const ordered_json& value, const Plan& plan, MeasureDefinition& measure,
                 std::vector<std::string>& problems) {
  using Kind = MeasureDefinition::Kind;
  if (!value.is_object()) {
    problems.push_back("measures." + name + ": expected a measure such as {\"plant\": \"height\"}, found " +
                       value.dump());
    return;
  }
  MemberReader reader(value, "measures." + name, problems);
  static constexpr std::pair<std::string_view, Kind> kKinds[] = {
      {"count", Kind::Count},     {"sum", Kind::Sum},           {"mean", Kind::Mean},
      {"minimum", Kind::Minimum}, {"maximum", Kind::Maximum},   {"deviation", Kind::Deviation},
      {"median", Kind::Quantile}, {"quantile", Kind::Quantile}, {"variable", Kind::Variable},
      {"plant", Kind::Plant},     {"profile", Kind::Profile},   {"mtg", Kind::Mtg}};
  Names names;
  for (const auto& entry : kKinds) {
    names.push_back(entry.first);
  }
  // a mistyped kind has a better message than a missing one
  static const Names kOthers{"of", "where", "value", "at", "along", "bins", "to", "order"};
  for (const auto& [member, unused] : value.items()) {
    if (std::find(names.begin(), names.end(), member) == names.end() &&
        std::find(kOthers.begin(), kOthers.end(), member) == kOthers.end()) {
      Names all = names;
      all.insert(all.end(), kOthers.begin(), kOthers.end());
      reader.complain(member, "there is no such measure or member. " + core::suggestName(member, all));
      return;
    }
  }
  const std::string_view chosen = onlyOne(reader, names, "a measure");
  if (chosen.empty()) {
    return;
  }
  measure.name = name;
  measure.kind = std::find_if(std::begin(kKinds), std::end(kKinds), [&](const auto& entry) {
                   return entry.first == chosen;
                 })->second;
  const std::string word(chosen);
  const bool isOverModules = measure.kind <= Kind::Quantile && measure.kind != Kind::Count;
  switch (measure.kind) {
    case Kind::Count:
      reader.text(word.c_str(), measure.of);
      break;
    case Kind::Quantile:
      if (chosen == "quantile") {
        reader.number("quantile", measure.probability);
        reader.text("value", measure.expression);
        if (measure.probability < 0.0 || measure.probability > 1.0) {
          reader.complain("quantile", "expected a number from 0 to 1");
        }
        if (measure.expression.empty()) {
          reader.complain("value", "missing: give an expression over the names in 'of'");
        }
        break;
      }
      [[fallthrough]];
    case Kind::Sum:
    case Kind::Mean:
    case Kind::Minimum:
    case Kind::Maximum:
    case Kind::Deviation:
      reader.text(word.c_str(), measure.expression);
      if (measure.expression.find_first_not_of(' ') == std::string::npos) {
        reader.complain(word, "expected an expression over the names in 'of'");
      }
      break;
    default:
      reader.text(word.c_str(), measure.what);
  }
  if (isOverModules || measure.kind == Kind::Mtg) {
    reader.text("of", measure.of);
  }
  if (isOverModules && measure.of.empty()) {
    reader.complain("of", "missing: give a module with names for its parameters, as \"F(l,w)\"");
  }
  if (isOverModules || measure.kind == Kind::Count) {
    reader.text("where", measure.where);
  }
  if (measure.kind == Kind::Plant) {
    requireName(reader, "plant", measure.what, shapeMeasureNames());
  } else if (measure.kind == Kind::Mtg) {
    requireName(reader, "mtg", measure.what, treeMeasureNames());
    measure.order = reader.whole("order", 0, 1'000'000);
  } else if (measure.kind == Kind::Profile) {
    requireName(reader, "profile", measure.what, profileNames());
    std::string along = "height";
    reader.text("along", along);
    requireName(reader, "along", along, std::vector<std::string_view>{"height", "radius"});
    measure.isAlongRadius = along == "radius";
    measure.bins = reader.whole("bins", 1, 1000).value_or(measure.bins);
    reader.number("to", measure.to);
    if (!(measure.to > 0.0)) {
      reader.complain("to", "expected the upper end of the last bin, a number above 0");
    }
  }
  readSteps(reader, plan.steps, measure);
  reader.refuseOthers();
}

void readFiles(const ordered_json& list, std::vector<KeptFile>& files, std::vector<std::string>& problems) {
  if (!list.is_array()) {
    problems.emplace_back("files: expected a list, as [{\"name\":\"tree.png\",\"every\":100}]");
    return;
  }
  for (std::size_t i = 0; i < list.size(); ++i) {
    MemberReader reader(list[i], "files[" + std::to_string(i) + "]", problems);
    KeptFile file;
    reader.text("name", file.name);
    file.every = reader.whole("every", 1, kMostRuns).value_or(1);
    reader.refuseOthers();
    if (file.name.empty() || file.name.find('/') != std::string::npos) {
      reader.complain("name", "expected the name of a file without a folder, as tree.png");
    }
    files.push_back(std::move(file));
  }
}

// NAME: number or text
std::vector<std::pair<std::string, std::string>> readSettings(const ordered_json& object, const std::string& place,
                                                              std::vector<std::string>& problems) {
  std::vector<std::pair<std::string, std::string>> settings;
  if (!object.is_object()) {
    problems.push_back(place + ": expected an object of names and values");
    return settings;
  }
  for (const auto& [name, value] : object.items()) {
    if (value.is_number() || value.is_string()) {
      settings.emplace_back(name, value.is_string() ? value.get<std::string>() : value.dump());
    } else {
      problems.push_back(place + "." + name + ": expected a number or a text, found " + value.dump());
    }
  }
  return settings;
}

void readModel(MemberReader& reader, Plan& plan, std::vector<std::string>& problems) {
  reader.text("model", plan.model);
  if (plan.model.empty()) {
    reader.complain("model", "missing: give a model folder, an L-system file or the name of a gallery model");
  }
  reader.text("object", plan.object);
  reader.text("view", plan.view);
  reader.text("dialect", plan.dialect);
  reader.text("compatibility", plan.compatibility);
  if (!plan.compatibility.empty()) {
    requireName(reader, "compatibility", plan.compatibility, std::vector<std::string_view>{"cpfg", "cpfg-batch"});
  }
  if (const ordered_json* environment = reader.find("environment")) {
    if (environment->is_object() || environment->is_array()) {
      plan.environment = environment->dump();
    } else {
      reader.text("environment", plan.environment);
    }
  }
  if (const ordered_json* world = reader.find("world")) {
    if (world->is_object()) {
      plan.world = world->dump();
    } else {
      reader.text("world", plan.world);
    }
  }
  reader.text("stepDuration", plan.stepDuration);
  if (!plan.stepDuration.empty() && !(protocol::daysOfDuration(plan.stepDuration).value_or(0.0) > 0.0)) {
    reader.complain("stepDuration", "expected a time above 0 such as \"1 h\" or \"0.25 d\"");
  }
  if (const ordered_json* defines = reader.find("defines")) {
    plan.defines = readSettings(*defines, "defines", problems);
  }
  if (const ordered_json* limits = reader.find("limits")) {
    for (const auto& [name, value] : readSettings(*limits, "limits", problems)) {
      plan.limits.push_back(name + "=" + value);
    }
  }
}

}  // namespace

Result<Plan> readPlan(std::string_view json) {
  if (const auto fault = protocol::jsonProblem(json)) {
    return problem("the plan is not valid JSON: " + *fault);
  }
  const ordered_json root = ordered_json::parse(json);
  std::vector<std::string> problems;
  Plan plan;
  plan.text = root.dump();
  MemberReader reader(root, "", problems);
  reader.find("$schema");
  reader.find("title");
  readModel(reader, plan, problems);
  plan.steps = reader.whole("steps", 0, 1'000'000'000);
  plan.seed = reader.whole("seed", 0, kLargestSeed).value_or(plan.seed);
  plan.firstSeed = plan.seed;
  reader.flag("answered", plan.isAnswered);
  if (const ordered_json* parameters = reader.find("parameters")) {
    readParameters(*parameters, plan.parameters, problems);
  }
  if (const ordered_json* runs = reader.find("runs")) {
    readDesign(*runs, plan.design, problems);
  }
  if (const ordered_json* replicates = reader.find("replicates")) {
    readReplicates(*replicates, plan, problems);
  }
  if (const ordered_json* measures = reader.find("measures"); measures != nullptr && measures->is_object()) {
    for (const auto& [name, value] : measures->items()) {
      readMeasure(name, value, plan, plan.measures.emplace_back(), problems);
    }
  }
  if (plan.measures.empty() && problems.empty()) {
    reader.complain("measures", "missing: give at least one, as {\"modules\":{\"count\":\"*\"}}");
  }
  if (const ordered_json* files = reader.find("files")) {
    readFiles(*files, plan.files, problems);
  }
  reader.refuseOthers();
  if (problems.empty()) {
    return plan;
  }
  std::string all;
  for (const std::string& sentence : problems) {
    all += (all.empty() ? "" : "\n") + sentence;
  }
  return problem(std::move(all));
}

}  // namespace espalier::command
