#include "protocol/methods.h"

#include <array>

#include "protocol/codec.h"

namespace espalier::protocol {
namespace {

template <auto decode>
std::optional<Error> problemWith(const Payload& params) {
  const auto decoded = decode(params);
  return decoded ? std::nullopt : std::optional(decoded.error());
}

constexpr std::array kMethods{
#define ESPALIER_METHOD(NAME, PARAMS, ANSWERER, ROLE, SUMMARY) \
  Method{NAME, #PARAMS, Answerer::ANSWERER, Role::ROLE, SUMMARY, &problemWith<&decode##PARAMS>},
#define ESPALIER_NOTIFICATION(NAME, SUMMARY) Method{NAME, {}, Answerer::Nobody, Role::Anyone, SUMMARY, nullptr},
#include "protocol/methods.def"
};

}  // namespace

std::span<const Method> methods() {
  return kMethods;
}

}  // namespace espalier::protocol
