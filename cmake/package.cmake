# The Debian packages that CPack makes: partscribe of the component `program`, python3-partscribe of `python`.

set(PARTSCRIBE_MAINTAINER "The Partscribe maintainers <maintainers@partscribe.invalid>" CACHE STRING
  "who answers for a Debian package that is made here")
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "${PARTSCRIBE_MAINTAINER}")
set(CPACK_COMPONENTS_ALL program)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)

set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME partscribe)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION graphics)
# `build` and `verify` run the scripts that were written, and confine what they run where they can.
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS openscad)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS bubblewrap)
set(CPACK_DEBIAN_PROGRAM_DESCRIPTION
"Partscribe reads 3-D scans of a part and writes the part as an editable CAD
procedure: named dimensions and named steps, not a bag of triangles. One run
writes OpenSCAD, Alpha_1 SCL, IGES and STEP. Then every file is run by its own
program, and what comes out is compared with the scan in both directions.")

if(TARGET partscribe_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-partscribe)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  # The module is for one version of Python, and the program of its own version reads STEP and IGES for it.
  math(EXPR next "${Python_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3 (>= ${Python_VERSION_MAJOR}.${Python_VERSION_MINOR}~), python3 (<< \
${Python_VERSION_MAJOR}.${next}), python3-numpy, partscribe (= ${PROJECT_VERSION})")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA
    "${PROJECT_SOURCE_DIR}/cmake/debian/postinst;${PROJECT_SOURCE_DIR}/cmake/debian/prerm")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_STRICT_PERMISSION ON)
  set(CPACK_DEBIAN_PYTHON_DESCRIPTION
"Partscribe as a Python package: scans and deviations as numpy arrays, builds,
measurements and verdicts as Python objects.")
endif()
include(CPack)
