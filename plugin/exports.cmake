# midair_public_exports(FILE FOLDER..): writes the linker's script FILE, by which a library exports the classes and functions that
# OSGMIDAIR_EXPORT marks in the headers FOLDER/osgMidair/*, with their parts, and nothing else.
function(midair_public_exports file)
    set(PATTERNS "")
    list(TRANSFORM ARGN APPEND /osgMidair/*)
    file(GLOB HEADERS CONFIGURE_DEPENDS ${ARGN})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${HEADERS})
    foreach(HEADER ${HEADERS})
        file(READ ${HEADER} TEXT)
        string(REGEX MATCHALL "(class|struct) OSGMIDAIR_EXPORT [A-Za-z0-9_]+" CLASSES "${TEXT}")
        foreach(CLASS ${CLASSES})
            string(REGEX REPLACE ".* " "osgMidair::" CLASS ${CLASS})
            list(APPEND PATTERNS "${CLASS}::*")
            foreach(OF vtable?for VTT?for typeinfo?for typeinfo?name?for)
                list(APPEND PATTERNS "${OF}?${CLASS}")
            endforeach()
            list(APPEND PATTERNS "non-virtual?thunk?to?${CLASS}::*" "virtual?thunk?to?${CLASS}::*")
        endforeach()
        # The name before the first bracket is the function's; what stands indented is part of a class that isn't exported as a whole.
        # ld takes letters, digits and wildcards alone.
        string(REGEX MATCHALL "\n *OSGMIDAIR_EXPORT [^(]*\\(" FUNCTIONS "${TEXT}")
        foreach(FUNCTION ${FUNCTIONS})
            string(REGEX MATCH "[A-Za-z0-9_=]+\\($" NAME "${FUNCTION}")
            string(REGEX REPLACE "[=(]" "?" NAME "${NAME}")
            if(FUNCTION MATCHES "^\n ")
                set(NAME "*::${NAME}")
            endif()
            list(APPEND PATTERNS "osgMidair::${NAME}*")
        endforeach()
    endforeach()
    list(REMOVE_DUPLICATES PATTERNS)
    list(JOIN PATTERNS "@" LINES)
    string(REPLACE "@" ";\n            " LINES "${LINES}")
    file(CONFIGURE OUTPUT ${file} CONTENT [[
# What libosgMidair.so exports: the classes and functions of its installed headers.
{
    global:
        extern "C++" {
            @LINES@;
        };
    local:
        *;
};
]] @ONLY)
endfunction()
