#include "samples/installations/shell/InstallationOptions.h"

#include "device/opening/MultiDevice.h"
#include "samples/shared/OverlayOptions.h"
#include "samples/shared/SettingOptions.h"

#include <cstdio>
#include <cstdlib>

namespace midair::samples
{

namespace
{

/// Reads "1280x720".
CLI::Validator sizeInPixels(std::pair<int, int>& size)
{
    return {[&size](std::string& text) -> std::string
            {
                int width = 0;
                int height = 0;
                char rest = 0;
                if (std::sscanf(text.c_str(), "%dx%d%c", &width, &height, &rest) != 2 ||
                    width < 200 || height < 150 || width > 8000 || height > 8000)
                    return "is \"" + text +
                           "\", should be WIDTHxHEIGHT in pixels, 200x150 .. "
                           "8000x8000";
                size = {width, height};
                return {};
            },
            ""};
}

/// Reads "maxPressure=800 Pa" and the like.
CLI::Validator settingOfScene(Given& given)
{
    return {[&given](std::string& text) -> std::string
            {
                const std::size_t equals = text.find('=');
                if (equals == std::string::npos) return "is \"" + text + "\", should be NAME=VALUE";
                const std::string name = text.substr(0, equals);
                const std::string value = text.substr(equals + 1);
                const std::string problem = osgMidair::HapticSettings::problemOf(name, value);
                if (!problem.empty()) return name + " " + problem;
                given.emplace_back(name, value);
                return {};
            },
            ""};
}

void addPlaying(CLI::App& app, InstallationOptions& options)
{
    app.add_option("--device", options.device, "What plays, a device's URI [sim:]")
        ->type_name("URI");
    app.add_option("--array", options.array, "Array: a name or a JSON file")->type_name("NAME");
    app.add_option("--hands",
                   options.hands,
                   "Tracked hands: openxr:, osc:, mouse:, FILE.csv, none; demo: a visitor of the "
                   "program's own [demo without a display, else what OSG_MIDAIR_HANDS names]")
        ->type_name("SOURCE");
    app.add_option("--set",
                   "Another setting of the scene, as -O of osgviewer takes it: maxPressure=800Pa")
        ->type_name("NAME=VALUE")
        ->check(settingOfScene(options.settings))
        ->expected(1, -1);
    app.add_flag("--muted", options.muted, "Begins muted; F8 lets it play");
    app.add_option("--linger", options.linger_s, "How long it plays on after the last hand, s")
        ->check(CLI::Range(0.0, 3600.0))
        ->capture_default_str();
    app.add_option("--state",
                   options.state,
                   "File that keeps a mute and counts crashes, so that a restart knows "
                   "[NAME.json in $STATE_DIRECTORY, which systemd sets]")
        ->type_name("FILE");
}

void addShowing(CLI::App& app, InstallationOptions& options)
{
    app.add_flag("--plain",
                 options.plain,
                 "For visitors: no overlays, and of the keys F8 and the installation's own alone; "
                 "ends by SIGTERM");
    app.add_option("--window", "A window, or pictures, of that size [full screen; 1200x800]")
        ->type_name("WIDTHxHEIGHT")
        ->check(sizeInPixels(options.size));
    app.add_option("--screen", options.screen, "Number of the screen that is filled")
        ->check(CLI::Range(0, 64))
        ->capture_default_str();
    app.add_flag("--headless", options.headless, "No window, even if there is a display");
    app.add_option("--frames", options.frames, "Frames to run [240 without a display]")
        ->check(CLI::Range(1, 100000000));
    app.add_option("--minutes", options.minutes, "How long to run, in place of --frames")
        ->check(CLI::Range(0.01, 100000.0));
    app.add_option("--pictures", options.pictures, "Pictures to take without a display")
        ->check(CLI::Range(0, 1000))
        ->capture_default_str();
    app.add_option("--out", options.out, "Folder for pictures and report.json, without a display")
        ->capture_default_str();
    app.add_option("--seed", options.seed, "Of what is drawn by lot")->capture_default_str();
}

} // namespace

bool parseInstallationOptions(
    Installation& installation, int argc, char** argv, InstallationOptions& options, int& status)
{
    const InstallationTitle title = installation.title();
    CLI::App app(title.purpose + " Full screen where there is a display; otherwise pictures and "
                                 "figures as files. F8 mutes the array, Escape ends.",
                 "midair-" + title.name);
    app.get_formatter()->column_width(30);
    installation.addOptions(app);
    addPlaying(app, options);
    addShowing(app, options);
    addMonitorOptions(app, options.monitor);
    addOverlays(app, options.overlays, options.numbers, "hands", {"plain"}); // --plain is a flag
    try
    {
        app.parse(argc, argv);
    }
    catch (const CLI::ParseError& error)
    {
        status = app.exit(error);
        return false;
    }
    options.hands = handsOf(options.hands);
    // NOLINTNEXTLINE(concurrency-mt-unsafe): nobody here changes the environment
    const char* folder = std::getenv("STATE_DIRECTORY");
    if (options.state.empty() && folder && *folder)
        options.state = std::string(folder) + "/" + title.name + ".json";
    return true;
}

std::string withHold(const std::string& uri)
{
    std::string all;
    for (const std::string& one : device::splitDeviceList(uri))
    {
        all += all.empty() ? one : "," + one;
        if (one.find("hold=") == std::string::npos)
            all += one.find('?') == std::string::npos ? "?hold=1s" : "&hold=1s";
    }
    return all;
}

} // namespace midair::samples
