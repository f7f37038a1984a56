// Finds where a display's screen and the array are, and checks the result.
#include "samples/shared/ToolOptions.h"
#include "samples/shared/views/Signals.h"
#include "samples/tools/display/DisplayCommands.h"

#include <cstdio>
#include <exception>

namespace
{

using namespace midair::samples;

int runDisplay(int argc, char** argv)
{
    CLI::App app(
        "Finds where a display's screen is, by touch or with a camera, and checks the result.\n"
        "Example: midair-display calibrate mirror.display.json --hands openxr:\n"
        "Exit code: 0 done, 1 the result is not usable and nothing is written, 2 wrong input.",
        "midair-display");
    app.require_subcommand(1);
    const auto calibrate = addCalibrate(app);
    const auto check = addCheck(app);
    int status = EXIT_DONE;
    if (!parseTool(app, argc, argv, status)) return status;
    catchStopSignals();
    status = calibrate->run();
    return status >= 0 ? status : check->run();
}

} // namespace

int main(int argc, char** argv)
{
    try
    {
        return runDisplay(argc, argv);
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "midair-display: %s\n", error.what());
        return EXIT_WRONG;
    }
}
