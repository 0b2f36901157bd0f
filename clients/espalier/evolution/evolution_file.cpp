#include <cmath>
#include <exception>
#include <nlohmann/json.hpp>

#include "clients/espalier/evolution/evolution.h"
#include "protocol/json_text.h"

namespace espalier::command {
namespace {

using nlohmann::json;

constexpr int kVersion = 1;

json toJson(const EvolutionSettings& settings) {
  json genes = json::array();
  for (const Gene& gene : settings.shape.genes) {
    genes.push_back({{"name", gene.name}, {"low", gene.low}, {"high", gene.high}});
  }
  return {{"model", settings.model},
          {"fitness", settings.fitness},
          {"seed", settings.seed},
          {"population", settings.populationCount},
          {"elite", settings.eliteCount},
          {"tournament", settings.tournamentSize},
          {"mutation", settings.mutationProbability},
          {"crossover", settings.crossoverProbability},
          {"genes", std::move(genes)},
          {"predecessors", settings.shape.predecessors},
          {"alphabet", settings.shape.alphabet},
          {"longestSuccessor", settings.shape.longestSuccessor},
          {"successors", settings.successors}};
}

json toJson(const Individual& individual) {
  json measures;
  for (std::size_t i = 0; i < kMeasureNames.size(); ++i) {
    measures[std::string(kMeasureNames[i])] = measure(individual.measures, i);
  }
  return {{"values", individual.genome.values}, {"successors", individual.genome.successors},
          {"hasGrown", individual.hasGrown},    {"fitness", individual.fitness},
          {"measures", std::move(measures)},    {"modules", individual.modules}};
}

Individual toIndividual(const json& item, const GenomeShape& shape) {
  Individual individual;
  individual.genome.values = item.at("values").get<std::vector<double>>();
  individual.genome.successors = item.at("successors").get<std::vector<Successor>>();
  if (individual.genome.values.size() != shape.genes.size() ||
      individual.genome.successors.size() != shape.predecessors.size()) {
    throw std::invalid_argument("an individual has other genes than this run");
  }
  individual.isEvaluated = true;
  individual.hasGrown = item.at("hasGrown").get<bool>();
  individual.fitness = item.at("fitness").get<double>();
  individual.modules = item.at("modules").get<std::uint64_t>();
  const json& measures = item.at("measures");
  const auto number = [&](const char* name) { return measures.at(name).get<double>(); };
  individual.measures = {.height = number("height"),
                         .light = number("light"),
                         .sky = number("sky"),
                         .symmetry = number("symmetry"),
                         .stability = number("stability"),
                         .branching = number("branching"),
                         .length = number("length"),
                         .extent = number("extent"),
                         .organs = number("organs")};
  return individual;
}

}  // namespace

std::string writeEvolution(const EvolutionSettings& settings, const Generation& generation) {
  json individuals = json::array();
  for (const Individual& individual : generation.individuals) {
    individuals.push_back(toJson(individual));
  }
  return json{{"espalierEvolution", kVersion},
              {"settings", toJson(settings)},
              {"generation", generation.number},
              {"individuals", std::move(individuals)}}
             .dump(1) +
         "\n";
}

Result<Generation> readEvolution(std::string_view text, const EvolutionSettings& settings) {
  if (const auto fault = protocol::jsonProblem(text)) {
    return problem("it is damaged: " + *fault);
  }
  try {
    const json file = json::parse(text);
    if (file.at("espalierEvolution").get<int>() != kVersion) {
      return problem("another version of espalier wrote it");
    }
    const json& before = file.at("settings");
    const json now = toJson(settings);
    for (const auto& [name, value] : now.items()) {
      if (before.at(name) != value) {
        return problem(name == "model" ? std::string("the model, its view or its environment has changed since")
                                       : "it was made with another " + name + ": " + before.at(name).dump() + ", now " +
                                             value.dump());
      }
    }
    Generation generation;
    generation.number = file.at("generation").get<std::uint32_t>();
    for (const json& item : file.at("individuals")) {
      generation.individuals.push_back(toIndividual(item, settings.shape));
    }
    if (generation.individuals.size() != settings.populationCount) {
      return problem("individuals are missing in it");
    }
    return generation;
  } catch (const std::exception& error) {
    return problem(std::string("it is damaged: ") + error.what());
  }
}

}  // namespace espalier::command
