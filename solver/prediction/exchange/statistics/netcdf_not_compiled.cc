// SPDX-License-Identifier: Apache-2.0
#include "physics/util/errors.h"
#include "solver/prediction/exchange/statistics/netcdf.h"

namespace drape {

bool HasNetcdf() { return false; }

void WriteNetcdf(const std::string& path, const std::vector<NetcdfGroup>&,
                 const NetcdfAttributes&) {
  throw InputError(path,
                   "cannot be written: this build has no libnetcdf (Debian: libnetcdf-dev), "
                   "expected csv, which needs none");
}

}  // namespace drape
