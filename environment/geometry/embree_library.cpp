#include <embree3/rtcore.h>

#include <cstddef>

#include "environment/base/loaded_library.h"

// The functions of Embree that are used; it is loaded when one is called first.

namespace {

const espalier::environment::LoadedLibrary kEmbree("libembree3.so.3", "libembree3-3");

}  // namespace

#define ESPALIER_EMBREE(result, name, parameters, arguments) \
  ESPALIER_LOADED(kEmbree, result, name, parameters, arguments)

extern "C" {

ESPALIER_EMBREE(RTCDevice, rtcNewDevice, (const char* config), (config))
ESPALIER_EMBREE(RTCError, rtcGetDeviceError, (RTCDevice device), (device))
ESPALIER_EMBREE(void, rtcReleaseDevice, (RTCDevice device), (device))
ESPALIER_EMBREE(void, rtcSetDeviceMemoryMonitorFunction,
                (RTCDevice device, RTCMemoryMonitorFunction monitor, void* data), (device, monitor, data))

ESPALIER_EMBREE(RTCScene, rtcNewScene, (RTCDevice device), (device))
ESPALIER_EMBREE(void, rtcSetSceneFlags, (RTCScene scene, RTCSceneFlags flags), (scene, flags))
ESPALIER_EMBREE(unsigned, rtcAttachGeometry, (RTCScene scene, RTCGeometry geometry), (scene, geometry))
ESPALIER_EMBREE(void, rtcCommitScene, (RTCScene scene), (scene))
ESPALIER_EMBREE(void, rtcReleaseScene, (RTCScene scene), (scene))

ESPALIER_EMBREE(RTCGeometry, rtcNewGeometry, (RTCDevice device, RTCGeometryType type), (device, type))
ESPALIER_EMBREE(void*, rtcSetNewGeometryBuffer,
                (RTCGeometry geometry, RTCBufferType type, unsigned slot, RTCFormat format, std::size_t stride,
                 std::size_t count),
                (geometry, type, slot, format, stride, count))
ESPALIER_EMBREE(void, rtcSetGeometryUserData, (RTCGeometry geometry, void* data), (geometry, data))
ESPALIER_EMBREE(void, rtcSetGeometryUserPrimitiveCount, (RTCGeometry geometry, unsigned count), (geometry, count))
ESPALIER_EMBREE(void, rtcSetGeometryBoundsFunction, (RTCGeometry geometry, RTCBoundsFunction bounds, void* data),
                (geometry, bounds, data))
ESPALIER_EMBREE(void, rtcSetGeometryIntersectFunction, (RTCGeometry geometry, RTCIntersectFunctionN intersect),
                (geometry, intersect))
ESPALIER_EMBREE(void, rtcSetGeometryIntersectFilterFunction, (RTCGeometry geometry, RTCFilterFunctionN filter),
                (geometry, filter))
ESPALIER_EMBREE(void, rtcSetGeometryOccludedFilterFunction, (RTCGeometry geometry, RTCFilterFunctionN filter),
                (geometry, filter))
ESPALIER_EMBREE(void, rtcCommitGeometry, (RTCGeometry geometry), (geometry))
ESPALIER_EMBREE(void, rtcReleaseGeometry, (RTCGeometry geometry), (geometry))

ESPALIER_EMBREE(void, rtcIntersect1, (RTCScene scene, RTCIntersectContext* context, RTCRayHit* ray),
                (scene, context, ray))
ESPALIER_EMBREE(void, rtcOccluded1, (RTCScene scene, RTCIntersectContext* context, RTCRay* ray), (scene, context, ray))
ESPALIER_EMBREE(bool, rtcPointQuery,
                (RTCScene scene, RTCPointQuery* query, RTCPointQueryContext* context, RTCPointQueryFunction visit,
                 void* data),
                (scene, query, context, visit, data))

}  // extern "C"
