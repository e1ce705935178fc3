// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace drape {

// The files of the folder scripts as they were when the library was built. They run inside another
// program; where a stiffness depends on the mesh, they measure it there.
extern const char *const kNewtonScript, *const kStyle3dScript, *const kBlenderScript;

}  // namespace drape
