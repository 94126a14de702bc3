# Which of Rust's targets is built for (rust_target, for_target; empty: cargo's own), who links for it (rust_linker), and what Rust's
# standard library asks of the system there (system_libraries, and as a list).

# On Windows compilers of two ABIs stand beside each other; elsewhere cargo's own target is the compiler's if none is crossed.
set(COVBEAM_RUST_TARGET "" CACHE STRING "Rust's name of the target; empty: found from CMake's")
set(rust_target "${COVBEAM_RUST_TARGET}")
if(NOT rust_target AND (CMAKE_CROSSCOMPILING OR WIN32))
    set(processor "${CMAKE_SYSTEM_PROCESSOR}")
    if(MSVC)
        set(processor "${CMAKE_C_COMPILER_ARCHITECTURE_ID}")
    endif()
    string(TOLOWER "${processor}" processor)
    string(REGEX REPLACE "^(amd64|x64)$" "x86_64" processor "${processor}")
    string(REGEX REPLACE "^arm64$" "aarch64" processor "${processor}")
    if(MSVC AND processor MATCHES "^(x86_64|aarch64)$")
        set(rust_target "${processor}-pc-windows-msvc")
    elseif(MINGW AND processor STREQUAL "x86_64")
        set(rust_target x86_64-pc-windows-gnu)
    elseif(CMAKE_SYSTEM_NAME STREQUAL "Linux" AND processor MATCHES "^(x86_64|aarch64)$")
        set(rust_target "${processor}-unknown-linux-gnu")
    else()
        message(FATAL_ERROR "Rust's name for ${CMAKE_SYSTEM_NAME} on ${CMAKE_SYSTEM_PROCESSOR} is not known here:"
            " set COVBEAM_RUST_TARGET to one of `rustc --print target-list`")
    endif()
endif()

# By itself rustc links with `cc`, which is the host's.
set(for_target "")
set(rust_linker "")
if(rust_target)
    set(for_target --target "${rust_target}")
    string(MAKE_C_IDENTIFIER "CARGO_TARGET_${rust_target}" variable)
    string(TOUPPER "${variable}" variable)
    if(NOT MSVC AND NOT DEFINED ENV{${variable}_LINKER})
        set(rust_linker "${variable}_LINKER=${CMAKE_C_COMPILER}")
        set(flags "$ENV{${variable}_RUSTFLAGS}")
        if(CMAKE_C_COMPILER_TARGET)
            string(APPEND flags " -Clink-arg=--target=${CMAKE_C_COMPILER_TARGET}")
        endif()
        if(CMAKE_SYSROOT)
            string(APPEND flags " -Clink-arg=--sysroot=${CMAKE_SYSROOT}")
        endif()
        if(flags)
            list(APPEND rust_linker "${variable}_RUSTFLAGS=${flags}")
        endif()
    endif()
endif()

# For programs that link the static library. None of covbeam's dependencies asks for more.
set(COVBEAM_SYSTEM_LIBRARIES "" CACHE STRING "What Rust's standard library links, such as -lm -lpthread; empty: what rustc says")
set(system_libraries "${COVBEAM_SYSTEM_LIBRARIES}")
if(NOT system_libraries)
    set(probe "${CMAKE_CURRENT_BINARY_DIR}/native-static-libs")
    file(WRITE "${probe}.rs" "")
    execute_process(
        COMMAND "${RUSTC}" ${for_target} --crate-type=staticlib --print=native-static-libs -o "${probe}.a" "${probe}.rs"
        WORKING_DIRECTORY "${root}" ERROR_VARIABLE printed RESULT_VARIABLE status)
    file(REMOVE "${probe}.a")
    if(NOT status EQUAL 0 OR NOT printed MATCHES "native-static-libs: ([^\n]*)")
        message(FATAL_ERROR "rustc has no standard library of ${rust_target}: `rustup target add ${rust_target}`, or if cargo builds one"
            " (build-std), set COVBEAM_SYSTEM_LIBRARIES to what that links.\n${printed}")
    endif()
    string(STRIP "${CMAKE_MATCH_1}" system_libraries)
endif()
# link.exe takes options with a dash, too; with a slash they are paths to CMake.
string(REGEX REPLACE "(^| )/" "\\1-" system_libraries "${system_libraries}")
# The unwinder is the compiler's own business: it links the shared one by itself, and with -static the other. There is no static gcc_s.
string(REGEX REPLACE "(^| )-lgcc_s( |$)" "\\1" system_libraries "${system_libraries}")
string(REPLACE " " ";" system_libraries_list "${system_libraries}")
