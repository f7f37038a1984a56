// Tells OSG where the kit's plugins are: beside this library, wherever it was installed or moved
// to. Otherwise scene files of a kit in a private prefix would need OSG_LIBRARY_PATH.
#include "haptics/base/UserEnvironment.h"
#include "plugin/gltf/GltfScene.h"
#include "plugin/serializers/Wrappers.h"

#include <osgMidair/FileFormats>

#include <osgDB/FileNameUtils>
#include <osgDB/FileUtils>
#include <osgDB/Registry>

namespace osgMidair
{

namespace
{

bool addOwnFolder()
{
    const std::string folder = midair::base::ownFolder().string();
    // First, so that plugins of another version in the system's folders are not used.
    if (!folder.empty()) osgDB::Registry::instance()->getLibraryFilePathList().push_front(folder);
    return true;
}

[[maybe_unused]] const bool kIsAdded = addOwnFolder();

} // namespace

/// OSG plugin that reads glTF models.
class ReaderWriterGltf : public osgDB::ReaderWriter
{
public:
    ReaderWriterGltf()
    {
        supportsExtension("gltf", "glTF 2.0 model");
        supportsExtension("glb", "glTF 2.0 model in one file");
    }

    const char* className() const override { return "osgMidair's reader of glTF"; }

    ReadResult readObject(const std::string& fileName, const osgDB::Options* options) const override
    {
        return readNode(fileName, options);
    }

    ReadResult readNode(const std::string& fileName, const osgDB::Options* options) const override
    {
        if (!acceptsExtension(osgDB::getLowerCaseFileExtension(fileName)))
            return ReadResult::FILE_NOT_HANDLED;
        const std::string file = osgDB::findDataFile(fileName, options);
        if (file.empty()) return ReadResult::FILE_NOT_FOUND;
        std::string error;
        const osg::ref_ptr<osg::Node> node = readGltfAndTell(file, error);
        return node ? ReadResult(node.get()) : ReadResult(error);
    }
};

void registerGltf()
{
    static const osgDB::RegisterReaderWriterProxy<ReaderWriterGltf> proxy;
}

void registerSerializers()
{
    registerProperties();
    registerHapticScene();
    registerHapticSurface();
    registerHapticSensation();
    registerHapticPoints();
    registerHapticOverlays();
}

} // namespace osgMidair
