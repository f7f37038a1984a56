#include "samples/demo/DemoOptions.h"

#include "samples/shared/OverlayOptions.h"
#include "samples/shared/SettingOptions.h"

#include <osgMidair/HapticProperty>
#include <osgMidair/HapticSettings>
#include <osgMidair/SettingDescription>

#include <algorithm>

namespace midair::samples
{

namespace
{

/// Returns the settings that \a T describes as options.
template<typename T>
std::vector<SettingOption> optionsOf()
{
    std::vector<SettingOption> options;
    for (const osgMidair::SettingDescription& said : T::getDescriptions())
        options.push_back({said.name,
                           said.summary,
                           typeOf(said.unit, !said.words.empty()),
                           said.isFlag,
                           [name = said.name](const std::string& text)
                           { return T::problemOf(name, text); }});
    return options;
}

/// Returns the most that an object's pressure may be.
double mostPressure()
{
    const std::vector<osgMidair::SettingDescription> all =
        osgMidair::HapticProperty::getDescriptions();
    return std::find_if(all.begin(),
                        all.end(),
                        [](const osgMidair::SettingDescription& said)
                        { return said.name == "pressure"; })
        ->high;
}

/// Takes "FILE.csv" for a recording of hands that repeats. An object stands still under a
/// recording: that was made with it at rest.
void useRecordings(DemoOptions& options)
{
    for (auto& [name, text] : options.scene)
    {
        if (name != "hands") continue;
        text = handsOf(text);
        if (text.compare(0, 9, "recorded:") == 0) options.still = true;
    }
}

} // namespace

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
        ->transform(inUnit("m", osgMidair::readQuantity))
        ->check(CLI::Range(0.0, 10.0))
        ->capture_default_str();
    app.add_option("--pressure",
                   options.pressure_Pa,
                   "Wanted peak pressure in Pa; 0: as loud as it accurately can")
        ->transform(inUnit("Pa", osgMidair::readQuantity))
        ->check(CLI::Range(0.0, mostPressure()));
    addSettings(app, optionsOf<osgMidair::HapticSettings>(), "The scene", {}, options.scene);
    addSettings(
        app,
        optionsOf<osgMidair::HapticProperty>(),
        "The object",
        {"enabled", "pressure", "render", "unit"}, // set by the scene's options and --pressure
        options.object);
    addOverlays(app, options.overlays, options.numbers);
    app.add_flag("--still",
                 options.still,
                 "The object stays where it is, as it does under a recording of hands");
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
    app.add_option("--zoom", options.zoom, "How much nearer the middle is seen, 1 .. 8")
        ->check(CLI::Range(1.0, 8.0))
        ->capture_default_str();
    app.add_option("--width", options.width, "Of pictures and window, in pixels")
        ->check(CLI::Range(200, 4000))
        ->capture_default_str();
    app.add_option("--height", options.height, "Of pictures and window, in pixels")
        ->check(CLI::Range(150, 4000))
        ->capture_default_str();
    addMonitorOptions(app, options.monitor);
    try
    {
        app.parse(argc, argv);
    }
    catch (const CLI::ParseError& error)
    {
        status = app.exit(error);
        return false;
    }
    useRecordings(options);
    return true;
}

} // namespace midair::samples
