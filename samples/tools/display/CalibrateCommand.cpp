#include "engine-bridge/display/DisplayFit.h"
#include "engine-bridge/display/Picture.h"
#include "engine-bridge/tags/TagFit.h"
#include "engine-bridge/tags/VideoCamera.h"
#include "haptics/base/InputError.h"
#include "haptics/base/RegularFile.h"
#include "haptics/base/text/Quantity.h"
#include "haptics/base/threads/SteadyClock.h"
#include "haptics/boards/BoardMeasurements.h"
#include "samples/shared/CalibrationFiles.h"
#include "samples/shared/SettingOptions.h"
#include "samples/shared/ToolOptions.h"
#include "samples/shared/views/Signals.h"
#include "samples/tools/display/DisplayCommands.h"
#include "samples/tools/display/ScreenSigns.h"
#include "samples/tools/display/TouchCollector.h"

#include <osgMidair/Calibration>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

using base::InputError;

constexpr std::size_t kMostDisplayFile_bytes = std::size_t(1) << 20U;
constexpr std::size_t kMostTouchFile_bytes = std::size_t(16) << 20U;
/// A headset has no file: the runtime knows its place, so only the array is touched.
constexpr const char* kHeadset = "openxr:";

/// Options of `midair-display calibrate`.
struct CalibrateOptions
{
    std::string file; ///< display file; "openxr:": a headset
    std::string out;  ///< empty: overwrite the file
    std::string touches, saved, picture, tags;
    int photos = 12;      ///< taken by a camera
    double every_s = 3.0; ///< interval
    TouchSources sources;
    bool isSight = false;
    bool isHeadless = false;
    std::string eye = "right";
    int screen = 0;
    int rounds = 1;
    double edge_m = 0.1;
    bridge::DisplayFitOptions fit;
    std::string array = "board", places, matrix, scene; ///< of headsets
};

void write(const std::string& path, const std::string& text)
{
    std::ofstream out(path);
    out << text;
    out.close();
    if (!out) throw InputError("can't write to \"" + path + "\"");
}

/// A place of the array to touch.
struct TouchedPlace
{
    std::string name;
    Eigen::Vector3d at; ///< m, array frame
};

/// Returns the corners of the array's boards, or the places of a file.
std::vector<TouchedPlace> placesOf(const CalibrateOptions& options)
{
    std::vector<TouchedPlace> places;
    const haptics::TransducerArray array = haptics::TransducerArray::load(options.array);
    if (!options.places.empty())
    {
        const std::string text = base::readRegularFile(
            options.places, kMostTouchFile_bytes, "places \"" + options.places + "\": ");
        for (const haptics::MeasuredPlace& place :
             haptics::readBoardMeasurements(text, options.places, array).places)
            places.push_back({place.name, place.position});
        if (places.empty()) throw InputError("\"" + options.places + "\" has no place NAME x y z");
        return places;
    }
    const haptics::BoardMarks marks(array);
    for (int board = 0; board < marks.boards(); ++board)
        for (const char letter : {'a', 'b', 'c', 'd'})
            places.push_back({fmt::format("{}:{}", board, letter),
                              array.positions.col(marks.corner(board, letter))});
    return places;
}

class CalibrateCommand : public DisplayCommand
{
public:
    explicit CalibrateCommand(CLI::App& app)
    {
        CLI::App& command = *app.add_subcommand(
            "calibrate",
            "finds where a display's screen is, or where the array is for a headset, by touching");
        command.add_option("FILE", _options.file, "the display's file; openxr: for a headset")
            ->required();
        command.add_option("--out", _options.out, "write it here instead of over FILE");
        command.add_option("--hands", _options.sources.hands, "hand source [openxr:]");
        command.add_option(
            "--head", _options.sources.heads, "head source, for --sight [the file's eye]");
        command.add_option("--touches", _options.touches, "file of touches, instead of hands");
        command.add_option("--save", _options.saved, "write the touches to this file");
        command.add_option(
            "--picture", _options.picture, "write a picture of the screen to this file and exit");
        command
            .add_option("--hold", _options.sources.hold_s, "how long to hold a fingertip still, s")
            ->transform(inUnit("s", base::parseQuantity))
            ->capture_default_str();
        command
            .add_option(
                "--rounds", _options.rounds, "how often to touch everything [1; with --sight 3]")
            ->check(CLI::Range(1, 20));
        command
            .add_option("--edge",
                        _options.edge_m,
                        "distance from the workspace's centre to its edge, metres")
            ->transform(inUnit("m", base::parseQuantity))
            ->capture_default_str();
        command.add_flag(
            "--sight",
            _options.isSight,
            "cover each cross with the fingertip for one eye, from three or more head positions");
        command.add_option("--eye", _options.eye, "the open eye: left, right, between")
            ->check(CLI::IsMember({"left", "right", "between"}))
            ->capture_default_str();
        command.add_flag(
            "--fit-eye", _options.fit.fitsEye, "also fit the eye's offset from the tracked head");
        command.add_option("--tags",
                           _options.tags,
                           "use a camera at the place of the eyes instead of hands; FILE lists the "
                           "tags on the screen and on the array");
        command.add_option("--photos", _options.photos, "number of photos")
            ->check(CLI::Range(3, 1000))
            ->capture_default_str();
        command.add_option("--every", _options.every_s, "interval between photos, s")
            ->transform(inUnit("s", base::parseQuantity))
            ->capture_default_str();
        command.add_option("--screen", _options.screen, "number of the screen")
            ->check(CLI::Range(0, 63))
            ->capture_default_str();
        command.add_flag(
            "--headless", _options.isHeadless, "don't open a window; the hands are a recording");
        addHeadset(command);
        _isAsked = &command;
    }

    int run() override
    {
        if (!*_isAsked) return -1;
        _options.sources.isRehearsal = _options.isHeadless;
        if (_options.sources.hands.empty()) _options.sources.hands = kHeadset;
        _options.sources.hands = onceOf(_options.sources.hands);
        if (_options.file.rfind(kHeadset, 0) == 0) return calibrateHeadset();
        return calibrateDisplay();
    }

private:
    void addHeadset(CLI::App& command)
    {
        const std::string group = "Headsets (FILE is openxr:)";
        command.add_option("--array", _options.array, "array whose board corners are touched")
            ->capture_default_str()
            ->group(group);
        command
            .add_option(
                "--places", _options.places, "file of other places to touch: place NAME x y z")
            ->group(group);
        command.add_option("--matrix", _options.matrix, "write the calibration to this file")
            ->group(group);
        command.add_option("--scene", _options.scene, "set the calibration in this scene file")
            ->group(group);
    }

    /// Removes "?loop": a recording is played once.
    static std::string onceOf(const std::string& hands)
    {
        const std::string loop = "?loop";
        const std::string text = handsOf(hands);
        const bool loops = isRecording(text) && text.size() > loop.size() &&
                           text.compare(text.size() - loop.size(), loop.size(), loop) == 0;
        return loops ? text.substr(0, text.size() - loop.size()) : text;
    }

    std::vector<bridge::CrossTouch> touchesOfFile() const
    {
        std::istringstream in(base::readRegularFile(
            _options.touches, kMostTouchFile_bytes, "touches \"" + _options.touches + "\": "));
        return bridge::readTouches(in, _options.touches, _options.isSight);
    }

    std::vector<bridge::CrossTouch> touchesOfHands(const bridge::Display& display)
    {
        const int crosses = static_cast<int>(bridge::displayCrosses().size());
        ScreenSigns signs(display);
        if (_options.isSight && _options.sources.heads.empty())
            _options.sources.heads = display.eye;
        if (_options.isSight && _options.rounds == 1) _options.rounds = 3;
        TouchCollector collector(_options.sources);
        if (!_options.isHeadless) signs.openWindow(_options.screen);
        const auto ask = [&](int number)
        {
            if (_options.isSight && number % crosses == 0)
                std::printf("head position %d of %d: move your head by 0.1 m or more\n",
                            number / crosses + 1,
                            _options.rounds);
            std::printf("cross %d: %s and hold still\n",
                        number % crosses + 1,
                        _options.isSight ? "cover it with your fingertip, seen with one eye,"
                                         : "touch it where you see it");
            std::fflush(stdout);
            signs.showCross(number % crosses);
        };
        const auto found =
            collector.collect(crosses * _options.rounds, ask, [&] { return signs.frame(); });
        std::vector<bridge::CrossTouch> touches;
        for (std::size_t k = 0; k < found.size(); ++k)
            touches.push_back({static_cast<int>(k) % crosses, found[k].tip, found[k].head});
        return touches;
    }

    static std::vector<bridge::TagPhoto> photosOfFiles(const bridge::TagRig& rig,
                                                       const bridge::Display& display)
    {
        bridge::TagDetector detector;
        std::vector<bridge::TagPhoto> photos;
        for (const std::string& file : rig.images)
            photos.push_back(bridge::takePhoto(detector, bridge::readPgm(file), display));
        return photos;
    }

    std::vector<bridge::TagPhoto> photosOfCamera(const bridge::TagRig& rig,
                                                 const bridge::Display& display) const
    {
        bridge::TagDetector detector;
        ScreenSigns signs(display);
        signs.showTags();
        bridge::VideoCamera camera(rig.device, rig.camera.width, rig.camera.height);
        signs.openWindow(_options.screen);
        std::printf("hold the camera where eyes will be; move it for each of the %d photos\n",
                    _options.photos);
        std::vector<bridge::TagPhoto> photos;
        double taken_s = base::steadySeconds();
        while (static_cast<int>(photos.size()) < _options.photos)
        {
            if (isStopAsked() || !signs.frame()) throw InputError("stopped; nothing is written");
            bridge::GrayImage image;
            const bool isTaken = camera.next(image); // of the camera's queue none is left to wait
            if (!isTaken || base::steadySeconds() - taken_s < _options.every_s) continue;
            photos.push_back(bridge::takePhoto(detector, image, display));
            std::printf("photo %zu: %zu tags\n", photos.size(), photos.back().seen.size());
            std::fflush(stdout);
            taken_s = base::steadySeconds();
        }
        return photos;
    }

    int calibrateDisplay()
    {
        const std::string text = base::readRegularFile(
            _options.file, kMostDisplayFile_bytes, "display file \"" + _options.file + "\" ");
        const bridge::Display display = bridge::readDisplay(text, _options.file);
        if (!_options.picture.empty())
        {
            ScreenSigns signs(display);
            if (_options.tags.empty())
                signs.showCross(0);
            else
                signs.showTags();
            signs.save(_options.picture);
            return EXIT_DONE;
        }
        _options.fit.edge_m = _options.edge_m;
        if (!_options.tags.empty())
        {
            const bridge::TagRig rig = bridge::loadTagRig(_options.tags);
            const std::vector<bridge::TagPhoto> photos =
                rig.device.empty() ? photosOfFiles(rig, display) : photosOfCamera(rig, display);
            return conclude(bridge::fitTags(display, rig, photos, _options.fit), text, display);
        }
        const std::vector<bridge::CrossTouch> touches =
            _options.touches.empty() ? touchesOfHands(display) : touchesOfFile();
        if (!_options.saved.empty())
        {
            std::string lines;
            for (const bridge::CrossTouch& touch : touches)
                lines += bridge::touchLine(touch, _options.isSight);
            write(_options.saved, lines);
        }
        _options.fit.eye = _options.eye == "left" ? -1 : _options.eye == "right" ? 1 : 0;
        const bridge::DisplayFit fit = _options.isSight
                                           ? bridge::fitSights(display, touches, _options.fit)
                                           : bridge::fitTouches(display, touches, _options.fit);
        return conclude(fit, text, display);
    }

    int conclude(const bridge::DisplayFit& fit,
                 const std::string& text,
                 const bridge::Display& before) const
    {
        const bool hasFound = fit.noise > 0.0;
        for (std::size_t k = 0; hasFound && k < fit.names.size(); ++k)
            std::printf("%-12s%8.2f %s%s\n",
                        fit.names[k].c_str(),
                        (fit.areInPixels ? 1.0 : 1e3) * fit.residuals[static_cast<Eigen::Index>(k)],
                        fit.areInPixels ? "px" : "mm",
                        fit.outlier[k] ? "  left out" : "");
        std::fputs(fit.text().c_str(), stdout);
        if (!fit.usable) return EXIT_PROBLEM;
        const Eigen::Vector3d moved = fit.middle() - bridge::Picture(before).at(0.5, 0.5);
        std::printf("the picture's centre is %.1f mm from its place in the old file\n",
                    1e3 * moved.norm());
        const std::string& to = _options.out.empty() ? _options.file : _options.out;
        write(to, bridge::withScreen(text, _options.file, fit.display));
        std::printf("written to %s\n", to.c_str());
        return EXIT_DONE;
    }

    osgMidair::CalibrationReport fitArray()
    {
        const std::vector<TouchedPlace> places = placesOf(_options);
        const int count = static_cast<int>(places.size());
        TouchCollector collector(_options.sources);
        const auto found = collector.collect(
            count * _options.rounds,
            [&](int number)
            {
                std::printf("touch %s and hold still\n",
                            places[static_cast<std::size_t>(number % count)].name.c_str());
                std::fflush(stdout);
            },
            [] { return true; });
        std::vector<osg::Vec3d> world, array;
        std::string lines;
        for (std::size_t k = 0; k < found.size(); ++k)
        {
            const Eigen::Vector3d& tip = found[k].tip;
            const Eigen::Vector3d& at = places[k % places.size()].at;
            world.emplace_back(tip.x(), tip.y(), tip.z());
            array.emplace_back(at.x(), at.y(), at.z());
            lines += fmt::format("{:.5f},{:.5f},{:.5f},{:.5f},{:.5f},{:.5f}\n",
                                 tip.x(),
                                 tip.y(),
                                 tip.z(),
                                 at.x(),
                                 at.y(),
                                 at.z());
        }
        if (!_options.saved.empty()) write(_options.saved, lines);
        osgMidair::CalibrationOptions options;
        options.edge_m = _options.edge_m;
        return osgMidair::calibrate(world, array, options);
    }

    int calibrateHeadset()
    {
        if (!_options.touches.empty())
            throw InputError("--touches works only for displays; for a headset, fit a file of "
                             "pairs with midair-calibrate");
        const osgMidair::CalibrationReport report = fitArray();
        std::fputs(report.text.c_str(), stdout);
        if (!report.usable) return EXIT_PROBLEM;
        if (!(report.edgeErrorMedian_m <= _options.fit.mostError_m))
        {
            std::printf("not usable: the likely error of %.1f mm is above %.1f mm: touch more "
                        "places, or touch each more often (--rounds)\n",
                        1e3 * report.edgeErrorMedian_m,
                        1e3 * _options.fit.mostError_m);
            return EXIT_PROBLEM;
        }
        if (!_options.matrix.empty()) writeMatrix(_options.matrix, report.worldToArray);
        if (!_options.scene.empty())
            writeScene(_options.scene,
                       _options.out.empty() ? _options.scene : _options.out,
                       report.worldToArray);
        return EXIT_DONE;
    }

    CalibrateOptions _options;
    CLI::App* _isAsked = nullptr;
};

} // namespace

std::unique_ptr<DisplayCommand> addCalibrate(CLI::App& app)
{
    return std::make_unique<CalibrateCommand>(app);
}

} // namespace midair::samples
