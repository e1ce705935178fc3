# SPDX-License-Identifier: Apache-2.0
# Debian packages of a release build (tools/README.md, "Packages"): in its folder `cpack -B packages`.
#   drapefit             programs, manual pages, completion, configs/
#   libdrapefit-dev      headers, static libraries, CMake package
#   python3-drapefit     the Python module, where the component `python` is installed
#   drapefit-cuda        in place of the others from a build with CUDA: as drapefit, with the GPU
set(DRAPE_PACKAGE_MAINTAINER "The drapefit maintainers <maintainers@drapefit.invalid>" CACHE STRING
    "Maintainer of the Debian packages, with an address of whoever distributes them")
set(DRAPE_PACKAGE_SOURCE_DIR ${PROJECT_SOURCE_DIR}/tools/setup/packaging/debian)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME drapefit)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each package has its own
set(CPACK_PACKAGE_VENDOR "The drapefit maintainers")
set(CPACK_PACKAGE_CONTACT "${DRAPE_PACKAGE_MAINTAINER}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
# What CMake's install rules do not know of Debian: each package is finished in its own folder.
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/tools/setup/cmake/drapefitFinishPackages.cmake)
set(CPACK_DRAPE_PACKAGE_SOURCE_DIR ${DRAPE_PACKAGE_SOURCE_DIR})
set(CPACK_DRAPE_CHANGELOG ${PROJECT_SOURCE_DIR}/CHANGELOG.md)
set(CPACK_DRAPE_PAGE ${PROJECT_SOURCE_DIR}/tools/programs/results/report/page/template.html)

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_SOURCE drapefit)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(CPACK_COMPONENTS_ALL "")
# drape_package(<name> SECTION ... SUMMARY ... DESCRIPTION ... [SHLIBDEPS] [DEPENDS ...]
# [RECOMMENDS ...] [SUGGESTS ...] [CONFLICTS ...] COMPONENTS ...): a package of install components.
macro(drape_package name)
  cmake_parse_arguments(ARG SHLIBDEPS "SECTION;SUMMARY;DESCRIPTION"
                        "DEPENDS;RECOMMENDS;SUGGESTS;CONFLICTS;COMPONENTS" ${ARGN})
  string(TOUPPER ${name} upper)
  foreach(component ${ARG_COMPONENTS})
    string(TOUPPER ${component} COMPONENT)
    set(CPACK_COMPONENT_${COMPONENT}_GROUP ${name})
    list(APPEND CPACK_COMPONENTS_ALL ${component})
  endforeach()
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${name})
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${ARG_SECTION})
  set(CPACK_DEBIAN_${upper}_PACKAGE_SHLIBDEPS ${ARG_SHLIBDEPS})
  set(CPACK_DEBIAN_${upper}_DESCRIPTION "${ARG_SUMMARY}\n${ARG_DESCRIPTION}")
  foreach(kind DEPENDS RECOMMENDS SUGGESTS CONFLICTS)
    list(JOIN ARG_${kind} ", " joined)
    set(CPACK_DEBIAN_${upper}_PACKAGE_${kind} "${joined}")
  endforeach()
endmacro()

set(programs_text "drapefit estimates the stretching and bending stiffness of a fabric from
photographs of the Cusick drape test (BS 5058, ISO 9073-9). It simulates the
drape, differentiates the simulation exactly, and fits the material by
nonlinear least squares.")
set(library_text "drapefit simulates hanging cloth, differentiates the simulation exactly, and
fits its material to silhouettes by nonlinear least squares.")
if(DRAPE_CUDA)
  drape_package(drapefit-cuda
    SECTION science
    SUMMARY "fabric stiffness from Cusick drape tests (programs for GPUs)"
    DESCRIPTION "${programs_text}
This package has the programs, fabrics and configurations. They use GPUs of
NVIDIA where there are any."
    SHLIBDEPS
    RECOMMENDS python3-jinja2 python3-matplotlib
    CONFLICTS drapefit
    COMPONENTS programs configs)
  set(CPACK_DEBIAN_DRAPEFIT-CUDA_PACKAGE_PROVIDES drapefit)
  set(CPACK_DEBIAN_DRAPEFIT-CUDA_PACKAGE_REPLACES drapefit)
else()
  drape_package(drapefit
    SECTION science
    SUMMARY "fabric stiffness from Cusick drape tests (programs)"
    DESCRIPTION "${programs_text}
This package has the programs, fabrics and configurations."
    SHLIBDEPS
    RECOMMENDS python3-jinja2 python3-matplotlib
    COMPONENTS programs configs)
  drape_package(libdrapefit-dev
    SECTION libdevel
    SUMMARY "fabric stiffness from Cusick drape tests (development files)"
    DESCRIPTION "${library_text}
This package has the headers, the static libraries and the CMake package:
find_package(drapefit), then link drape::solver."
    DEPENDS g++ libceres-dev libcgal-dev libeigen3-dev libexif-dev libgflags-dev libgoogle-glog-dev
            libmetis-dev libopencv-core-dev libopencv-imgproc-dev libpng-dev libsuitesparse-dev
            libturbojpeg0-dev nettle-dev nlohmann-json3-dev zlib1g-dev
    SUGGESTS cmake
    COMPONENTS devel)
  # The Python module, where its component is installed; it is of one version of Python.
  get_cmake_property(installed COMPONENTS)
  if(python IN_LIST installed)
    find_package(Python3 REQUIRED COMPONENTS Interpreter)
    math(EXPR next "${Python3_VERSION_MINOR} + 1")
    drape_package(python3-drapefit
      SECTION python
      SUMMARY "fabric stiffness from Cusick drape tests (Python module)"
      DESCRIPTION "${library_text}
This package has the Python module."
      SHLIBDEPS
      DEPENDS "python3 (>= 3.${Python3_VERSION_MINOR}~)" "python3 (<< 3.${next})" python3-numpy
      COMPONENTS python)
  endif()
endif()

set(CPACK_DEBIAN_PYTHON3-DRAPEFIT_PACKAGE_CONTROL_EXTRA
    ${DRAPE_PACKAGE_SOURCE_DIR}/python3/postinst ${DRAPE_PACKAGE_SOURCE_DIR}/python3/prerm)
# A program compiled for AVX2 says so before it is installed, not by an illegal instruction.
get_target_property(machine_flags drape_build_flags INTERFACE_COMPILE_OPTIONS)
if(machine_flags MATCHES "x86-64-v3")
  foreach(name DRAPEFIT DRAPEFIT-CUDA LIBDRAPEFIT-DEV PYTHON3-DRAPEFIT)
    list(APPEND CPACK_DEBIAN_${name}_PACKAGE_CONTROL_EXTRA ${DRAPE_PACKAGE_SOURCE_DIR}/preinst)
  endforeach()
endif()
include(CPack)
