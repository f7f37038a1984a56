#include "samples/tools/bake/BakeScene.h"

#include "haptics/base/Bytes.h"
#include "haptics/base/InputError.h"
#include "haptics/base/RegularFile.h"
#include "haptics/base/text/Number.h"

#include <osgMidair/FileFormats>

#include <osgDB/FileNameUtils>
#include <osgDB/FileUtils>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

using base::InputError;
using osgMidair::HapticScene;

constexpr std::size_t kMostBytes = std::size_t(2) << 30;
constexpr std::int64_t kMostFrames = 100000000;

bool parseFrame(const std::string& text, std::int64_t& frame)
{
    double value = 0.0;
    if (!base::parseNumber(text, value) || value != std::floor(value) || value < 0.0 ||
        value > static_cast<double>(kMostFrames))
        return false;
    frame = static_cast<std::int64_t>(value);
    return true;
}

CheckOptions checkOptions(const BakeArguments& arguments)
{
    CheckOptions options;
    options.file = arguments.scene;
    options.settings = arguments.settings;
    options.options = arguments.options;
    return options;
}

} // namespace

// Computed from the frame's number, so that rounding errors don't add up.
std::uint64_t BakeArguments::time_ns(std::uint64_t number) const
{
    return static_cast<std::uint64_t>(std::llround(static_cast<double>(number) * 1e9 / fps));
}

void parseFrames(const std::string& text, BakeArguments& arguments)
{
    const std::size_t colon = text.find(':');
    if (colon == std::string::npos || !parseFrame(text.substr(0, colon), arguments.first) ||
        !parseFrame(text.substr(colon + 1), arguments.end) || arguments.end <= arguments.first)
        throw InputError(fmt::format("--frames is \"{}\", should be A:B with 0 <= A < B <= {}: "
                                     "frames A to B - 1",
                                     text,
                                     kMostFrames));
}

void ReadFiles::note(const std::string& file, const osgDB::Options* options)
{
    const std::string found = osgDB::findDataFile(file, options);
    // MODEL.EXT.haptic and MODEL.EXT.(NAME=VALUE, ..).haptic
    if (found.empty() && osgDB::getLowerCaseFileExtension(file) == "haptic")
        note(file.substr(0, std::min(file.rfind(".haptic"), file.rfind(".("))), options);
    if (!found.empty() && std::find(_files.begin(), _files.end(), found) == _files.end())
        _files.push_back(found);
}

osgDB::ReaderWriter::ReadResult ReadFiles::readObject(const std::string& file,
                                                      const osgDB::Options* options)
{
    note(file, options);
    return osgDB::ReadFileCallback::readObject(file, options);
}

osgDB::ReaderWriter::ReadResult ReadFiles::readImage(const std::string& file,
                                                     const osgDB::Options* options)
{
    note(file, options);
    return osgDB::ReadFileCallback::readImage(file, options);
}

osgDB::ReaderWriter::ReadResult ReadFiles::readNode(const std::string& file,
                                                    const osgDB::Options* options)
{
    note(file, options);
    return osgMidair::readModel(file, options);
}

// Names are relative to the scene's folder, so that they match on other machines.
nlohmann::json ReadFiles::describe(const std::string& folder) const
{
    namespace fs = std::filesystem;
    std::error_code error;
    const fs::path root = fs::weakly_canonical(folder.empty() ? "." : folder, error);
    nlohmann::json all = nlohmann::json::object();
    for (const std::string& file : _files)
    {
        fs::path name = fs::weakly_canonical(file, error).lexically_relative(root);
        if (name.empty()) name = file;
        const std::string bytes = base::readRegularFile(file, kMostBytes, "\"" + file + "\" ");
        const auto* begin = reinterpret_cast<const std::uint8_t*>(bytes.data());
        all[name.generic_string()] = {
            {"bytes", bytes.size()},
            {"crc32c", fmt::format("{:08x}", base::crc32c(begin, bytes.size()))}};
    }
    return all;
}

BakeScene::BakeScene(const BakeArguments& arguments) :
    _arguments(arguments),
    _files(new ReadFiles),
    _stamp(new osg::FrameStamp)
{
    osgDB::Registry::instance()->setReadFileCallback(_files);
    _loaded = std::make_unique<LoadedScene>(checkOptions(arguments));
    osgDB::Registry::instance()->setReadFileCallback(nullptr);
    _scene = &onlyScene();
    _baker = new osgMidair::FieldBaker(*_scene, arguments.threads);
    _visitor.setFrameStamp(_stamp);
    advanceTo(0);
    std::string error;
    if (!_baker->look(*_stamp, LoadedScene::worldAbove(*_scene), error)) throw InputError(error);
    if (_baker->getNumTransducers() == 0)
        throw InputError("the scene's \"enabled\" is false, so it plays nothing");
    const std::vector<std::string> live = _baker->getUnbakeable();
    if (!live.empty() && !arguments.withoutLive)
    {
        std::string all;
        for (const std::string& what : live)
            all += "\n  " + what;
        throw InputError("these can't be baked; --without-live leaves them out:" + all);
    }
    for (const std::string& what : live)
        _notes.push_back("left out: " + what);
    for (const std::string& what : _baker->getUnkept())
        _notes.push_back(what);
}

BakeScene::~BakeScene()
{
    _baker = nullptr;
    _scene = nullptr;
}

// A recording holds the output of one array.
HapticScene& BakeScene::onlyScene() const
{
    std::vector<HapticScene*> played;
    std::string names;
    for (const LoadedScene::Scene& scene : _loaded->scenes())
    {
        const osg::NodePathList paths = scene.node->getParentalNodePaths();
        const bool isInside =
            !paths.empty() && std::any_of(paths.front().begin(),
                                          paths.front().end() - 1,
                                          [](const osg::Node* node)
                                          { return dynamic_cast<const HapticScene*>(node); });
        if (isInside || !LoadedScene::hiddenBy(*scene.node).empty()) continue;
        played.push_back(scene.node.get());
        names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", scene.node->getName());
    }
    if (played.size() != 1)
        throw InputError(
            fmt::format("\"{}\" has {} playing scenes ({}); a recording needs exactly one",
                        _arguments.scene,
                        played.size(),
                        names.empty() ? "none" : names));
    return *played.front();
}

// Traverses every frame, even those of other shards, because callbacks may depend on the previous
// frame.
void BakeScene::advanceTo(std::uint64_t number)
{
    for (; _next <= number; ++_next)
    {
        const std::int64_t frame = _arguments.first + static_cast<std::int64_t>(_next);
        const double time_s = static_cast<double>(frame) / _arguments.fps;
        _stamp->setFrameNumber(static_cast<unsigned int>(frame + 1));
        _stamp->setSimulationTime(time_s);
        _stamp->setReferenceTime(time_s);
        _visitor.reset();
        _visitor.setTraversalNumber(static_cast<unsigned int>(frame + 1));
        _loaded->root().accept(_visitor);
    }
}

osgMidair::BakedFrame BakeScene::bake(std::uint64_t number)
{
    advanceTo(number);
    osgMidair::BakedFrame frame;
    std::string error;
    if (!_baker->bake(*_stamp,
                      LoadedScene::worldAbove(*_scene),
                      _arguments.time_ns(number),
                      _arguments.time_ns(number + 1),
                      frame,
                      error))
        throw InputError(fmt::format("frame {} can't be solved: {}",
                                     _arguments.first + static_cast<std::int64_t>(number),
                                     error));
    return frame;
}

nlohmann::json BakeScene::work() const
{
    nlohmann::json settings = nlohmann::json::object();
    for (const auto& [name, value] : _baker->getIdentity())
        settings[name] = value;
    return {{"what", "midair-bake 1"},
            {"scene", osgDB::getSimpleFileName(_arguments.scene)},
            {"files", _files->describe(osgDB::getFilePath(osgDB::findDataFile(_arguments.scene)))},
            {"options", _arguments.options},
            {"firstFrame", _arguments.first},
            {"endFrame", _arguments.end},
            {"fps", _arguments.fps},
            {"chunk", _arguments.chunk},
            {"withoutLive", _arguments.withoutLive},
            {"settings", settings}};
}

std::vector<std::string> BakeScene::messages() const
{
    std::vector<std::string> all;
    const auto add = [&all](const std::string& line)
    {
        if (std::find(all.begin(), all.end(), line) == all.end()) all.push_back(line);
    };
    for (const CheckedMessage& message : _loaded->notices({}))
        add(message.message.text);
    for (const osgMidair::HapticMessage& message : _baker->getMessages())
        add(message.path.empty() ? message.text : message.path + ": " + message.text);
    return all;
}

} // namespace midair::samples
