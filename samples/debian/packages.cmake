# cpack in a build's folder makes the Debian packages; samples/debian/build.sh configures such a build, for /usr. What is in which
# package stands in contents.txt. What they depend on is read from the binaries, but for what they have of each other.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME osgmidair)
set(CPACK_PACKAGE_VENDOR osgMidair)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "") # each package has its own
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
# Whoever makes packages is their maintainer, named as Debian's own tools want it.
set(CPACK_PACKAGE_CONTACT "osgMidair maintainers <osgmidair@packages.debian.org>")
if(DEFINED ENV{DEBEMAIL})
    set(CPACK_PACKAGE_CONTACT "$ENV{DEBFULLNAME} <$ENV{DEBEMAIL}>")
endif()
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/sort.cmake)
set(CPACK_MIDAIR_BUILD ${CMAKE_BINARY_DIR})
set(CPACK_MIDAIR_SOURCE ${PROJECT_SOURCE_DIR})
set(CPACK_MIDAIR_INSTALL_PREFIX ${CMAKE_INSTALL_PREFIX})
set(CPACK_MIDAIR_PACKAGED ${MIDAIR_PACKAGED})

# A library's package is named by its SONAME, so that two of them can be installed.
set(MIDAIR_SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
set(CPACK_MIDAIR_VERSION ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})

# midair_package(COMPONENT [NAME name] SECTION section SUMMARY line TEXT line.. [DEPENDS package..] [OWN component..]
# [RECOMMENDS package..] [LIBRARY name] [ANY_MACHINE]): a package, of what contents.txt gives to COMPONENT. OWN are others of these that
# it needs, of the same version; LIBRARY is the name of the shared library in it; ANY_MACHINE has no binaries.
function(midair_package component)
    cmake_parse_arguments(PARSE_ARGV 1 ARG "ANY_MACHINE" "NAME;SECTION;SUMMARY;LIBRARY" "TEXT;DEPENDS;OWN;RECOMMENDS")
    string(TOUPPER ${component} UPPER)
    set(PREFIX CPACK_DEBIAN_${UPPER})
    list(JOIN ARG_TEXT "\n" TEXT)
    set(DEPENDS ${ARG_DEPENDS})
    foreach(OTHER ${ARG_OWN})
        string(TOUPPER ${OTHER} UPPER_OTHER)
        list(APPEND DEPENDS "${CPACK_DEBIAN_${UPPER_OTHER}_PACKAGE_NAME} (= ${CPACK_MIDAIR_VERSION})")
    endforeach()
    list(JOIN DEPENDS ", " DEPENDS)
    list(JOIN ARG_RECOMMENDS ", " RECOMMENDS)
    if(NOT ARG_NAME)
        set(ARG_NAME ${component})
    endif()
    set(SHLIBDEPS ON)
    if(ARG_ANY_MACHINE)
        set(SHLIBDEPS OFF)
        set(${PREFIX}_PACKAGE_ARCHITECTURE all PARENT_SCOPE)
    endif()
    if(ARG_LIBRARY) # what other packages' binaries depend on, and that the loader looks for it from now on
        set(CONTROL ${CMAKE_CURRENT_BINARY_DIR}/debian/${component})
        file(WRITE ${CONTROL}/shlibs "${ARG_LIBRARY} ${MIDAIR_SOVERSION} ${ARG_NAME} (>= ${PROJECT_VERSION})\n")
        file(WRITE ${CONTROL}/triggers "activate-noawait ldconfig\n")
        set(${PREFIX}_PACKAGE_CONTROL_EXTRA ${CONTROL}/shlibs ${CONTROL}/triggers PARENT_SCOPE)
    endif()
    set(${PREFIX}_PACKAGE_NAME ${ARG_NAME} PARENT_SCOPE)
    set(${PREFIX}_PACKAGE_SECTION ${ARG_SECTION} PARENT_SCOPE)
    set(${PREFIX}_PACKAGE_SHLIBDEPS ${SHLIBDEPS} PARENT_SCOPE)
    set(${PREFIX}_PACKAGE_DEPENDS "${DEPENDS}" PARENT_SCOPE)
    set(${PREFIX}_PACKAGE_RECOMMENDS "${RECOMMENDS}" PARENT_SCOPE)
    set(${PREFIX}_DESCRIPTION "${ARG_SUMMARY}\n${TEXT}" PARENT_SCOPE)
    set(CPACK_COMPONENTS_ALL ${CPACK_COMPONENTS_ALL} ${component} PARENT_SCOPE)
endfunction()

set(CPACK_COMPONENTS_ALL "")
set(MIDAIR_WHAT "osgMidair makes meshes touchable in mid-air: a phased array of ultrasound"
                "transducers presses on a bare hand where an object is seen.")
midair_package(osgmidair-data SECTION misc ANY_MACHINE SUMMARY "arrays, materials, models and scenes of osgMidair"
    TEXT ${MIDAIR_WHAT} "This package has the files of arrays and materials that its libraries read,"
         "and the models, scenes and recorded hands that its programs show.")
midair_package(libmidair NAME libmidair${MIDAIR_SOVERSION} SECTION libs LIBRARY libmidair OWN osgmidair-data
    SUMMARY "touch in mid-air by ultrasound, without a scene graph"
    TEXT ${MIDAIR_WHAT} "This package has its solver, devices, contacts and hands, with an interface in C.")
midair_package(libosgmidair NAME libosgmidair${MIDAIR_SOVERSION} SECTION libs LIBRARY libosgMidair OWN libmidair osgmidair-data RECOMMENDS libgl1-mesa-dri
    SUMMARY "OpenSceneGraph node kit for touch in mid-air by ultrasound"
    TEXT ${MIDAIR_WHAT} "This package has the node kit and the plugins by which any program that uses"
         "OpenSceneGraph, such as osgviewer, plays its scene files.")
midair_package(libmidair-dev SECTION libdevel OWN libmidair
    SUMMARY "touch in mid-air by ultrasound, in C: development files"
    TEXT ${MIDAIR_WHAT} "This package has the headers of the C interface, for CMake and pkg-config.")
midair_package(libosgmidair-dev SECTION libdevel OWN libosgmidair libmidair-dev
    DEPENDS libopenscenegraph-dev libeigen3-dev nlohmann-json3-dev libfmt-dev pkg-config
    SUMMARY "OpenSceneGraph node kit for touch in mid-air: development files"
    TEXT ${MIDAIR_WHAT} "This package has the headers of the node kit, its files for CMake and"
         "pkg-config, and the headers of libmidair for C++.")
midair_package(osgmidair-tools SECTION science OWN libosgmidair osgmidair-data RECOMMENDS fonts-dejavu-core python3-matplotlib
    SUMMARY "programs for touch in mid-air by ultrasound"
    TEXT ${MIDAIR_WHAT} "This package has a demonstration, midair-demo; programs that solve, check,"
         "bake and sweep scenes, and that find, calibrate, tune and mute arrays; and"
         "the udev rule by which whoever sits at a computer may use its arrays. The"
         "installations have a unit of systemd, which nothing starts unasked.")
midair_package(osgmidair-samples SECTION science ANY_MACHINE OWN osgmidair-data RECOMMENDS libosgmidair-dev libcli11-dev libbullet-dev zlib1g-dev libexpat1-dev
    SUMMARY "sources of the samples of osgMidair"
    TEXT ${MIDAIR_WHAT} "This package has the sources of its programs and of samples in C++ and"
         "Python, as a project of CMake that builds against the installed libraries.")
midair_package(osgmidair-doc SECTION doc ANY_MACHINE
    SUMMARY "documents of osgMidair" TEXT ${MIDAIR_WHAT} "This package has its documents, as Markdown with pictures.")
if(TARGET midair_python)
    # The module is for the version of Python that it is built for. libmidair brings the C++ library, too.
    string(REGEX MATCH "^[0-9]+\\.[0-9]+" PYTHON "${Python_VERSION}")
    if(NOT PYTHON)
        execute_process(COMMAND ${MIDAIR_PYTHON} -c "import sys; print('%d.%d' % sys.version_info[:2], end='')" OUTPUT_VARIABLE PYTHON)
    endif()
    string(REGEX REPLACE "^3\\." "" MINOR "${PYTHON}")
    math(EXPR NEXT "${MINOR} + 1")
    midair_package(python3-midair SECTION python OWN libmidair DEPENDS "python3 (>= ${PYTHON})" "python3 (<< 3.${NEXT})" python3-numpy
        SUMMARY "touch in mid-air by ultrasound, in Python"
        TEXT ${MIDAIR_WHAT} "This package has the module midair, which stands on libmidair.")
endif()
include(CPack)
