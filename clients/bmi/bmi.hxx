// The Basic Model Interface 2.0 in C++, as CSDMS specifies it (bmi.readthedocs.io; Hutton, Piper & Tucker 2020, JOSS 5): the names,
// the signatures and the order of the functions are the specification's, so a component that was written for the file bmi.hxx of
// CSDMS compiles with this one unchanged. A component that brings that file includes it first; this one then declares nothing.
#if !defined(BMI_HXX) && !defined(BMI_HPP)
#define BMI_HXX
#define BMI_HPP

#include <string>
#include <vector>

namespace bmi {

const int BMI_SUCCESS = 0;
const int BMI_FAILURE = 1;
const int MAX_COMPONENT_NAME = 2048;
const int MAX_VAR_NAME = 2048;
const int MAX_UNITS_NAME = 2048;
const int MAX_TYPE_NAME = 2048;

class Bmi {
 public:
  virtual ~Bmi() {}

  // control
  virtual void Initialize(std::string config_file) = 0;
  virtual void Update() = 0;
  virtual void UpdateUntil(double time) = 0;
  virtual void Finalize() = 0;

  // what there is
  virtual std::string GetComponentName() = 0;
  virtual int GetInputItemCount() = 0;
  virtual int GetOutputItemCount() = 0;
  virtual std::vector<std::string> GetInputVarNames() = 0;
  virtual std::vector<std::string> GetOutputVarNames() = 0;

  // variables
  virtual int GetVarGrid(std::string name) = 0;
  virtual std::string GetVarType(std::string name) = 0;
  virtual std::string GetVarUnits(std::string name) = 0;
  virtual int GetVarItemsize(std::string name) = 0;
  virtual int GetVarNbytes(std::string name) = 0;
  virtual std::string GetVarLocation(std::string name) = 0;

  // time
  virtual double GetCurrentTime() = 0;
  virtual double GetStartTime() = 0;
  virtual double GetEndTime() = 0;
  virtual std::string GetTimeUnits() = 0;
  virtual double GetTimeStep() = 0;

  // values
  virtual void GetValue(std::string name, void* dest) = 0;
  virtual void* GetValuePtr(std::string name) = 0;
  virtual void GetValueAtIndices(std::string name, void* dest, int* inds, int count) = 0;
  virtual void SetValue(std::string name, void* src) = 0;
  virtual void SetValueAtIndices(std::string name, int* inds, int count, void* src) = 0;

  // grids
  virtual int GetGridRank(const int grid) = 0;
  virtual int GetGridSize(const int grid) = 0;
  virtual std::string GetGridType(const int grid) = 0;
  virtual void GetGridShape(const int grid, int* shape) = 0;
  virtual void GetGridSpacing(const int grid, double* spacing) = 0;
  virtual void GetGridOrigin(const int grid, double* origin) = 0;
  virtual void GetGridX(const int grid, double* x) = 0;
  virtual void GetGridY(const int grid, double* y) = 0;
  virtual void GetGridZ(const int grid, double* z) = 0;
  virtual int GetGridNodeCount(const int grid) = 0;
  virtual int GetGridEdgeCount(const int grid) = 0;
  virtual int GetGridFaceCount(const int grid) = 0;
  virtual void GetGridEdgeNodes(const int grid, int* edge_nodes) = 0;
  virtual void GetGridFaceEdges(const int grid, int* face_edges) = 0;
  virtual void GetGridFaceNodes(const int grid, int* face_nodes) = 0;
  virtual void GetGridNodesPerFace(const int grid, int* nodes_per_face) = 0;
};

}  // namespace bmi

#endif
