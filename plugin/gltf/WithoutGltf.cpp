// Replaces the other sources here if tinygltf wasn't found: refuses glTF models with a message.

#include "plugin/gltf/GltfScene.h"

namespace osgMidair
{

osg::ref_ptr<osg::Node> readGltfAndTell(const std::string& path, GltfMessages&, std::string& error)
{
    return readGltfAndTell(path, error);
}

osg::ref_ptr<osg::Node> readGltfAndTell(const std::string& path, std::string& error)
{
    error = path + ": glTF is not in this build; configure it with -DMIDAIR_GLTF=ON";
    return nullptr;
}

} // namespace osgMidair
