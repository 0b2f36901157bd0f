#include "clients/cpp/environment.h"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iostream>
#include <utility>

#include "clients/cpp/client.h"
#include "protocol/codec.h"
#include "protocol/json_writer.h"
#include "protocol/version.h"

namespace espalier::client {
namespace {

using protocol::ErrorCode;
using protocol::Expected;

constexpr std::chrono::hours kWait{24};

Vector vectorAt(std::span<const double> column, std::size_t row) {
  return column.empty() ? Vector{} : Vector{column[3 * row], column[3 * row + 1], column[3 * row + 2]};
}

std::span<const double> rowOf(std::span<const double> values, std::span<const std::uint64_t> offset, std::size_t row) {
  return offset.empty() ? std::span<const double>() : values.subspan(offset[row], offset[row + 1] - offset[row]);
}

protocol::Error failed(const std::string& what) {
  return {ErrorCode::EnvironmentFailed, "The environment failed: " + what, R"({"retryable":false})"};
}

std::string encodeReplies(const Replies& replies) {
  std::vector<std::uint32_t> ids;
  std::vector<std::uint64_t> offset{0};
  std::vector<double> values;
  for (std::size_t query = 0; query < replies.values().size(); ++query) {
    const std::vector<double>& reply = replies.values()[query];
    if (!reply.empty()) {
      ids.push_back(static_cast<std::uint32_t>(query));
      values.insert(values.end(), reply.begin(), reply.end());
      offset.push_back(values.size());
    }
  }
  protocol::ReplyColumns columns;
  columns.count = ids.size();
  columns.id = ids;
  columns.offset = offset;
  columns.values = values;
  columns.notes = replies.notes();
  return protocol::encode(columns);
}

// answers on standard input and output until the input ends
int serveOnStdio(EnvironmentHost& host) {
  std::string line;
  while (std::getline(std::cin, line)) {
    const auto message = protocol::decodeMessage(line);
    if (!message) {
      std::cout << protocol::encodeError(message.error().id, message.error().error) << std::flush;
    } else if (message->kind == protocol::Message::Kind::Request) {
      const auto result = host.answer(message->method, message->payload);
      std::cout << (result ? protocol::encodeResult(message->id, *result)
                           : protocol::encodeError(message->id, result.error()))
                << std::flush;
    }
  }
  return 0;
}

int offerTo(EnvironmentHost& host, const std::string& name, const std::string& address, const std::string& token) {
  ClientOptions options;
  options.name = name;
  options.roles = {"environment"};
  options.token = token;
  options.capabilities = {"strict"};  // queries come as text
  const auto client = Client::connect(address, options);
  if (!client) {
    std::cerr << name << ": " << client.error().message << '\n';
    return 1;
  }
  protocol::JsonWriter offer;
  const auto offered =
      (*client)->request("environment.offer", offer.beginObject().key("name").text(name).endObject().view());
  if (!offered) {
    std::cerr << name << ": " << offered.error().message << '\n';
    return 1;
  }
  std::cerr << "environment '" << name << "' is offered to " << address << '\n';
  while ((*client)->isOpen()) {
    const auto request = (*client)->nextRequest(kWait);
    if (!request) {
      continue;
    }
    const auto result = host.answer(request->method, request->params);
    if (result) {
      static_cast<void>((*client)->respond(request->id, *result));
    } else {
      static_cast<void>((*client)->respondError(request->id, result.error()));
    }
  }
  return 0;
}

}  // namespace

Query Queries::operator[](std::size_t index) const {
  const protocol::QueryColumns& all = params_.queries;
  Query query;
  query.plant = all.plant[index];
  query.symbol = all.symbols[all.symbol[index]];
  query.parameters = rowOf(all.parameters, all.offset, index);
  query.position = vectorAt(all.position, index);
  query.heading = vectorAt(all.heading, index);
  query.left = vectorAt(all.left, index);
  query.up = vectorAt(all.up, index);
  query.width = all.width.empty() ? 0.0 : all.width[index];
  query.scale = all.scale.empty() ? 1.0 : all.scale[index];
  if (!all.following.empty() && all.following[index] != protocol::QueryColumns::kNoSymbol) {
    query.following = all.symbols[all.following[index]];
    query.followingParameters = rowOf(all.followingParameters, all.followingOffset, index);
  }
  return query;
}

Expected<EnvironmentHost::Opened*> EnvironmentHost::find(const std::string& simulation) {
  const auto found = opened_.find(simulation);
  if (found == opened_.end()) {
    return tl::unexpected(protocol::Error{
        ErrorCode::NotFound, "The simulation '" + simulation + "' is not open here. Send environment.open first.", {}});
  }
  return &found->second;
}

Expected<std::string> EnvironmentHost::step(const protocol::Payload& payload) {
  const auto params = protocol::decodeEnvironmentStepParams(payload);
  if (!params) {
    return tl::unexpected(params.error());
  }
  const auto found = find(params->simulation);
  if (!found) {
    return tl::unexpected(found.error());
  }
  Opened& opened = **found;
  const std::pair now(params->step, params->iteration);
  // an environment with a state must not advance twice for a step that is sent again
  if (description_.isStateful && opened.last == now) {
    return opened.reply;
  }
  Replies replies(params->queries.count);
  opened.environment->respond(Queries(*params), replies);
  opened.reply = encodeReplies(replies);
  opened.last = now;
  return opened.reply;
}

Expected<std::string> EnvironmentHost::carryOut(const std::string& method, const protocol::Payload& payload) {
  if (method == "environment.step") {
    return step(payload);
  }
  if (method == "environment.describe") {
    EnvironmentDescription description = description_;
    description.canCheckpoint = description.isStateful;
    return protocol::encode(description);
  }
  if (method == "environment.open") {
    const auto params = protocol::decodeOpenParams(payload);
    if (!params) {
      return tl::unexpected(params.error());
    }
    // opened again in the middle of a run, after a lost connection: an existing object goes on
    if (!params->resumeStep || !opened_.contains(params->simulation)) {
      std::unique_ptr<Environment> environment = factory_();
      environment->opened(*params);
      opened_[params->simulation] = Opened{.environment = std::move(environment), .last = {}};
    }
    return "{}";
  }
  if (method == "environment.save" || method == "environment.close") {
    const auto params = protocol::decodeSimulationParams(payload);
    if (!params) {
      return tl::unexpected(params.error());
    }
    if (method == "environment.close") {
      opened_.erase(params->simulation);
      return "{}";
    }
    const auto found = find(params->simulation);
    return found ? Expected<std::string>(protocol::encodeSaveResult((*found)->environment->save()))
                 : tl::unexpected(found.error());
  }
  if (method == "environment.restore") {
    const auto params = protocol::decodeRestoreStateParams(payload);
    const auto found = params ? find(params->simulation) : tl::unexpected(params.error());
    if (!found) {
      return tl::unexpected(found.error());
    }
    (*found)->environment->restore(params->state);
    (*found)->last.reset();
    return "{}";
  }
  if (method == "hello") {
    return protocol::encode(protocol::HelloResult{.protocol = protocol::kProtocolVersion,
                                                  .session = "1",
                                                  .server = description_.name,
                                                  .roles = {},
                                                  .capabilities = {"checkpoint"},
                                                  .limits = {}});
  }
  if (method == "ping") {
    return "{}";
  }
  return tl::unexpected(
      protocol::Error{ErrorCode::UnknownMethod, "An environment does not know the method '" + method + "'.", {}});
}

Expected<std::string> EnvironmentHost::answer(const std::string& method, const protocol::Payload& params) {
  try {
    return carryOut(method, params);
  } catch (const protocol::NonFiniteNumber&) {
    return tl::unexpected(protocol::Error{
        ErrorCode::NonFinite, "A reply of the environment is NaN or infinite. Check what it computes.", {}});
  } catch (const std::exception& exception) {
    return tl::unexpected(failed(exception.what()));
  }
}

int serveEnvironment(EnvironmentDescription description, EnvironmentFactory factory, int count,
                     const char* const* arguments) {
  std::string address;
  std::string token;
  std::string tokenFile;
  for (int i = 1; i < count; i += 2) {
    const std::string_view option = arguments[i];
    std::string* const value = option == "--offer"        ? &address
                               : option == "--token"      ? &token
                               : option == "--token-file" ? &tokenFile
                                                          : nullptr;
    if (value == nullptr || i + 1 >= count) {
      std::cerr << "usage: " << arguments[0] << " [--offer HOST:PORT [--token-file FILE | --token TOKEN]]\n";
      return 2;
    }
    *value = arguments[i + 1];
  }
  if (!tokenFile.empty()) {
    std::ifstream file(tokenFile);
    if (!std::getline(file, token) || token.empty()) {
      std::cerr << "the token file '" << tokenFile << "' cannot be read, or its first line is empty\n";
      return 2;
    }
  }
  const std::string name = description.name;
  EnvironmentHost host(std::move(description), std::move(factory));
  return address.empty() ? serveOnStdio(host) : offerTo(host, name, address, token);
}

}  // namespace espalier::client
