#include "clients/espalier/evolution/fitness_process.h"

#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "server/remote/processes/line_channel.h"

namespace espalier::command {
namespace {

using nlohmann::json;
using server::LineChannel;

constexpr std::size_t kLongestReply = 1'000'000;

std::string request(const JudgedPlant& plant) {
  json parameters = json::object();
  for (std::size_t i = 0; i < plant.shape.genes.size(); ++i) {
    parameters[plant.shape.genes[i].name] = plant.genome.values[i];
  }
  json productions = json::object();
  for (std::size_t i = 0; i < plant.shape.predecessors.size(); ++i) {
    std::string text;
    for (const std::string& module : plant.genome.successors[i]) {
      text += module;
    }
    productions[plant.shape.predecessors[i]] = std::move(text);
  }
  json measures = json::object();
  for (std::size_t i = 0; i < kMeasureNames.size(); ++i) {
    measures[std::string(kMeasureNames[i])] = measure(plant.measures, i);
  }
  json segments = json::array();
  for (const turtle::Segment& segment : plant.scene.segments) {
    const std::int64_t parent = segment.parent == turtle::kNoParent ? -1 : static_cast<std::int64_t>(segment.parent);
    segments.push_back({segment.start.x, segment.start.y, segment.start.z, segment.end.x, segment.end.y, segment.end.z,
                        segment.startWidth, segment.endWidth, parent});
  }
  return json{{"generation", plant.generation},
              {"individual", plant.individual},
              {"modules", plant.modules},
              {"parameters", std::move(parameters)},
              {"productions", std::move(productions)},
              {"measures", std::move(measures)},
              {"segments", std::move(segments)},
              {"string", plant.string}}
             .dump() +
         "\n";
}

}  // namespace

struct FitnessProcess::Parts {
  std::unique_ptr<server::ChildProcess::Started> child;
  LineChannel channel;
};

FitnessProcess::FitnessProcess(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

FitnessProcess::~FitnessProcess() {
  parts_->channel.closeOutput();
}

Result<std::unique_ptr<FitnessProcess>> FitnessProcess::start(const std::string& command) {
  auto started = server::ChildProcess::start(command);
  if (!started) {
    return problem(std::move(started.error()));
  }
  auto child = std::move(*started);
  LineChannel channel(std::move(child->input), std::move(child->output), kLongestReply);
  return std::unique_ptr<FitnessProcess>(
      new FitnessProcess(std::unique_ptr<Parts>(new Parts{std::move(child), std::move(channel)})));
}

Result<double> FitnessProcess::judge(const JudgedPlant& plant, double seconds) {
  const auto deadline =
      std::chrono::steady_clock::now() +
      std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(seconds));
  std::string line;
  LineChannel::Status status = parts_->channel.write(request(plant), deadline);
  // a program that no longer reads may have answered before
  if (status == LineChannel::Status::Done || status == LineChannel::Status::Closed) {
    status = parts_->channel.readLine(line, deadline);
  }
  if (status == LineChannel::Status::Timeout) {
    return problem("the fitness program did not answer within " + std::to_string(static_cast<int>(seconds)) + " s");
  }
  if (status != LineChannel::Status::Done) {
    // its output ends a moment before the process ends
    std::string fate = parts_->child->process.fate();
    for (int i = 0; i < 100 && fate.empty(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      fate = parts_->child->process.fate();
    }
    return problem("the fitness program " + (fate.empty() ? std::string("closed its output") : fate) +
                   " instead of answering; its own messages are above");
  }
  const json reply = json::parse(line, nullptr, false);
  if (reply.is_object() && reply.contains("error") && reply["error"].is_string()) {
    return problem("the fitness program says: " + reply["error"].get<std::string>());
  }
  if (!reply.is_object() || !reply.contains("fitness") || !reply["fitness"].is_number() ||
      !std::isfinite(reply["fitness"].get<double>())) {
    return problem("the fitness program answered '" + line.substr(0, 100) + "', not {\"fitness\": NUMBER}");
  }
  return reply["fitness"].get<double>();
}

}  // namespace espalier::command
