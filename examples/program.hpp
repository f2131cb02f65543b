// What render and viewer share as programs. Every failure is one sentence on the standard error output and exit code 2.
#pragma once

#include <CLI/CLI.hpp>
#include <epoxy/gl.h>

#include <cstdio>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>

inline void check_gl() {
    const GLenum error = glGetError();
    char sentence[40];
    std::snprintf(sentence, sizeof sentence, "OpenGL reports error 0x%04x", error);
    if (error != GL_NO_ERROR) { throw std::runtime_error(sentence); }
}

// That a file can be written, before the work starts: a typing error costs no time.
inline void check_file(const std::string& path) {
    const std::filesystem::path directory = std::filesystem::path(path).parent_path();
    std::error_code error;
    if (std::filesystem::is_directory(path, error)) { throw std::runtime_error("\"" + path + "\" is a directory"); }
    if (!directory.empty() && !std::filesystem::is_directory(directory, error)) {
        throw std::runtime_error("there is no directory \"" + directory.string() + "\"");
    }
}

inline void require_written(bool written, const std::string& path) {
    if (!written) { throw std::runtime_error("cannot write \"" + path + "\""); }
}

// The exit code of a program that does what its command line asks for.
template <typename Work>
int run_program(const char* name, const char* purpose, const Work& work) {
    try {
        CLI::App app(purpose);
        try {
            work(&app);
        } catch (const CLI::Success& success) {
            app.exit(success); // prints the help
        }
        require_written(std::fflush(stdout) == 0, "the standard output");
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s: %s\n", name, error.what());
        return 2;
    }
}
