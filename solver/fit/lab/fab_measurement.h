// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "solver/fit/lab/lab_measurement.h"

namespace drape {

// The tensile tests of a U3M 1.1 material: raw data of a FAB device, strips of width 5 cm that are
// stretched at a gauge of 8 cm (S2) along the length (L: warp), the width (W: weft) and the bias
// (B). Their samples alternate distance [cm] and force [gf], cycle by cycle; the file is JSON with
//   "raw_data": {"B" | "L" | "W": {"S2": {"width" [cm], "samplesTree": [[d, f, d, f, …], …]}}}.
// Of each strip the loading with the largest force counts. It begins where the strip is taut: its
// first sample is the rest length, its mean force over the first samples zero. The points are means
// of ten equal parts of the force. The readings' standard deviation is one hundredth of the largest
// strain, at least 1e-3: the file states none. Other members (bending loops, thickness) are not
// read.

// The measurements of one file that a user names: a file of ReadLabMeasurement, such a file of raw
// data, or a .u3m that names it in material.physics.devices.fab, relative to itself. Names of
// strips are those of the file with "_weft", "_bias" or "_warp". Throws InputError, as
// ReadLabMeasurement does, for strips with other members, without a loading or without a stretch.
std::vector<LabMeasurement> ReadLabMeasurements(const std::string& path);

}  // namespace drape
