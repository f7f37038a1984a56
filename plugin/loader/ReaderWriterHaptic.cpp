#include "haptics/base/RegularFile.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Quantity.h"
#include "haptics/base/text/Words.h"
#include "plugin/extending/RegisteredNames.h"
#include "plugin/loader/ModelFile.h"
#include "plugin/settings/AllSettings.h"
#include "plugin/settings/Assignments.h"
#include "plugin/settings/Grants.h"
#include "plugin/settings/UserOptions.h"

#include <osgMidair/FileFormats>
#include <osgMidair/HapticDevice>
#include <osgMidair/HapticOverlays>
#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>

#include <osg/MatrixTransform>
#include <osg/Notify>
#include <osgDB/FileNameUtils>
#include <osgDB/FileUtils>
#include <osgDB/ReadFile>
#include <osgDB/Registry>

#include <algorithm>
#include <set>
#include <sstream>

namespace osgMidair
{

namespace
{

constexpr std::size_t kMostSettingsBytes = 1 << 20;

/// Replaces the value of \a row in \a object, given as \a value, by the default if it is out of
/// range; then sets \a error and returns false.
template<class T>
bool keepInRange(const Setting<T>& row, const std::string& value, T& object, std::string& error)
{
    const std::string problem = row.problem(object, value);
    std::string what;
    if (!row.repair(object, what)) return true;
    error = row.name + " " + problem +
            (row.isSafety ? "; nothing is played" : "; " + row.defaultText() + " is used");
    return false;
}

/// Options of MODEL.haptic and FILE.haptic.
struct LoaderOptions
{
    HapticProperty property;
    HapticSettings settings;
    double size_m = 0.0; ///< 0: unchanged
    osg::Vec3d position;
    osg::Vec3d rotation_deg;
    bool isSizeSet = false;
    osg::ref_ptr<HapticOverlays> overlays; ///< null: none

    /// True for a viewer's device, which plays the viewer's scene instead of a model: options that
    /// place a model cause a warning.
    bool forDevice = false;

    /// Parses options; warns about invalid ones, with \a where they came from. If safety may depend
    /// on one, silences the scene. \a isOwnFile: no other plugin's options are among them.
    void parse(const std::string& text, const std::string& where, bool isOwnFile = false)
    {
        std::set<std::string> seen;
        for (const Assignment& one : assignmentsIn(text))
        {
            std::string error;
            const bool isUnclear = !take(one, isOwnFile, seen, error);
            if (error.empty()) continue;
            // Warnings about settings files of the kit name the line.
            const bool hasLines = isOwnFile && forDevice;
            const std::string place = hasLines ? where + ":" + std::to_string(one.line) : where;
            error.insert(0, place + ": ");
            error = printable(error);
            if (isUnclear) silence(settings, error);
            OSG_WARN << "osgMidair: " << error << std::endl;
        }
    }

    void silenceWithProperty() { silenceFor(property.whySilenced); }

    // If something in the viewer's scene is tagged, the property of the whole scene isn't checked.
    void silenceFor(const std::vector<std::string>& reasons)
    {
        for (const std::string& reason : reasons)
            silence(settings, reason);
    }

    /// Tags define the haptics: warns if the property is set, too.
    void leaveToTags(const std::string& where)
    {
        silenceWithProperty();
        if (property != HapticProperty())
            OSG_WARN << "osgMidair: "
                     << printable(where +
                                  ": haptic options are ignored, because nodes of the model have "
                                  "their own haptic tags")
                     << std::endl;
    }

private:
    /// Sets one assignment, or sets \a error. Returns false if safety may depend on it.
    bool
    take(const Assignment& one, bool isOwnFile, std::set<std::string>& seen, std::string& error)
    {
        const std::string& name = one.name;
        if (name.empty()) return !standsAlone(one.value, isOwnFile, error);
        if (!seen.insert(name).second && isKnown(name))
        {
            const bool isSafety =
                sceneSettings().concernsSafety(name) || surfaceProperties().concernsSafety(name);
            error = givenTwice(name, isSafety);
            return !isSafety;
        }
        if (setOwn(name, one.value, error)) return true;
        // "enabled" is in both tables; here it means the array.
        if (const auto* row = sceneSettings().find(name))
            return (settings.set(name, one.value, error) &&
                    keepInRange(*row, one.value, settings, error)) ||
                   !row->isSafety;
        const auto* row = surfaceProperties().find(name);
        if (!row) return !isUnknown(name, isOwnFile, error);
        if (property.set(name, one.value, error) &&
            !keepInRange(*row, one.value, property, error) && row->isSafety)
            property.whySilenced.push_back(error);
        return true;
    }

    static bool isPlacing(const std::string& name)
    {
        return std::find(std::begin(kPlacingOptions), std::end(kPlacingOptions), name) !=
               std::end(kPlacingOptions);
    }

    static bool isKnown(const std::string& name)
    {
        return sceneSettings().find(name) || surfaceProperties().find(name) || isPlacing(name);
    }

    // Options may be another plugin's; a file of settings belongs to the kit alone.
    static bool standsAlone(const std::string& word, bool isOwnFile, std::string& error)
    {
        error = wordWarning(word);
        if (!isOwnFile && !isSafetyWord(word)) return false;
        if (error.empty()) error = "\"" + word + "\" should be name=value";
        error += "; nothing is played";
        return true;
    }

    static bool isUnknown(const std::string& name, bool isOwnFile, std::string& error)
    {
        const std::vector<std::string> names = optionNames();
        const bool isUnclear = sceneSettings().concernsSafety(name) ||
                               surfaceProperties().concernsSafety(name) ||
                               (isOwnFile && midair::base::nearestWords(name, names).empty());
        error = "unknown option \"" + name + "\"" + midair::base::didYouMean(name, names) +
                (isUnclear ? "; nothing is played" : "");
        return isUnclear;
    }

    bool setOwn(const std::string& name, const std::string& value, std::string& error)
    {
        if (forDevice && isPlacing(name))
        {
            error = name +
                    " is for MODEL.haptic and is ignored here: a viewer's scene is felt where it "
                    "is seen (metresPerUnit and calibration place the array)";
            return true;
        }
        if (name == "size")
        {
            isSizeSet = midair::base::parseQuantity(value, "m", size_m) && size_m > 0.0;
            if (!isSizeSet)
            {
                size_m = 0.0;
                error = "size is \"" + value + "\", should be over 0 (metres)";
            }
            return true;
        }
        if (name == "overlays")
        {
            setOverlays(value, error);
            return true;
        }
        if (name != "position" && name != "rotation") return false;
        const bool isPlace = name == "position";
        if (!parseNumbers(
                value, (isPlace ? position : rotation_deg).ptr(), 3, isPlace ? "m" : "deg"))
            error = name + " is \"" + value + "\", should be three numbers";
        return true;
    }

    // Yes, no, or the names of overlays to show.
    void setOverlays(const std::string& value, std::string& error)
    {
        bool isYes = false;
        const bool isYesOrNo = midair::base::parseYesNo(value, isYes);
        overlays = isYesOrNo && !isYes ? nullptr : new HapticOverlays;
        if (isYesOrNo) return;
        std::vector<std::string> words;
        std::istringstream in(value);
        for (std::string word; in >> word;)
            words.push_back(word);
        error = words.empty() ? "there is no name" : overlays->showOnly(words);
        if (error.empty()) return;
        overlays = nullptr;
        error =
            "overlays is \"" + value + "\", should be true, false or names of overlays: " + error;
    }
};

/// MODEL.EXT.haptic, or MODEL.EXT.(NAME=VALUE, ..).haptic with options for this object alone.
struct ObjectName
{
    std::string model;   ///< MODEL.EXT
    std::string options; ///< empty: none

    explicit ObjectName(const std::string& fileName) : model(osgDB::getNameLessExtension(fileName))
    {
        const std::size_t open = model.rfind(".(");
        if (model.empty() || model.back() != ')' || open == std::string::npos) return;
        options = model.substr(open + 2, model.size() - open - 3);
        // As in OSG's own "cow.osg.(1,0,0).trans": these are numbers.
        if (options.find('=') == std::string::npos) options.clear();
        if (!options.empty()) model.erase(open);
    }
};

/// Returns \a model scaled and placed by the options.
osg::ref_ptr<osg::Node> placed(osg::Node* model, const LoaderOptions& options)
{
    const osg::BoundingBoxd box = boundsOf(*model);
    if (!box.valid()) return model;
    const osg::Vec3d extent = box._max - box._min;
    const double largest = std::max({extent.x(), extent.y(), extent.z()});
    const bool moved = options.position.length2() > 0.0 || options.rotation_deg.length2() > 0.0;
    if ((!options.isSizeSet || largest <= 0.0) && !moved) return model;

    const double scale = options.isSizeSet && largest > 0.0 ? options.size_m / largest : 1.0;
    const osg::Vec3d turn = options.rotation_deg * midair::base::toRadians(1.0);
    osg::ref_ptr<osg::MatrixTransform> transform = new osg::MatrixTransform(
        osg::Matrixd::translate(options.isSizeSet ? -box.center() : osg::Vec3d()) *
        osg::Matrixd::scale(scale, scale, scale) *
        osg::Matrixd::rotate(turn.x(), osg::X_AXIS, turn.y(), osg::Y_AXIS, turn.z(), osg::Z_AXIS) *
        osg::Matrixd::translate(options.position));
    transform->getOrCreateStateSet()->setMode(GL_NORMALIZE, osg::StateAttribute::ON);
    transform->addChild(model);
    return transform;
}

} // namespace

/// OSG plugin that reads MODEL.haptic, any model that OSG reads, as a haptic object below a
/// HapticScene; and FILE.haptic, settings for --device.
class ReaderWriterHaptic : public osgDB::ReaderWriter
{
public:
    ReaderWriterHaptic()
    {
        supportsExtension("haptic", "Mid-air haptics: MODEL.EXT.haptic, or settings for --device");
        supportsOption(
            "size=<metres>",
            "largest extent of the model, in metres or with a unit: 8 cm; also centres it "
            "(default: unchanged)");
        supportsOption("position=<x y z>", "metres, or with a unit: 0 0 12 cm (default 0 0 0)");
        supportsOption("rotation=<x y z>", "degrees about x, then y, then z (default 0 0 0)");
        std::string words;
        for (const OverlayDescription& one : HapticOverlays::describe())
            words += (words.empty() ? "" : ", ") + one.word;
        supportsOption("overlays=<true/false/names>",
                       "show what is played: all of it, or some of " + words +
                           " with blanks between (default false; F7 in a viewer)");
        for (const auto& [name, help] : HapticProperty::describe())
            if (name != "enabled") supportsOption(name + "=", help);
        for (const auto& [name, help] : HapticSettings::describe())
            supportsOption(name + "=", help);
    }

    /// Includes the names that the program has registered by now.
    const FormatDescriptionMap& supportedOptions() const override
    {
        _options = _supportedOptions;
        for (const char* name : {"solver", "device", "hands", "heads"})
        {
            const std::string own = registeredNames(name);
            if (!own.empty()) _options[std::string(name) + "="] += "; registered: " + own;
        }
        return _options;
    }

    const char* className() const override { return "Mid-air haptics pseudo-loader"; }

    ReadResult readObject(const std::string& fileName, const osgDB::Options* options) const override
    {
        const std::string file = settingsFile(fileName, options);
        if (file.empty()) return readNode(fileName, options);
        std::string text;
        try
        {
            text = midair::base::readRegularFile(file, kMostSettingsBytes);
        }
        catch (const midair::base::FileError& error)
        {
            return ReadResult("settings \"" + printable(file) + "\": " + error.what());
        }
        LoaderOptions loader;
        loader.forDevice = true;
        loader.parse(text, file, true);
        lookBeside(osgDB::getFilePath(file), loader.settings);
        if (options) loader.parse(options->getOptionString(), file);
        if (options && options->getOptionString() != userOptions())
            makeWishes(loader.settings, osgDB::getFilePath(file));
        loader.silenceWithProperty();
        return new HapticDevice(loader.settings, loader.property);
    }

    ReadResult readNode(const std::string& fileName, const osgDB::Options* options) const override
    {
        if (!acceptsExtension(osgDB::getLowerCaseFileExtension(fileName)))
            return ReadResult::FILE_NOT_HANDLED;
        if (!settingsFile(fileName, options).empty())
            return ReadResult(printable(fileName) + " holds settings: use it as --device " +
                              printable(fileName));
        const ObjectName name(fileName);
        const std::string& modelName = name.model;
        if (osgDB::getFileExtension(modelName).empty()) return ReadResult::FILE_NOT_FOUND;
        ModelFile model = readModelFile(modelName, options);
        if (!model.read.validNode())
            return model.read.message().empty() ? ReadResult(ReadResult::FILE_NOT_HANDLED)
                                                : ReadResult(model.read.message());

        LoaderOptions loader;
        loader.parse(model.settings, fileName + ", extras of its scene", true);
        if (options) loader.parse(options->getOptionString(), fileName);
        loader.parse(name.options, fileName, true);
        if (!model.isTagged) loader.silenceFor(model.unfollowed);
        makeWishes(loader.settings, osgDB::getFilePath(osgDB::findDataFile(modelName, options)));
        osg::ref_ptr<osg::Group> object;
        if (model.isTagged)
            loader.leaveToTags(fileName);
        else
        {
            const osg::ref_ptr<HapticSurface> surface = new HapticSurface;
            surface->setProperty(loader.property);
            object = surface;
        }
        if (!object) object = new osg::Group;
        object->setName(osgDB::getSimpleFileName(modelName));
        object->addChild(placed(model.read.getNode(), loader));
        osg::ref_ptr<HapticScene> scene = new HapticScene;
        scene->setSettings(loader.settings);
        scene->setJoined(true); // osgviewer shows several files side by side
        scene->addChild(object);
        if (loader.overlays) scene->addChild(loader.overlays);
        return scene.get();
    }

private:
    mutable FormatDescriptionMap _options; ///< of the last supportedOptions()

    /// Returns the path of the file if it exists; empty for MODEL.EXT.haptic.
    std::string settingsFile(const std::string& fileName, const osgDB::Options* options) const
    {
        if (!acceptsExtension(osgDB::getLowerCaseFileExtension(fileName))) return {};
        return osgDB::findDataFile(fileName, options);
    }
};

void registerLoader()
{
    static const osgDB::RegisterReaderWriterProxy<ReaderWriterHaptic> proxy;
}

} // namespace osgMidair
