// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "solver/forward/accuracy_table.h"
#include "solver/studies/bench/bench_job.h"

namespace drape {

// Of the runs of a forward work; `time` is the clock that counts. A setting that for one of the
// fabrics loses the branch or is not at rest gives no row. Throws InputError where no row is left.
AccuracyTable MakeAccuracyTable(const BenchJob& job, const BenchResult& result, BenchMeasure time,
                                double safety);

}  // namespace drape
