#include "clients/bmi/espalier_bmi.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "clients/bmi/settings.h"
#include "clients/bmi/stepped_model.h"
#include "engine/core/number_text.h"
#include "engine/turtle/world.h"

namespace espalier::bmi {
namespace {

std::string numberText(double value) {
  std::string text;
  if (std::isfinite(value)) {
    core::appendNumber(text, value, core::NumberStyle::Shortest);
  } else {
    text = std::isnan(value) ? "nan" : value > 0.0 ? "inf" : "-inf";
  }
  return text;
}

/// The answer for the grid 0, the only one.
template <typename Value>
Value ofGrid(int grid, Value value) {
  if (grid != 0) {
    throw BmiError("there is no grid " + std::to_string(grid) + ": all variables are on grid 0.");
  }
  return value;
}

[[noreturn]] void refuseGrid(int grid) {
  ofGrid(grid, 0);
  throw BmiError("a scalar has no points, edges or faces.");
}

void checkIndices(const std::string& name, const int* inds, int count) {
  if (std::any_of(inds, inds + std::max(count, 0), [](int index) { return index != 0; })) {
    throw BmiError("'" + name + "' has the index 0 only.");
  }
}

}  // namespace

struct EspalierBmi::Running {
  Settings settings;
  SteppedModel model;
  std::vector<double> inputs;   // (settings.inputs); a caller may have pointers to them
  std::vector<double> known;    // the values that the model has (settings.inputs)
  std::vector<double> outputs;  // (settings.outputs)
  std::uint64_t step = 0;

  explicit Running(Settings read)
      : settings(std::move(read)),
        model(settings),
        inputs(settings.inputValues),
        known(inputs),
        outputs(settings.outputs.size()) {
    readOutputs();
  }

  void readOutputs() {
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      outputs[i] = model.output(settings.outputs[i]);
    }
  }

  /// Gives the model the inputs that changed since the last step.
  void sendInputs() {
    std::vector<std::pair<std::string, double>> changed;
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      if (!std::isfinite(inputs[i])) {
        throw BmiError("the input '" + settings.inputs[i] + "' cannot be " + numberText(inputs[i]) +
                       ": set it to a finite number.");
      }
      if (inputs[i] != known[i]) {
        changed.emplace_back(settings.inputs[i], inputs[i]);
      }
    }
    if (!changed.empty()) {
      model.set(changed);
      known = inputs;
    }
  }
};

EspalierBmi::EspalierBmi() = default;
EspalierBmi::~EspalierBmi() = default;

EspalierBmi::Running& EspalierBmi::running() {
  if (!running_) {
    throw BmiError("the model is not initialized: call Initialize(config_file) first.");
  }
  return *running_;
}

double& EspalierBmi::value(const std::string& name) {
  Running& now = running();
  std::string known;
  for (auto [names, values] :
       {std::pair(&now.settings.inputs, &now.inputs), std::pair(&now.settings.outputs, &now.outputs)}) {
    for (std::size_t i = 0; i < names->size(); ++i) {
      if ((*names)[i] == name) {
        return (*values)[i];
      }
      known += (known.empty() ? "" : ", ") + (*names)[i];
    }
  }
  throw BmiError("there is no variable '" + name + "'. Variables: " + known + ".");
}

void EspalierBmi::Initialize(std::string config_file) {
  Finalize();
  Settings settings = readSettings(config_file);
  try {
    running_ = std::make_unique<Running>(std::move(settings));
  } catch (const BmiError& error) {
    throw BmiError(config_file + ": the model cannot start. Correct this and initialize it again: " + error.what());
  }
}

void EspalierBmi::Update() {
  Running& now = running();
  const std::uint64_t last = now.model.lastStep();
  if (now.step >= last) {
    throw BmiError("the model ends after " + std::to_string(last) +
                   " steps: initialize it with a larger 'derivationLength'.");
  }
  now.sendInputs();
  now.model.step();
  ++now.step;
  now.readOutputs();
}

void EspalierBmi::UpdateUntil(double time) {
  Running& now = running();
  const double current = GetCurrentTime();
  if (!std::isfinite(time)) {
    throw BmiError("the time " + numberText(time) + " is not finite: give a number of days from " +
                   numberText(current) + " on.");
  }
  // a half of a step's rounding error
  const double until = time + std::abs(time) * 1e-12;
  if (until < current) {
    throw BmiError("the time " + numberText(time) + " is before " + numberText(current) +
                   ": a model does not go back. Initialize it again.");
  }
  while (turtle::beginOfStep(now.model.stepDays(), now.step + 1) <= until) {
    Update();
  }
}

void EspalierBmi::Finalize() {
  running_.reset();
}

std::string EspalierBmi::GetComponentName() {
  return "Espalier";
}

int EspalierBmi::GetInputItemCount() {
  return static_cast<int>(running().inputs.size());
}

int EspalierBmi::GetOutputItemCount() {
  return static_cast<int>(running().outputs.size());
}

std::vector<std::string> EspalierBmi::GetInputVarNames() {
  return running().settings.inputs;
}

std::vector<std::string> EspalierBmi::GetOutputVarNames() {
  return running().settings.outputs;
}

int EspalierBmi::GetVarGrid(std::string name) {
  value(name);
  return 0;
}

std::string EspalierBmi::GetVarType(std::string name) {
  value(name);
  return "double";
}

std::string EspalierBmi::GetVarUnits(std::string name) {
  value(name);
  return name == "height" ? "m" : "1";
}

int EspalierBmi::GetVarItemsize(std::string name) {
  return static_cast<int>(sizeof(value(name)));
}

int EspalierBmi::GetVarNbytes(std::string name) {
  return static_cast<int>(sizeof(value(name)));
}

std::string EspalierBmi::GetVarLocation(std::string name) {
  value(name);
  return "node";
}

double EspalierBmi::GetCurrentTime() {
  const Running& now = running();
  return turtle::beginOfStep(now.model.stepDays(), now.step);
}

double EspalierBmi::GetStartTime() {
  return 0.0;
}

double EspalierBmi::GetEndTime() {
  const Running& now = running();
  return turtle::beginOfStep(now.model.stepDays(), now.model.lastStep());
}

std::string EspalierBmi::GetTimeUnits() {
  return "d";
}

double EspalierBmi::GetTimeStep() {
  return running().model.stepDays();
}

void EspalierBmi::GetValue(std::string name, void* dest) {
  std::memcpy(dest, &value(name), sizeof(double));
}

void* EspalierBmi::GetValuePtr(std::string name) {
  return &value(name);
}

void EspalierBmi::GetValueAtIndices(std::string name, void* dest, int* inds, int count) {
  const double& found = value(name);
  checkIndices(name, inds, count);
  for (int i = 0; i < count; ++i) {
    std::memcpy(static_cast<char*>(dest) + static_cast<std::size_t>(i) * sizeof(double), &found, sizeof(double));
  }
}

void EspalierBmi::SetValue(std::string name, void* src) {
  double& found = value(name);
  const std::vector<std::string>& inputs = running().settings.inputs;
  if (std::find(inputs.begin(), inputs.end(), name) == inputs.end()) {
    std::string known;
    for (const std::string& input : inputs) {
      known += (known.empty() ? "" : ", ") + input;
    }
    throw BmiError("'" + name + "' is no input. Inputs: " + (known.empty() ? "none" : known) + ".");
  }
  double given = 0.0;
  std::memcpy(&given, src, sizeof(given));
  if (!std::isfinite(given)) {
    throw BmiError("the input '" + name + "' cannot be " + numberText(given) + ": set it to a finite number.");
  }
  found = given;
}

void EspalierBmi::SetValueAtIndices(std::string name, int* inds, int count, void* src) {
  value(name);
  checkIndices(name, inds, count);
  if (count > 0) {
    SetValue(name, src);
  }
}

int EspalierBmi::GetGridRank(const int grid) {
  return ofGrid(grid, 0);
}

int EspalierBmi::GetGridSize(const int grid) {
  return ofGrid(grid, 1);
}

std::string EspalierBmi::GetGridType(const int grid) {
  return ofGrid(grid, std::string("scalar"));
}

int EspalierBmi::GetGridNodeCount(const int grid) {
  return ofGrid(grid, 1);
}

int EspalierBmi::GetGridEdgeCount(const int grid) {
  return ofGrid(grid, 0);
}

int EspalierBmi::GetGridFaceCount(const int grid) {
  return ofGrid(grid, 0);
}

void EspalierBmi::GetGridShape(const int grid, int* /*shape*/) {
  refuseGrid(grid);
}

void EspalierBmi::GetGridSpacing(const int grid, double* /*spacing*/) {
  refuseGrid(grid);
}

void EspalierBmi::GetGridOrigin(const int grid, double* /*origin*/) {
  refuseGrid(grid);
}

void EspalierBmi::GetGridX(const int grid, double* /*x*/) {
  refuseGrid(grid);
}

void EspalierBmi::GetGridY(const int grid, double* /*y*/) {
  refuseGrid(grid);
}

void EspalierBmi::GetGridZ(const int grid, double* /*z*/) {
  refuseGrid(grid);
}

void EspalierBmi::GetGridEdgeNodes(const int grid, int* /*edge_nodes*/) {
  refuseGrid(grid);
}

void EspalierBmi::GetGridFaceEdges(const int grid, int* /*face_edges*/) {
  refuseGrid(grid);
}

void EspalierBmi::GetGridFaceNodes(const int grid, int* /*face_nodes*/) {
  refuseGrid(grid);
}

void EspalierBmi::GetGridNodesPerFace(const int grid, int* /*nodes_per_face*/) {
  refuseGrid(grid);
}

}  // namespace espalier::bmi
