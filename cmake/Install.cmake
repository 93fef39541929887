# `cmake --install build/release --prefix P` gives a tree that can be moved: P/bin/gustlab, P/lib with MuJoCo beside it,
# and P/share/gustlab with the models, configs, experiments and scripts the program looks for
include(GNUInstallDirs)

set_target_properties(gustlab PROPERTIES INSTALL_RPATH "$ORIGIN/../${CMAKE_INSTALL_LIBDIR}")
install(TARGETS gustlab RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
get_target_property(mujoco_imported MuJoCo::MuJoCo TYPE)
if(mujoco_imported STREQUAL "SHARED_LIBRARY")
  file(REAL_PATH ${MuJoCo_LIBRARY} mujoco_file)
  install(PROGRAMS ${mujoco_file} DESTINATION ${CMAKE_INSTALL_LIBDIR} RENAME libmujoco.so.${MuJoCo_VERSION})
endif()
install(DIRECTORY models configs experiments scripts DESTINATION ${CMAKE_INSTALL_DATADIR}/gustlab
  USE_SOURCE_PERMISSIONS PATTERN "__pycache__" EXCLUDE)
