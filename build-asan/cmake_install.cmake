# Install script for directory: /work/trees/chart

# Set the install prefix
if(NOT DEFINED CMAKE_INSTALL_PREFIX)
  set(CMAKE_INSTALL_PREFIX "/usr/local")
endif()
string(REGEX REPLACE "/$" "" CMAKE_INSTALL_PREFIX "${CMAKE_INSTALL_PREFIX}")

# Set the install configuration name.
if(NOT DEFINED CMAKE_INSTALL_CONFIG_NAME)
  if(BUILD_TYPE)
    string(REGEX REPLACE "^[^A-Za-z0-9_]+" ""
           CMAKE_INSTALL_CONFIG_NAME "${BUILD_TYPE}")
  else()
    set(CMAKE_INSTALL_CONFIG_NAME "Debug")
  endif()
  message(STATUS "Install configuration: \"${CMAKE_INSTALL_CONFIG_NAME}\"")
endif()

# Set the component getting installed.
if(NOT CMAKE_INSTALL_COMPONENT)
  if(COMPONENT)
    message(STATUS "Install component: \"${COMPONENT}\"")
    set(CMAKE_INSTALL_COMPONENT "${COMPONENT}")
  else()
    set(CMAKE_INSTALL_COMPONENT)
  endif()
endif()

# Install shared libraries without execute permission?
if(NOT DEFINED CMAKE_INSTALL_SO_NO_EXE)
  set(CMAKE_INSTALL_SO_NO_EXE "1")
endif()

# Is this installation the result of a crosscompile?
if(NOT DEFINED CMAKE_CROSSCOMPILING)
  set(CMAKE_CROSSCOMPILING "FALSE")
endif()

# Set default install directory permissions.
if(NOT DEFINED CMAKE_OBJDUMP)
  set(CMAKE_OBJDUMP "/usr/bin/objdump")
endif()

if(NOT CMAKE_INSTALL_LOCAL_ONLY)
  # Include the install script for the subdirectory.
  include("/work/trees/chart/build-asan/tests/cmake_install.cmake")
endif()

if(CMAKE_INSTALL_COMPONENT STREQUAL "Unspecified" OR NOT CMAKE_INSTALL_COMPONENT)
  if(EXISTS "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/bin/kith" AND
     NOT IS_SYMLINK "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/bin/kith")
    file(RPATH_CHECK
         FILE "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/bin/kith"
         RPATH "")
  endif()
  file(INSTALL DESTINATION "${CMAKE_INSTALL_PREFIX}/bin" TYPE EXECUTABLE FILES "/work/trees/chart/build-asan/bin/kith")
  if(EXISTS "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/bin/kith" AND
     NOT IS_SYMLINK "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/bin/kith")
    if(CMAKE_INSTALL_DO_STRIP)
      execute_process(COMMAND "/usr/bin/strip" "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/bin/kith")
    endif()
  endif()
endif()

if(CMAKE_INSTALL_COMPONENT STREQUAL "Unspecified" OR NOT CMAKE_INSTALL_COMPONENT)
  file(INSTALL DESTINATION "${CMAKE_INSTALL_PREFIX}/share/kith" TYPE DIRECTORY FILES "/work/trees/chart/inputs" FILES_MATCHING REGEX "/[^/]*\\.yaml$" REGEX "/[^/]*\\.csv$")
endif()

if(CMAKE_INSTALL_COMPONENT STREQUAL "Unspecified" OR NOT CMAKE_INSTALL_COMPONENT)
  if(EXISTS "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/bin/kith-1d" AND
     NOT IS_SYMLINK "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/bin/kith-1d")
    file(RPATH_CHECK
         FILE "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/bin/kith-1d"
         RPATH "")
  endif()
  file(INSTALL DESTINATION "${CMAKE_INSTALL_PREFIX}/bin" TYPE EXECUTABLE FILES "/work/trees/chart/build-asan/bin/kith-1d")
  if(EXISTS "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/bin/kith-1d" AND
     NOT IS_SYMLINK "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/bin/kith-1d")
    file(RPATH_CHANGE
         FILE "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/bin/kith-1d"
         OLD_RPATH "/usr/lib/x86_64-linux-gnu/hdf5/openmpi:/usr/lib/x86_64-linux-gnu/openmpi/lib:"
         NEW_RPATH "")
    if(CMAKE_INSTALL_DO_STRIP)
      execute_process(COMMAND "/usr/bin/strip" "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/bin/kith-1d")
    endif()
  endif()
endif()

if(CMAKE_INSTALL_COMPONENT STREQUAL "Unspecified" OR NOT CMAKE_INSTALL_COMPONENT)
  file(INSTALL DESTINATION "${CMAKE_INSTALL_PREFIX}/lib" TYPE STATIC_LIBRARY FILES "/work/trees/chart/build-asan/libkith1d.a")
endif()

if(CMAKE_INSTALL_COMPONENT STREQUAL "Unspecified" OR NOT CMAKE_INSTALL_COMPONENT)
  file(INSTALL DESTINATION "${CMAKE_INSTALL_PREFIX}/include/kith/boundaries" TYPE FILE FILES
    "/work/trees/chart/boundaries/boundary.h"
    "/work/trees/chart/boundaries/images.h"
    )
  file(INSTALL DESTINATION "${CMAKE_INSTALL_PREFIX}/include/kith/integrator" TYPE FILE FILES
    "/work/trees/chart/integrator/integrator.h"
    "/work/trees/chart/integrator/stages.h"
    "/work/trees/chart/integrator/vector.h"
    )
  file(INSTALL DESTINATION "${CMAKE_INSTALL_PREFIX}/include/kith/lib/connectivity" TYPE FILE FILES
    "/work/trees/chart/lib/connectivity/connectivity.h"
    "/work/trees/chart/lib/connectivity/excluder.h"
    "/work/trees/chart/lib/connectivity/internal.h"
    "/work/trees/chart/lib/connectivity/rebuild.h"
    "/work/trees/chart/lib/connectivity/shield.h"
    "/work/trees/chart/lib/connectivity/traversal.h"
    )
  file(INSTALL DESTINATION "${CMAKE_INSTALL_PREFIX}/include/kith/lib/core" TYPE FILE FILES
    "/work/trees/chart/lib/core/base.h"
    "/work/trees/chart/lib/core/family.h"
    "/work/trees/chart/lib/core/key.h"
    "/work/trees/chart/lib/core/lanes.h"
    "/work/trees/chart/lib/core/profile.h"
    "/work/trees/chart/lib/core/vec.h"
    )
  file(INSTALL DESTINATION "${CMAKE_INSTALL_PREFIX}/include/kith/lib/io" TYPE FILE FILES
    "/work/trees/chart/lib/io/atomic_file.h"
    "/work/trees/chart/lib/io/checkpoint.h"
    "/work/trees/chart/lib/io/json.h"
    "/work/trees/chart/lib/io/snapshot.h"
    )
  file(INSTALL DESTINATION "${CMAKE_INSTALL_PREFIX}/include/kith/lib/neighbor" TYPE FILE FILES
    "/work/trees/chart/lib/neighbor/grid.h"
    "/work/trees/chart/lib/neighbor/keyed.h"
    "/work/trees/chart/lib/neighbor/search.h"
    )
  file(INSTALL DESTINATION "${CMAKE_INSTALL_PREFIX}/include/kith/lib/nodes" TYPE FILE FILES "/work/trees/chart/lib/nodes/nodes.h")
  file(INSTALL DESTINATION "${CMAKE_INSTALL_PREFIX}/include/kith/physics" TYPE FILE FILES
    "/work/trees/chart/physics/density.h"
    "/work/trees/chart/physics/eos.h"
    "/work/trees/chart/physics/force.h"
    "/work/trees/chart/physics/hydro.h"
    "/work/trees/chart/physics/kernel.h"
    "/work/trees/chart/physics/package.h"
    )
  file(INSTALL DESTINATION "${CMAKE_INSTALL_PREFIX}/include/kith/physics/sph" TYPE FILE FILES "/work/trees/chart/physics/sph/sph.h")
endif()

if(CMAKE_INSTALL_COMPONENT STREQUAL "Unspecified" OR NOT CMAKE_INSTALL_COMPONENT)
  if(EXISTS "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/lib/cmake/kith/kith-targets.cmake")
    file(DIFFERENT _cmake_export_file_changed FILES
         "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/lib/cmake/kith/kith-targets.cmake"
         "/work/trees/chart/build-asan/CMakeFiles/Export/35ac3461f978b6f9a5682777ecf5fe5b/kith-targets.cmake")
    if(_cmake_export_file_changed)
      file(GLOB _cmake_old_config_files "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/lib/cmake/kith/kith-targets-*.cmake")
      if(_cmake_old_config_files)
        string(REPLACE ";" ", " _cmake_old_config_files_text "${_cmake_old_config_files}")
        message(STATUS "Old export file \"$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/lib/cmake/kith/kith-targets.cmake\" will be replaced.  Removing files [${_cmake_old_config_files_text}].")
        unset(_cmake_old_config_files_text)
        file(REMOVE ${_cmake_old_config_files})
      endif()
      unset(_cmake_old_config_files)
    endif()
    unset(_cmake_export_file_changed)
  endif()
  file(INSTALL DESTINATION "${CMAKE_INSTALL_PREFIX}/lib/cmake/kith" TYPE FILE FILES "/work/trees/chart/build-asan/CMakeFiles/Export/35ac3461f978b6f9a5682777ecf5fe5b/kith-targets.cmake")
  if(CMAKE_INSTALL_CONFIG_NAME MATCHES "^([Dd][Ee][Bb][Uu][Gg])$")
    file(INSTALL DESTINATION "${CMAKE_INSTALL_PREFIX}/lib/cmake/kith" TYPE FILE FILES "/work/trees/chart/build-asan/CMakeFiles/Export/35ac3461f978b6f9a5682777ecf5fe5b/kith-targets-debug.cmake")
  endif()
endif()

if(CMAKE_INSTALL_COMPONENT STREQUAL "Unspecified" OR NOT CMAKE_INSTALL_COMPONENT)
  file(INSTALL DESTINATION "${CMAKE_INSTALL_PREFIX}/lib/cmake/kith" TYPE FILE FILES
    "/work/trees/chart/build-asan/kith-config.cmake"
    "/work/trees/chart/build-asan/kith-config-version.cmake"
    )
endif()

if(CMAKE_INSTALL_COMPONENT)
  set(CMAKE_INSTALL_MANIFEST "install_manifest_${CMAKE_INSTALL_COMPONENT}.txt")
else()
  set(CMAKE_INSTALL_MANIFEST "install_manifest.txt")
endif()

string(REPLACE ";" "\n" CMAKE_INSTALL_MANIFEST_CONTENT
       "${CMAKE_INSTALL_MANIFEST_FILES}")
file(WRITE "/work/trees/chart/build-asan/${CMAKE_INSTALL_MANIFEST}"
     "${CMAKE_INSTALL_MANIFEST_CONTENT}")
