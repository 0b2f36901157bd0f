#pragma once

#include <optional>
#include <string>

#include "clients/espalier/messages.h"
#include "engine/core/streams.h"
#include "protocol/codec.h"

namespace espalier::command {

/// The JSON in a file, ready to decode. `what` is the file in an error: `forest file`. Prints an error and returns
/// nothing when there is no such file or no JSON in it.
[[nodiscard]] std::optional<protocol::Payload> readJsonFile(const std::string& file, const std::string& what,
                                                            core::FileProvider& files);

/// Prints the error of a decoder, whose paths begin with `params`, as one of the file. With `provider` the error has
/// the line and the column of the member there.
void printFileError(const std::string& file, std::string message, core::FileProvider* provider);

/// Reads and decodes a file that a person wrote. Without `hasPlaces` the file is a part of another one, and errors have
/// no line.
template <typename Record>
[[nodiscard]] std::optional<Record> decodeJsonFile(const std::string& file, const std::string& what,
                                                   core::FileProvider& files,
                                                   protocol::Expected<Record> (*decode)(const protocol::Payload&),
                                                   bool hasPlaces = true) {
  const auto payload = readJsonFile(file, what, files);
  if (!payload) {
    return std::nullopt;
  }
  auto decoded = decode(*payload);
  if (!decoded) {
    printFileError(file, decoded.error().message, hasPlaces ? &files : nullptr);
    return std::nullopt;
  }
  return std::move(*decoded);
}

}  // namespace espalier::command
