/// Shows the models of a folder on a turntable in the array, one after the other.
#include "samples/installations/shell/Installation.h"
#include "samples/installations/shell/Looks.h"
#include "samples/shared/views/ShownObject.h"

#include <osgMidair/FileFormats>
#include <osgMidair/HapticSurface>

#include <osg/MatrixTransform>
#include <osgDB/FileNameUtils>
#include <osgDB/Registry>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <future>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace
{

using namespace midair::samples;
using namespace midair;

namespace fs = std::filesystem;

/// Returns true for files that accompany models: materials, buffers, pictures, texts.
bool isBeside(const std::string& extension)
{
    static const std::set<std::string> kBeside = {"mtl",
                                                  "bin",
                                                  "png",
                                                  "jpg",
                                                  "jpeg",
                                                  "tga",
                                                  "bmp",
                                                  "gif",
                                                  "tif",
                                                  "tiff",
                                                  "dds",
                                                  "hdr",
                                                  "rgb",
                                                  "txt",
                                                  "md",
                                                  "csv",
                                                  "json"};
    return kBeside.count(extension) > 0;
}

/// Returns true if OpenSceneGraph has a plugin for \a path. The content may still be unreadable.
bool isModel(const fs::path& path)
{
    const std::string extension = osgDB::getLowerCaseFileExtension(path.string());
    return !extension.empty() && !isBeside(extension) &&
           osgDB::Registry::instance()->getReaderWriterForExtension(extension);
}

/// The models of a folder in an endless cycle. The folder is read again at the start of each round.
/// A model that can't be shown is skipped until it changes.
class ModelFolder
{
public:
    /// Throws std::runtime_error if \a folder is not a folder or has no model.
    explicit ModelFolder(fs::path folder) : _folder(std::move(folder))
    {
        look();
        if (!_problem.empty()) throw std::runtime_error(_problem);
        if (_paths.empty())
            throw std::runtime_error("there are no models in the folder \"" + _folder.string() +
                                     "\"");
    }

    /// Returns the path of the next model, or an empty path if there is none; problem() returns
    /// why.
    std::string next()
    {
        if (_next >= _paths.size()) look();
        if (_paths.empty() && _problem.empty())
            _problem = "none of the models in \"" + _folder.string() + "\" can be felt";
        if (_paths.empty()) return {};
        if (_next == 0) ++_rounds;
        return _paths[_next++];
    }

    /// Skips a model from now on.
    void skip(const std::string& path, const std::string& reason)
    {
        std::error_code ignored;
        _changed[path] = fs::last_write_time(path, ignored);
        _skipped[osgDB::getSimpleFileName(path)] = reason;
    }

    const std::string& problem() const { return _problem; }
    const std::map<std::string, std::string>& skipped() const { return _skipped; } ///< by name
    /// names of other files, such as textures
    const std::vector<std::string>& others() const { return _others; }
    int rounds() const { return _rounds; }

private:
    void look()
    {
        std::error_code error;
        std::vector<std::string> paths;
        std::vector<std::string> others;
        for (const fs::directory_entry& entry : fs::directory_iterator(_folder, error))
        {
            std::error_code ignored;
            if (entry.is_directory(ignored)) continue;
            // A dangling link or a pipe is not a model, whatever its name.
            const bool isShown = entry.is_regular_file(ignored) && isModel(entry.path());
            (isShown ? paths : others).push_back(entry.path().string());
        }
        _problem = error ? "can't read the folder \"" + _folder.string() + "\": " + error.message()
                         : std::string();
        std::sort(paths.begin(), paths.end());
        _others.clear();
        for (const std::string& other : others)
            _others.push_back(osgDB::getSimpleFileName(other));
        std::sort(_others.begin(), _others.end());
        const auto isLeftOut = [&](const std::string& path)
        {
            const auto left = _changed.find(path);
            if (left == _changed.end() || fs::last_write_time(path, error) == left->second)
                return left != _changed.end();
            _skipped.erase(osgDB::getSimpleFileName(path));
            _changed.erase(left);
            return false;
        };
        paths.erase(std::remove_if(paths.begin(), paths.end(), isLeftOut), paths.end());
        _paths = std::move(paths);
        _next = 0;
    }

    std::filesystem::path _folder;
    std::vector<std::string> _paths;
    std::vector<std::string> _others;
    std::string _problem; ///< why _paths is empty
    std::size_t _next = 0;
    int _rounds = 0; ///< started rounds
    std::map<std::string, std::string> _skipped;
    std::map<std::string, std::filesystem::file_time_type> _changed; ///< of skipped models
};

class Gallery : public Installation
{
public:
    InstallationTitle title() const override
    {
        return {"gallery",
                "Touchable models on a turntable, one after the other.",
                "Feel what you see: put your hand into the array"};
    }

    void addOptions(CLI::App& app) override
    {
        app.add_option("folder", _folder, "Folder with models [those of the samples]");
        app.add_option("--size", _size_m, "Largest extent of each model, m")
            ->check(CLI::Range(0.005, 0.3))
            ->capture_default_str();
        app.add_option("--seconds", _seconds, "How long each is shown to visitors, s")
            ->check(CLI::Range(0.1, 36000.0))
            ->capture_default_str();
        app.add_option("--attract", _attract_s, "How long each is shown while nobody is there, s")
            ->check(CLI::Range(0.1, 36000.0))
            ->capture_default_str();
    }

    void arrange(osgMidair::HapticSettings& settings) override
    {
        settings.render = osgMidair::HapticSettings::AUTO;
        settings.motionTolerance = 0.02;
    }

    void build(Stage& stage) override
    {
        osgMidair::registerSerializers();
        osgMidair::registerGltf();
        _haptics = &stage.haptics;
        _models = std::make_unique<ModelFolder>(_folder.empty() ? sampleFile("models") : _folder);
        for (const std::string& name : _models->others())
            say(name + " is not a model and is skipped");
        _table->setDataVariance(osg::Object::DYNAMIC);
        stage.haptics.addChild(_table);
        const auto radius = static_cast<float>(0.7 * _size_m);
        osg::ref_ptr<osg::MatrixTransform> stand =
            new osg::MatrixTransform(osg::Matrix::translate(0.0, 0.0, -0.5 * _size_m - 0.006));
        stand->addChild(
            solid(new osg::Cylinder({}, radius, 0.003F), {0.22F, 0.25F, 0.31F, 1.0F}, 2.0F));
        stage.lit.addChild(stand);
        while (!_onTable.felt) // a scene begins with a model
        {
            beginLoading(0.0);
            if (!_loading.valid()) throw std::runtime_error(_models->problem());
            _loading.wait();
            takeLoaded(0.0);
        }
    }

    Viewpoint viewpoint() const override
    {
        const osg::Vec3d from = osg::Vec3d(3.4, -5.6, 3.0) * _size_m;
        return {from, osg::Vec3d(0.0, -0.1, -0.1) * _size_m, osg::Z_AXIS, 15.0};
    }

    // Arrives, strokes the model's front for some seconds and leaves.
    bool demonstrate(double time_s, std::vector<osgMidair::Hand>& hands) override
    {
        constexpr double kPeriod_s = 16.0;
        constexpr double kInside_s = 8.0;
        const double t = std::fmod(time_s, kPeriod_s);
        if (t > kInside_s) return false;
        const double in = std::min(eased(t, 0.3, 1.2), 1.0 - eased(t, kInside_s - 0.8, kInside_s));
        hands.push_back(pointingHand({0.25 * _size_m * std::sin(1.7 * t),
                                      -0.8 * _size_m + in * (0.72 * _size_m),
                                      0.12 * _size_m * std::sin(1.1 * t)}));
        return true;
    }

    void update(const Moment& now) override
    {
        takeLoaded(now.time_s);
        if (!_loading.valid() && now.time_s >= _nextTry_s) beginLoading(now.time_s);
        if (!_onTable.felt) return;
        judge(now);
        const double slow = now.isSomebodyThere ? kVisitedTurn_deg_s : kAttractTurn_deg_s;
        _angle += osg::DegreesToRadians(slow) * now.step_s;
        _table->setMatrix(osg::Matrix::rotate(_angle, osg::Z_AXIS));
        const double shown_s = now.isSomebodyThere ? _seconds : _attract_s;
        const bool isHeld = _fingers > 0 && now.time_s - _onTable.since_s < kPatience * shown_s;
        _isDue = now.time_s - _onTable.since_s >= shown_s && !isHeld;
    }

    void touched(const osgMidair::Touch& /*touch*/) override
    {
        ++_fingers;
        ++_counts.touches[_onTable.name];
    }
    void left(const osgMidair::Touch& /*touch*/) override { --_fingers; }

    std::string caption() const override { return _onTable.name; }

    void report(nlohmann::ordered_json& figures) const override
    {
        figures["rounds"] = _models->rounds();
        figures["shown"] = _counts.shown;
        figures["felt"] = _counts.felt;
        figures["objects"] = _counts.objects;
        figures["touches"] = _counts.touches;
        figures["skipped"] = _models->skipped();
        figures["passedOver"] = _models->others();
    }

private:
    static constexpr double kVisitedTurn_deg_s = 8.0;
    static constexpr double kAttractTurn_deg_s = 45.0;
    static constexpr double kPatience = 3.0; ///< a touched model is shown so many times longer
    static constexpr double kTry_s = 2.0;    ///< between checks of a folder without models
    static constexpr double kJudged_s = 0.5; ///< with visitors, until the model must have control
                                             ///< points

    /// The model on the table.
    struct OnTable
    {
        osg::ref_ptr<osg::Group> felt;
        std::string path;
        std::string name;
        double since_s = 0.0;
        double enabled_s = 0.0; ///< time during which it could be felt
        bool isJudged = false;
    };
    /// Counts by name.
    struct Counts
    {
        std::map<std::string, int> shown;
        std::map<std::string, int> felt;
        std::map<std::string, int> objects; ///< haptic objects of it
        std::map<std::string, int> touches;
    };
    struct Loaded
    {
        std::string path;
        ShownObject object;
        std::string problem;
    };

    // Runs on a separate thread because large files take time; no other thread sees these nodes
    // yet.
    static Loaded load(std::string path, double size_m)
    {
        Loaded loaded;
        try
        {
            loaded.object = loadShownObject(path, size_m, true);
        }
        catch (const std::exception& error)
        {
            loaded.problem = error.what();
        }
        loaded.path = std::move(path);
        return loaded;
    }

    // If the folder disappears, e.g. an unplugged stick, the current model stays until it is back.
    void beginLoading(double time_s)
    {
        const std::string path = _models->next();
        if (path.empty())
        {
            if (_problem != _models->problem()) say(_models->problem());
            _problem = _models->problem();
            _nextTry_s = time_s + kTry_s;
            return;
        }
        _problem.clear();
        _loading = std::async(std::launch::async, load, path, _size_m);
    }

    static void say(const std::string& text)
    {
        std::fprintf(stderr, "midair-gallery: %s\n", text.c_str());
    }

    void skip(const std::string& path, const std::string& reason)
    {
        say(reason);
        _models->skip(path, reason);
        _isDue = true;
    }

    // Shows the next model once it is loaded and the current one's time is over.
    void takeLoaded(double time_s)
    {
        if (!_isDue || !_loading.valid() ||
            _loading.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
            return;
        Loaded loaded = _loading.get();
        if (!loaded.problem.empty()) return skip(loaded.path, loaded.problem + "; skipped");
        _onTable = {loaded.object.felt, loaded.path, loaded.object.name, time_s};
        if (loaded.object.surface) loaded.object.surface->setTouchEvents(true);
        _table->removeChildren(0, _table->getNumChildren());
        _table->addChild(_onTable.felt);
        _table->addChild(loaded.object.edges);
        _haptics->dirtyTags();
        _isDue = false;
        ++_counts.shown[_onTable.name];
    }

    // The scene may still list objects of the previous model.
    bool isOnTable(const osgMidair::FoundObject& found) const
    {
        osg::ref_ptr<osg::Node> node;
        if (!found.node.lock(node)) return false;
        const osg::Node* above = node;
        while (above != _onTable.felt.get() && above->getNumParents() > 0)
            above = above->getParent(0);
        return above == _onTable.felt.get();
    }

    // Skips a model that has no control points.
    void judge(const Moment& now)
    {
        if (_onTable.isJudged || !_haptics->getEnabled() || now.statistics.objectsBeingRead > 0)
            return;
        _onTable.enabled_s += now.step_s;
        int objects = 0;
        for (const osgMidair::FoundObject& found : _haptics->getFoundObjects())
            if (found.hasShape && isOnTable(found)) ++objects;
        if (objects > 0)
        {
            _onTable.isJudged = true;
            _counts.objects[_onTable.name] = objects;
            ++_counts.felt[_onTable.name];
            return;
        }
        if (_onTable.enabled_s < kJudged_s) return;
        _onTable.isJudged = true;
        skip(_onTable.path, "the model " + _onTable.path + " has no touchable parts; skipped");
    }

    std::string _folder;
    double _size_m = 0.09;
    double _seconds = 30.0;
    double _attract_s = 12.0;
    osgMidair::HapticScene* _haptics = nullptr;
    std::unique_ptr<ModelFolder> _models;
    std::future<Loaded> _loading;
    osg::ref_ptr<osg::MatrixTransform> _table = new osg::MatrixTransform;
    OnTable _onTable;
    std::string _problem;    ///< already reported
    double _nextTry_s = 0.0; ///< when to look for a model again
    double _angle = 0.4;
    int _fingers = 0;
    bool _isDue = true; ///< show the next model
    Counts _counts;
};

} // namespace

int main(int argc, char** argv)
{
    Gallery gallery;
    return runInstallation(gallery, argc, argv);
}
