/// The main sample: an object that moves in the array, with the field that is played for it, in a
/// window or as pictures.
#include "samples/demo/DemoScene.h"
#include "samples/shared/DisplayOptions.h"
#include "samples/shared/monitor/SceneMonitor.h"
#include "samples/shared/views/Offscreen.h"
#include "samples/shared/views/ShownObject.h"
#include "samples/shared/views/Signals.h"

#include <osgMidair/FieldSliceOverlay>
#include <osgMidair/FieldVolumeOverlay>
#include <osgMidair/HapticField>
#include <osgMidair/HapticStatistics>
#include <osgMidair/HologramCounters>
#include <osgMidair/Hud>

#include <osg/Timer>
#include <osgDB/WriteFile>
#include <osgGA/OrbitManipulator>
#include <osgViewer/Viewer>
#include <osgViewer/ViewerEventHandlers>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace
{

using namespace midair::samples;
using namespace midair;

/// A picture that was written, with data to check that its parts show the same frame.
struct DemoPicture
{
    std::string file;
    std::uint64_t frame = 0;      ///< frame of the pose that is shown
    std::uint64_t fieldFrame = 0; ///< frame of the field that is shown in the slice and played
    double latency_ms = 0.0;      ///< from that frame's stamp to the drive signal
    double peak_Pa = 0.0;         ///< maximum of the slice ..
    double peakToPoint_mm = 0.0;  ///< .. and its distance from the nearest control point
};

/// Returns the quantile \a share (0 .. 1) of \a values, or 0 if there are none.
double percentile(std::vector<double> values, double share)
{
    if (values.empty()) return 0.0;
    const auto at = values.begin() + std::lround(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

/// Returns the median and p99 of times as JSON.
nlohmann::ordered_json spreadOf(const std::vector<double>& values)
{
    return {{"median", percentile(values, 0.5)}, {"p99", percentile(values, 0.99)}};
}

/// Collects figures of a run frame by frame for report.json and the summary at the end.
class DemoReport
{
public:
    /// Adds a frame, and the figures of \a now once for each new field.
    void addFrame(double frame_ms, const osgMidair::HapticStatistics& now)
    {
        _frame_ms.push_back(frame_ms);
        // A field that rests keeps its frame, and is evened out or made louder.
        const bool isNew = now.fieldFrame != _lastField || now.level_Pa != _last.level_Pa;
        if (now.figures.empty() || !isNew) return;
        _lastField = now.fieldFrame;
        if (now.points == 0) return; // of nothing
        _last = levelsOf(now);
        if (now.evened) return; // it is not for its points
        _solved_Pa = now.level_Pa;
        _solve_ms.push_back(now.matrix_ms + now.solve_ms);
        _rms.push_back(now.rms);
        _loudness.push_back(now.loudness);
        _latency_ms.push_back(now.latency_ms);
    }

    void addPicture(const DemoPicture& picture) { _pictures.push_back(picture); }

    /// Writes the report to \a path and replaces an existing file. Returns false and sets \a error
    /// on failure.
    bool write(const std::string& path, std::string& error) const
    {
        std::ofstream file(path);
        file << toJson().dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
        file.close();
        if (file) return true;
        error = "can't write " + path;
        return false;
    }

    void print() const
    {
        std::printf("object      %s, largest extent %.0f mm, %d control points\n",
                    model.c_str(),
                    1e3 * options.size_m,
                    statistics.points);
        std::printf(
            "array       %s, %d transducers, %.1f C\n", array.c_str(), transducers, temperature_C);
        std::printf("device      %s\n", statistics.device.c_str());
        std::printf("frames      %zu at %.1f/s, 99 %% within %.1f ms\n",
                    _frame_ms.size(),
                    framesPerSecond(),
                    percentile(_frame_ms, 0.99));
        std::printf(
            "fields      %llu solved of %llu requested; skipped: %llu outdated, %llu unchanged\n",
            static_cast<unsigned long long>(statistics.solves),
            static_cast<unsigned long long>(statistics.snapshots),
            static_cast<unsigned long long>(statistics.superseded),
            static_cast<unsigned long long>(statistics.skippedUnmoved));
        if (statistics.contactFields > 0)
            std::printf("contacts    %llu fields at touching hands\n",
                        static_cast<unsigned long long>(statistics.contactFields));
        std::printf("solve       %.2f ms median, %.2f ms p99 (matrix included)\n",
                    percentile(_solve_ms, 0.5),
                    percentile(_solve_ms, 0.99));
        printField();
        std::printf("latency     %.2f ms median, %.2f ms p99, frame stamp to drive signal\n",
                    percentile(_latency_ms, 0.5),
                    percentile(_latency_ms, 0.99));
        if (picturesProblem.empty())
            std::printf("pictures    %zu in %s, slice in %.1f ms\n",
                        _pictures.size(),
                        options.out.c_str(),
                        slice_ms);
        else
            std::printf("pictures    none: %s\n", picturesProblem.c_str());
        for (const std::string& message : statistics.messages)
            std::printf("note        %s\n", message.c_str());
    }

    std::string model;
    int transducers = 0;
    std::string array; ///< array of the scene
    double temperature_C = 0.0;
    DemoOptions options;
    osgMidair::HapticStatistics statistics; ///< at the end
    double slice_ms = 0.0;
    double slicesPerSecond = 0.0;
    double seconds = 0.0;        ///< duration of the frames that ran at full speed
    std::string picturesProblem; ///< why there are no pictures; empty: there are

private:
    double framesPerSecond() const
    {
        return seconds > 0.0 ? static_cast<double>(_frame_ms.size()) / seconds : 0.0;
    }

    nlohmann::ordered_json toJson() const
    {
        nlohmann::ordered_json json = {{"model", model},
                                       {"size_m", options.size_m},
                                       {"array", array},
                                       {"transducers", transducers},
                                       {"device", statistics.device},
                                       {"stop", statistics.stop},
                                       {"temperature_C", temperature_C},
                                       {"frames", _frame_ms.size()},
                                       {"framesPerSecond", framesPerSecond()},
                                       {"frame_ms", spreadOf(_frame_ms)},
                                       {"objects", statistics.objects},
                                       {"points", statistics.points}};
        for (const bridge::CounterRow& row : bridge::kHologramCounters)
            json[row.name] = statistics.*row.value;
        json["idleFrames"] = statistics.idleFrames;
        json["updatesPerSecond"] = statistics.updatesPerSecond;
        json["solve_ms"] = spreadOf(_solve_ms);
        // null: no field had points
        json["rms"] = nullptr;
        json["loudness"] = nullptr;
        if (!_rms.empty())
        {
            json["rms"] = {{"median", percentile(_rms, 0.5)}, {"max", percentile(_rms, 1.0)}};
            json["loudness"] = {{"median", percentile(_loudness, 0.5)},
                                {"min", percentile(_loudness, 0.0)}};
        }
        json["maxPressure_Pa"] = statistics.maxPressure_Pa;
        json["latency_ms"] = spreadOf(_latency_ms);
        json["fieldsInTurn"] = statistics.fieldsInTurn;
        json["fieldRate_Hz"] = statistics.fieldRate_Hz;
        json["outline"] = statistics.outline;
        json["evened"] = statistics.evened;
        addFigures(json);
        json["feeling"] = statistics.feeling;
        json["slice_ms"] = slice_ms;
        json["slicesPerSecond"] = slicesPerSecond;
        json["pictures"] = nlohmann::ordered_json::array();
        for (const DemoPicture& picture : _pictures)
            json["pictures"].push_back({{"file", picture.file},
                                        {"frame", picture.frame},
                                        {"fieldFrame", picture.fieldFrame},
                                        {"latency_ms", picture.latency_ms},
                                        {"peak_Pa", picture.peak_Pa},
                                        {"peakToPoint_mm", picture.peakToPoint_mm}});
        if (!picturesProblem.empty()) json["picturesProblem"] = picturesProblem;
        json["messages"] = statistics.messages;
        return json;
    }

    /// Adds figures of the newest field, except those already present as medians.
    void addFigures(nlohmann::ordered_json& json) const
    {
        for (const auto& [name, value] : statistics.figures)
        {
            std::string place = "/" + name; // "/surface/mean_Pa"
            std::replace(place.begin(), place.end(), '.', '/');
            const nlohmann::ordered_json::json_pointer pointer(place);
            if (json.contains(pointer)) continue;
            // Counts are written as whole numbers.
            if (value == std::floor(value) && std::abs(value) < 1e15)
                json[pointer] = static_cast<std::int64_t>(value);
            else
                json[pointer] = value;
        }
        if (statistics.certifiedGap >= 0.0) json["certifiedGap"] = statistics.certifiedGap;
        json["exposure"]["what"] = haptics::kExposureMeaning;
        for (const haptics::ExposureRow& row : haptics::kExposureFigures)
            std::visit([&](auto member)
                       { json["exposure"][row.name] = statistics.exposure.*member; },
                       row.value);
    }

    /// Level of a field, and what a fingertip gets of it.
    struct Levels
    {
        double level_Pa = 0.0;
        double fingertip_N = 0.0;
        std::string feeling;
    };

    static Levels levelsOf(const osgMidair::HapticStatistics& now)
    {
        return {now.level_Pa, now.fingertipForce_N, now.feeling};
    }

    /// Of the fields with points; the level and the force of the last of them.
    void printLevels() const
    {
        const Levels last = statistics.points > 0 ? levelsOf(statistics) : _last;
        if (_rms.empty())
        {
            std::printf("accuracy    none: nothing was played\n");
            return;
        }
        const char* as = statistics.evened ? ", as solved" : "";
        std::printf("accuracy    rms %.3f %% median, %.3f %% worst%s\n",
                    100.0 * percentile(_rms, 0.5),
                    100.0 * percentile(_rms, 1.0),
                    as);
        std::printf("loudness    E %.3f, %.0f Pa (peak) at the points%s%s\n",
                    percentile(_loudness, 0.5),
                    statistics.evened ? _solved_Pa : last.level_Pa,
                    as,
                    statistics.stop == "silenced" ? ": silenced" : "");
        if (statistics.evened)
            std::printf("at rest     evened out over the surface: %.1f Pa of radiation pressure on "
                        "average, give or take %.0f %%\n",
                        statistics.surface.mean_Pa,
                        100.0 * statistics.surface.coefficientOfVariation);
        if (!last.feeling.empty())
            std::printf("feeling     %s on a fingertip: %s\n",
                        osgMidair::HapticField::forceText(last.fingertip_N).c_str(),
                        last.feeling.c_str());
    }

    void printField() const
    {
        printLevels();
        if (statistics.maxPressure_Pa > 0.0)
            std::printf("cap         %.0f Pa at every point: %llu fields lowered, the last to %.3f "
                        "of its amplitude\n",
                        statistics.maxPressure_Pa,
                        static_cast<unsigned long long>(statistics.capped),
                        statistics.capFactor);
        const haptics::ExposureFigures& heard = statistics.exposure;
        if (heard.places > 0)
            std::printf(
                "at ears     %.0f dB re 20 uPa (rms) on average over %.1f s, at most %.0f dB over "
                "a second, at the loudest of %d places, including %.0f dB for a head%s\n",
                heard.eq_dB,
                heard.time_s,
                heard.max_dB,
                heard.places,
                heard.head_dB,
                heard.limit_dB > 0.0 ? ", with a limit" : "");
        if (statistics.outline) std::printf("curves      one stationary field of dense points\n");
        if (statistics.fieldsInTurn > 1)
            std::printf("in turn     %d fields at %.0f/s, audible change %.2f of the drive\n",
                        statistics.fieldsInTurn,
                        statistics.fieldRate_Hz,
                        statistics.audibleChange);
        if (statistics.surface.samples > 0)
            std::printf("surface     %.1f Pa mean, cv %.2f, first percentile %.2f of the mean",
                        statistics.surface.mean_Pa,
                        statistics.surface.coefficientOfVariation,
                        statistics.surface.percentile1);
        if (statistics.surface.offSamples > 0)
            std::printf(", contrast %.2f +- %.2f",
                        statistics.surface.contrast,
                        statistics.surface.contrastError);
        if (statistics.surface.samples > 0) std::printf("\n");
        if (statistics.certifiedGap >= 0.0)
            std::printf("certificate phases at most %.2f %% above the optimum\n",
                        100.0 * statistics.certifiedGap);
    }

    std::vector<double> _frame_ms;
    std::vector<double> _solve_ms;
    std::vector<double> _rms;
    std::vector<double> _loudness;
    std::vector<double> _latency_ms;
    std::vector<DemoPicture> _pictures;
    std::uint64_t _lastField = 0;
    Levels _last;            ///< of the last field with points
    double _solved_Pa = 0.0; ///< of the last of them that was not evened out
};

constexpr double kFrameTime_s = 1.0 / 60.0;
constexpr int kPictures = 6;
constexpr int kContactFrames = 10;

void aim(osg::Camera& camera, double zoom)
{
    osg::Vec3d eye;
    osg::Vec3d centre;
    osg::Vec3d up;
    DemoScene::lookAt(eye, centre, up);
    camera.setViewMatrixAsLookAt(eye, centre, up);
    camera.setProjectionMatrix(camera.getProjectionMatrix() * osg::Matrix::scale(zoom, zoom, 1.0));
    camera.setClearColor(kShownBackground);
}

/// Processor time used by this process so far.
struct CpuTimes
{
    double process_ms = 0.0;
    double thread_ms = 0.0; ///< of the calling thread

    static CpuTimes now()
    {
        const auto read_ms = [](clockid_t clock)
        {
            timespec time{};
            clock_gettime(clock, &time);
            return 1e3 * static_cast<double>(time.tv_sec) +
                   1e-6 * static_cast<double>(time.tv_nsec);
        };
        return {read_ms(CLOCK_PROCESS_CPUTIME_ID), read_ms(CLOCK_THREAD_CPUTIME_ID)};
    }
};

/// The shown scene with its report, viewer and operator's page.
struct Show
{
    explicit Show(const DemoOptions& options) :
        display(openDisplay(options.display)),
        scene(options),
        monitor(options.monitor, scene.haptics(), "midair-demo: " + scene.name())
    {
        report.options = options;
        report.model = scene.name();
        if (display) std::printf("display     %s\n", display->getStatus().c_str());
        viewer.setLightingMode(osg::View::NO_LIGHT);
    }

    /// Runs one frame at scene time \a time_s; \a draw false skips rendering.
    void frame(double time_s, bool draw)
    {
        scene.moveTo(time_s);
        viewer.advance(time_s);
        viewer.eventTraversal();
        viewer.updateTraversal();
        if (draw) viewer.renderingTraversals();
    }

    /// Fills in the figures known only at the end.
    void finish()
    {
        const auto& slice = *scene.overlays().get<osgMidair::FieldSliceOverlay>();
        report.statistics = scene.haptics().getStatistics();
        report.array = scene.haptics().getArray();
        report.temperature_C = scene.haptics().getTemperature();
        report.slice_ms = slice.getComputeTime_ms();
        report.slicesPerSecond = slice.getSlicesPerSecond();
        report.transducers = report.statistics.transducers;
    }

    const osg::ref_ptr<osgMidair::DisplayView> display; ///< null: none
    DemoScene scene;
    MuteSignals signals{[this](bool isMuted) { scene.haptics().setMuted(isMuted); }};
    const SilenceAtStop atStop{[this] { scene.haptics().setMuted(true); }};
    SceneMonitor monitor;
    DemoReport report;
    osgViewer::Viewer viewer;
};

double seconds()
{
    return osg::Timer::instance()->time_s();
}

/// Returns the distance from \a place (array frame, m) to the nearest control point of \a field.
double nearestPoint_mm(const osgMidair::HapticField& field, const osg::Vec3d& place)
{
    double nearest_mm = field.getPoints().empty() ? 0.0 : 1e9;
    for (const osgMidair::HapticField::ControlPoint& point : field.getPoints())
        nearest_mm =
            std::min(nearest_mm, 1e3 * (point.position * field.getWorldToArray() - place).length());
    return nearest_mm;
}

/// Repeats the frame at \a time_s until its field is solved and its slice is drawn, so that all
/// parts of a picture show the same frame.
DemoPicture settle(Show& show, double time_s, bool draw)
{
    DemoScene& scene = show.scene;
    DemoPicture picture;
    osgMidair::FieldSliceOverlay& slice = *scene.overlays().get<osgMidair::FieldSliceOverlay>();
    picture.frame = show.viewer.getFrameStamp()->getFrameNumber();
    const double start = seconds();
    // Contact fields are updated independently of frames.
    const bool isWhole =
        scene.haptics().getGrantedSettings().render == osgMidair::HapticSettings::OBJECT;
    const double longest_s = isWhole ? 20.0 : 0.3;
    osg::ref_ptr<const osgMidair::HapticField> field;
    for (;;)
    {
        const osgMidair::HapticStatistics s = scene.haptics().getStatistics();
        field = scene.haptics().getField();
        const bool handled = s.processed >= s.snapshots;
        const bool isOff = !scene.haptics().getGrantedSettings().enabled;
        if ((field && field->getFrameNumber() >= picture.frame) || (field && handled) || isOff ||
            seconds() - start > longest_s || isStopAsked())
            break;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    if (!field) return picture;
    picture.latency_ms = scene.haptics().getStatistics().latency_ms;
    show.frame(time_s, draw); // hands the field to the overlays
    if (slice.isShown()) slice.waitFor(field->getFrameNumber(), 20.0);
    if (scene.overlays().isShown("volume"))
        scene.overlays().get<osgMidair::FieldVolumeOverlay>()->waitFor(field->getFrameNumber(),
                                                                       20.0);
    picture.fieldFrame = slice.getShownFrame();
    picture.peak_Pa = slice.getPeakPressure();
    picture.peakToPoint_mm = nearestPoint_mm(*field, slice.getPeak());
    show.frame(time_s, draw); // updates the figures of the HUD
    // Contacts without new hand data while the slice was drawn are silent; wait until they play
    // again.
    for (int i = 0; i < kContactFrames && scene.haptics().getStatistics().contactFields > 0; ++i)
    {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        show.frame(time_s, draw);
    }
    return picture;
}

/// Takes the picture \a file of the frame at \a time_s with current figures. Returns false if it
/// can't be written.
bool takePicture(Show& show, double time_s, PictureTaker& camera, const std::string& file)
{
    osgMidair::Hud& figures = *show.scene.overlays().get<osgMidair::Hud>();
    const double interval_s = figures.getUpdateInterval();
    figures.setUpdateInterval(0.0);
    DemoPicture picture = settle(show, time_s, true);
    figures.setUpdateInterval(interval_s);
    picture.file = file;
    const osg::ref_ptr<osg::Image> image = camera.take();
    if (!image || !osgDB::writeImageFile(*image, file)) return false;
    show.report.addPicture(picture);
    return true;
}

int runHeadless(const DemoOptions& options)
{
    Show show(options);
    DemoScene& scene = show.scene;
    osgViewer::Viewer& viewer = show.viewer;
    DemoReport& report = show.report;
    std::filesystem::create_directories(options.out);

    // No key can be pressed here, so hide the key list unless --key-time asks for it.
    const bool areKeysAsked = std::any_of(options.numbers.begin(),
                                          options.numbers.end(),
                                          [](const auto& each) { return each.first == "keyTime"; });
    if (!areKeysAsked) scene.overlays().get<osgMidair::Hud>()->setKeyTime(0.0);

    const bool draw =
        setUpOffscreen(viewer, 800, 600, DemoScene::kFovy_deg, &report.picturesProblem);
    if (draw)
    {
        aim(*viewer.getCamera(), options.zoom);
        show.monitor.show(*viewer.getCamera());
    }
    else
        show.monitor.showNothing(report.picturesProblem);
    viewer.setSceneData(scene.root());
    const bool isScreen = show.display && !show.display->isRehearsal();
    PictureTaker camera(
        *scene.root(),
        scene.overlays(),
        isScreen ? show.display->getWidth() : options.width,
        isScreen ? show.display->getHeight() : options.height,
        DemoScene::kFovy_deg,
        [&](osg::Camera& view) { aim(view, options.zoom); },
        report.picturesProblem);
    camera.showOn(show.display);

    const int frames = options.frames > 0 ? options.frames : 240;
    const int between = std::max(1, frames / kPictures);
    const std::string stem =
        (std::filesystem::path(options.out) / std::filesystem::path(scene.name()).stem()).string();
    int taken = 0;
    std::string unwritten;
    for (int i = 0; i < frames && !isStopAsked(); ++i)
    {
        const double begin = seconds();
        show.frame(i * kFrameTime_s, draw);
        const double spent = seconds() - begin;
        report.seconds += spent;
        report.addFrame(1e3 * spent, scene.haptics().getStatistics());
        if (!draw || i % between != between - 1) continue;
        const std::string file = fmt::format("{}_{}.png", stem, ++taken);
        if (!takePicture(show, i * kFrameTime_s, camera, file))
            report.picturesProblem = unwritten = "can't write " + file;
    }
    show.finish();
    std::string error;
    const bool written = report.write(options.out + "/report.json", error);
    report.print();
    if (!written) std::fprintf(stderr, "midair-demo: %s\n", error.c_str());
    return written && unwritten.empty() ? 0 : 1;
}

int runBenchmark(const DemoOptions& options)
{
    Show show(options);
    DemoScene& scene = show.scene;
    osgViewer::Viewer& viewer = show.viewer;
    DemoReport& report = show.report;
    std::string problem;
    if (!setUpOffscreen(viewer, 800, 600, DemoScene::kFovy_deg, &problem))
    {
        std::fprintf(stderr, "midair-demo: %s\n", problem.c_str());
        return 1;
    }
    aim(*viewer.getCamera(), options.zoom);
    show.monitor.show(*viewer.getCamera());
    viewer.setSceneData(scene.root());
    show.frame(0.0, true);
    settle(show, 0.0, true);
    const int frames = options.frames > 0 ? options.frames : 300;
    const double start = seconds();
    const CpuTimes before = CpuTimes::now();
    int done = 0;
    double update_ms = 0.0;
    for (; done < frames && !isStopAsked(); ++done)
    {
        const double begin = seconds();
        const double beginUpdate_ms = CpuTimes::now().thread_ms;
        show.frame(begin - start, false);
        update_ms += CpuTimes::now().thread_ms - beginUpdate_ms;
        viewer.renderingTraversals();
        report.addFrame(1e3 * (seconds() - begin), scene.haptics().getStatistics());
    }
    report.seconds = seconds() - start;
    const CpuTimes after = CpuTimes::now();
    show.finish();
    report.picturesProblem = "benchmark";
    report.print();
    std::printf("slice       %.1f/s, %.1f ms each; volume %.1f/s, %.1f ms each\n",
                report.slicesPerSecond,
                report.slice_ms,
                scene.overlays().get<osgMidair::FieldVolumeOverlay>()->getVolumesPerSecond(),
                scene.overlays().get<osgMidair::FieldVolumeOverlay>()->getComputeTime_ms());
    const double thread_ms = (after.thread_ms - before.thread_ms) / std::max(1, done);
    std::printf("cpu         %.1f ms a frame in all threads; of these %.1f ms update, %.1f ms cull "
                "and draw in the viewer's thread\n",
                (after.process_ms - before.process_ms) / std::max(1, done),
                update_ms / std::max(1, done),
                thread_ms - update_ms / std::max(1, done));
    return 0;
}

int runWindow(const DemoOptions& options)
{
    Show show(options);
    DemoScene& scene = show.scene;
    osgViewer::Viewer& viewer = show.viewer;
    DemoReport& report = show.report;
    if (show.display && !show.display->isRehearsal())
        viewer.setUpViewOnSingleScreen(0);
    else
        viewer.setUpViewInWindow(60, 60, options.width, options.height);
    viewer.getCamera()->setProjectionMatrixAsPerspective(DemoScene::kFovy_deg / options.zoom,
                                                         static_cast<double>(options.width) /
                                                             options.height,
                                                         0.01,
                                                         10.0);
    viewer.getCamera()->setClearColor(kShownBackground);
    osg::ref_ptr<osgGA::OrbitManipulator> manipulator = new osgGA::OrbitManipulator;
    osg::Vec3d eye;
    osg::Vec3d centre;
    osg::Vec3d up;
    DemoScene::lookAt(eye, centre, up);
    manipulator->setHomePosition(eye, centre, up);
    if (!show.display) viewer.setCameraManipulator(manipulator);
    osg::ref_ptr<osg::ApplicationUsage> usage = new osg::ApplicationUsage;
    osgMidair::OverlayKeys(&scene.overlays()).getUsage(*usage);
    viewer.addEventHandler(new osgViewer::StatsHandler);
    viewer.addEventHandler(new osgViewer::WindowSizeHandler);
    viewer.addEventHandler(new osgViewer::HelpHandler(usage));
    show.monitor.show(*viewer.getCamera());
    viewer.setSceneData(scene.root());
    viewer.realize();
    showOn(show.display, viewer);
    const auto headset = showInHeadset(options.display, viewer);
    if (headset) viewer.setCameraManipulator(nullptr);
    report.picturesProblem = "shown in a window";
    const double start = seconds();
    for (int i = 0; !viewer.done() && !isStopAsked() && (options.frames == 0 || i < options.frames);
         ++i)
    {
        const double begin = seconds();
        show.frame(begin - start, true);
        report.addFrame(1e3 * (seconds() - begin), scene.haptics().getStatistics());
    }
    report.seconds = seconds() - start;
    show.finish();
    report.print();
    return 0;
}

} // namespace

int main(int argc, char** argv)
{
    DemoOptions options;
    int status = 0;
    if (!parseDemoOptions(argc, argv, options, status)) return status;
    catchStopSignals();
    catchMuteSignals();
    registerEmulatedDevices();
    try
    {
        if (options.benchmark) return runBenchmark(options);
        return options.headless || !haveDisplay() ? runHeadless(options) : runWindow(options);
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "midair-demo: %s\n", error.what());
        return 1;
    }
}
