# SPDX-License-Identifier: Apache-2.0
# Installs the headers of the library: solver/drapefit.h with the headers that it includes, which are
# supported, and in the folder `internal` what these include in turn, which may change.
#   cmake -D SOURCE=<sources> -D OUTPUT=<folder> -P drapefitHeaders.cmake
cmake_minimum_required(VERSION 3.25)

# The headers of ours that a header includes.
function(drape_list_included header result)
  file(STRINGS ${SOURCE}/${header} lines REGEX "^#include \"")
  list(TRANSFORM lines REPLACE "^#include \"([^\"]+)\".*" "\\1")
  set(${result} ${lines} PARENT_SCOPE)
endfunction()

drape_list_included(solver/drapefit.h public)
set(queue ${public})
list(APPEND public solver/drapefit.h)
set(internal)
while(queue)
  list(POP_FRONT queue header)
  drape_list_included(${header} headers)
  foreach(included IN LISTS headers)
    if(NOT included IN_LIST public AND NOT included IN_LIST internal)
      list(APPEND internal ${included})
      list(APPEND queue ${included})
    endif()
  endforeach()
endwhile()
foreach(header IN LISTS public internal)
  cmake_path(GET header PARENT_PATH folder)
  if(header IN_LIST internal)
    set(folder internal/${folder})
  endif()
  file(INSTALL ${SOURCE}/${header} DESTINATION ${OUTPUT}/${folder} MESSAGE_NEVER)
endforeach()
