include(CTest)
function(ament_package)
endfunction()
