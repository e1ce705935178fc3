# SPDX-License-Identifier: Apache-2.0
# Writes the entries of ctest for the suites of a GoogleTest program.
# usage: cmake -D PROGRAM=<program> -D LABELS=<labels> -D FILE=<output> -P suites.cmake
execute_process(COMMAND ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE list COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "(^|\n)[A-Za-z0-9_/]+\\." suites "${list}")
set(entries "")
foreach(suite ${suites})
  string(REGEX REPLACE "[\n.]" "" suite ${suite})
  # Skipped are those of which each case was skipped: one that fails beside a skipped case has failed.
  string(APPEND entries
    "add_test([=[${suite}]=] [=[${PROGRAM}]=] [=[--gtest_filter=${suite}.*]=])\n"
    "set_tests_properties([=[${suite}]=] PROPERTIES LABELS [=[${LABELS}]=] TIMEOUT 1200\n"
    "  SKIP_REGULAR_EXPRESSION [=[\\[  PASSED  \\] 0 tests\\.\n(\\[  SKIPPED \\][^\n]*\n)+$]=])\n")
endforeach()
file(WRITE ${FILE} "${entries}")
