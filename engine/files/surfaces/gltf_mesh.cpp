#include <tiny_gltf.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "engine/files/surfaces/mesh_file.h"

namespace espalier::files {
namespace {

using core::Vec3;

constexpr int kDeepestNode = 64;

/// Why the mesh cannot be read; caught in readGltfMesh.
struct Unreadable {
  std::string what;
};

/// A linear map and a translation.
struct Transform {
  std::array<Vec3, 3> columns{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  Vec3 origin;

  [[nodiscard]] Vec3 direction(const Vec3& v) const { return v.x * columns[0] + v.y * columns[1] + v.z * columns[2]; }
  [[nodiscard]] Vec3 point(const Vec3& p) const { return origin + direction(p); }
  // by the cofactors: the transposed inverse except for its length, and for its sign when mirrored
  [[nodiscard]] Vec3 normal(const Vec3& n) const {
    const Vec3 turned = n.x * core::cross(columns[1], columns[2]) + n.y * core::cross(columns[2], columns[0]) +
                        n.z * core::cross(columns[0], columns[1]);
    return isMirrored() ? -turned : turned;
  }
  [[nodiscard]] bool isMirrored() const { return core::dot(core::cross(columns[0], columns[1]), columns[2]) < 0.0; }
};

Transform combined(const Transform& outer, const Transform& inner) {
  Transform both;
  for (std::size_t k = 0; k < 3; ++k) {
    both.columns[k] = outer.direction(inner.columns[k]);
  }
  both.origin = outer.point(inner.origin);
  return both;
}

// v turned by the quaternion x, y, z, w
Vec3 rotated(const Vec3& v, const std::vector<double>& q) {
  const Vec3 axis{q[0], q[1], q[2]};
  return v + 2.0 * core::cross(axis, core::cross(axis, v) + q[3] * v);
}

Transform transformOf(const tinygltf::Node& node) {
  Transform transform;
  if (node.matrix.size() == 16) {
    const auto column = [&](std::size_t k) {
      return Vec3{node.matrix[4 * k], node.matrix[4 * k + 1], node.matrix[4 * k + 2]};
    };
    transform.columns = {column(0), column(1), column(2)};
    transform.origin = column(3);
    return transform;
  }
  for (std::size_t k = 0; k < 3; ++k) {
    if (node.scale.size() == 3) {
      transform.columns[k] = node.scale[k] * transform.columns[k];
    }
    if (node.rotation.size() == 4) {
      transform.columns[k] = rotated(transform.columns[k], node.rotation);
    }
  }
  if (node.translation.size() == 3) {
    transform.origin = {node.translation[0], node.translation[1], node.translation[2]};
  }
  return transform;
}

/// The numbers of one accessor, checked against the data that the file has.
class Numbers {
 public:
  Numbers(const tinygltf::Model& model, int index, int type, const char* name) {
    const auto invalid = [name](const char* what) { return Unreadable{std::string("its ") + name + what}; };
    if (index < 0 || static_cast<std::size_t>(index) >= model.accessors.size()) {
      throw invalid(" are not in the file");
    }
    const tinygltf::Accessor& accessor = model.accessors[static_cast<std::size_t>(index)];
    if (accessor.type != type) {
      throw invalid(" have a number of components that the format does not allow");
    }
    if (accessor.sparse.isSparse || accessor.bufferView < 0 ||
        static_cast<std::size_t>(accessor.bufferView) >= model.bufferViews.size()) {
      throw invalid(" are sparse or compressed, which is not supported");
    }
    const tinygltf::BufferView& view = model.bufferViews[static_cast<std::size_t>(accessor.bufferView)];
    const int stride = accessor.ByteStride(view);
    const int componentBytes = tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(accessor.componentType));
    if (view.buffer < 0 || static_cast<std::size_t>(view.buffer) >= model.buffers.size() || stride <= 0 ||
        componentBytes <= 0) {
      throw invalid(" have no data");
    }
    const std::vector<unsigned char>& data = model.buffers[static_cast<std::size_t>(view.buffer)].data;
    components_ = static_cast<std::size_t>(tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(type)));
    count_ = accessor.count;
    stride_ = static_cast<std::size_t>(stride);
    componentType_ = accessor.componentType;
    isNormalised_ = accessor.normalized;
    componentBytes_ = static_cast<std::size_t>(componentBytes);
    const std::size_t begin = view.byteOffset + accessor.byteOffset;
    const std::size_t elementBytes = components_ * componentBytes_;
    const bool fits = begin <= data.size() && elementBytes <= data.size() - begin &&
                      (count_ == 0 || (count_ - 1) <= (data.size() - begin - elementBytes) / stride_);
    if (!fits) {
      throw invalid(" reach beyond the end of the data");
    }
    data_ = data.data() + begin;
  }

  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] double at(std::size_t i, std::size_t component) const {
    const unsigned char* from = data_ + i * stride_ + component * componentBytes_;
    switch (componentType_) {
      case TINYGLTF_COMPONENT_TYPE_FLOAT:
        return read<float>(from);
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return scaled(read<std::uint8_t>(from), 255.0);
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return scaled(read<std::uint16_t>(from), 65'535.0);
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        return read<std::uint32_t>(from);
      case TINYGLTF_COMPONENT_TYPE_BYTE:
        return scaled(read<std::int8_t>(from), 127.0);
      case TINYGLTF_COMPONENT_TYPE_SHORT:
        return scaled(read<std::int16_t>(from), 32'767.0);
      default:
        throw Unreadable{"its numbers have the unknown type " + std::to_string(componentType_)};
    }
  }
  [[nodiscard]] Vec3 vector(std::size_t i) const { return {at(i, 0), at(i, 1), at(i, 2)}; }

 private:
  template <typename Number>
  static Number read(const unsigned char* from) {
    Number number;
    std::memcpy(&number, from, sizeof(Number));
    return number;
  }
  [[nodiscard]] double scaled(double value, double largest) const {
    return isNormalised_ ? std::max(value / largest, -1.0) : value;
  }

  const unsigned char* data_ = nullptr;
  std::size_t count_ = 0, stride_ = 0, components_ = 0, componentBytes_ = 0;
  int componentType_ = 0;
  bool isNormalised_ = false;
};

class SceneReader {
 public:
  explicit SceneReader(const tinygltf::Model& model) : model_(model) {}

  [[nodiscard]] std::vector<SurfaceTriangle> read() {
    if (!model_.scenes.empty()) {
      const auto scene = static_cast<std::size_t>(std::max(model_.defaultScene, 0));
      if (scene >= model_.scenes.size()) {
        throw Unreadable{"its scene is not in the file"};
      }
      for (const int node : model_.scenes[scene].nodes) {
        addNode(node, {}, 0);
      }
      return std::move(triangles_);
    }
    for (const tinygltf::Mesh& mesh : model_.meshes) {
      addMesh(mesh, {});
    }
    return std::move(triangles_);
  }

 private:
  void addNode(int index, const Transform& outer, int depth) {
    if (index < 0 || static_cast<std::size_t>(index) >= model_.nodes.size()) {
      throw Unreadable{"a node of its scene is not in the file"};
    }
    // nodes that refer to each other would be visited without end
    if (depth > kDeepestNode || ++visitedNodes_ > kMostMeshTriangles) {
      throw Unreadable{"its scene has too many nodes, or nodes at too deep a level"};
    }
    const tinygltf::Node& node = model_.nodes[static_cast<std::size_t>(index)];
    const Transform transform = combined(outer, transformOf(node));
    if (node.mesh >= 0) {
      if (static_cast<std::size_t>(node.mesh) >= model_.meshes.size()) {
        throw Unreadable{"a mesh of its scene is not in the file"};
      }
      addMesh(model_.meshes[static_cast<std::size_t>(node.mesh)], transform);
    }
    for (const int child : node.children) {
      addNode(child, transform, depth + 1);
    }
  }

  void addMesh(const tinygltf::Mesh& mesh, const Transform& transform) {
    for (const tinygltf::Primitive& primitive : mesh.primitives) {
      // -1: not given, which means triangles; points and lines have no surface
      if (primitive.mode == -1 || primitive.mode >= TINYGLTF_MODE_TRIANGLES) {
        addPrimitive(primitive, transform);
      }
    }
  }

  void addPrimitive(const tinygltf::Primitive& primitive, const Transform& transform);
  void addTriangle(std::array<std::size_t, 3> at, const Transform& transform);

  const tinygltf::Model& model_;
  std::vector<SurfaceTriangle> triangles_;
  std::size_t visitedNodes_ = 0;
  std::optional<Numbers> positions_, normals_, coordinates_;  // of the primitive
};

void SceneReader::addTriangle(std::array<std::size_t, 3> at, const Transform& transform) {
  if (triangles_.size() == kMostMeshTriangles) {
    throw Unreadable{"it has more than " + std::to_string(kMostMeshTriangles) + " triangles"};
  }
  if (transform.isMirrored()) {
    std::swap(at[1], at[2]);
  }
  std::array<MeshCorner, 3> corners;
  for (std::size_t k = 0; k < 3; ++k) {
    if (at[k] >= positions_->count()) {
      throw Unreadable{"a triangle has the vertex " + std::to_string(at[k]) + " of " +
                       std::to_string(positions_->count())};
    }
    corners[k].position = transform.point(positions_->vector(at[k]));
    if (const Vec3& p = corners[k].position; !std::isfinite(p.x + p.y + p.z)) {
      throw Unreadable{"vertex " + std::to_string(at[k]) + " is not finite"};
    }
    if (normals_ && at[k] < normals_->count()) {
      corners[k].normal = transform.normal(normals_->vector(at[k]));
    }
    if (coordinates_ && at[k] < coordinates_->count()) {
      corners[k].coordinates = {coordinates_->at(at[k], 0), 1.0 - coordinates_->at(at[k], 1)};
    }
  }
  triangles_.push_back(triangleOf(corners));
}

void SceneReader::addPrimitive(const tinygltf::Primitive& primitive, const Transform& transform) {
  const auto numbers = [&](const char* attribute, int type, const char* name) -> std::optional<Numbers> {
    const auto found = primitive.attributes.find(attribute);
    return found == primitive.attributes.end()
               ? std::nullopt
               : std::optional<Numbers>(std::in_place, model_, found->second, type, name);
  };
  positions_ = numbers("POSITION", TINYGLTF_TYPE_VEC3, "positions");
  if (!positions_) {
    return;
  }
  normals_ = numbers("NORMAL", TINYGLTF_TYPE_VEC3, "normals");
  coordinates_ = numbers("TEXCOORD_0", TINYGLTF_TYPE_VEC2, "texture coordinates");
  std::optional<Numbers> indices;
  if (primitive.indices >= 0) {
    indices.emplace(model_, primitive.indices, TINYGLTF_TYPE_SCALAR, "indices");
  }
  const std::size_t count = indices ? indices->count() : positions_->count();
  const auto at = [&](std::size_t i) { return indices ? static_cast<std::size_t>(indices->at(i, 0)) : i; };
  for (std::size_t i = 0; i + 2 < count;
       i += primitive.mode == TINYGLTF_MODE_TRIANGLE_STRIP || primitive.mode == TINYGLTF_MODE_TRIANGLE_FAN ? 1 : 3) {
    if (primitive.mode == TINYGLTF_MODE_TRIANGLE_FAN) {
      addTriangle({at(0), at(i + 1), at(i + 2)}, transform);
    } else if (primitive.mode == TINYGLTF_MODE_TRIANGLE_STRIP && i % 2 == 1) {
      addTriangle({at(i + 1), at(i), at(i + 2)}, transform);
    } else {
      addTriangle({at(i), at(i + 1), at(i + 2)}, transform);
    }
  }
}

// a loader that opens no further files and decodes no images
tinygltf::TinyGLTF closedLoader() {
  tinygltf::TinyGLTF loader;
  tinygltf::FsCallbacks callbacks{};
  callbacks.FileExists = [](const std::string&, void*) { return true; };
  callbacks.ExpandFilePath = [](const std::string& file, void*) { return file; };
  callbacks.ReadWholeFile = [](std::vector<unsigned char>*, std::string* error, const std::string& file, void*) {
    *error = "it needs the file '" + file + "', but only data inside the file is read; export it as .glb";
    return false;
  };
  callbacks.WriteWholeFile = [](std::string*, const std::string&, const std::vector<unsigned char>&, void*) {
    return false;
  };
  loader.SetFsCallbacks(callbacks);
  loader.SetImageLoader([](tinygltf::Image*, const int, std::string*, std::string*, int, int, const unsigned char*, int,
                           void*) { return true; },
                        nullptr);
  return loader;
}

}  // namespace

MeshTriangles readGltfMesh(const std::string& bytes) {
  tinygltf::Model model;
  std::string error;
  std::string warning;
  tinygltf::TinyGLTF loader = closedLoader();
  const auto size = static_cast<unsigned int>(std::min<std::size_t>(bytes.size(), std::numeric_limits<int>::max()));
  const bool isBinary = bytes.starts_with("glTF");
  const bool isRead = isBinary ? loader.LoadBinaryFromMemory(&model, &error, &warning,
                                                             reinterpret_cast<const unsigned char*>(bytes.data()), size)
                               : loader.LoadASCIIFromString(&model, &error, &warning, bytes.data(), size, "");
  if (!isRead) {
    // the library's message ends in a line feed
    while (!error.empty() && (error.back() == '\n' || error.back() == ' ')) {
      error.pop_back();
    }
    return tl::unexpected("it is not a glTF 2.0 file: " + error);
  }
  if (!model.extensionsRequired.empty()) {
    return tl::unexpected("it needs the extension " + model.extensionsRequired.front() + ", which is not supported");
  }
  try {
    return SceneReader(model).read();
  } catch (const Unreadable& problem) {
    return tl::unexpected(problem.what);
  }
}

}  // namespace espalier::files
