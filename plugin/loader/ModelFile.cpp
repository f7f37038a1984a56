#include "plugin/loader/ModelFile.h"

#include "plugin/gltf/GltfScene.h"
#include "plugin/scene/CollectHapticSurfacesVisitor.h"
#include "plugin/scene/SceneMarks.h"

#include <osgDB/FileNameUtils>
#include <osgDB/FileUtils>
#include <osgDB/ReadFile>

namespace osgMidair
{

ModelFile readModelFile(const std::string& name, const osgDB::Options* options)
{
    ModelFile model;
    const std::string extension = osgDB::getLowerCaseFileExtension(name);
    if (extension != "gltf" && extension != "glb")
    {
        model.node = osgDB::readRefNodeFile(name, options);
        return model;
    }
    const std::string file = osgDB::findDataFile(name, options);
    if (file.empty()) return model;
    GltfMessages messages;
    model.node = readGltfAndTell(file, messages, model.error);
    if (!model.node) return model;
    model.settings = messages.settings();
    model.unfollowed = messages.unfollowed();
    markTags(*model.node);
    SceneMarks marks;
    marks.look({model.node});
    model.isTagged = marks.state() == SceneMarks::State::SOME;
    return model;
}

} // namespace osgMidair
