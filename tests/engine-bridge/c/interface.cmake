# The C interface beyond its functions: its ABI, its headers in C99, and the Python module on it.
if(NOT MIDAIR_SANITIZE)
    add_test(NAME CInterface.abi COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/engine-bridge/c/abi.sh $<TARGET_FILE:midair>)
    set_tests_properties(CInterface.abi PROPERTIES LABELS engine-bridge/c TIMEOUT 300 SKIP_RETURN_CODE 77)
endif()
add_test(NAME CInterface.headers_are_c99_and_cpp
         COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/engine-bridge/c/headers.sh ${PROJECT_SOURCE_DIR}/engine-bridge/c)
set_tests_properties(CInterface.headers_are_c99_and_cpp PROPERTIES LABELS engine-bridge/c TIMEOUT 120)
add_test(NAME CInterface.threads_of_each_function
         COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/engine-bridge/c/threads.sh ${PROJECT_SOURCE_DIR}/engine-bridge/c ${PROJECT_SOURCE_DIR}/samples/guides/C.md)
set_tests_properties(CInterface.threads_of_each_function PROPERTIES LABELS engine-bridge/c TIMEOUT 60)

# midair_python_test(NAME FILE): one of unittest's files, with the module of this build.
function(midair_python_test name file)
    add_test(NAME Python.${name} COMMAND ${MIDAIR_PYTHON} ${CMAKE_CURRENT_SOURCE_DIR}/engine-bridge/python/${file})
    set(ENVIRONMENT PYTHONPATH=${CMAKE_LIBRARY_OUTPUT_DIRECTORY}/python MPLBACKEND=Agg PYTHONDONTWRITEBYTECODE=1
        MIDAIR_ROOT=${PROJECT_SOURCE_DIR} MIDAIR_WHEEL=${PROJECT_BINARY_DIR}/python MIDAIR_BIN=${CMAKE_RUNTIME_OUTPUT_DIRECTORY})
    if(MIDAIR_SANITIZER_RUNTIME)
        # Python itself leaves memory behind when it ends.
        # Python itself links no C++: without its library, too, the sanitizer finds no function that throws.
        execute_process(COMMAND ${CMAKE_CXX_COMPILER} -print-file-name=libstdc++.so.6 OUTPUT_VARIABLE LIBRARY OUTPUT_STRIP_TRAILING_WHITESPACE)
        list(APPEND ENVIRONMENT LD_PRELOAD=${MIDAIR_SANITIZER_RUNTIME}:${LIBRARY} ASAN_OPTIONS=detect_leaks=0)
    endif()
    set_tests_properties(Python.${name} PROPERTIES LABELS engine-bridge/python TIMEOUT 600 ENVIRONMENT "${ENVIRONMENT}")
endfunction()
if(TARGET midair_python)
    midair_python_test(module module_test.py)
    midair_python_test(interface interface_test.py)
    if(NOT MIDAIR_SANITIZE)
        midair_python_test(wheel wheel_test.py)
    endif()
    midair_python_test(gallery gallery_test.py)
endif()
