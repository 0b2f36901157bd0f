# the CMake package `espalier`: the target espalier::client
include(CMakeFindDependencyMacro)
find_dependency(Threads)
find_dependency(Boost 1.81)
find_dependency(nlohmann_json 3.11)
find_dependency(simdjson 3.0)
include(${CMAKE_CURRENT_LIST_DIR}/espalier-targets.cmake)
