# find_package(partscribe): the target partscribe::partscribe is the whole library, partscribe::fit and so on are its
# stages. The library is static: what it is made with has to be there.
include(CMakeFindDependencyMacro)
find_dependency(Threads)
find_dependency(Eigen3)
find_dependency(CGAL)
find_dependency(nlohmann_json)
find_dependency(OpenCASCADE)
find_dependency(PNG)
find_dependency(EXPAT)
find_dependency(PkgConfig)
pkg_check_modules(MINIZIP REQUIRED IMPORTED_TARGET minizip)
include(${CMAKE_CURRENT_LIST_DIR}/partscribe-targets.cmake)
