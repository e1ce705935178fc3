// SPDX-License-Identifier: Apache-2.0
#include "physics/util/options/field.h"

#include <glog/logging.h>

namespace drape {

void CheckRange(double value, const Field& field) {
  CHECK(field.above_least ? value > field.least : value >= field.least)
      << field.key << ": " << value;
  CHECK_LE(value, field.most) << field.key;
}

}  // namespace drape
