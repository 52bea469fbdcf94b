#----------------------------------------------------------------
# Generated CMake target import file for configuration "Debug".
#----------------------------------------------------------------

# Commands may need to know the format version.
set(CMAKE_IMPORT_FILE_VERSION 1)

# Import target "kith::kith1d" for configuration "Debug"
set_property(TARGET kith::kith1d APPEND PROPERTY IMPORTED_CONFIGURATIONS DEBUG)
set_target_properties(kith::kith1d PROPERTIES
  IMPORTED_LINK_INTERFACE_LANGUAGES_DEBUG "C"
  IMPORTED_LOCATION_DEBUG "${_IMPORT_PREFIX}/lib/libkith1d.a"
  )

list(APPEND _cmake_import_check_targets kith::kith1d )
list(APPEND _cmake_import_check_files_for_kith::kith1d "${_IMPORT_PREFIX}/lib/libkith1d.a" )

# Commands beyond this point should not need to know the version.
set(CMAKE_IMPORT_FILE_VERSION)
