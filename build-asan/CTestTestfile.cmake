# CMake generated Testfile for 
# Source directory: /work/trees/chart
# Build directory: /work/trees/chart/build-asan
# 
# This file includes the relevant testing commands required for 
# testing this directory and lists subdirectories to be tested as well.
add_test([=[install]=] "/usr/bin/cmake" "-D" "build=/work/trees/chart/build-asan" "-D" "compiler=/usr/bin/cc" "-P" "/work/trees/chart/tests/install/install.cmake")
set_tests_properties([=[install]=] PROPERTIES  LABELS "scene" TIMEOUT "120" _BACKTRACE_TRIPLES "/work/trees/chart/CMakeLists.txt;102;add_test;/work/trees/chart/CMakeLists.txt;0;")
add_test([=[launcher]=] "/work/trees/chart/tests/launcher.sh" "/work/trees/chart/build-asan/bin/kith")
set_tests_properties([=[launcher]=] PROPERTIES  LABELS "scene" TIMEOUT "120" _BACKTRACE_TRIPLES "/work/trees/chart/CMakeLists.txt;104;add_test;/work/trees/chart/CMakeLists.txt;0;")
subdirs("tests")
