# SPDX-License-Identifier: Apache-2.0
# The public headers are those of physics, losses and solver, and the maker of a backend; neither the
# studies, garments and programs nor what only the sources of one library include.
#   DRAPE_HEADER_FOLDERS, DRAPE_HEADER_RULES   of install(DIRECTORY) and file(COPY)
# As a script it copies them:  cmake -D SOURCE=... -D OUTPUT=... -P drapefitHeaders.cmake
set(DRAPE_HEADER_FOLDERS physics losses solver)
set(private_headers
    supernodal_factor.h symbolic_analysis.h simd.h triangulate.h hausdorff.h
    batching_backend.h csv_log.h weighted_drapes.h)
set(DRAPE_HEADER_RULES FILES_MATCHING PATTERN "*.h")
foreach(private studies garment photo plot kernels ${private_headers})
  list(APPEND DRAPE_HEADER_RULES PATTERN ${private} EXCLUDE)
endforeach()

if(CMAKE_SCRIPT_MODE_FILE)
  file(REMOVE_RECURSE "${OUTPUT}")
  list(TRANSFORM DRAPE_HEADER_FOLDERS PREPEND "${SOURCE}/" OUTPUT_VARIABLE folders)
  file(COPY ${folders} DESTINATION "${OUTPUT}" ${DRAPE_HEADER_RULES})
  file(COPY "${SOURCE}/cuda/make_backend.h" DESTINATION "${OUTPUT}/cuda")
endif()
