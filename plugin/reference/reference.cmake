# `ninja doc`: the reference of all installed headers, by Doxygen, into doc/html of the build's folder. A warning fails it.
# It is installed beside the documents where it was made.
# Of the kit and of the C interface each member has to have a comment, which a first pass looks at.
find_program(DOXYGEN_PROGRAM doxygen)
set(MIDAIR_REFERENCE_KIT "")
foreach(FOLDER plugin/include/osgMidair plugin/extending/include/osgMidair plugin/overlays/include/osgMidair haptics/include/osgMidair
               engine-bridge/include/osgMidair engine-bridge/c)
    string(APPEND MIDAIR_REFERENCE_KIT " ${PROJECT_SOURCE_DIR}/${FOLDER}")
endforeach()
get_property(MIDAIR_REFERENCE_LIBRARIES GLOBAL PROPERTY MIDAIR_LIBRARY_FOLDERS)
list(TRANSFORM MIDAIR_REFERENCE_LIBRARIES PREPEND ${PROJECT_SOURCE_DIR}/)
list(JOIN MIDAIR_REFERENCE_LIBRARIES " " LIBRARIES)

set(MIDAIR_REFERENCE_LIBRARIES "")
set(MIDAIR_REFERENCE_HTML strict)
set(MIDAIR_REFERENCE_STRICT YES)
configure_file(${CMAKE_CURRENT_LIST_DIR}/Doxyfile.in ${CMAKE_BINARY_DIR}/Doxyfile.strict @ONLY)
set(MIDAIR_REFERENCE_LIBRARIES "${LIBRARIES} ${CMAKE_CURRENT_LIST_DIR}/main.dox")
set(MIDAIR_REFERENCE_HTML html)
set(MIDAIR_REFERENCE_STRICT NO)
configure_file(${CMAKE_CURRENT_LIST_DIR}/Doxyfile.in ${CMAKE_BINARY_DIR}/Doxyfile @ONLY)

if(DOXYGEN_PROGRAM)
    add_custom_target(doc
        COMMAND ${DOXYGEN_PROGRAM} ${CMAKE_BINARY_DIR}/Doxyfile.strict
        COMMAND ${DOXYGEN_PROGRAM} ${CMAKE_BINARY_DIR}/Doxyfile
        COMMAND ${CMAKE_COMMAND} -E echo "${CMAKE_BINARY_DIR}/doc/html/index.html"
        WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} VERBATIM USES_TERMINAL)
else()
    add_custom_target(doc COMMAND ${CMAKE_COMMAND} -E echo "doxygen isn't installed; Debian: apt-get install doxygen"
                          COMMAND ${CMAKE_COMMAND} -E false)
endif()
install(DIRECTORY ${CMAKE_BINARY_DIR}/doc/html DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT kit OPTIONAL)
