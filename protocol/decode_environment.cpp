#include <algorithm>

#include "protocol/base64.h"
#include "protocol/codec.h"
#include "protocol/json_tree.h"

namespace espalier::protocol {
namespace {

std::array<double, 3> readVector(const Field& field) {
  if (field.arraySize() != 3) {
    field.failExpected("three numbers");
  }
  return {field.element(0).number(), field.element(1).number(), field.element(2).number()};
}

void readOptionalVector(const Field& field, std::optional<std::array<double, 3>>& vector) {
  if (!field.isAbsent()) {
    vector = readVector(field);
  }
}

void readNumbers(const Field& field, std::vector<double>& numbers) {
  if (field.isAbsent()) {
    return;
  }
  const std::size_t count = field.arraySize();
  numbers.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    numbers.push_back(field.element(i).number());
  }
}

void readOptionalNumber(const Field& field, std::optional<double>& number) {
  if (!field.isAbsent()) {
    number = field.number();
  }
}

std::string readOptionalText(const Field& field) {
  return field.isAbsent() ? std::string() : field.text();
}

void readQuery(const Field& field, QueryRecord& query) {
  field.requireObject();
  query.id = field["id"].count();
  query.plant = field["plant"].isAbsent() ? 0 : static_cast<std::uint32_t>(field["plant"].integer(0, 0xFFFFFFFF));
  query.module = field["module"].isAbsent() ? 0 : field["module"].count();
  query.isTransient = !field["transient"].isAbsent() && field["transient"].boolean();
  query.symbol = field["symbol"].text();
  readNumbers(field["parameters"], query.parameters);
  readOptionalVector(field["position"], query.position);
  readOptionalVector(field["heading"], query.heading);
  readOptionalVector(field["left"], query.left);
  readOptionalVector(field["up"], query.up);
  readOptionalNumber(field["width"], query.width);
  readOptionalNumber(field["scale"], query.scale);
  if (const Field following = field["following"]; !following.isAbsent()) {
    following.requireObject();
    query.followingSymbol = following["symbol"].text();
    readNumbers(following["parameters"], query.followingParameters);
  }
}

void readReply(const Field& field, ReplyRecord& reply, std::size_t queryCount, std::vector<bool>& isAnswered) {
  field.requireObject();
  const Field id = field["id"];
  reply.id = id.count();
  if (reply.id >= queryCount) {
    id.fail("there is no query " + std::to_string(reply.id) + "; this step has " + std::to_string(queryCount) +
            " queries, numbered from 0");
  }
  if (isAnswered[reply.id]) {
    id.fail("query " + std::to_string(reply.id) + " is answered twice; answer each at most once");
  }
  isAnswered[reply.id] = true;
  const Field parameters = field["parameters"];
  if (parameters.isAbsent()) {
    return;
  }
  const std::size_t count = parameters.arraySize();
  reply.parameters.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Field value = parameters.element(i);
    reply.parameters.push_back(value.isNull() ? std::nullopt : std::optional<double>(value.number()));
  }
}

void readNeeds(const Field& field, NeedsRecord& needs) {
  if (field.isAbsent()) {
    return;
  }
  const std::size_t count = field.arraySize();
  for (std::size_t i = 0; i < count; ++i) {
    const Field element = field.element(i);
    const std::string& name = element.text();
    if (name == "position") {
      needs.position = true;
    } else if (name == "heading") {
      needs.heading = true;
    } else if (name == "left") {
      needs.left = true;
    } else if (name == "up") {
      needs.up = true;
    } else if (name == "width") {
      needs.width = true;
    } else if (name == "scale") {
      needs.scale = true;
    } else if (name == "parameters") {
      needs.parameters = true;
    } else if (name == "following") {
      needs.following = true;
    } else if (name == "geometry") {
      needs.geometry = true;
    } else {
      element.failExpected("one of position, heading, left, up, width, scale, parameters, following, geometry");
    }
  }
}

std::vector<VariableRecord> readVariables(const Field& field) {
  std::vector<VariableRecord> variables;
  if (field.isAbsent()) {
    return variables;
  }
  const std::size_t count = field.arraySize();
  for (std::size_t i = 0; i < count; ++i) {
    const Field element = field.element(i);
    element.requireObject();
    VariableRecord variable;
    variable.name = element["name"].text();
    if (const Field unit = element["unit"]; !unit.isAbsent()) {
      variable.unit = unit.text();
    }
    variable.type = readOptionalText(element["type"]);
    variables.push_back(std::move(variable));
  }
  return variables;
}

void readWorld(const Field& field, WorldRecord& world) {
  if (field.isAbsent()) {
    return;
  }
  field.requireObject();
  if (const Field unit = field["lengthUnit"]; !unit.isAbsent()) {
    world.lengthUnit = unit.text();
  }
  if (const Field up = field["up"]; !up.isAbsent()) {
    world.up = readVector(up);
  }
  if (const Field north = field["north"]; !north.isAbsent()) {
    world.north = readVector(north);
  }
  if (const Field duration = field["stepDuration"]; !duration.isAbsent()) {
    world.stepDurationDays = duration.number();
  }
  readOptionalNumber(field["latitude"], world.latitudeDegrees);
  readOptionalNumber(field["longitude"], world.longitudeDegrees);
  world.start = readOptionalText(field["start"]);
}

std::string readBytes(const Field& field) {
  auto bytes = fromBase64(field.text());
  if (!bytes) {
    field.fail("expected base64");
  }
  return std::move(*bytes);
}

}  // namespace

Decoded<OpenParams> decodeOpenParams(const Payload& payload) {
  return decodePayload<OpenParams>(payload, [](const Field& params, OpenParams& open) {
    params.requireObject();
    open.simulation = params["simulation"].text();
    if (const Field plants = params["plants"]; !plants.isAbsent()) {
      open.plants = static_cast<std::uint32_t>(plants.integer(0, 0xFFFFFFFF));
    }
    if (const Field symbols = params["symbols"]; !symbols.isAbsent()) {
      const std::size_t count = symbols.arraySize();
      for (std::size_t i = 0; i < count; ++i) {
        open.symbols.push_back(symbols.element(i).text());
      }
    }
    if (const Field configuration = params["configuration"]; !configuration.isAbsent()) {
      configuration.requireObject();
      open.configurationJson = configuration.json().empty() ? std::string() : configuration.dump();
    }
    if (const Field seed = params["seed"]; !seed.isAbsent()) {
      open.seed = seed.wide();
    }
    if (const Field resume = params["resume"]; !resume.isAbsent()) {
      open.resumeStep = resume.count();
    }
    readWorld(params["world"], open.world);
  });
}

Decoded<EnvironmentStepParams> decodeEnvironmentStepParams(const Payload& payload) {
  return decodePayload<EnvironmentStepParams>(payload, [](const Field& params, EnvironmentStepParams& step) {
    params.requireObject();
    step.simulation = params["simulation"].text();
    step.step = params["step"].count();
    if (const Field iteration = params["iteration"]; !iteration.isAbsent()) {
      step.iteration = static_cast<std::uint32_t>(iteration.integer(0, 0xFFFFFFFF));
    }
    if (const Field time = params["time"]; !time.isAbsent()) {
      step.timeDays = time.number();
    }
    const Field queries = params["queries"];
    const std::size_t count = queries.arraySize();
    step.queries.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      const Field query = queries.element(i);
      readQuery(query, step.queries[i]);
      if (step.queries[i].id != i) {
        query["id"].fail("expected " + std::to_string(i) + ": queries are numbered from 0 in order");
      }
    }
  });
}

Decoded<RestoreStateParams> decodeRestoreStateParams(const Payload& payload) {
  return decodePayload<RestoreStateParams>(payload, [](const Field& params, RestoreStateParams& restore) {
    params.requireObject();
    restore.simulation = params["simulation"].text();
    restore.state = readBytes(params["state"]);
  });
}

Decoded<DescribeResult> decodeDescribeResult(const Payload& payload) {
  return decodePayload<DescribeResult>(payload, [](const Field& result, DescribeResult& description) {
    result.requireObject();
    description.name = readOptionalText(result["name"]);
    description.summary = readOptionalText(result["summary"]);
    readNeeds(result["needs"], description.needs);
    description.inputs = readVariables(result["inputs"]);
    description.outputs = readVariables(result["outputs"]);
    description.isStateful = !result["stateful"].isAbsent() && result["stateful"].boolean();
    description.canCheckpoint = !result["checkpoint"].isAbsent() && result["checkpoint"].boolean();
  });
}

Decoded<std::vector<ReplyRecord>> decodeReplies(const Payload& payload, std::size_t queryCount) {
  return decodePayload<std::vector<ReplyRecord>>(payload,
                                                 [queryCount](const Field& result, std::vector<ReplyRecord>& replies) {
                                                   result.requireObject();
                                                   const Field list = result["replies"];
                                                   const std::size_t count = list.arraySize();
                                                   std::vector<bool> isAnswered(queryCount, false);
                                                   replies.reserve(std::min(count, queryCount));
                                                   for (std::size_t i = 0; i < count; ++i) {
                                                     ReplyRecord reply;
                                                     readReply(list.element(i), reply, queryCount, isAnswered);
                                                     replies.push_back(std::move(reply));
                                                   }
                                                 });
}

Decoded<std::string> decodeSaveResult(const Payload& payload) {
  return decodePayload<std::string>(payload, [](const Field& result, std::string& state) {
    result.requireObject();
    state = readBytes(result["state"]);
  });
}

}  // namespace espalier::protocol
