# Installs the build, moves the installed tree away from where it was installed, and lets tests/consumer find it there.
foreach(name IN ITEMS BUILD_DIR CONFIG SOURCE_DIR WORK_DIR GENERATOR CXX VERSION)
  if(NOT ${name})
    message(FATAL_ERROR "-D ${name}=... is missing")
  endif()
endforeach()

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE ${WORK_DIR})
run(${CMAKE_COMMAND} --install ${BUILD_DIR} --config ${CONFIG} --prefix ${WORK_DIR}/first)
file(RENAME ${WORK_DIR}/first ${WORK_DIR}/prefix)

file(GLOB_RECURSE package_files ${WORK_DIR}/prefix/*.cmake)
foreach(path IN LISTS package_files)
  file(READ ${path} text)
  foreach(dir IN ITEMS ${SOURCE_DIR} ${WORK_DIR})
    string(FIND "${text}" "${dir}" position)
    if(NOT position EQUAL -1)
      message(FATAL_ERROR "${path} names ${dir}: the package cannot be moved")
    endif()
  endforeach()
endforeach()

run(
  ${CMAKE_COMMAND}
  -S ${SOURCE_DIR}/tests/consumer
  -B ${WORK_DIR}/consumer
  -G ${GENERATOR}
  -D CMAKE_BUILD_TYPE=${CONFIG}
  -D CMAKE_CXX_COMPILER=${CXX}
  -D CMAKE_CXX_FLAGS=${CXX_FLAGS}
  -D CMAKE_PREFIX_PATH=${WORK_DIR}/prefix
  -D CMAKE_FIND_USE_PACKAGE_REGISTRY=OFF
  -D SBRDF_VERSION=${VERSION})
run(${CMAKE_COMMAND} --build ${WORK_DIR}/consumer --config ${CONFIG})
run(${WORK_DIR}/consumer/consumer)
if(PROGRAM)
  run(${WORK_DIR}/prefix/bin/sbrdf --version)
endif()
