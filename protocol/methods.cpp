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
#define ESPALIER_METHOD(NAME, PARAMS, ANSWERER, SUMMARY) \
  Method{NAME, #PARAMS, Answerer::ANSWERER, SUMMARY, &problemWith<&decode##PARAMS>},
#define ESPALIER_NOTIFICATION(NAME, SUMMARY) Method{NAME, {}, Answerer::Nobody, SUMMARY, nullptr},
#include "protocol/methods.def"
};

}  // namespace

std::span<const Method> methods() {
  return kMethods;
}

}  // namespace espalier::protocol
