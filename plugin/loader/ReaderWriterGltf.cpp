#include "plugin/gltf/GltfScene.h"
#include "plugin/settings/Grants.h"

#include <osgMidair/FileFormats>

#include <osg/Notify>
#include <osgDB/FileNameUtils>
#include <osgDB/FileUtils>
#include <osgDB/Registry>

namespace osgMidair
{

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
        GltfMessages messages;
        const osg::ref_ptr<osg::Node> node = readGltfAndTell(file, messages, error);
        if (!messages.settings().empty())
            OSG_WARN << "osgMidair: " << printable(file)
                     << ": what its scene says of the array isn't followed, as it would be in "
                     << osgDB::getSimpleFileName(printable(file))
                     << ".haptic: " << printable(messages.settings()) << std::endl;
        return node ? ReadResult(node.get()) : ReadResult(error);
    }
};

void registerGltf()
{
    static const osgDB::RegisterReaderWriterProxy<ReaderWriterGltf> proxy;
}

} // namespace osgMidair
