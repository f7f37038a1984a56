#include "plugin/gltf/GltfSkins.h"

#include "plugin/gltf/GltfMessages.h"

#include <osgAnimation/RigGeometry>
#include <osgAnimation/RigTransformSoftware>
#include <osgAnimation/VertexInfluence>

#include <cmath>

#include <fmt/format.h>

namespace osgMidair
{

GltfSkins::GltfSkins(const tinygltf::Model& model, GltfNumbers& numbers, GltfMessages& messages) :
    _model(model),
    _messages(messages),
    _isBone(model.nodes.size()),
    _isJoint(model.nodes.size()),
    _inverse(model.nodes.size())
{
    for (const tinygltf::Skin& skin : model.skins)
        readSkin(skin, numbers);
}

void GltfSkins::readSkin(const tinygltf::Skin& skin, GltfNumbers& numbers)
{
    std::vector<float> given;
    if (skin.inverseBindMatrices >= 0) given = numbers.floats(skin.inverseBindMatrices, 16);
    if (!given.empty() && given.size() < 16 * skin.joints.size())
        throw GltfError("skin \"" + skin.name + "\" has not as many matrices as joints");
    for (std::size_t i = 0; i < skin.joints.size(); ++i)
    {
        const int joint = skin.joints[i];
        if (joint < 0 || static_cast<std::size_t>(joint) >= _isBone.size())
            throw GltfError(
                fmt::format("skin \"{}\" has a joint {}, which is no node", skin.name, joint));
        const auto node = static_cast<std::size_t>(joint);
        osg::Matrixd inverse;
        // Column by column for column vectors is row by row for OSG's row vectors.
        if (!given.empty()) inverse.set(&given[16 * i]);
        if (_isJoint[node] && inverse != _inverse[node])
            _messages.say(
                "two skins have a joint in two places at rest: it is where the first has it");
        else
            _inverse[node] = inverse;
        _isJoint[node] = _isBone[node] = true;
    }
}

void GltfSkins::addParents(const std::vector<int>& parents)
{
    for (std::size_t node = 0; node < _isBone.size(); ++node)
        for (int above = _isJoint[node] ? parents[node] : -1;
             above >= 0 && !_isBone[static_cast<std::size_t>(above)];
             above = parents[static_cast<std::size_t>(above)])
            _isBone[static_cast<std::size_t>(above)] = true;
}

// OSG moves vertices once a frame has updated the bones; what is looked at before, the size of a
// model above all, has to be right, too.
osg::ref_ptr<osg::Vec3Array> GltfSkins::atRest(const GltfPart& part,
                                               const std::vector<int>& joints,
                                               const std::vector<osg::Matrixd>& places) const
{
    const auto& from = static_cast<const osg::Vec3Array&>(*part.geometry->getVertexArray());
    const osg::ref_ptr<osg::Vec3Array> moved =
        new osg::Vec3Array(osg::Array::BIND_PER_VERTEX, from.getNumElements());
    std::vector<osg::Matrixd> ways;
    for (const int joint : joints)
        ways.push_back(inverseBind(joint) * places[static_cast<std::size_t>(joint)]);
    for (std::size_t i = 0; i < moved->size(); ++i)
    {
        osg::Vec3d place;
        double weights = 0.0;
        for (std::size_t k = 4 * i; k < 4 * i + 4; ++k)
        {
            if (!(part.weights[k] > 0.0F)) continue;
            place += osg::Vec3d(from[i]) * ways[part.joints[k]] * double(part.weights[k]);
            weights += double(part.weights[k]);
        }
        (*moved)[i] = weights > 0.0 ? osg::Vec3(place / weights) : from[i];
        if (!(*moved)[i].valid() || !std::isfinite((*moved)[i].length2()))
            throw GltfError("the bones of mesh \"" + part.geometry->getName() +
                            "\" lead to no place");
    }
    return moved;
}

osg::ref_ptr<osg::Geometry> GltfSkins::follow(const GltfPart& part,
                                              int skin,
                                              const std::vector<std::string>& names,
                                              const std::vector<osg::Matrixd>& places)
{
    const std::vector<int>& joints = _model.skins[static_cast<std::size_t>(skin)].joints;
    const osg::ref_ptr<osgAnimation::VertexInfluenceMap> map = new osgAnimation::VertexInfluenceMap;
    for (std::size_t i = 0; i < part.joints.size(); ++i)
    {
        if (!(part.weights[i] > 0.0F)) continue;
        if (part.joints[i] >= joints.size())
        {
            _messages.say(
                fmt::format("vertices of mesh \"{}\" follow joint {}, which its skin lacks",
                            part.geometry->getName(),
                            part.joints[i]));
            return part.geometry;
        }
        const std::string& name = names[static_cast<std::size_t>(joints[part.joints[i]])];
        osgAnimation::VertexInfluence& influence = (*map)[name];
        influence.setName(name);
        influence.push_back({static_cast<unsigned int>(i / 4), part.weights[i]});
    }
    const osg::ref_ptr<osgAnimation::RigGeometry> rig = new osgAnimation::RigGeometry;
    rig->setName(part.geometry->getName());
    rig->setSourceGeometry(part.geometry);
    rig->copyFrom(*part.geometry);
    rig->setVertexArray(atRest(part, joints, places));
    rig->setInfluenceMap(map);
    rig->setRigTransformImplementation(new osgAnimation::RigTransformSoftware);
    rig->setDataVariance(osg::Object::DYNAMIC);
    rig->setUseDisplayList(false);
    return rig;
}

} // namespace osgMidair
