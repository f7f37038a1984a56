// Warnings at saving: most formats keep neither the kit's nodes nor user values nor descriptions,
// and OSG doesn't report that. Installed when the library is loaded.
#include "plugin/scene/CollectHapticSurfacesVisitor.h"
#include "plugin/scene/SceneMarks.h"

#include <osg/NodeVisitor>
#include <osg/Notify>
#include <osg/UserDataContainer>
#include <osgDB/FileNameUtils>
#include <osgDB/Registry>

#include <algorithm>
#include <initializer_list>
#include <string>

namespace osgMidair
{

namespace
{

/// Counts the kit's nodes, and the nodes with a user value or a description that makes them haptic.
class Lost : public osg::NodeVisitor
{
public:
    Lost() : osg::NodeVisitor(TRAVERSE_ALL_CHILDREN) { setNodeMaskOverride(~0U); }

    void apply(osg::Node& node) override
    {
        if (std::string(node.libraryName()) == "osgMidair") kitNodes.add(node);
        const osg::UserDataContainer* container = node.getUserDataContainer();
        if (container &&
            (container->getUserObject("haptic") || container->getUserObject("obstacle")))
            values.add(node);
        else if (hasHapticTag(node) || hasObstacleTag(node))
            descriptions.add(node);
        traverse(node);
    }

    Some kitNodes;
    Some values;
    Some descriptions;
};

/// The format of a file without compression: "ive" of scene.ive.gz.
std::string formatOf(const std::string& fileName)
{
    const std::string extension = osgDB::getLowerCaseFileExtension(fileName);
    if (extension == "gz")
        return osgDB::getLowerCaseFileExtension(osgDB::getNameLessExtension(fileName));
    return extension == "ivez" ? "ive" : extension == "osgz" ? "osg" : extension;
}

bool isOneOf(const std::string& format, std::initializer_list<const char*> all)
{
    return std::find(all.begin(), all.end(), format) != all.end();
}

class SavingCallback : public osgDB::WriteFileCallback
{
public:
    using Result = osgDB::ReaderWriter::WriteResult;

    /// \a next: the previous callback; null: none, i.e. OSG's default writer.
    explicit SavingCallback(osgDB::WriteFileCallback* next) :
        _next(next ? next : new osgDB::WriteFileCallback)
    {
    }

    Result writeNode(const osg::Node& node,
                     const std::string& fileName,
                     const osgDB::Options* options) override
    {
        if (std::string why = tell(node, fileName); !why.empty()) return {why};
        return _next->writeNode(node, fileName, options);
    }
    Result writeObject(const osg::Object& object,
                       const std::string& fileName,
                       const osgDB::Options* options) override
    {
        const auto* node = dynamic_cast<const osg::Node*>(&object);
        if (std::string why = node ? tell(*node, fileName) : ""; !why.empty()) return {why};
        return _next->writeObject(object, fileName, options);
    }
    Result writeImage(const osg::Image& image,
                      const std::string& fileName,
                      const osgDB::Options* options) override
    {
        return _next->writeImage(image, fileName, options);
    }
    Result writeHeightField(const osg::HeightField& field,
                            const std::string& fileName,
                            const osgDB::Options* options) override
    {
        return _next->writeHeightField(field, fileName, options);
    }
    Result writeShader(const osg::Shader& shader,
                       const std::string& fileName,
                       const osgDB::Options* options) override
    {
        return _next->writeShader(shader, fileName, options);
    }

private:
    /// Warns about what the format of \a fileName can't keep of \a node. Returns the reason if the
    /// file would be empty, so that nothing is written.
    static std::string tell(const osg::Node& node, const std::string& fileName)
    {
        const std::string format = formatOf(fileName);
        if (isOneOf(format, {"osgt", "osgb", "osgx", "osg2"})) return {};
        Lost lost;
        const_cast<osg::Node&>(node).accept(lost); // it doesn't modify the node
        const std::string keep = "; .osgt, .osgb and .osgx keep all";
        if (lost.kitNodes.count > 0 && format == "osg")
            return "osgMidair: " + fileName + " is not written: .osg can't hold " +
                   lost.kitNodes.text() + keep;
        if (lost.kitNodes.count > 0)
            OSG_WARN << "osgMidair: " << fileName << ": ." << format << " doesn't keep "
                     << lost.kitNodes.text() << ", which will be missing" << keep << std::endl;
        if (lost.values.count > 0)
            OSG_WARN << "osgMidair: " << fileName << ": ." << format
                     << " keeps no user values; lost are the tags of " << lost.values.text() << keep
                     << std::endl;
        if (lost.descriptions.count > 0 && !isOneOf(format, {"ive", "osg"}))
            OSG_WARN << "osgMidair: " << fileName << ": ." << format
                     << " keeps no descriptions; lost are the tags of " << lost.descriptions.text()
                     << keep << std::endl;
        return {};
    }

    const osg::ref_ptr<osgDB::WriteFileCallback> _next;
};

const bool kInstalled = []
{
    osgDB::Registry* registry = osgDB::Registry::instance();
    registry->setWriteFileCallback(new SavingCallback(registry->getWriteFileCallback()));
    return true;
}();

} // namespace

} // namespace osgMidair
