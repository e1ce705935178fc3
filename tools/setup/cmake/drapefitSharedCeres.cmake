# SPDX-License-Identifier: Apache-2.0
# Makes Ceres::ceres the shared library. The packaged static one is compiled without AVX; linked into
# code with AVX, the linker would keep one copy of each Eigen function for both, though they align
# and free memory differently. A shared library keeps its own copies.
find_library(DRAPE_SHARED_CERES NAMES libceres.so)
if(DRAPE_SHARED_CERES)
  set_target_properties(Ceres::ceres PROPERTIES IMPORTED_LOCATION "${DRAPE_SHARED_CERES}"
    IMPORTED_LOCATION_RELEASE "${DRAPE_SHARED_CERES}")
else()
  message(WARNING "no shared Ceres library: with a static one of other machine flags, fits may crash")
endif()
