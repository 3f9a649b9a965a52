# What `cmake --install` lays down, in two components: `program`, and `library`, which other programs find with
# find_package(partscribe). A third one, `python`, is python/CMakeLists.txt's.

include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# ---- The program, and its manual page and completions as it prints them. ----
set(made ${PROJECT_BINARY_DIR}/generated/manual)
file(MAKE_DIRECTORY ${made})
# Whole or not at all: what failed half-way would pass for made.
add_custom_command(
  OUTPUT ${made}/partscribe.1.gz ${made}/partscribe ${made}/_partscribe ${made}/partscribe.fish ${made}/changelog.gz
  COMMAND partscribe help --completion bash > ${made}/partscribe
  COMMAND partscribe help --completion zsh > ${made}/_partscribe
  COMMAND partscribe help --completion fish > ${made}/partscribe.fish
  COMMAND partscribe help --man > ${made}/partscribe.1
  COMMAND gzip -9nf ${made}/partscribe.1
  COMMAND gzip -9nc ${PROJECT_SOURCE_DIR}/CHANGELOG.md > ${made}/changelog.gz
  DEPENDS partscribe ${PROJECT_SOURCE_DIR}/CHANGELOG.md
  COMMENT "Writing the manual page and completions" VERBATIM)
add_custom_target(manual ALL DEPENDS ${made}/partscribe.1.gz)

install(TARGETS partscribe RUNTIME COMPONENT program)
install(FILES ${made}/partscribe.1.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program)
install(FILES ${made}/partscribe DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT program)
install(FILES ${made}/_partscribe DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions COMPONENT program)
install(FILES ${made}/partscribe.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d
  COMPONENT program)
install(FILES ${made}/changelog.gz ${PROJECT_SOURCE_DIR}/cmake/copyright DESTINATION ${CMAKE_INSTALL_DOCDIR}
  COMPONENT program)
install(FILES README.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program PATTERN docs/site EXCLUDE)
install(DIRECTORY corpus/pin corpus/tie_bar corpus/carton DESTINATION ${CMAKE_INSTALL_DOCDIR}/examples
  COMPONENT program)

# ---- The library: all stages but the command line. ----
set(folders core geometry model scan fit codegen verify)
add_library(partscribe_library INTERFACE)
add_library(partscribe::partscribe ALIAS partscribe_library)
set_target_properties(partscribe_library PROPERTIES EXPORT_NAME partscribe)
set(libraries partscribe_library)
foreach(folder IN LISTS folders)
  set_target_properties(partscribe_${folder} PROPERTIES EXPORT_NAME ${folder})
  target_link_libraries(partscribe_library INTERFACE partscribe_${folder})
  list(APPEND libraries partscribe_${folder})
endforeach()
set(described ${CMAKE_INSTALL_LIBDIR}/cmake/partscribe)
install(TARGETS ${libraries} EXPORT partscribe ARCHIVE COMPONENT library)
install(EXPORT partscribe NAMESPACE partscribe:: FILE partscribe-targets.cmake DESTINATION ${described}
  COMPONENT library)
install(DIRECTORY ${folders} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/partscribe COMPONENT library
  FILES_MATCHING PATTERN "*.h")
write_basic_package_version_file(${PROJECT_BINARY_DIR}/generated/partscribe-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES cmake/partscribe-config.cmake ${PROJECT_BINARY_DIR}/generated/partscribe-config-version.cmake
  DESTINATION ${described} COMPONENT library)
