# FindMuJoCo: defines the imported target MuJoCo::MuJoCo and MuJoCo_VERSION.
#
# Looked for in this order; the first place that is named or present decides:
#   1. MUJOCO_ROOT (cache or environment): a folder with include/mujoco/mujoco.h and the library in it, lib/ or bin/
#   2. a CMake package of the version asked for (`mujoco::mujoco`)
#   3. the wheel `mujoco-core` in <repository>/.venv, which scripts/setup.sh installs; it has no unversioned link

include(FindPackageHandleStandardArgs)

set(_mujoco_advice "Run scripts/setup.sh, or set MUJOCO_ROOT to a MuJoCo ${MuJoCo_FIND_VERSION} release.")
get_filename_component(_mujoco_repository ${CMAKE_CURRENT_LIST_DIR} DIRECTORY)
if(NOT MUJOCO_ROOT)
  set(MUJOCO_ROOT "$ENV{MUJOCO_ROOT}")
endif()

# where to look: the named folder, else the package, else the wheel
set(_mujoco_place "")
if(MUJOCO_ROOT)
  set(_mujoco_place ${MUJOCO_ROOT})
  set(_mujoco_advice "MUJOCO_ROOT is ${MUJOCO_ROOT}: unset it to use .venv (scripts/setup.sh), or name a MuJoCo ${MuJoCo_FIND_VERSION} release.")
else()
  find_package(mujoco ${MuJoCo_FIND_VERSION} EXACT CONFIG QUIET)
  if(NOT mujoco_FOUND)
    file(GLOB _mujoco_place ${_mujoco_repository}/.venv/lib/python3*/site-packages/mujoco)
  endif()
endif()

if(mujoco_FOUND AND NOT MUJOCO_ROOT)
  set(MuJoCo_VERSION ${mujoco_VERSION})
  set(MuJoCo_LIBRARY mujoco::mujoco)
  get_target_property(MuJoCo_INCLUDE_DIR mujoco::mujoco INTERFACE_INCLUDE_DIRECTORIES)
elseif(_mujoco_place)
  find_path(MuJoCo_INCLUDE_DIR mujoco/mujoco.h PATHS ${_mujoco_place} PATH_SUFFIXES include NO_DEFAULT_PATH NO_CACHE)
  find_library(MuJoCo_LIBRARY NAMES libmujoco.so.${MuJoCo_FIND_VERSION} mujoco
    PATHS ${_mujoco_place} PATH_SUFFIXES lib bin . NO_DEFAULT_PATH NO_CACHE)
endif()

# the version the headers declare: mjVERSION_HEADER is major * 10^6 + minor * 10^3 + patch
if(NOT MuJoCo_VERSION AND MuJoCo_INCLUDE_DIR)
  file(STRINGS ${MuJoCo_INCLUDE_DIR}/mujoco/mujoco.h _mujoco_line REGEX "define mjVERSION_HEADER")
  string(REGEX MATCH "[0-9]+" _mujoco_number "${_mujoco_line}")
  if(_mujoco_number GREATER_EQUAL 1000000)
    math(EXPR _mujoco_major "${_mujoco_number} / 1000000")
    math(EXPR _mujoco_minor "${_mujoco_number} / 1000 % 1000")
    math(EXPR _mujoco_patch "${_mujoco_number} % 1000")
    set(MuJoCo_VERSION ${_mujoco_major}.${_mujoco_minor}.${_mujoco_patch})
  elseif(_mujoco_number)
    # releases before 4 wrote 337 for 3.3.7
    string(REGEX REPLACE "^(.)(.)(.+)$" "\\1.\\2.\\3" MuJoCo_VERSION ${_mujoco_number})
  endif()
endif()

find_package_handle_standard_args(MuJoCo
  REQUIRED_VARS MuJoCo_LIBRARY MuJoCo_INCLUDE_DIR
  VERSION_VAR MuJoCo_VERSION
  REASON_FAILURE_MESSAGE "${_mujoco_advice}")

if(MuJoCo_FOUND AND NOT TARGET MuJoCo::MuJoCo)
  if(TARGET mujoco::mujoco)
    add_library(MuJoCo::MuJoCo INTERFACE IMPORTED)
    target_link_libraries(MuJoCo::MuJoCo INTERFACE mujoco::mujoco)
  else()
    add_library(MuJoCo::MuJoCo SHARED IMPORTED)
    set_target_properties(MuJoCo::MuJoCo PROPERTIES
      IMPORTED_LOCATION ${MuJoCo_LIBRARY}
      IMPORTED_SONAME libmujoco.so.${MuJoCo_VERSION}
      INTERFACE_INCLUDE_DIRECTORIES ${MuJoCo_INCLUDE_DIR})
  endif()
endif()
