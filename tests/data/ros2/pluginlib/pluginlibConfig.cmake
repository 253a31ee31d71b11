add_library(pluginlib::pluginlib INTERFACE IMPORTED)
# Beside the build, a file a plugin's category says where its description is.
function(pluginlib_export_plugin_description_file category file)
    if(NOT EXISTS "${CMAKE_CURRENT_SOURCE_DIR}/${file}")
        message(FATAL_ERROR "${file} does not exist")
    endif()
    file(WRITE "${CMAKE_BINARY_DIR}/plugins/${category}" "${CMAKE_CURRENT_SOURCE_DIR}/${file}")
endfunction()
