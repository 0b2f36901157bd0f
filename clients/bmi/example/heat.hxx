// A component with the Basic Model Interface that knows nothing of Espalier: a plate that spreads heat and gives some away.
//
// Configuration: four numbers, nodes along y, nodes along x, the distance of nodes in m, and the share of the difference to its
// neighbours that a node gets in a step. At first the middle of the plate has the temperature 100.
#pragma once

#include <bmi.hxx>
#include <cstring>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

class Heat : public bmi::Bmi {
 public:
  void Initialize(std::string config_file) override {
    std::ifstream file(config_file);
    if (!(file >> rows_ >> columns_ >> spacing_ >> share_) || rows_ < 1 || columns_ < 1) {
      throw std::runtime_error("'" + config_file + "' must hold four numbers: rows, columns, spacing, share.");
    }
    time_ = 0.0;
    values_["plate_surface__temperature"].assign(size(), 0.0);
    values_["plate_surface__heat_loss"].assign(size(), 0.0);
    values_["plate_surface__temperature"][size() / 2] = 100.0;
  }

  void Update() override {
    const std::vector<double> before = values_["plate_surface__temperature"];
    const std::vector<double>& loss = values_["plate_surface__heat_loss"];
    for (int row = 0; row < rows_; ++row) {
      for (int column = 0; column < columns_; ++column) {
        const double here = before[at(row, column)];
        double change = 0.0;
        for (const auto& [up, right] : {std::pair(-1, 0), std::pair(1, 0), std::pair(0, -1), std::pair(0, 1)}) {
          const int other = row + up;
          const int beside = column + right;
          if (other >= 0 && other < rows_ && beside >= 0 && beside < columns_) {
            change += share_ * (before[at(other, beside)] - here);
          }
        }
        values_["plate_surface__temperature"][at(row, column)] = here + change - loss[at(row, column)];
      }
    }
    time_ += 1.0;
  }
  void UpdateUntil(double time) override {
    while (time_ + 1.0 <= time) {
      Update();
    }
  }
  void Finalize() override { values_.clear(); }

  std::string GetComponentName() override { return "Heat"; }
  int GetInputItemCount() override { return 1; }
  int GetOutputItemCount() override { return 1; }
  std::vector<std::string> GetInputVarNames() override { return {"plate_surface__heat_loss"}; }
  std::vector<std::string> GetOutputVarNames() override { return {"plate_surface__temperature"}; }

  int GetVarGrid(std::string name) override { return of(name), 0; }
  std::string GetVarType(std::string name) override { return of(name), "double"; }
  std::string GetVarUnits(std::string name) override { return of(name), "K"; }
  int GetVarItemsize(std::string name) override { return of(name), static_cast<int>(sizeof(double)); }
  int GetVarNbytes(std::string name) override { return static_cast<int>(of(name).size() * sizeof(double)); }
  std::string GetVarLocation(std::string name) override { return of(name), "node"; }

  double GetCurrentTime() override { return time_; }
  double GetStartTime() override { return 0.0; }
  double GetEndTime() override { return 1e9; }
  std::string GetTimeUnits() override { return "d"; }
  double GetTimeStep() override { return 1.0; }

  void GetValue(std::string name, void* dest) override { std::memcpy(dest, of(name).data(), of(name).size() * sizeof(double)); }
  void* GetValuePtr(std::string name) override { return of(name).data(); }
  void GetValueAtIndices(std::string name, void* dest, int* inds, int count) override {
    for (int i = 0; i < count; ++i) {
      static_cast<double*>(dest)[i] = of(name).at(static_cast<std::size_t>(inds[i]));
    }
  }
  void SetValue(std::string name, void* src) override { std::memcpy(of(name).data(), src, of(name).size() * sizeof(double)); }
  void SetValueAtIndices(std::string name, int* inds, int count, void* src) override {
    for (int i = 0; i < count; ++i) {
      of(name).at(static_cast<std::size_t>(inds[i])) = static_cast<double*>(src)[i];
    }
  }

  int GetGridRank(const int) override { return 2; }
  int GetGridSize(const int) override { return static_cast<int>(size()); }
  std::string GetGridType(const int) override { return "uniform_rectilinear"; }
  void GetGridShape(const int, int* shape) override { shape[0] = rows_, shape[1] = columns_; }
  void GetGridSpacing(const int, double* spacing) override { spacing[0] = spacing[1] = spacing_; }
  void GetGridOrigin(const int, double* origin) override { origin[0] = 0.0, origin[1] = -spacing_ * (columns_ / 2); }
  void GetGridX(const int, double*) override { absent(); }
  void GetGridY(const int, double*) override { absent(); }
  void GetGridZ(const int, double*) override { absent(); }
  int GetGridNodeCount(const int) override { return static_cast<int>(size()); }
  int GetGridEdgeCount(const int) override { return 0; }
  int GetGridFaceCount(const int) override { return 0; }
  void GetGridEdgeNodes(const int, int*) override { absent(); }
  void GetGridFaceEdges(const int, int*) override { absent(); }
  void GetGridFaceNodes(const int, int*) override { absent(); }
  void GetGridNodesPerFace(const int, int*) override { absent(); }

 private:
  std::size_t size() const { return static_cast<std::size_t>(rows_) * static_cast<std::size_t>(columns_); }
  std::size_t at(int row, int column) const { return static_cast<std::size_t>(row * columns_ + column); }
  std::vector<double>& of(const std::string& name) {
    const auto found = values_.find(name);
    if (found == values_.end()) {
      throw std::runtime_error("Heat has no variable '" + name + "'.");
    }
    return found->second;
  }
  [[noreturn]] static void absent() { throw std::runtime_error("the grid of Heat is uniform."); }

  int rows_ = 0;
  int columns_ = 0;
  double spacing_ = 1.0;
  double share_ = 0.0;
  double time_ = 0.0;
  std::map<std::string, std::vector<double>> values_;
};
