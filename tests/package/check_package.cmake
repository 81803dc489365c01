# cmake -D ... -P check_package.cmake: installs the build into a scratch prefix, then configures, builds and runs the
# project beside this file against it.
function(run what)
  message(STATUS ${what})
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "${what} failed (${result}).\n  ${command}\n${output}")
  endif()
endfunction()

file(REMOVE_RECURSE ${SCRATCH})
run("install" ${CMAKE_COMMAND} --install ${BINARY_DIR} --prefix ${SCRATCH}/prefix)

# A package that remembers where it was built breaks on the next machine.
file(GLOB_RECURSE package_files ${SCRATCH}/prefix/*.cmake)
foreach(file ${package_files})
  file(READ ${file} text)
  foreach(folder ${SOURCE_DIR} ${BINARY_DIR} ${SCRATCH})
    string(FIND "${text}" "${folder}/" found)
    if(NOT found EQUAL -1)
      message(FATAL_ERROR "${file} names the build's own folder ${folder}.")
    endif()
  endforeach()
endforeach()

run("configure" ${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${SCRATCH}/build -G ${GENERATOR}
    -D CMAKE_PREFIX_PATH=${SCRATCH}/prefix -D CMAKE_BUILD_TYPE=${BUILD_TYPE} -D CMAKE_CXX_COMPILER=${CXX}
    -D CMAKE_CXX_FLAGS=${CXX_FLAGS} -D CMAKE_EXE_LINKER_FLAGS=${LINK_FLAGS})
run("build" ${CMAKE_COMMAND} --build ${SCRATCH}/build)
run("run" ${SCRATCH}/build/app)
