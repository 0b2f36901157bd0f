#pragma once

#include <cstddef>

namespace espalier::server {

/// The C library keeps freed memory, in a heap for each thread until there are eight for each core. A server bounds the
/// number, so that what threads have freed is there for others, and how much each heap keeps at its end. For the whole
/// process, before its threads begin.
void boundHeaps(unsigned workers);

/// So many bytes are being freed, such as a message or the memory of a turn. When they are many, the heaps are to be
/// trimmed.
void noteFreed(std::size_t bytes) noexcept;
/// Many bytes were freed since the heaps were trimmed, and that was a second ago.
[[nodiscard]] bool isHeapTrimDue() noexcept;
/// Gives freed memory back to the system when that is due. Large turns do it at their end; after the last of many that
/// end together somebody else has to.
void trimHeap() noexcept;

}  // namespace espalier::server
