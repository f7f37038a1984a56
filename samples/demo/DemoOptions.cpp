#include "samples/demo/DemoOptions.h"

#include "plugin/overlays/OverlayKinds.h"
#include "plugin/settings/AllSettings.h"
#include "samples/SettingOptions.h"

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
    app.add_option("--pressure",
                   options.pressure_Pa,
                   "Wanted peak pressure in Pa; 0: as loud as it accurately can")
        ->check(CLI::Range(0.0, osgMidair::surfaceProperties().find("pressure")->range.high));
    addSettings(app, osgMidair::sceneSettings(), "The scene", {}, options.scene);
    addSettings(app,
                osgMidair::surfaceProperties(),
                "The object",
                {"enabled", "pressure", "unit"}, // set by the scene's options and --pressure
                options.object);
    std::vector<std::string> overlays;
    for (const auto& [place, kind] : osgMidair::overlayKinds())
        overlays.push_back(kind.word);
    overlays.emplace_back("none");
    app.add_option("--overlays", options.overlays, "What is drawn over the scene [everything]")
        ->check(CLI::IsMember(overlays))
        ->delimiter(',');
    for (const auto& [place, kind] : osgMidair::overlayKinds())
        for (const osgMidair::OverlayNumber& number : kind.numbers)
            app.add_option_function<double>(
                   optionName(number.name),
                   [&options, name = number.name](double value)
                   { options.numbers.emplace_back(name, value); },
                   number.help + " (" + number.numbers() + ")")
                ->type_name(number.unit.empty() ? "VALUE" : number.unit)
                ->check(CLI::Range(number.range.low, number.range.high))
                ->group("The overlays");
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
