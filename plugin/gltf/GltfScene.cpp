#include "plugin/gltf/GltfScene.h"

#include "plugin/gltf/GltfFile.h"
#include "plugin/gltf/GltfMeshes.h"
#include "plugin/gltf/GltfMotion.h"
#include "plugin/gltf/GltfTags.h"
#include "plugin/settings/Grants.h"

#include <osg/Geode>
#include <osg/Group>
#include <osg/MatrixTransform>
#include <osg/Matrixd>
#include <osg/Notify>
#include <osgAnimation/Bone>
#include <osgAnimation/Skeleton>
#include <osgAnimation/StackedMatrixElement>
#include <osgAnimation/StackedQuaternionElement>
#include <osgAnimation/StackedScaleElement>
#include <osgAnimation/StackedTranslateElement>
#include <osgAnimation/UpdateBone>
#include <osgAnimation/UpdateMatrixTransform>
#include <osgDB/FileNameUtils>

#include <cmath>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

using osgAnimation::UpdateMatrixTransform;

const std::string kInstancing = "EXT_mesh_gpu_instancing";

/// Returns the \a count numbers of a node's property; \a otherwise if it is missing.
std::vector<double> numbersOf(const std::vector<double>& given,
                              std::vector<double> otherwise,
                              const char* what,
                              int node)
{
    if (given.empty()) return otherwise;
    const bool isFinite =
        std::all_of(given.begin(), given.end(), [](double x) { return std::abs(x) < 1e9; });
    if (given.size() != otherwise.size() || !isFinite)
        failGltf(
            "the {} of node {} should be {} numbers, within 1e9", what, node, otherwise.size());
    return given;
}

/// A node's transform in glTF: a matrix, or the animated parts.
struct Place
{
    osg::Matrixd matrix;
    osg::Vec3 translation;
    osg::Quat rotation;
    osg::Vec3 scale = osg::Vec3(1, 1, 1);
    bool isMatrix = false;

    Place(const tinygltf::Node& node, int number)
    {
        isMatrix = !node.matrix.empty();
        if (isMatrix)
        {
            matrix.set(numbersOf(node.matrix, std::vector<double>(16), "matrix", number).data());
            return;
        }
        const auto t = numbersOf(node.translation, {0, 0, 0}, "translation", number);
        const auto r = numbersOf(node.rotation, {0, 0, 0, 1}, "rotation", number);
        const auto s = numbersOf(node.scale, {1, 1, 1}, "scale", number);
        translation = osg::Vec3d(t[0], t[1], t[2]);
        rotation = osg::Quat(r[0], r[1], r[2], r[3]);
        if (!(rotation.length() > 1e-3))
            failGltf("the rotation of node {} should be a quaternion", number);
        rotation /= rotation.length();
        scale = osg::Vec3d(s[0], s[1], s[2]);
        matrix = osg::Matrixd::scale(scale) * osg::Matrixd::rotate(rotation) *
                 osg::Matrixd::translate(translation);
    }

    void addTo(UpdateMatrixTransform& update) const
    {
        osgAnimation::StackedTransform& stack = update.getStackedTransforms();
        if (isMatrix)
        {
            stack.push_back(new osgAnimation::StackedMatrixElement("matrix", matrix));
            return;
        }
        stack.push_back(new osgAnimation::StackedTranslateElement(kGltfTranslation, translation));
        stack.push_back(new osgAnimation::StackedQuaternionElement(kGltfRotation, rotation));
        stack.push_back(new osgAnimation::StackedScaleElement(kGltfScale, scale));
    }
};

/// glTF: x left or right as seen, y up, z to the viewer; OSG: z up, y ahead.
osg::Matrixd upright()
{
    return osg::Matrixd::rotate(osg::PI_2, osg::X_AXIS);
}

/// Makes the nodes of a model below a given one.
class GltfNodes
{
public:
    static constexpr int kDeepest = 200; ///< limit for the recursion of OSG's visitors
    static constexpr std::size_t kMostNodes = 200000;
    static constexpr std::size_t kMostSkinnedParts = 10000;

    /// Throws GltfError if the nodes are no trees, are too many or have no valid transform.
    GltfNodes(GltfReading& from, GltfSkins& skins) :
        _from(from),
        _skins(skins),
        _meshes(gltfMeshes(from)),
        _parents(from.model.nodes.size(), -1),
        _isMoved(movedByGltf(from.model))
    {
        if (_parents.size() > kMostNodes)
            failGltf("{} nodes, should be up to {}", _parents.size(), kMostNodes);
        findParents();
        checkDepth();
        skins.addParents(_parents);
        nameNodes();
    }

    /// Adds the nodes of scene \a scene (-1: all without a parent) below \a root, which is the
    /// skeleton if there are skins.
    void addTo(osg::Group& root, int scene)
    {
        std::vector<int> tops;
        if (scene >= 0)
            tops = _from.model.scenes[static_cast<std::size_t>(scene)].nodes;
        else
            for (std::size_t i = 0; i < _parents.size(); ++i)
                if (_parents[i] < 0) tops.push_back(static_cast<int>(i));
        std::set<int> seen;
        for (const int top : tops)
        {
            if (top < 0 || static_cast<std::size_t>(top) >= _parents.size())
                failGltf("the scene has a node {}, which doesn't exist", top);
            if (_parents[static_cast<std::size_t>(top)] >= 0 || !seen.insert(top).second)
                failGltf("node {} of the scene is below another, or there twice", top);
        }
        addAll(tops, root);
        // OSG moves skinned nodes after it has visited the bones.
        for (const osg::ref_ptr<osg::Node>& skinned : _skinnedNodes)
            root.addChild(skinned);
        _skinnedNodes.clear();
    }

private:
    void findParents()
    {
        for (std::size_t i = 0; i < _from.model.nodes.size(); ++i)
            for (const int child : _from.model.nodes[i].children)
            {
                if (child < 0 || static_cast<std::size_t>(child) >= _parents.size())
                    failGltf("node {} has the child {}, which doesn't exist", i, child);
                int& parent = _parents[static_cast<std::size_t>(child)];
                if (parent >= 0)
                    failGltf("node {} is below node {} and below node {}; nodes "
                             "should be trees",
                             child,
                             parent,
                             i);
                parent = static_cast<int>(i);
            }
    }

    // As each node has one parent, nodes that aren't below a root form a cycle.
    void checkDepth() const
    {
        for (std::size_t i = 0; i < _parents.size(); ++i)
        {
            int depth = 0;
            for (int above = _parents[i]; above >= 0;
                 above = _parents[static_cast<std::size_t>(above)])
                if (++depth > kDeepest)
                    failGltf("node {} is more than {} deep, or below itself", i, kDeepest);
        }
    }

    // Skins find their bones by name.
    void nameNodes()
    {
        std::set<std::string> taken;
        for (std::size_t i = 0; i < _from.model.nodes.size(); ++i)
        {
            std::string name = _from.model.nodes[i].name;
            const bool isBone = _skins.isBone(static_cast<int>(i));
            if (isBone && (name.empty() || !taken.insert(name).second))
                name += fmt::format(name.empty() ? "node {}" : " (node {})", i);
            _names.push_back(name);
        }
    }

    // OSG needs the bones below a bone or a skeleton before its other children.
    void addAll(const std::vector<int>& numbers, osg::Group& to)
    {
        for (const bool areBones : {true, false})
            for (const int number : numbers)
                if (_skins.isBone(number) == areBones) to.addChild(make(number));
    }

    osg::ref_ptr<osg::Node> make(int number)
    {
        const tinygltf::Node& from = nodeAt(number);
        const osg::ref_ptr<osg::MatrixTransform> node = transformOf(number);
        node->setName(_names[static_cast<std::size_t>(number)]);
        const bool isSkinned = from.mesh >= 0 && from.skin >= 0;
        const tinygltf::Value& ofMesh = meshExtras(number);
        // A node's tag counts for everything below it, a mesh's for the mesh: if there is more
        // below the node, the mesh gets a tag of its own (addMesh()). A skinned mesh is not below
        // its node and takes its tag along.
        if (!isSkinned && from.children.empty())
            addGltfTags(
                joinedExtras(from.extras, ofMesh), nameForMessages(number), *node, _from.messages);
        else if (!isSkinned && (isMarked(from.extras) || !saysHowItFeels(ofMesh)))
            addGltfTags(from.extras, nameForMessages(number), *node, _from.messages);
        addAll(from.children, *node);
        if (from.mesh >= 0) addMesh(number, *node);
        return node;
    }

    osg::ref_ptr<osg::MatrixTransform> transformOf(int number)
    {
        const Place place(nodeAt(number), number);
        const bool isMoved = _isMoved[static_cast<std::size_t>(number)];
        osg::ref_ptr<osg::MatrixTransform> transform;
        osg::ref_ptr<UpdateMatrixTransform> update;
        if (_skins.isBone(number))
        {
            const osg::ref_ptr<osgAnimation::Bone> bone = new osgAnimation::Bone;
            bone->setInvBindMatrixInSkeletonSpace(_skins.inverseBind(number));
            transform = bone;
            update = new osgAnimation::UpdateBone(gltfTargetName(number));
        }
        else
        {
            transform = new osg::MatrixTransform;
            if (isMoved) update = new UpdateMatrixTransform(gltfTargetName(number));
        }
        transform->setMatrix(place.matrix);
        if (!update) return transform;
        if (isMoved && place.isMatrix)
            _from.messages.say(
                fmt::format("node {} has a matrix, so no animation moves it", number));
        place.addTo(*update);
        transform->setUpdateCallback(update);
        transform->setDataVariance(osg::Object::DYNAMIC);
        return transform;
    }

    void addMesh(int number, osg::Group& node)
    {
        const tinygltf::Node& from = nodeAt(number);
        if (from.skin >= 0)
        {
            addSkinned(number);
            return;
        }
        const osg::ref_ptr<osg::Node> mesh = sharedMesh(number);
        if (from.children.empty() || !saysHowItFeels(meshExtras(number)))
        {
            addInstances(number, *mesh, node);
            return;
        }
        const osg::ref_ptr<osg::Group> tagged = new osg::Group;
        tagged->setName(mesh->getName());
        addGltfTags(joinedExtras(from.extras, meshExtras(number)),
                    nameForMessages(number) + ", its mesh",
                    *tagged,
                    _from.messages);
        addInstances(number, *mesh, *tagged);
        node.addChild(tagged);
    }

    osg::ref_ptr<osg::Node> sharedMesh(int number)
    {
        const tinygltf::Node& from = nodeAt(number);
        osg::ref_ptr<osg::Node>& shared = _shared[{from.mesh, from.weights}];
        if (!shared)
        {
            const osg::ref_ptr<osg::Geode> geode = new osg::Geode;
            for (const GltfPart& part : _meshes(from.mesh, from.weights))
                geode->addDrawable(part.geometry);
            geode->setName(_from.model.meshes[static_cast<std::size_t>(from.mesh)].name);
            shared = geode;
        }
        return shared;
    }

    /// Adds \a mesh once, or for each instance in EXT_mesh_gpu_instancing of node \a number.
    void addInstances(int number, osg::Node& mesh, osg::Group& node)
    {
        const tinygltf::Node& from = nodeAt(number);
        const auto found = from.extensions.find(kInstancing);
        if (found == from.extensions.end())
        {
            node.addChild(&mesh);
            return;
        }
        const auto read = [&](const char* name, int width)
        {
            static const tinygltf::Value none;
            const tinygltf::Value& attributes =
                found->second.Has("attributes") ? found->second.Get("attributes") : none;
            if (!attributes.Has(name)) return std::vector<float>();
            const tinygltf::Value& accessor = attributes.Get(name);
            return _from.numbers.floats(accessor.IsInt() ? accessor.Get<int>() : -1, width);
        };
        const std::vector<float> moves = read("TRANSLATION", 3);
        const std::vector<float> turns = read("ROTATION", 4);
        const std::vector<float> sizes = read("SCALE", 3);
        const std::size_t count = std::max({moves.size() / 3, turns.size() / 4, sizes.size() / 3});
        const auto fits = [&](const std::vector<float>& given, std::size_t width)
        { return given.empty() || given.size() == count * width; };
        if (count == 0 || !fits(moves, 3) || !fits(turns, 4) || !fits(sizes, 3))
            failGltf("the instances of node {} should have translations, rotations or scales, as "
                     "many of "
                     "each",
                     number);
        if ((_instances += count) > kMostNodes) failGltf("more than {} instances", kMostNodes);
        for (std::size_t i = 0; i < count; ++i)
        {
            tinygltf::Node one;
            if (!moves.empty()) one.translation.assign(&moves[3 * i], &moves[3 * i] + 3);
            if (!turns.empty()) one.rotation.assign(&turns[4 * i], &turns[4 * i] + 4);
            if (!sizes.empty()) one.scale.assign(&sizes[3 * i], &sizes[3 * i] + 3);
            const osg::ref_ptr<osg::MatrixTransform> instance =
                new osg::MatrixTransform(Place(one, number).matrix);
            instance->setName(fmt::format("instance {}", i));
            instance->addChild(&mesh);
            node.addChild(instance);
        }
    }

    // Only its bones place a skinned mesh (glTF 2.0, 3.7.3.3), so it is below the skeleton; it gets
    // the tags of its node and those above it.
    void addSkinned(int number)
    {
        const tinygltf::Node& from = nodeAt(number);
        if (!gltfEntry(_from.model.skins, from.skin))
            failGltf("node {} has the skin {}, which doesn't exist", number, from.skin);
        if (from.extensions.count(kInstancing) > 0)
            _from.messages.say(nameForMessages(number) +
                               ": a mesh with a skin has only one instance");
        const osg::ref_ptr<osg::Geode> geode = new osg::Geode;
        for (const GltfPart& part : _meshes(from.mesh, from.weights))
        {
            if (++_skinned > kMostSkinnedParts)
                failGltf("more than {} skinned meshes", kMostSkinnedParts);
            geode->addDrawable(part.joints.empty()
                                   ? part.geometry
                                   : _skins.follow(part, from.skin, _names, places()));
        }
        const osg::ref_ptr<osg::Group> group = new osg::Group;
        group->setName(_names[static_cast<std::size_t>(number)]);
        group->addChild(geode);
        addGltfTags(joinedExtras(from.extras, meshExtras(number)),
                    nameForMessages(number),
                    *group,
                    _from.messages);
        for (int above = _parents[static_cast<std::size_t>(number)]; above >= 0;
             above = _parents[static_cast<std::size_t>(above)])
            if (!group->getUserDataContainer())
                addGltfTags(nodeAt(above).extras, nameForMessages(above), *group, _from.messages);
        _skinnedNodes.push_back(group);
    }

    const tinygltf::Node& nodeAt(int number) const
    {
        return _from.model.nodes[static_cast<std::size_t>(number)];
    }

    std::string nameForMessages(int number) const
    {
        return "node \"" + printable(nodeAt(number).name) + "\"";
    }

    /// Returns the extras of a node's mesh; null: none.
    const tinygltf::Value& meshExtras(int number) const
    {
        static const tinygltf::Value none;
        const tinygltf::Mesh* mesh = gltfEntry(_from.model.meshes, nodeAt(number).mesh);
        return mesh ? mesh->extras : none;
    }

    /// Returns the transforms of all nodes in the model at rest.
    const std::vector<osg::Matrixd>& places()
    {
        if (!_places.empty()) return _places;
        _places.resize(_from.model.nodes.size());
        for (std::size_t i = 0; i < _places.size(); ++i)
            for (int at = static_cast<int>(i); at >= 0; at = _parents[static_cast<std::size_t>(at)])
                _places[i] = _places[i] * Place(nodeAt(at), at).matrix;
        return _places;
    }

    GltfReading& _from;
    GltfSkins& _skins;
    const GltfMeshReader _meshes;
    std::vector<int> _parents; ///< -1: none
    std::vector<std::string> _names;
    std::vector<bool> _isMoved;
    /// meshes without skins, by their numbers and the weights of their morph targets
    std::map<std::pair<int, std::vector<double>>, osg::ref_ptr<osg::Node>> _shared;
    std::vector<osg::Matrixd> _places; ///< of places(); empty: not computed yet
    std::size_t _instances = 0;
    std::vector<osg::ref_ptr<osg::Node>> _skinnedNodes; ///< to be added below the root
    std::size_t _skinned = 0;
};

int sceneOf(const tinygltf::Model& model, GltfMessages& messages)
{
    if (model.scenes.empty()) return -1;
    if (model.scenes.size() > 1)
        messages.say(fmt::format("only one of its {} scenes is read", model.scenes.size()));
    if (model.defaultScene < 0) return 0;
    if (static_cast<std::size_t>(model.defaultScene) >= model.scenes.size())
        failGltf("there is no scene {}", model.defaultScene);
    return model.defaultScene;
}

osg::ref_ptr<osg::Node> sceneFrom(const tinygltf::Model& model, GltfMessages& messages)
{
    if (model.asset.version.compare(0, 1, "2") != 0)
        throw GltfError("its version is \"" + printable(model.asset.version) + "\", should be 2.0");
    GltfNumbers numbers(model);
    GltfReading reading{model, numbers, messages};
    GltfSkins skins(reading);
    GltfNodes nodes(reading, skins);
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
                 << ": its scene's settings of the array are ignored; they would count in "
                 << osgDB::getSimpleFileName(printable(path))
                 << ".haptic: " << printable(messages.settings()) << std::endl;
    return node;
}

} // namespace osgMidair
