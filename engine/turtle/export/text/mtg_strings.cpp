#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "engine/core/number_text.h"
#include "engine/turtle/export/text/mtg_reader.h"

namespace espalier::turtle::mtg {

std::size_t MtgReader::ancestorAt(std::size_t vertex, int scale) const {
  while (vertex != kNoVertex && vertices_[vertex].scale > scale) {
    vertex = vertices_[vertex].complex;
    ++looks_;
  }
  return vertex != kNoVertex && vertices_[vertex].scale == scale ? vertex : kNoVertex;
}

// which numbers are the parameters of each class of the finest scale
void MtgReader::chooseParameters() {
  std::map<std::string, std::vector<bool>> isGiven;  // by class and feature
  for (const Vertex& vertex : vertices_) {
    std::vector<bool>& given = isGiven[vertex.entityClass];
    given.resize(features_.size());
    for (std::size_t i = 0; i < vertex.numbers.size(); ++i) {
      given[i] = given[i] || !std::isnan(vertex.numbers[i]);
    }
  }
  for (const auto& [name, given] : isGiven) {
    std::vector<std::size_t>& chosen = parameters_[name];
    for (std::size_t i = 0; i < given.size(); ++i) {
      if (given[i]) {
        chosen.push_back(i);
      }
    }
  }
}

void MtgReader::appendModule(std::string& text, const Vertex& vertex) const {
  text += vertex.text.value_or(vertex.entityClass);
  const std::vector<std::size_t>& chosen = parameters_.at(vertex.entityClass);
  if (vertex.text || chosen.empty()) {
    return;
  }
  char separator = '(';
  for (const std::size_t i : chosen) {
    text += separator;
    separator = ',';
    const double number = i < vertex.numbers.size() ? vertex.numbers[i] : kUnknown;
    core::appendNumber(text, std::isnan(number) ? 0.0 : number, core::NumberStyle::Shortest);
  }
  text += ')';
}

// a branch that ends, or an entity with everything that grows on it
void MtgReader::appendTree(std::string& text, std::size_t root) const {
  constexpr std::size_t kClose = kNoVertex;
  std::vector<std::size_t> waiting{root};
  while (!waiting.empty()) {
    const std::size_t at = waiting.back();
    waiting.pop_back();
    if (at == kClose) {
      text += ']';
      continue;
    }
    const Vertex& vertex = vertices_[at];
    if (vertex.edge == '+') {
      text += '[';
    }
    appendModule(text, vertex);
    // branches first, then the rest of the axis: the stack takes them in the opposite order
    std::vector<std::size_t> order;
    for (const char edge : {'+', '<'}) {
      for (const std::size_t child : vertex.children) {
        if (vertices_[child].edge == edge) {
          order.push_back(child);
        }
      }
    }
    for (std::size_t i = order.size(); i-- > 0;) {
      // a branch is closed behind its whole subtree
      if (vertices_[order[i]].edge == '+') {
        waiting.push_back(kClose);
      }
      waiting.push_back(order[i]);
    }
  }
}

MtgStrings MtgReader::strings() const {
  int finest = 0;
  for (const Vertex& vertex : vertices_) {
    finest = std::max(finest, vertex.scale);
  }
  MtgStrings result;
  std::map<std::size_t, std::string> byPlant;
  std::set<std::string> classes;
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    const Vertex& vertex = vertices_[i];
    if (vertex.scale == finest && vertex.parent == kNoVertex) {
      const std::size_t plant = coarsest_ >= finest ? 0 : ancestorAt(i, coarsest_);
      appendTree(byPlant[plant], i);
    }
    if (vertex.scale == finest && !vertex.text) {
      classes.insert(vertex.entityClass);
      for (const std::size_t k : parameters_.at(vertex.entityClass)) {
        result.missingNumbers += k >= vertex.numbers.size() || std::isnan(vertex.numbers[k]) ? 1 : 0;
      }
    }
  }
  for (auto& [plant, text] : byPlant) {
    result.strings.push_back(std::move(text));
  }
  for (const std::string& name : classes) {
    result.modules += (result.modules.empty() ? "" : ", ") + name;
    char separator = '(';
    for (const std::size_t i : parameters_.at(name)) {
      result.modules += separator + features_[i];
      separator = ',';
    }
    result.modules += separator == ',' ? ")" : "";
  }
  return result;
}

}  // namespace espalier::turtle::mtg
