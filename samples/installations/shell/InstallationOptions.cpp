#include "samples/installations/shell/InstallationOptions.h"

#include "device/DeviceUri.h"
#include "device/limits/UserLimits.h"
#include "device/opening/MultiDevice.h"
#include "engine-bridge/playing/EarBound.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/UserEnvironment.h"
#include "haptics/base/text/Quantity.h"
#include "haptics/propagation/Exposure.h"
#include "samples/shared/DisplayOptions.h"
#include "samples/shared/OverlayOptions.h"
#include "samples/shared/ToolOptions.h"
#include "samples/shared/monitor/SceneMonitor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <stdexcept>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

/// Parses "1280x720".
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

/// Parses "maxPressure=800 Pa" etc.
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
    app.add_option("--device", options.device, "Device to play on, a URI [sim:]")->type_name("URI");
    app.add_option("--array", options.array, "Array: a name or a JSON file")->type_name("NAME");
    app.add_option("--hands",
                   options.hands,
                   "Hand source: openxr:, osc:, mouse:, FILE.csv, none; demo: a simulated visitor "
                   "[demo without a display, else OSG_MIDAIR_HANDS]")
        ->type_name("SOURCE");
    app.add_option("--set", "Other settings of the scene, as for osgviewer's -O: maxPressure=800Pa")
        ->type_name("NAME=VALUE")
        ->check(settingOfScene(options.settings))
        ->expected(1, -1);
    app.add_flag("--muted", options.muted, "Start muted; F8 unmutes");
    app.add_option(
           "--linger", options.linger_s, "How long the array plays on after the last hand, s")
        ->check(CLI::Range(0.0, 3600.0))
        ->capture_default_str();
    app.add_option("--state",
                   options.state,
                   "File that stores the mute and counts crashes, for restarts [NAME.json in "
                   "$STATE_DIRECTORY, which systemd sets]")
        ->type_name("FILE");
}

void addShowing(CLI::App& app, InstallationOptions& options)
{
    app.add_flag("--plain",
                 options.plain,
                 "For visitors: no overlays, no keys except F8 and the installation's own; ends "
                 "with SIGTERM");
    app.add_option("--window", "Size of window or pictures [full screen; 1200x800]")
        ->type_name("WIDTHxHEIGHT")
        ->check(sizeInPixels(options.size));
    addDisplay(app, options.display);
    app.add_option("--screen", options.screen, "Number of the screen")
        ->check(CLI::Range(0, 64))
        ->capture_default_str();
    app.add_flag("--headless", options.headless, "Don't open a window, even if there is a display");
    app.add_option("--frames", options.frames, "Frames to run [240 without a display]")
        ->check(CLI::Range(1, 100000000));
    app.add_option("--minutes", options.minutes, "How long to run, instead of --frames")
        ->check(CLI::Range(0.01, 100000.0));
    app.add_option("--pictures", options.pictures, "Number of pictures to take without a display")
        ->check(CLI::Range(0, 1000))
        ->capture_default_str();
    app.add_option("--out", options.out, "Folder for pictures and report.json, without a display")
        ->capture_default_str();
    app.add_option("--seed", options.seed, "Random seed")->capture_default_str();
}

constexpr int kPlacesAround = 30;

haptics::TransducerArray arrayOf(const osgMidair::HapticSettings& settings)
{
    haptics::TransducerArray array = haptics::TransducerArray::load(settings.array);
    array.mark(settings.dead, settings.weak);
    return array;
}

Eigen::Matrix3Xd placesOf(const osgMidair::HapticSettings& settings,
                          const haptics::TransducerArray& array)
{
    const Eigen::Matrix3Xd around = haptics::placesAround(array, kPlacesAround);
    std::vector<std::array<double, 3>> named;
    base::parsePlaces(device::joinedPlaces(settings.earPoints, device::capsOfUser().earPoints),
                      named);
    Eigen::Matrix3Xd places(3, around.cols() + static_cast<Eigen::Index>(named.size()));
    places.leftCols(around.cols()) = around;
    for (std::size_t l = 0; l < named.size(); ++l)
        places.col(around.cols() + static_cast<Eigen::Index>(l)) =
            Eigen::Map<const Eigen::Vector3d>(named[l].data());
    return places;
}

} // namespace

bool parseInstallationOptions(
    Installation& installation, int argc, char** argv, InstallationOptions& options, int& status)
{
    const InstallationTitle title = installation.title();
    CLI::App app(title.purpose +
                     " Full screen if there is a display; otherwise writes pictures and figures. "
                     "F8 mutes the array, Escape ends the program.\n"
                     "Example: midair-" +
                     title.name + " --device usb: --hands openxr: --set earLimit=110",
                 "midair-" + title.name);
    app.get_formatter()->column_width(30);
    installation.addOptions(app);
    addPlaying(app, options);
    addShowing(app, options);
    addMonitorOptions(app, options.monitor);
    addOverlays(app, options.overlays, options.numbers, "hands", {"plain"}); // --plain is a flag
    if (!parseTool(app, argc, argv, status)) return false;
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

bool isSimulated(const std::string& device)
{
    try
    {
        const std::vector<std::string> all = device::splitDeviceList(device);
        return std::all_of(all.begin(),
                           all.end(),
                           [](const std::string& one)
                           {
                               const std::string scheme = device::DeviceUri(one).scheme();
                               return scheme == "sim" || scheme == "null";
                           });
    }
    catch (const std::runtime_error&) // not a URI: reported elsewhere
    {
        return false;
    }
}

std::string whyEarLimitIsMissing(const osgMidair::HapticSettings& settings,
                                 const InstallationOptions& options)
{
    // OSG_MIDAIR_DEVICE overrides the command line.
    const std::string users = base::userVariable("OSG_MIDAIR_DEVICE").value_or("");
    const std::string& device = users.empty() ? settings.device : users;
    const bool isChosen = device::capsOfUser().isEarLimitChosen ||
                          std::any_of(options.settings.begin(),
                                      options.settings.end(),
                                      [](const auto& one) { return one.first == "earLimit"; });
    if (isChosen || isSimulated(device)) return {};
    return "device \"" + device +
           "\" is not a simulator, and no ear limit is chosen: the program does not start";
}

struct EarNeedMeter::Listener
{
    explicit Listener(const osgMidair::HapticSettings& settings) :
        array(arrayOf(settings)),
        exposure(std::make_shared<haptics::Exposure>(
            array, haptics::Medium(), placesOf(settings, array))),
        bound(haptics::kPublicEarLimit_dB, exposure)
    {
    }
    const haptics::TransducerArray array;
    const std::shared_ptr<haptics::Exposure> exposure;
    const bridge::EarBound bound;
};

EarNeedMeter::EarNeedMeter(const osgMidair::HapticSettings& settings) :
    _listener(std::make_unique<Listener>(settings))
{
    if (_listener->exposure->size() > 0)
        _need.radius_m = _listener->exposure->places().col(0).norm();
}

EarNeedMeter::~EarNeedMeter() = default;

// Uses PressureCap's rule, as the pipeline does.
void EarNeedMeter::add(const std::vector<std::vector<std::complex<float>>>& fields)
{
    std::vector<Eigen::VectorXcf> played;
    for (const std::vector<std::complex<float>>& field : fields)
    {
        if (static_cast<int>(field.size()) != _listener->array.size()) return;
        played.emplace_back(Eigen::Map<const Eigen::VectorXcf>(
            field.data(), static_cast<Eigen::Index>(field.size())));
    }
    if (played.empty() || _listener->exposure->size() == 0) return;
    const double heard_Pa2 = _listener->exposure->heard_Pa2(played).maxCoeff();
    _need.level_dB = std::max(_need.level_dB, haptics::soundLevel_dB(heard_Pa2));
    const double more =
        std::pow(10.0, 0.05 * (haptics::kWorkersEarLimit_dB - haptics::kPublicEarLimit_dB));
    for (const Eigen::VectorXcf& q : played)
    {
        const double excess = _listener->bound.excess(q, 0.0F, {});
        if (!(excess > 0.0)) continue;
        _need.publicShare = std::min(_need.publicShare, 1.0 / excess);
        _need.workersShare = std::min(_need.workersShare, more / excess);
    }
}

EarNeed EarNeedMeter::need()
{
    if (_need.level_dB > 0.0) return _need;
    std::mt19937 random(1);
    std::uniform_real_distribution<float> turn(0.0F, 6.2831853F);
    std::vector<std::complex<float>> full(static_cast<std::size_t>(_listener->array.size()));
    for (std::complex<float>& one : full)
        one = std::polar(1.0F, turn(random));
    add({full});
    _need.isFullDrive = true;
    return _need;
}

std::string describe(const EarNeed& need, const std::string& array)
{
    std::string text = fmt::format("  At ears, {:.1f} m from the centre of array \"{}\", {} up to "
                                   "{:.0f} dB (computed, including {:g} dB for a head).\n",
                                   need.radius_m,
                                   array,
                                   need.isFullDrive ? "full drive has" : "its fields have",
                                   need.level_dB,
                                   haptics::kHeadMargin_dB);
    const auto limit = [&](double limit_dB, const char* whose, double share)
    {
        text += fmt::format("  earLimit={:g}   the limit for {}: leaves {:.2g} % of the pressure\n",
                            limit_dB,
                            whose,
                            100.0 * share);
    };
    limit(haptics::kPublicEarLimit_dB, "the public", need.publicShare);
    limit(haptics::kWorkersEarLimit_dB, "workers", need.workersShare);
    return text + "  earLimit=none  no limit\n"
                  "  Choose one with --set earLimit=.. or OSG_MIDAIR_EAR_LIMIT. "
                  "samples/guides/SAFETY.md explains the limits; none is known to be safe.";
}

} // namespace midair::samples
