// SPDX-License-Identifier: Apache-2.0
#include "physics/util/options/field.h"

#include <glog/logging.h>

namespace drape {

void CheckRange(double value, const Field& field) {
  CHECK(field.range.Contains(value)) << field.key << ": " << value;
}

}  // namespace drape
