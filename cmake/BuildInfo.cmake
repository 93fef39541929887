# adds the target `build_info`: the one source file that knows commit, compiler and flags. The script part runs at
# every build and rewrites the file only when its text changes, so a commit recompiles this file alone.

if(CMAKE_SCRIPT_MODE_FILE)
  set(BUILD_COMMIT unknown)
  if(EXISTS ${SOURCE_DIR}/.git)
    execute_process(
      COMMAND ${CMAKE_COMMAND} -E env GIT_OPTIONAL_LOCKS=0
        git -c safe.directory=* describe --always --dirty --abbrev=12 --exclude=*
      WORKING_DIRECTORY ${SOURCE_DIR} OUTPUT_VARIABLE described OUTPUT_STRIP_TRAILING_WHITESPACE
      RESULT_VARIABLE git_failed ERROR_QUIET)
    if(NOT git_failed)
      set(BUILD_COMMIT ${described})
    endif()
  endif()
  configure_file(${CMAKE_CURRENT_LIST_DIR}/build_info.cpp.in ${OUTPUT} @ONLY)
  return()
endif()

string(TOUPPER "${CMAKE_BUILD_TYPE}" _configuration)
string(STRIP "${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_${_configuration}} ${GUSTLAB_FP_FLAGS}" _flags)
set(_build_info ${PROJECT_BINARY_DIR}/generated/build_info.cpp)
add_custom_target(build_info_text
  COMMAND ${CMAKE_COMMAND}
    -DSOURCE_DIR=${PROJECT_SOURCE_DIR} -DOUTPUT=${_build_info}
    -DBUILD_VERSION=${PROJECT_VERSION} -DBUILD_MUJOCO=${MuJoCo_VERSION}
    "-DBUILD_COMPILER=${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION}" "-DBUILD_FLAGS=${_flags}"
    -P ${CMAKE_CURRENT_LIST_FILE}
  BYPRODUCTS ${_build_info}
  COMMENT "Reading the commit" VERBATIM)
add_library(build_info OBJECT ${_build_info})
target_include_directories(build_info PRIVATE ${PROJECT_SOURCE_DIR}/include)
add_dependencies(build_info build_info_text)
