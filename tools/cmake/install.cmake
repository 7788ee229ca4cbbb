# What is installed, by component: runtime (the shared library), development (header, package files, archive or link to
# the shared library), program.
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)

set(sbrdf_is_static ON)
if(BUILD_SHARED_LIBS)
  set(sbrdf_is_static OFF)
endif()
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/sbrdf)
install(
  TARGETS sbrdf_library
  EXPORT sbrdfTargets
  RUNTIME COMPONENT runtime
  LIBRARY COMPONENT runtime NAMELINK_COMPONENT development
  ARCHIVE COMPONENT development
  FILE_SET HEADERS COMPONENT development)
install(EXPORT sbrdfTargets NAMESPACE sbrdf:: DESTINATION ${package_dir} COMPONENT development)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/sbrdfConfig.cmake.in ${PROJECT_BINARY_DIR}/sbrdfConfig.cmake
                              INSTALL_DESTINATION ${package_dir})
# Before 1.0 each minor version may change the interface.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/sbrdfConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(
  FILES ${PROJECT_BINARY_DIR}/sbrdfConfig.cmake ${PROJECT_BINARY_DIR}/sbrdfConfigVersion.cmake
  DESTINATION ${package_dir}
  COMPONENT development)

if(IS_ABSOLUTE "${CMAKE_INSTALL_LIBDIR}" OR IS_ABSOLUTE "${CMAKE_INSTALL_INCLUDEDIR}")
  message(FATAL_ERROR "CMAKE_INSTALL_LIBDIR and CMAKE_INSTALL_INCLUDEDIR must be relative to the prefix")
endif()
# pkg-config: paths relative to the file itself, so that the installed tree can be moved.
file(RELATIVE_PATH pc_to_prefix /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
set(pc_private "libzstd fmt libhwy zlib hdf5 OpenEXR pugixml qhull_r")
if(SBRDF_WITH_TBB)
  string(APPEND pc_private " tbb")
endif()
set(pc_requires "Requires.private: ${pc_private}")
if(sbrdf_is_static)
  # There is nothing but the archive to link, so what it needs is needed always.
  set(pc_requires "Requires: ${pc_private}")
  set(pc_public_libraries " -lhdf5_hl") # belongs to hdf5, whose own file does not name it
endif()
configure_file(${CMAKE_CURRENT_LIST_DIR}/sbrdf.pc.in ${PROJECT_BINARY_DIR}/sbrdf.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/sbrdf.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT development)

if(TARGET sbrdf)
  install(TARGETS sbrdf RUNTIME COMPONENT program)
endif()
