#include "plugin/gltf/GltfScene.h"

#include "plugin/gltf/GltfFile.h"
#include "plugin/gltf/GltfMessages.h"
#include "plugin/gltf/GltfMotion.h"
#include "plugin/gltf/GltfNodes.h"
#include "plugin/gltf/GltfTags.h"
#include "plugin/settings/Grants.h"

#include <osg/Notify>
#include <osgAnimation/Skeleton>
#include <osgDB/FileNameUtils>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

/// glTF: x left or right as seen, y up, z to the viewer; OSG: z up, y ahead.
osg::Matrixd upright()
{
    return osg::Matrixd::rotate(osg::PI_2, osg::X_AXIS);
}

int sceneOf(const tinygltf::Model& model, GltfMessages& messages)
{
    if (model.scenes.empty()) return -1;
    if (model.scenes.size() > 1)
        messages.say(fmt::format("of its {} scenes one is read", model.scenes.size()));
    if (model.defaultScene < 0) return 0;
    if (static_cast<std::size_t>(model.defaultScene) >= model.scenes.size())
        throw GltfError(fmt::format("there is no scene {}", model.defaultScene));
    return model.defaultScene;
}

osg::ref_ptr<osg::Node> sceneFrom(const tinygltf::Model& model, GltfMessages& messages)
{
    if (model.asset.version.compare(0, 1, "2") != 0)
        throw GltfError("its version is \"" + printable(model.asset.version) + "\", should be 2.0");
    GltfNumbers numbers(model);
    GltfReading reading{model, numbers, messages};
    GltfMaterials materials(reading);
    GltfMeshes meshes(reading, materials);
    GltfSkins skins(reading);
    GltfNodes nodes(reading, skins, meshes);
    osg::ref_ptr<osg::MatrixTransform> root;
    if (model.skins.empty())
        root = new osg::MatrixTransform;
    else
    {
        const osg::ref_ptr<osgAnimation::Skeleton> skeleton = new osgAnimation::Skeleton;
        skeleton->setDefaultUpdateCallback();
        root = skeleton;
    }
    root->setMatrix(upright());
    const int scene = sceneOf(model, messages);
    nodes.addTo(*root, scene);
    if (scene >= 0)
        addGltfSceneTags(model.scenes[static_cast<std::size_t>(scene)], *root, messages);
    addGltfAnimations(reading, *root);
    if (!model.cameras.empty() || !model.lights.empty())
        messages.sayOfPicture("its cameras and lights are left out");
    return root;
}

} // namespace

osg::ref_ptr<osg::Node> readGltf(const std::string& path, GltfMessages& messages)
{
    return sceneFrom(readGltfModel(path, messages), messages);
}

osg::ref_ptr<osg::Node> readGltfBytes(const std::string& bytes, GltfMessages& messages)
{
    return sceneFrom(readGltfModel(bytes, "", messages), messages);
}

osg::ref_ptr<osg::Node>
readGltfAndTell(const std::string& path, GltfMessages& messages, std::string& error)
{
    osg::ref_ptr<osg::Node> node;
    try
    {
        node = readGltf(path, messages);
    }
    catch (const GltfError& wrong)
    {
        error = printable(path + ": can't be read: " + wrong.what());
    }
    for (const std::string& message : messages.all())
        OSG_WARN << "osgMidair: " << printable(fmt::format("{}: {}", path, message)) << std::endl;
    for (const std::string& message : messages.ofPicture())
        OSG_NOTICE << "osgMidair: " << printable(fmt::format("{}: {}", path, message)) << std::endl;
    return node;
}

osg::ref_ptr<osg::Node> readGltfAndTell(const std::string& path, std::string& error)
{
    GltfMessages messages;
    const osg::ref_ptr<osg::Node> node = readGltfAndTell(path, messages, error);
    if (!messages.settings().empty())
        OSG_WARN << "osgMidair: " << printable(path)
                 << ": what its scene says of the array isn't followed, as it would be in "
                 << osgDB::getSimpleFileName(printable(path))
                 << ".haptic: " << printable(messages.settings()) << std::endl;
    return node;
}

} // namespace osgMidair
