# Installs the build below itself, then builds and runs a consumer with what was installed.
set(place ${build}/install-test)
file(REMOVE_RECURSE ${place})
macro(run)
  execute_process(COMMAND ${ARGN} OUTPUT_VARIABLE output ERROR_VARIABLE output RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${ARGN}\n${output}")
  endif()
endmacro()
run(${CMAKE_COMMAND} --install ${build} --prefix ${place}/prefix)
# Nothing may lean on the build: only the installed files are named.
run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${place}/build -G Ninja -D CMAKE_C_COMPILER=${compiler}
  -D CMAKE_PREFIX_PATH=${place}/prefix)
run(${CMAKE_COMMAND} --build ${place}/build)
run(${CMAKE_CTEST_COMMAND} --test-dir ${place}/build --no-tests=error --output-on-failure)
