#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "clients/bmi/bmi.hxx"

namespace espalier::bmi {

/// A call that the interface cannot answer: one sentence that says what is wrong and what to do.
class BmiError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A simulation in this process as a BMI model. The configuration is that of `espalier.bmi` in Python
/// (docs/howto/basic-model-interface.md), and the values have the same bits. Time is in days; a step of the model is
/// one time step. All values are one double of the whole simulation. Everything that fails throws BmiError. One thread
/// at a time uses a model.
class EspalierBmi final : public ::bmi::Bmi {
 public:
  EspalierBmi();
  ~EspalierBmi();
  EspalierBmi(const EspalierBmi&) = delete;
  EspalierBmi& operator=(const EspalierBmi&) = delete;

  void Initialize(std::string config_file) override;
  void Update() override;
  void UpdateUntil(double time) override;
  void Finalize() override;

  std::string GetComponentName() override;
  int GetInputItemCount() override;
  int GetOutputItemCount() override;
  std::vector<std::string> GetInputVarNames() override;
  std::vector<std::string> GetOutputVarNames() override;

  int GetVarGrid(std::string name) override;
  std::string GetVarType(std::string name) override;
  std::string GetVarUnits(std::string name) override;
  int GetVarItemsize(std::string name) override;
  int GetVarNbytes(std::string name) override;
  std::string GetVarLocation(std::string name) override;

  double GetCurrentTime() override;
  double GetStartTime() override;
  double GetEndTime() override;
  std::string GetTimeUnits() override;
  double GetTimeStep() override;

  void GetValue(std::string name, void* dest) override;
  /// Stays valid until Finalize. Values that are written to an input count from the next step on.
  void* GetValuePtr(std::string name) override;
  void GetValueAtIndices(std::string name, void* dest, int* inds, int count) override;
  void SetValue(std::string name, void* src) override;
  void SetValueAtIndices(std::string name, int* inds, int count, void* src) override;

  int GetGridRank(const int grid) override;
  int GetGridSize(const int grid) override;
  std::string GetGridType(const int grid) override;
  void GetGridShape(const int grid, int* shape) override;
  void GetGridSpacing(const int grid, double* spacing) override;
  void GetGridOrigin(const int grid, double* origin) override;
  void GetGridX(const int grid, double* x) override;
  void GetGridY(const int grid, double* y) override;
  void GetGridZ(const int grid, double* z) override;
  int GetGridNodeCount(const int grid) override;
  int GetGridEdgeCount(const int grid) override;
  int GetGridFaceCount(const int grid) override;
  void GetGridEdgeNodes(const int grid, int* edge_nodes) override;
  void GetGridFaceEdges(const int grid, int* face_edges) override;
  void GetGridFaceNodes(const int grid, int* face_nodes) override;
  void GetGridNodesPerFace(const int grid, int* nodes_per_face) override;

 private:
  struct Running;
  std::unique_ptr<Running> running_;  // null: not initialized

  Running& running();
  double& value(const std::string& name);
};

}  // namespace espalier::bmi
