#include "samples/demo/DemoScene.h"

#include "samples/shared/DisplayOptions.h"
#include "samples/shared/ModelAxes.h"
#include "samples/shared/OverlayOptions.h"
#include "samples/shared/ScenesBelow.h"
#include "samples/shared/SettingOptions.h"
#include "samples/shared/ToolOptions.h"
#include "samples/shared/monitor/SceneMonitor.h"
#include "samples/shared/views/ShownObject.h"

#include <osgMidair/FileFormats>
#include <osgMidair/HapticProperty>
#include <osgMidair/HapticSettings>
#include <osgMidair/HapticSurface>
#include <osgMidair/SettingDescription>

#include <osgDB/FileNameUtils>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace midair::samples
{

namespace
{

/// Adds an option for each setting of \a T except those of \a without.
template<typename T>
void addSettingsOf(CLI::App& app,
                   const char* group,
                   const std::vector<std::string>& without,
                   Given& given)
{
    for (const osgMidair::SettingDescription& said : T::getDescriptions())
        if (std::count(without.begin(), without.end(), said.name) == 0)
            addSetting(
                app,
                said.name,
                said.summary,
                typeOf(said.unit, !said.words.empty()),
                said.isFlag,
                [name = said.name](const std::string& text) { return T::problemOf(name, text); },
                given)
                ->group(group);
}

/// Returns the upper limit of an object's pressure, Pa.
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

/// Turns "FILE.csv" into a looping hand recording. An object stands still then, because recordings
/// are made with the object at rest.
void useRecordings(DemoOptions& options)
{
    for (auto& [name, text] : options.scene)
    {
        if (name != "hands") continue;
        text = handsOf(text);
        if (text.compare(0, 9, "recorded:") == 0) options.still = true;
    }
}

std::string starFile()
{
    return sampleFile("models/star.obj");
}

/// Adds the options of the run and the window.
void addFrames(CLI::App& app, DemoOptions& options)
{
    app.add_flag(
        "--still", options.still, "Don't move the object; the default with recorded hands");
    app.add_option("--frames",
                   options.frames,
                   "Frames to run [240 without a display, else until the window is closed]")
        ->check(CLI::Range(1, 10000000));
    app.add_option("--out", options.out, "Folder for the pictures and report.json")
        ->capture_default_str();
    app.add_flag("--headless", options.headless, "Don't open a window, even if there is a display");
    app.add_flag("--benchmark",
                 options.benchmark,
                 "Run off screen at 800 x 600 with all overlays as fast as possible, and print "
                 "frames per second");
    addDisplay(app, options.display);
    app.add_option("--zoom", options.zoom, "Magnification of the centre, 1 .. 8")
        ->check(CLI::Range(1.0, 8.0))
        ->capture_default_str();
    app.add_option("--width", options.width, "Width of pictures and window, pixels")
        ->check(CLI::Range(200, 4000))
        ->capture_default_str();
    app.add_option("--height", options.height, "Height of pictures and window, pixels")
        ->check(CLI::Range(150, 4000))
        ->capture_default_str();
}

} // namespace

bool parseDemoOptions(int argc, char** argv, DemoOptions& options, int& status)
{
    CLI::App app(
        "Shows an object and its field in a simulated array of ultrasound transducers. Opens a "
        "window if there is a display; otherwise writes pictures and report.json.\n"
        "Example: midair-demo model.obj --size 8cm --pressure 4000",
        "midair-demo");
    app.get_formatter()->column_width(28);
    app.add_option(
        "model", options.model, "Model or scene file that OpenSceneGraph reads [the paper's star]");
    app.add_option("--size", options.size_m, "Largest extent of the model, m; 0: as in the file")
        ->transform(inUnit("m", osgMidair::readQuantity))
        ->check(CLI::Range(0.0, 10.0))
        ->capture_default_str();
    app.add_option("--pressure",
                   options.pressure_Pa,
                   "Peak pressure, Pa; 0: as strong as the field stays accurate")
        ->transform(inUnit("Pa", osgMidair::readQuantity))
        ->check(CLI::Range(0.0, mostPressure()));
    addSettingsOf<osgMidair::HapticSettings>(app, "The scene", {}, options.scene);
    addSettingsOf<osgMidair::HapticProperty>(
        app,
        "The object",
        {"enabled", "pressure", "render", "unit"}, // set by the scene's options and --pressure
        options.object);
    addOverlays(app, options.overlays, options.numbers);
    addFrames(app, options);
    addMonitorOptions(app, options.monitor);
    if (!parseTool(app, argc, argv, status)) return false;
    useRecordings(options);
    return true;
}

osg::Matrix demoPose(double time_s)
{
    const auto wave = [&](double period_s, double phase)
    { return std::sin(2.0 * osg::PI * (time_s / period_s + phase)); };
    return osg::Matrix::rotate(2.0 * osg::PI * time_s / 9.0, osg::Y_AXIS) *
           osg::Matrix::rotate(osg::DegreesToRadians(24.0) * wave(7.0, 0.15), osg::X_AXIS) *
           osg::Matrix::rotate(osg::DegreesToRadians(32.0) * wave(5.0, 0.0), osg::Z_AXIS) *
           osg::Matrix::translate(
               0.024 * wave(6.0, 0.0), 0.010 * wave(4.0, 0.25), 0.018 * wave(3.0, 0.0));
}

namespace
{

/// Prints the size and orientation of the model if they differ from the file.
void tellPlace(const ShownObject& object, const DemoOptions& options)
{
    const double size_m = std::max({object.extent_m.x(), object.extent_m.y(), object.extent_m.z()});
    const double most = 1e-3; // relative size difference that is not worth a line
    if (std::abs(object.scale - 1.0) > most)
        std::printf("size        %.4g m; %.4g in the file. --size 0 keeps the file's. For the same "
                    "size in osgviewer:\n"
                    "            osgviewer %s.haptic -O size=%g\n",
                    size_m,
                    size_m / object.scale,
                    options.model.c_str(),
                    options.size_m);
    if (const std::string axes = turnedAxes(options.model); !axes.empty())
        std::printf("axes        %s\n", axes.c_str());
}

} // namespace

DemoScene::DemoScene(const DemoOptions& options) :
    _still(options.still),
    _root(new osg::Group),
    _overlays(new osgMidair::HapticOverlays)
{
    const std::string file = options.model.empty() ? starFile() : options.model;
    _name = osgDB::getSimpleFileName(file);
    osg::ref_ptr<osg::Node> read;
    if (osgDB::getLowerCaseFileExtension(file).compare(0, 3, "osg") == 0 ||
        osgDB::getLowerCaseFileExtension(file) == "haptic")
        read = osgMidair::readModel(file).getNode();
    if (read)
        for (osgMidair::HapticScene* scene : scenesBelow(*read, false))
            if (!_haptics) _haptics = scene;
    if (_haptics)
    {
        _root->addChild(lit(read));
        applySettings(options);
        leaveToScene(options);
    }
    else
        wrap(options);
    _haptics->setName(_name);
    // Uses the scene's own overlays: a second set would be drawn over them.
    for (unsigned int i = 0; i < _haptics->getNumChildren(); ++i)
        if (auto* own = dynamic_cast<osgMidair::HapticOverlays*>(_haptics->getChild(i)))
            _overlays = own;
    if (_overlays->getNumParents() == 0) _haptics->addChild(_overlays);
    for (const auto& [name, value] : options.numbers)
        _overlays->setNumber(name, value);
    if (!options.overlays.empty()) _overlays->showOnly(options.overlays); // known words
}

void DemoScene::wrap(const DemoOptions& options)
{
    const ShownObject object =
        loadShownObject(options.model.empty() ? starFile() : options.model, options.size_m);
    tellPlace(object, options);
    osgMidair::HapticProperty property;
    property.touchEvents = true; // for the labels at fingers
    std::string error;
    for (const auto& [name, text] : options.object)
        if (!property.set(name, text, error)) throw std::runtime_error(error);
    if (options.pressure_Pa > 0.0)
    {
        property.pressureUnit = osgMidair::HapticProperty::PASCAL;
        property.pressure = options.pressure_Pa;
    }
    if (object.surface)
        object.surface->setProperty(property);
    else
        leaveToScene(options);
    _moved = new osg::MatrixTransform;
    _moved->setDataVariance(osg::Object::DYNAMIC);
    _moved->addChild(object.felt);
    _moved->addChild(object.edges);
    _haptics = new osgMidair::HapticScene;
    _haptics->addChild(_moved);
    applySettings(options);
    _root->addChild(lit(_haptics));
}

// The file defines the objects, so options for an object are ignored with a warning.
void DemoScene::leaveToScene(const DemoOptions& options) const
{
    if (options.object.empty() && !(options.pressure_Pa > 0.0)) return;
    std::fprintf(stderr,
                 "midair-demo: %s defines its own haptic objects, so --%s is ignored\n",
                 _name.c_str(),
                 options.object.empty() ? "pressure" : options.object[0].first.c_str());
}

// Options override the settings of a scene file.
void DemoScene::applySettings(const DemoOptions& options)
{
    osgMidair::HapticSettings settings = _haptics->getSettings();
    std::string error;
    for (const auto& [name, text] : options.scene)
        if (!settings.set(name, text, error)) throw std::runtime_error(error);
    _haptics->setSettings(settings);
}

void DemoScene::moveTo(double time_s)
{
    if (_moved && !_still) _moved->setMatrix(demoPose(time_s));
}

void DemoScene::lookAt(osg::Vec3d& eye, osg::Vec3d& centre, osg::Vec3d& up)
{
    eye.set(0.075, -1.20, 0.085);
    centre.set(-0.010, 0.0, 0.0);
    up = osg::Z_AXIS;
}

} // namespace midair::samples
