# The Python module, built where pybind11 and Python's own headers are installed. A build that looks for faults makes
# none: no interpreter would load it.
if(NOT CMAKE_BUILD_TYPE STREQUAL Release)
  return()
endif()
set(Python_EXECUTABLE /usr/bin/python3 CACHE FILEPATH "the Python that the module is for")
set(PYBIND11_FINDPYTHON ON)
find_package(Python 3.9 QUIET COMPONENTS Interpreter Development.Module)
find_package(pybind11 2.9 QUIET CONFIG)
if(NOT Python_Development.Module_FOUND OR NOT pybind11_FOUND)
  message(STATUS "No Python module: it needs pybind11-dev and python3-dev (for ${Python_EXECUTABLE})")
  return()
endif()

pybind11_add_module(partscribe_python MODULE NO_EXTRAS python/arrays.cpp python/module.cpp python/run.cpp)
target_link_libraries(partscribe_python PRIVATE partscribe_cli)
# Nobody else's copy of a library meets those within.
target_link_options(partscribe_python PRIVATE -Wl,--exclude-libs,ALL)
target_compile_definitions(partscribe_python PRIVATE PARTSCRIBE_VERSION="${PROJECT_VERSION}")

# The package as it is imported from the build: PYTHONPATH=build/release/python. Beside the module stands the program,
# which reads STEP and IGES for it.
set(python_package ${PROJECT_BINARY_DIR}/python/partscribe)
set_target_properties(partscribe_python PROPERTIES OUTPUT_NAME _native LIBRARY_OUTPUT_DIRECTORY ${python_package}
  UNITY_BUILD OFF)
add_dependencies(partscribe_python partscribe)
file(MAKE_DIRECTORY ${python_package})
set(python_files)
foreach(file __init__.py errors.py results.py _native.pyi py.typed)
  list(APPEND python_files python/partscribe/${file})
  file(CREATE_LINK ${PROJECT_SOURCE_DIR}/python/partscribe/${file} ${python_package}/${file} SYMBOLIC)
endforeach()
file(CREATE_LINK ../../partscribe ${python_package}/partscribe SYMBOLIC)

# Where Debian's Python looks below /usr. A plain `cmake --install` leaves it out: its prefix may be none of Python's.
set(PARTSCRIBE_PYTHON_FOLDER lib/python3/dist-packages CACHE STRING "folder of Python packages below the prefix")
install(TARGETS partscribe_python LIBRARY DESTINATION ${PARTSCRIBE_PYTHON_FOLDER}/partscribe COMPONENT python
  EXCLUDE_FROM_ALL)
install(FILES ${python_files} DESTINATION ${PARTSCRIBE_PYTHON_FOLDER}/partscribe COMPONENT python EXCLUDE_FROM_ALL)
install(FILES ${PROJECT_BINARY_DIR}/generated/manual/changelog.gz cmake/copyright
  DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/python3-partscribe COMPONENT python EXCLUDE_FROM_ALL)
install(FILES examples/python/deviations.py
  DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/python3-partscribe/examples COMPONENT python EXCLUDE_FROM_ALL)
