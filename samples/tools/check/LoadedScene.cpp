#include "samples/tools/check/LoadedScene.h"

#include "haptics/base/text/Words.h"
#include "samples/shared/ScenesBelow.h"

#include <osgMidair/FileFormats>
#include <osgMidair/HapticDevice>

#include <osg/NodeVisitor>
#include <osg/PagedLOD>
#include <osg/ProxyNode>
#include <osg/Switch>
#include <osg/UserDataContainer>
#include <osgDB/FileNameUtils>
#include <osgDB/FileUtils>
#include <osgDB/ReadFile>
#include <osgDB/Registry>

#include <algorithm>
#include <deque>
#include <fstream>
#include <functional>
#include <iterator>
#include <stdexcept>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

/// A file to be loaded as the next child of a node.
struct Wanted
{
    osg::ref_ptr<osg::Group> parent;
    std::string name;
    osg::ref_ptr<osgDB::Options> options;
    std::function<void(std::deque<Wanted>&)> addNext; ///< queues the parent's next file
};

template<typename Loader>
void addWanted(Loader& loader, std::deque<Wanted>& wanted)
{
    const unsigned int next = loader.getNumChildren();
    if (next >= loader.getNumFileNames() || loader.getFileName(next).empty()) return;
    wanted.push_back({&loader,
                      loader.getDatabasePath() + loader.getFileName(next),
                      dynamic_cast<osgDB::Options*>(loader.getDatabaseOptions()),
                      [&loader](std::deque<Wanted>& all) { addWanted(loader, all); }});
}

/// Finds child files that are not loaded, below hidden nodes as well.
class FindWanted : public osg::NodeVisitor
{
public:
    explicit FindWanted(std::deque<Wanted>& wanted) :
        osg::NodeVisitor(TRAVERSE_ALL_CHILDREN),
        _wanted(wanted)
    {
        setNodeMaskOverride(~0U);
    }

    void apply(osg::PagedLOD& node) override
    {
        addWanted(node, _wanted);
        traverse(node);
    }
    void apply(osg::ProxyNode& node) override
    {
        if (node.getLoadingExternalReferenceMode() != osg::ProxyNode::NO_AUTOMATIC_LOADING)
            addWanted(node, _wanted);
        traverse(node);
    }

private:
    std::deque<Wanted>& _wanted;
};

using osgMidair::HapticScene;

const std::string kOurs = "osgMidair: ";

/// Returns true if \a line is only about materials, images or fonts, or about faces that a reader
/// flipped to match their normals. None of these affect the haptics.
bool isAboutLooks(const std::string& line)
{
    constexpr const char* kWords[] = {"material",
                                      "texture",
                                      "image",
                                      "shader",
                                      "were reversed",
                                      ".mtl",
                                      ".png",
                                      ".jp",
                                      ".tga",
                                      ".bmp",
                                      ".dds"};
    const std::string lower = osgDB::convertToLowerCase(line);
    return std::any_of(std::begin(kWords),
                       std::end(kWords),
                       [&lower](const char* word)
                       { return lower.find(word) != std::string::npos; });
}

/// Returns the last notice as the reason why a file can't be read.
std::string why(const NoticeKeeper& keeper)
{
    const std::vector<NoticeKeeper::Line> said = keeper.lines();
    return said.empty() ? "OpenSceneGraph's reader finds no model in it" : said.back().text;
}

/// Returns why \a file can't be read; \a message is what the reader said.
std::string
whyUnreadable(const std::string& file, const std::string& message, const NoticeKeeper& keeper)
{
    const std::string extension = osgDB::getLowerCaseFileExtension(file);
    const std::string meant = extension == "haptic" ? "" : base::didYouMean(extension, {"haptic"});
    const std::string model = extension == "haptic" ? osgDB::getNameLessExtension(file) : file;
    const std::string format = osgDB::getLowerCaseFileExtension(model);
    const bool isThere = !osgDB::findDataFile(model).empty();
    if (!isThere && !meant.empty()) return "unknown ending ." + extension + meant;
    if (!message.empty() && message.find("Could not find plugin") == std::string::npos)
        return message;
    if (!isThere) return "there is no such file";
    if (!osgDB::Registry::instance()->getReaderWriterForExtension(format))
        return "OpenSceneGraph's plugin for ." + format +
               " is not installed; .gltf, .glb and .obj are read without";
    return why(keeper);
}

const std::vector<std::string> kTags = {"haptic", "obstacle", "reflector"};

/// Finds descriptions of nodes that look like tags and are none.
class FindMisspelt : public osg::NodeVisitor
{
public:
    FindMisspelt() : osg::NodeVisitor(TRAVERSE_ALL_CHILDREN) { setNodeMaskOverride(~0U); }

    void apply(osg::Node& node) override
    {
        const osg::UserDataContainer* data = node.getUserDataContainer();
        for (const std::string& text :
             data ? data->getDescriptions() : osg::Node::DescriptionList())
        {
            const std::string tag = text.substr(0, text.find_first_of(" :="));
            const std::string meant = base::didYouMean(tag, kTags);
            if (meant.empty() || std::find(kTags.begin(), kTags.end(), tag) != kTags.end())
                continue;
            sentences.push_back(fmt::format("{} '{}' has the description \"{}\", which is no tag{}",
                                            node.className(),
                                            node.getName(),
                                            base::printable(tag),
                                            meant));
        }
        traverse(node);
    }

    std::vector<std::string> sentences;
};

} // namespace

osgDB::ReaderWriter::ReadResult readSafely(const std::string& file, const osgDB::Options* options)
{
    osgDB::Registry* registry = osgDB::Registry::instance();
    return registry->getReadFileCallback() ? registry->getReadFileCallback()->readNode(
                                                 file, options ? options : registry->getOptions())
                                           : osgMidair::readModel(file, options);
}

std::vector<std::string> readPagedFiles(osg::Node& root)
{
    std::vector<std::string> notRead;
    std::deque<Wanted> wanted;
    FindWanted finder(wanted);
    root.accept(finder);
    for (int read = 0; !wanted.empty() && read < kMostPagedFiles; ++read)
    {
        const Wanted one = wanted.front();
        wanted.pop_front();
        const osg::ref_ptr<osg::Node> child = readSafely(one.name, one.options).getNode();
        if (!child)
        {
            notRead.push_back(fmt::format(
                "{} '{}' refers to \"{}\", which can't be read; its objects are not checked",
                one.parent->className(),
                one.parent->getName(),
                one.name));
            continue;
        }
        one.parent->addChild(child);
        one.addNext(wanted);
        child->accept(finder);
    }
    if (!wanted.empty())
        notRead.push_back(fmt::format("only the first {} files of PagedLODs and ProxyNodes are "
                                      "checked; \"{}\" and {} more are not",
                                      kMostPagedFiles,
                                      wanted.front().name,
                                      wanted.size() - 1));
    return notRead;
}

void NoticeKeeper::notify(osg::NotifySeverity severity, const char* message)
{
    std::string line = message;
    while (!line.empty() && (line.back() == '\n' || line.back() == ' '))
        line.pop_back();
    // OSG's own NOTICE messages are not about the file.
    const bool isOurs = line.compare(0, kOurs.size(), kOurs) == 0;
    if (severity > (isOurs ? osg::NOTICE : osg::WARN)) return;
    const bool isNote = severity > osg::WARN || (!isOurs && isAboutLooks(line));
    if (isOurs) line.erase(0, kOurs.size());
    const base::Lock lock(_mutex);
    if (_isPaused) return;
    const auto isIt = [&line](const Line& one) { return one.text == line; };
    if (!line.empty() && std::none_of(_lines.begin(), _lines.end(), isIt))
        _lines.push_back({line, isOurs, isNote});
}

void NoticeKeeper::setPaused(bool isPaused)
{
    const base::Lock lock(_mutex);
    _isPaused = isPaused;
}

std::vector<NoticeKeeper::Line> NoticeKeeper::lines() const
{
    const base::Lock lock(_mutex);
    return _lines;
}

LoadedScene::LoadedScene(const CheckOptions& options) :
    _file(options.file),
    _keeper(new NoticeKeeper),
    _before(osg::getNotifyHandler()),
    _root(new osg::Group)
{
    osg::setNotifyHandler(_keeper);
    if (!options.options.empty())
        osgDB::Registry::instance()->setOptions(new osgDB::Options(options.options));
    osgDB::ReaderWriter::ReadResult read = readSafely(options.file, nullptr);
    const osg::ref_ptr<osg::Node> node = read.getNode();
    if (!node)
    {
        osg::setNotifyHandler(_before);
        throw std::runtime_error("can't read \"" + options.file +
                                 "\": " + whyUnreadable(options.file, read.message(), *_keeper));
    }
    _notRead = readPagedFiles(*node);
    FindMisspelt misspelt;
    node->accept(misspelt);
    _notRead.insert(_notRead.end(), misspelt.sentences.begin(), misspelt.sentences.end());
    const std::vector<HapticScene*> found = scenesBelow(*node, true);
    if (found.empty() || !options.settings.empty())
        wrap(options, *node);
    else
        _root->addChild(node);
    for (HapticScene* scene : found)
        _scenes.push_back({scene, scene->getSettings()});
    for (const Scene& scene : _scenes)
        scene.node->setRehearsed(true);
    readLines();
}

LoadedScene::~LoadedScene()
{
    _scenes.clear();
    _root = nullptr; // its destructors may log
    osg::setNotifyHandler(_before);
}

// Like a viewer's --device: plays the tagged nodes, or the whole scene if no node is tagged.
void LoadedScene::wrap(const CheckOptions& options, osg::Node& node)
{
    const osg::ref_ptr<HapticScene> scene = new HapticScene;
    osgMidair::HapticProperty property;
    if (!options.settings.empty())
    {
        osg::ref_ptr<osg::Object> read = osgDB::readRefObjectFile(options.settings);
        const auto* device = dynamic_cast<const osgMidair::HapticDevice*>(read.get());
        if (!device)
        {
            osg::setNotifyHandler(_before);
            throw std::runtime_error("can't read the settings \"" + options.settings +
                                     "\": " + why(*_keeper));
        }
        scene->setSettings(device->getSettings());
        property = device->getProperty();
        _keeper->setPaused(true); // its destructor would warn that it played nothing
        read = nullptr;
        _keeper->setPaused(false);
    }
    else
        scene->endReading(osgDB::getFilePath(osgDB::findDataFile(options.file)));
    scene->setName(osgDB::getSimpleFileName(options.file));
    scene->setRehearsed(true);
    const osgMidair::HapticSettings asked = scene->getSettings();
    scene->addChild(&node);
    _root->addChild(scene);
    _scenes.push_back({scene, asked});
    scene->setUnmarkedProperty(property);
    _wrapped = "the file names no array, so it is played on the default one, as by osgviewer "
               "--device";
    if (!options.settings.empty()) _wrapped = "it is played with \"" + options.settings + "\"";
}

std::string LoadedScene::hiddenBy(const osg::Node& node)
{
    const auto nameOf = [](const osg::Node& one)
    {
        const std::string& name = one.getName();
        return one.className() + (name.empty() ? name : " '" + name + "'");
    };
    if (node.getNodeMask() == 0) return "its node mask";
    if (node.getNumParents() == 0) return {};
    std::string by;
    for (const osg::Group* parent : node.getParents())
    {
        const auto* choice = dynamic_cast<const osg::Switch*>(parent);
        if (choice && !choice->getChildValue(&node))
            by = nameOf(*parent);
        else if (parent->getNodeMask() == 0)
            by = "the node mask of " + nameOf(*parent);
        else
            by = hiddenBy(*parent);
        if (by.empty()) return {};
    }
    return by;
}

osg::Matrixd LoadedScene::worldAbove(osg::Node& node)
{
    const osg::NodePathList paths = node.getParentalNodePaths();
    if (paths.empty() || paths.front().size() < 2) return osg::Matrixd();
    return osg::computeLocalToWorld(osg::NodePath(paths.front().begin(), paths.front().end() - 1));
}

// Only text files have line numbers.
void LoadedScene::readLines()
{
    const std::string extension = osgDB::getLowerCaseFileExtension(_file);
    if (extension != "osgt" && extension != "osgx") return;
    std::ifstream in(osgDB::findDataFile(_file));
    const std::string start = extension == "osgt" ? "Name \"" : "<Name attribute=\"&quot;";
    const std::string end = extension == "osgt" ? "\"" : "&quot;";
    int number = 1;
    for (std::string line; std::getline(in, line); ++number)
        for (std::size_t at = line.find(start); at != std::string::npos; at = line.find(start, at))
        {
            at += start.size();
            const std::size_t stop = line.find(end, at);
            if (stop != std::string::npos) _names.emplace_back(line.substr(at, stop - at), number);
        }
}

CheckedMessage LoadedScene::located(const osgMidair::HapticMessage& message) const
{
    CheckedMessage result;
    result.message = message;
    const std::string& path = message.path;
    const std::size_t end =
        path.empty() || path.back() != '\'' ? std::string::npos : path.size() - 1;
    if (end == std::string::npos || end == 0) return result;
    const std::size_t begin = path.rfind('\'', end - 1);
    if (begin == std::string::npos) return result;
    const std::string name = path.substr(begin + 1, end - begin - 1);
    const auto isIt = [&name](const std::pair<std::string, int>& one) { return one.first == name; };
    if (std::count_if(_names.begin(), _names.end(), isIt) != 1) return result;
    result.file = _file;
    result.line = std::find_if(_names.begin(), _names.end(), isIt)->second;
    return result;
}

std::vector<CheckedMessage> LoadedScene::notices(const std::vector<CheckedScene>& scenes) const
{
    std::vector<CheckedMessage> result;
    for (const std::string& what : _notRead)
    {
        CheckedMessage& kept = result.emplace_back();
        kept.message.code = "reading";
        kept.message.text = what;
    }
    for (const NoticeKeeper::Line& line : _keeper->lines())
    {
        const bool isTold =
            std::any_of(scenes.begin(),
                        scenes.end(),
                        [&line](const CheckedScene& scene)
                        {
                            const auto& told = scene.statistics.told;
                            return std::any_of(told.begin(),
                                               told.end(),
                                               [&line](const osgMidair::HapticMessage& message)
                                               { return message.text == line.text; });
                        });
        if (isTold) continue;
        CheckedMessage& kept = result.emplace_back();
        kept.message.severity =
            line.isNote ? osgMidair::HapticMessage::NOTICE : osgMidair::HapticMessage::WARNING;
        kept.message.code = line.isOurs ? "reading" : "osg";
        kept.message.text = line.text;
    }
    return result;
}

} // namespace midair::samples
