# gustlab_together(TARGET [TIMES N] [ALONE...]): files of a folder include the same headers and instantiate the same templates, so some of them are
# compiled as one. Names in a folder are unique; the files that share some (ALONE, parts of their paths) are compiled by themselves.
# TIMES N: so many times more files as one, where headers take most of the time.
set(GUSTLAB_TOGETHER 8 CACHE STRING "so many files of a folder are compiled as one; fewer: an edit is quicker, a whole build slower")
set(GUSTLAB_ALONE /score _loop /layouts /pendulum /rigid_body /swing_fit)  # of src/
function(gustlab_together target)
  cmake_parse_arguments(PARSE_ARGV 1 together "" TIMES "")
  if(NOT together_TIMES)
    set(together_TIMES 1)
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  get_target_property(sources ${target} SOURCES)
  foreach(alone IN ITEMS TARGET_OBJECTS ${together_UNPARSED_ARGUMENTS})
    list(FILTER sources EXCLUDE REGEX ${alone})
  endforeach()
  foreach(source IN LISTS sources)
    get_filename_component(folder ${source} DIRECTORY)
    file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR} ${folder})
    string(MAKE_C_IDENTIFIER ${folder} folder)
    math(EXPR group "0${count_${folder}} / (${together_TIMES} * ${GUSTLAB_TOGETHER})")
    math(EXPR count_${folder} "0${count_${folder}} + 1")
    set_source_files_properties(${source} TARGET_DIRECTORY ${target} PROPERTIES UNITY_GROUP ${folder}_${group})
  endforeach()
endfunction()
