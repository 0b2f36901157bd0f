#pragma once

#include "clients/espalier/sweep/swept_model.h"

namespace espalier::command {

/// Makes runs for another program, until standard input ends. All numbers are little-endian.
///
/// At the start it writes a line of JSON: {"parameters":[names],"measures":[names],"seed":S}. Then, again and again, it
/// reads n (8 bytes), a 1 when seeds follow or a 0 (8 bytes), n rows of parameters (doubles) and perhaps n seeds (8
/// bytes each). It writes n rows of measures (doubles; not a number: no value), the length of a text (8 bytes), and the
/// text, a JSON list of [row, error] of the runs that failed. False: the input ended within a request, or the output
/// is closed.
[[nodiscard]] bool servePipe(SweptModel& model, unsigned workers);

}  // namespace espalier::command
