// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace drape {

// Whether a shape could be read.
enum ReadStatus : int {
  kRead = 0,
  kUnreadable = 1,  // not finite, behind the camera, or an angle without cloth
  kNoRoom = 2       // more crossings or pieces than there is room for: the host's to read
};

}  // namespace drape
