# `cmake --install build/release --prefix P` gives a tree that can be moved:
#   P/bin/gustlab, P/lib with MuJoCo beside it, P/share/gustlab with the models, configs, experiments, scripts and schemas;
#   P/share/man and completions for bash, zsh and fish, which the program prints itself;
#   P/include and P/lib/cmake/gustlab: find_package(gustlab) gives gustlab::core (see examples/hover)
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set_target_properties(gustlab PROPERTIES INSTALL_RPATH "$ORIGIN/../${CMAKE_INSTALL_LIBDIR}")
install(TARGETS gustlab RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
get_target_property(mujoco_imported MuJoCo::MuJoCo TYPE)
if(mujoco_imported STREQUAL "SHARED_LIBRARY")
  file(REAL_PATH ${MuJoCo_LIBRARY} mujoco_file)
  install(PROGRAMS ${mujoco_file} DESTINATION ${CMAKE_INSTALL_LIBDIR} RENAME libmujoco.so.${MuJoCo_VERSION})
endif()
install(DIRECTORY models configs experiments scripts schemas DESTINATION ${CMAKE_INSTALL_DATADIR}/gustlab
  USE_SOURCE_PERMISSIONS PATTERN "__pycache__" EXCLUDE)
install(FILES LICENSE CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR})

# man page and completions: [file of the install tree, what prints it]
foreach(made "${CMAKE_INSTALL_MANDIR}/man1/gustlab.1|man" "${CMAKE_INSTALL_DATADIR}/bash-completion/completions/gustlab|completion;bash"
        "${CMAKE_INSTALL_DATADIR}/zsh/site-functions/_gustlab|completion;zsh" "${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d/gustlab.fish|completion;fish")
  string(REGEX MATCH "^[^|]*" file "${made}")
  string(REGEX REPLACE "^[^|]*[|]" "" arguments "${made}")
  get_filename_component(folder ${file} DIRECTORY)
  get_filename_component(name ${file} NAME)
  string(MAKE_C_IDENTIFIER ${file} made_name)
  set(made_file ${PROJECT_BINARY_DIR}/generated/${made_name})
  install(CODE "execute_process(COMMAND \"$<TARGET_FILE:gustlab>\" ${arguments} OUTPUT_FILE \"${made_file}\" COMMAND_ERROR_IS_FATAL ANY)")
  install(FILES ${made_file} DESTINATION ${folder} RENAME ${name})
endforeach()

# the library: include/gustlab is what the author of a plug-in reads, include/gustlab/src what the rest of the program uses
install(TARGETS gustlab_core EXPORT gustlab ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
set_target_properties(gustlab_core PROPERTIES EXPORT_NAME core)
install(DIRECTORY include/gustlab DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(DIRECTORY src/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/gustlab/src FILES_MATCHING PATTERN "*.hpp")
install(EXPORT gustlab NAMESPACE gustlab:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/gustlab FILE gustlabTargets.cmake)
configure_package_config_file(cmake/gustlabConfig.cmake.in ${PROJECT_BINARY_DIR}/gustlabConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/gustlab PATH_VARS CMAKE_INSTALL_LIBDIR)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/gustlabConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/gustlabConfig.cmake ${PROJECT_BINARY_DIR}/gustlabConfigVersion.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/gustlab)
