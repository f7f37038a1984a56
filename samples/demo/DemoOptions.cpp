#include "samples/demo/DemoOptions.h"

#include <CLI/CLI.hpp>

namespace midair::samples
{

bool parseDemoOptions(int argc, char** argv, DemoOptions& options, int& status)
{
    CLI::App app("Shows an object in a simulated array of ultrasound transducers, with the field "
                 "that the array makes for "
                 "it. A window where there is a display; otherwise pictures and figures as files.",
                 "midair-demo");
    app.get_formatter()->column_width(28);
    app.add_option("model",
                   options.model,
                   "Model or scene, any file that OpenSceneGraph reads [the paper's star]");
    app.add_option(
           "--size", options.size_m, "Largest extent of the model in m; 0: as it is in the file")
        ->check(CLI::Range(0.0, 10.0))
        ->capture_default_str();
    app.add_option(
        "--array",
        options.array,
        "octagon, board, a shipped array's name, or a JSON file [the scene's, or octagon]");
    app.add_option("--device",
                   options.device,
                   "What plays the field: sim:, record:FILE, null:, .. [the scene's, or sim:]");
    app.add_option("--solver", options.solver, "Name of the solver [the kit's default]");
    app.add_option("--temperature", options.temperature_C, "Of the air, in degrees Celsius")
        ->check(CLI::Range(-40.0, 60.0))
        ->capture_default_str();
    app.add_option("--sampling", options.sampling, "Where the control points are")
        ->check(CLI::IsMember({"surface", "edges", "vertices"}));
    app.add_option("--spacing",
                   options.spacing_m,
                   "Smallest distance of control points in m; 0: one wavelength")
        ->check(CLI::Range(0.0, 1.0));
    app.add_option("--pressure",
                   options.pressure_Pa,
                   "Wanted peak pressure in Pa; 0: as loud as it accurately can")
        ->check(CLI::Range(0.0, 1e5));
    app.add_option("--max-pressure",
                   options.maxPressure_Pa,
                   "Peak Pa that no control point gets more than; 0: no cap")
        ->check(CLI::Range(0.0, 1e6));
    app.add_option("--loudness",
                   options.loudness,
                   "1: as loud as it accurately can; below: quieter; above: louder, less accurate")
        ->check(CLI::Range(0.01, 2.0))
        ->capture_default_str();
    app.add_option("--cycle",
                   options.cycle,
                   "Fields for shifted points in turn, which smooth the object where it rests")
        ->check(CLI::Range(1, 64));
    app.add_option("--cycle-steps", options.cycleSteps, "Between one of them and the next")
        ->check(CLI::Range(0, 16));
    app.add_option("--subsets", options.subsets, "Of the points, in turn: harder, less often")
        ->check(CLI::Range(1, 64));
    app.add_option("--field-rate", options.fieldRate_Hz, "Fields a second where they take turns")
        ->check(CLI::Range(1.0, 40000.0))
        ->capture_default_str();
    app.add_option("--modulation", options.modulation_Hz, "Of the object's pressure, Hz; 0: steady")
        ->check(CLI::Range(0.0, 500.0));
    app.add_option("--monitor",
                   options.monitor_s,
                   "Certify a field and measure its surface so often, in s; 0: never")
        ->check(CLI::Range(0.0, 1e6));
    app.add_option("--max-points", options.maxPoints, "Budget of control points; 0: no limit")
        ->check(CLI::Range(0, 100000));
    app.add_option("--overlays", options.overlays, "What is drawn over the scene [everything]")
        ->check(CLI::IsMember(
            {"points", "slice", "volume", "array", "workspace", "hands", "figures", "none"}))
        ->delimiter(',');
    app.add_flag("--still", options.still, "The object stays where it is");
    app.add_option("--frames",
                   options.frames,
                   "Frames to run [240 without a display, else until the window is closed]")
        ->check(CLI::Range(1, 10000000));
    app.add_option("--out", options.out, "Folder for the pictures and report.json")
        ->capture_default_str();
    app.add_flag("--headless", options.headless, "No window, even if there is a display");
    app.add_flag("--benchmark",
                 options.benchmark,
                 "Runs at 800 x 600 off screen with all overlays as fast as it can, and prints "
                 "frames a second");
    app.add_option("--width", options.width, "Of pictures and window, in pixels")
        ->check(CLI::Range(200, 4000))
        ->capture_default_str();
    app.add_option("--height", options.height, "Of pictures and window, in pixels")
        ->check(CLI::Range(150, 4000))
        ->capture_default_str();
    try
    {
        app.parse(argc, argv);
    }
    catch (const CLI::ParseError& error)
    {
        status = app.exit(error);
        return false;
    }
    return true;
}

} // namespace midair::samples
