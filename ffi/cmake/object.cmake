# The static library as one relocatable object in which only what the headers declare is a symbol for others. Rust's standard library and all
# else in it are its own, so that it links beside other libraries in Rust, and a plug-in has none of Rust's symbols.

# GNU ld and objcopy of the target, which the C compiler knows where to find.
set(of_target "")
if(CMAKE_C_COMPILER_TARGET)
    set(of_target "--target=${CMAKE_C_COMPILER_TARGET}")
endif()
set(needed_ld --force-group-allocation --require-defined)
set(needed_objcopy --keep-global-symbols)
foreach(tool ld objcopy)
    string(TOUPPER "COVBEAM_${tool}" variable)
    execute_process(COMMAND "${CMAKE_C_COMPILER}" ${of_target} -print-prog-name=${tool}
        OUTPUT_VARIABLE named OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
    find_program(${variable} NAMES "${named}" DOC "${tool} of GNU binutils, for the target")
    set(help "")
    if(${variable})
        execute_process(COMMAND "${${variable}}" --help OUTPUT_VARIABLE help ERROR_QUIET)
    endif()
    foreach(option IN LISTS needed_${tool})
        if(NOT help MATCHES "${option}")
            message(FATAL_ERROR "${tool} of the target (${${variable}}) does not know ${option}:"
                " install GNU binutils for it, and set ${variable} to their ${tool}")
        endif()
    endforeach()
endforeach()

# The declared functions: what begins a line, has a name before its first parenthesis, and is not in line.
set(headers covbeam.h covbeam_extra.h)
if(COVBEAM_SESSION)
    list(APPEND headers covbeam_session.h)
endif()
set(required "")
set(symbols "")
foreach(header IN LISTS headers)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${root}/include/${header}")
    file(READ "${root}/include/${header}" text)
    string(REGEX MATCHALL "\n[a-z][a-z0-9_ *]*[ *]covbeam_[a-z0-9_]+\\(" declarations "${text}")
    list(FILTER declarations EXCLUDE REGEX "^\n(static|typedef) ")
    foreach(declaration IN LISTS declarations)
        string(REGEX MATCH "covbeam_[a-z0-9_]+\\($" name "${declaration}")
        string(REPLACE "(" "" name "${name}")
        string(APPEND symbols "${name}\n")
        string(APPEND required "--require-defined=${name}\n")
    endforeach()
endforeach()
file(CONFIGURE OUTPUT symbols CONTENT "${symbols}")
file(CONFIGURE OUTPUT required CONTENT "${required}")

# No debug information, of which most is the standard library's; no bitcode. Each function stays in a section of its own: a program
# that is linked with --gc-sections holds what it calls.
set(object "${CMAKE_CURRENT_BINARY_DIR}/covbeam.o")
add_custom_command(OUTPUT "${static}"
    COMMAND "${COVBEAM_LD}" -r --force-group-allocation --gc-sections "@${CMAKE_CURRENT_BINARY_DIR}/required"
        "${archive}" -o "${object}"
    COMMAND "${COVBEAM_OBJCOPY}" "--keep-global-symbols=${CMAKE_CURRENT_BINARY_DIR}/symbols"
        --remove-section=.llvmbc --remove-section=.llvmcmd --strip-unneeded "${object}"
    COMMAND "${CMAKE_COMMAND}" -E rm -f "${static}"
    COMMAND "${CMAKE_AR}" rcsD "${static}" "${object}"
    COMMAND "${CMAKE_COMMAND}" -E rm "${object}"
    DEPENDS covbeam_cargo "${archive}" "${CMAKE_CURRENT_BINARY_DIR}/symbols" "${CMAKE_CURRENT_BINARY_DIR}/required"
    COMMENT "${static_name}: one object"
    VERBATIM)
