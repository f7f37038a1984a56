// Says what of a scene file or a model is felt and where, what isn't and why, without a window and
// without hardware.

#include "samples/tools/check/CheckReport.h"

#include <osgMidair/FileFormats>

#include <cstdio>
#include <exception>
#include <iostream>

#include <CLI/CLI.hpp>
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

namespace
{

/// Sends what plugins print to stderr, so that what is printed here is the program's alone.
class OwnOutput
{
public:
    OwnOutput() : _before(::dup(STDOUT_FILENO))
    {
        std::fflush(stdout);
        ::dup2(STDERR_FILENO, STDOUT_FILENO);
    }
    ~OwnOutput()
    {
        std::fflush(stdout);
        std::cout.flush();
        ::dup2(_before, STDOUT_FILENO);
        ::close(_before);
    }
    OwnOutput(const OwnOutput&) = delete;
    OwnOutput& operator=(const OwnOutput&) = delete;

private:
    int _before;
};

/// Reads the file as the kit asks for before it does so itself (osgMidair::readModel()): that this
/// process lives is the answer, at the socket that it was given.
[[noreturn]] void tryToRead(const midair::samples::CheckOptions& options) noexcept
{
    constexpr int kSocket = 3;
    const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
    ::dup2(nowhere, STDOUT_FILENO);
    ::dup2(nowhere, STDERR_FILENO);
    const rlimit none{};
    ::setrlimit(RLIMIT_CORE, &none);
    osgMidair::readModelOnTrial(options.file, new osgDB::Options(options.options));
    ::send(kSocket, "1", 1, MSG_NOSIGNAL);
    ::_exit(0);
}

} // namespace

int main(int argc, char** argv)
{
    using namespace midair::samples;
    constexpr int kUnreadable = 2;
    CheckOptions options;
    bool json = false;
    bool isTrial = false;
    CLI::App app("midair-check: says what of a scene file or a model is felt, and what isn't and "
                 "why. It opens no hardware: sim: plays in place of any device but sim: and null:, "
                 "and of hands only recordings are read, by the clock.\n"
                 "Exit code: 0 all is felt as it is asked for, 1 something isn't or was left out, "
                 "2 the file can't be read or an option is wrong.",
                 "midair-check");
    app.add_option(
           "scene", options.file, "scene or model, as osgviewer reads it (MODEL.haptic too)")
        ->required();
    app.add_option(
        "--device", options.settings, "file of settings, as for osgviewer's --device FILE.haptic");
    app.add_option("-O,--options", options.options, "options, as for osgviewer's -O");
    app.add_option("--frames", options.frames, "frames to play, 60 for each second of the scene")
        ->check(CLI::Range(1, 100000))
        ->capture_default_str();
    app.add_option("--wait", options.wait_s, "longest wait for the field of one frame, s")
        ->check(CLI::Range(0.001, 3600.0))
        ->capture_default_str();
    app.add_flag("--json", json, "print the same as JSON");
    app.add_flag("--try", isTrial)->group("");
    try
    {
        app.parse(argc, argv);
        if (isTrial) tryToRead(options);
        const CheckResult result = [&options]
        {
            const OwnOutput others;
            return checkScene(options);
        }();
        std::puts((json ? checkJson(result) : checkText(result)).c_str());
        return result.exitCode();
    }
    catch (const CLI::ParseError& error)
    {
        return app.exit(error) == 0 ? 0 : kUnreadable;
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "midair-check: %s\n", error.what());
        return kUnreadable;
    }
}
