#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "server/store/database.h"

namespace espalier::server {

/// The changes that make a database of each version from one of the version before: the first makes version 1 from an
/// empty database. A released change never changes again; a new version gets a new row. A change may have several
/// statements and sets no version itself.
[[nodiscard]] std::span<const char* const> storeChanges();

/// The version of the database that this program writes.
[[nodiscard]] std::int64_t storeVersion();

/// The version of an open database; 0: it is empty.
[[nodiscard]] std::int64_t versionOf(Database& database);

/// Whether an open database has tables, and none of them is ours.
[[nodiscard]] bool isOfAnotherProgram(Database& database);

/// Brings an open database to the present version, in one transaction: a program that is killed meanwhile leaves the
/// old version whole. Failures are in problem(). False: the database is of a newer version, and nothing was changed.
/// `changes` are those that lead to the present version.
[[nodiscard]] bool migrate(Database& database, std::span<const char* const> changes = storeChanges());

}  // namespace espalier::server
