# SPDX-License-Identifier: Apache-2.0
# Run by CPack between installation and packing: gives the folder of each package what Debian's
# policy asks for. Programs lose the path that finds libraries beside them in a bundle, static
# libraries their debugging symbols; manual pages are compressed; copyright, changelogs and
# overrides are added.
set(source ${CPACK_DRAPE_PACKAGE_SOURCE_DIR})
set(version ${CPACK_PACKAGE_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# The time of the last commit, so that the same sources give the same package.
if(DEFINED ENV{SOURCE_DATE_EPOCH})
  set(time $ENV{SOURCE_DATE_EPOCH})
else()
  execute_process(COMMAND git log -1 --format=%ct WORKING_DIRECTORY ${source} OUTPUT_VARIABLE time
                  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  if(NOT time)
    string(TIMESTAMP time %s UTC)
  endif()
endif()
execute_process(COMMAND date -u -R -d @${time} OUTPUT_VARIABLE date OUTPUT_STRIP_TRAILING_WHITESPACE)

file(GLOB roots LIST_DIRECTORIES true ${CPACK_TEMPORARY_DIRECTORY}/*)
foreach(root ${roots})
  get_filename_component(package ${root} NAME)
  if(NOT IS_DIRECTORY ${root}/usr)
    continue()
  endif()
  file(GLOB programs ${root}/usr/bin/*)
  file(GLOB_RECURSE modules ${root}/usr/lib/*.so)
  foreach(program ${programs} ${modules})
    if(NOT IS_SYMLINK ${program})  # a name of drapefit
      file(RPATH_REMOVE FILE ${program})
    endif()
  endforeach()
  if(modules)
    run(strip --strip-unneeded ${modules})
    run(chmod 644 ${modules})
  endif()
  file(GLOB_RECURSE libraries ${root}/usr/lib/*.a)
  foreach(library ${libraries})
    run(strip --strip-debug --remove-section=.comment --remove-section=.note
        --enable-deterministic-archives ${library})
  endforeach()
  file(GLOB pages ${root}/usr/share/man/man1/*.1)
  foreach(page ${pages})
    run(gzip -9nf ${page})
  endforeach()

  set(documents ${root}/usr/share/doc/${package})
  file(MAKE_DIRECTORY ${documents})
  file(READ ${source}/copyright copyright)
  if(EXISTS ${root}/usr/bin/drape_report)
    execute_process(COMMAND awk -f ${source}/page_notices.awk ${CPACK_DRAPE_PAGE}
                    OUTPUT_VARIABLE notices COMMAND_ERROR_IS_FATAL ANY)
    string(APPEND copyright "${notices}")
  endif()
  file(WRITE ${documents}/copyright "${copyright}")
  configure_file(${CPACK_DRAPE_CHANGELOG} ${documents}/changelog COPYONLY)
  file(WRITE ${documents}/changelog.Debian
       "drapefit (${version}) unstable; urgency=medium\n\n"
       "  * Version ${CPACK_PACKAGE_VERSION}; what changed is in changelog.gz.\n\n"
       " -- ${CPACK_PACKAGE_CONTACT}  ${date}\n")
  run(gzip -9nf ${documents}/changelog ${documents}/changelog.Debian)
  configure_file(${source}/lintian_overrides ${root}/usr/share/lintian/overrides/${package} COPYONLY)
  run(find ${root}/usr -type d -exec chmod 755 {} +)
  run(find ${root}/usr -exec touch -h -d @${time} {} +)
endforeach()
