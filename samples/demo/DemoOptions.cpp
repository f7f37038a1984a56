#include "samples/demo/DemoOptions.h"

#include "plugin/overlays/OverlayKinds.h"
#include "plugin/settings/SettingTable.h"

#include <algorithm>
#include <cctype>
#include <cstdint>

#include <CLI/CLI.hpp>

namespace midair::samples
{

namespace
{

using Given = std::vector<std::pair<std::string, std::string>>;

/// Returns the option of a setting: "maxPressure" is --max-pressure. Two have older, shorter names.
std::string optionName(const std::string& setting)
{
    std::string name = "--";
    for (const char c : setting)
    {
        if (std::isupper(static_cast<unsigned char>(c))) name += '-';
        name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
    if (setting == "monitorInterval") name += ",--monitor";
    if (setting == "modulationFrequency") name += ",--modulation";
    return name;
}

/// Adds an option for each row of \a table except \a without; their values go to \a given. Values
/// that aren't understood or are out of range are refused.
template<typename T>
void addSettings(CLI::App& app,
                 const osgMidair::SettingTable<T>& table,
                 const char* group,
                 const std::vector<std::string>& without,
                 Given& given)
{
    for (const osgMidair::Setting<T>& row : table.rows())
    {
        if (std::count(without.begin(), without.end(), row.name) > 0) continue;
        const std::string name = optionName(row.name);
        if (std::holds_alternative<bool T::*>(row.member))
        {
            app.add_flag_function(
                   name + ",--no-" + name.substr(2) + "{false}",
                   [&given, &row](std::int64_t count)
                   { given.emplace_back(row.name, count > 0 ? "true" : "false"); },
                   row.summary())
                ->group(group);
            continue;
        }
        const auto problem = [&row](const std::string& text) -> std::string
        {
            T scratch;
            std::string what;
            if (row.assign(scratch, text) && !row.repair(scratch, what)) return {};
            return "is \"" + text + "\", should be " + row.expected();
        };
        app.add_option_function<std::string>(
               name,
               [&given, &row](const std::string& text) { given.emplace_back(row.name, text); },
               row.summary())
            ->type_name(row.words.empty() ? row.unit.empty() ? "VALUE" : row.unit : "WORD")
            ->check(CLI::Validator(problem, ""))
            ->group(group);
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
