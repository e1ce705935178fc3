# SPDX-License-Identifier: Apache-2.0
# Writes build.cc with the version and the commit of the checkout SOURCE, if it is another than
# before:
#   cmake -D SOURCE=… -D version=… -D build_type=… -D OUTPUT=… -P write_build.cmake
execute_process(COMMAND git describe --always --dirty --exclude=*
  WORKING_DIRECTORY "${SOURCE}" OUTPUT_VARIABLE commit ERROR_QUIET
  OUTPUT_STRIP_TRAILING_WHITESPACE)
configure_file(${CMAKE_CURRENT_LIST_DIR}/build.cc.in "${OUTPUT}" @ONLY)
