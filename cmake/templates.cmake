# Compiles the template packs into a library, so that a program works without installed files.
#
# Included by CMakeLists.txt it adds the generated source to a target; run with `cmake -P` it writes that source.

if(CMAKE_SCRIPT_MODE_FILE)
  file(GLOB files RELATIVE ${TEMPLATES} ${TEMPLATES}/*/*)
  list(SORT files)
  set(text "// Generated from templates/ by cmake/templates.cmake.\n#include \"codegen/template.h\"\n\nnamespace partscribe::codegen {\n\nconst std::vector<EmbeddedTemplate>& embedded_templates() {\n  static const std::vector<EmbeddedTemplate> all = {\n")
  foreach(name IN LISTS files)
    file(READ ${TEMPLATES}/${name} content)
    get_filename_component(pack ${name} DIRECTORY)
    get_filename_component(file ${name} NAME)
    string(APPEND text "      {\"${pack}\", \"${file}\", R\"~~~(${content})~~~\"},\n")
  endforeach()
  string(APPEND text "  };\n  return all;\n}\n\n}  // namespace partscribe::codegen\n")
  file(WRITE ${OUTPUT} "${text}")
  return()
endif()

function(partscribe_embed_templates target)
  set(folder ${PROJECT_SOURCE_DIR}/templates)
  set(output ${PROJECT_BINARY_DIR}/generated/embedded_templates.cpp)
  file(GLOB files CONFIGURE_DEPENDS ${folder}/*/*)
  add_custom_command(OUTPUT ${output}
    COMMAND ${CMAKE_COMMAND} -DTEMPLATES=${folder} -DOUTPUT=${output} -P ${PROJECT_SOURCE_DIR}/cmake/templates.cmake
    DEPENDS ${files} ${PROJECT_SOURCE_DIR}/cmake/templates.cmake
    COMMENT "Embedding the templates" VERBATIM)
  target_sources(${target} PRIVATE ${output})
endfunction()
