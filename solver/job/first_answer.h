// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "losses/metrics/laboratory_drape.h"
#include "physics/util/run_control.h"
#include "solver/job/fit_input.h"

namespace drape {

// An answer before any fit [METHODS, P77]: for each image, its drape coefficient and nodes, and the
// bending length and rigidity of the drapes of a built-in pool that are like it, with intervals of
// 90 %. Logs a line for each. No sheets where no pool has the images' discs.
std::vector<LaboratorySheet> AnswerAtOnce(const FitInput& input, const RunControl& control);

// The bending length of that answer, by an outline in the plane of the support [m], of a multiple
// of kPoolAngles points; none where no pool has the discs.
std::optional<LaboratoryRow> AnswerBendingLength(const Eigen::VectorXd& radius,
                                                 const DrapeDiscs& discs);

// A sentence where the intervals that an answer and a fitted sheet have for the bending length do
// not meet.
std::optional<std::string> FindDisagreement(const LaboratorySheet& at_once,
                                            const LaboratorySheet& fitted);

}  // namespace drape
