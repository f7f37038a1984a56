#include "plugin/gltf/GltfMotion.h"

#include <osgAnimation/BasicAnimationManager>
#include <osgAnimation/Channel>
#include <osgAnimation/RigGeometry>
#include <osgAnimation/RigTransformSoftware>
#include <osgAnimation/Sampler>
#include <osgAnimation/VertexInfluence>

#include <cmath>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

/// Number of straight pieces that replace a cubic spline between two keys.
constexpr int kPieces = 8;

/// The keys of one channel: values of \a width numbers each.
struct Keys
{
    std::vector<float> times_s;
    std::vector<float> values;
    std::size_t width = 3;

    std::size_t size() const { return times_s.size(); }
};

// Each key of a spline is an in-tangent, a value and an out-tangent (glTF 2.0, appendix C.5):
// p(t) = (2 t^3 - 3 t^2 + 1) v_0 + d (t^3 - 2 t^2 + t) b_0 + (3 t^2 - 2 t^3) v_1 + d (t^3 - t^2)
// a_1
Keys straightened(const Keys& spline)
{
    Keys keys;
    keys.width = spline.width;
    const std::size_t width = spline.width;
    const auto part = [&](std::size_t key, std::size_t which, std::size_t k)
    { return spline.values[(3 * key + which) * width + k]; };
    for (std::size_t i = 0; i < spline.size(); ++i)
    {
        const bool isLast = i + 1 == spline.size();
        const float d = isLast ? 0.0F : spline.times_s[i + 1] - spline.times_s[i];
        for (int piece = 0; piece < (isLast ? 1 : kPieces); ++piece)
        {
            const float t = static_cast<float>(piece) / kPieces;
            const float t2 = t * t;
            const float t3 = t2 * t;
            keys.times_s.push_back(spline.times_s[i] + t * d);
            for (std::size_t k = 0; k < width; ++k)
                keys.values.push_back(isLast ? part(i, 1, k)
                                             : (2 * t3 - 3 * t2 + 1) * part(i, 1, k) +
                                                   d * (t3 - 2 * t2 + t) * part(i, 2, k) +
                                                   (3 * t2 - 2 * t3) * part(i + 1, 1, k) +
                                                   d * (t3 - t2) * part(i + 1, 0, k));
        }
    }
    return keys;
}

Keys readKeys(const tinygltf::AnimationSampler& sampler, std::size_t width, GltfNumbers& numbers)
{
    Keys keys;
    keys.width = width;
    keys.times_s = numbers.floats(sampler.input, 1);
    keys.values = numbers.floats(sampler.output, static_cast<int>(width));
    const bool isSpline = sampler.interpolation == "CUBICSPLINE";
    requireGltf(!keys.times_s.empty(), "it has no keys");
    requireGltf(keys.values.size() == (isSpline ? 3 : 1) * width * keys.size(),
                "the numbers of values and times differ");
    for (std::size_t i = 0; i < keys.size(); ++i)
        requireGltf(keys.times_s[i] >= 0.0F && (i == 0 || keys.times_s[i] > keys.times_s[i - 1]),
                    "its times don't rise");
    return isSpline ? straightened(keys) : keys;
}

osg::Vec3 valueOf(const Keys& keys, std::size_t i, osg::Vec3* /*kind*/)
{
    const float* v = &keys.values[3 * i];
    return osg::Vec3(v[0], v[1], v[2]);
}

osg::Quat valueOf(const Keys& keys, std::size_t i, osg::Quat* /*kind*/)
{
    const float* v = &keys.values[4 * i];
    const osg::Quat turn(v[0], v[1], v[2], v[3]);
    requireGltf(turn.length() > 1e-3, "one of its rotations is zero");
    return turn / turn.length();
}

template<class Channel, class Value>
osg::ref_ptr<osgAnimation::Channel> channelOf(const Keys& keys)
{
    const osg::ref_ptr<Channel> channel = new Channel;
    auto* frames = channel->getOrCreateSampler()->getOrCreateKeyframeContainer();
    for (std::size_t i = 0; i < keys.size(); ++i)
        frames->push_back(osgAnimation::TemplateKeyframe<Value>(
            static_cast<double>(keys.times_s[i]), valueOf(keys, i, static_cast<Value*>(nullptr))));
    return channel;
}

osg::ref_ptr<osgAnimation::Channel> readChannel(const tinygltf::Animation& animation,
                                                const tinygltf::AnimationChannel& one,
                                                GltfNumbers& numbers)
{
    requireGltf(one.sampler >= 0 &&
                    static_cast<std::size_t>(one.sampler) < animation.samplers.size(),
                "it has no sampler");
    const tinygltf::AnimationSampler& sampler =
        animation.samplers[static_cast<std::size_t>(one.sampler)];
    const bool isTurn = one.target_path == kGltfRotation;
    const bool isStep = sampler.interpolation == "STEP";
    const Keys keys = readKeys(sampler, isTurn ? 4 : 3, numbers);
    osg::ref_ptr<osgAnimation::Channel> channel;
    if (isTurn)
        channel = isStep ? channelOf<osgAnimation::QuatStepChannel, osg::Quat>(keys)
                         : channelOf<osgAnimation::QuatSphericalLinearChannel, osg::Quat>(keys);
    else
        channel = isStep ? channelOf<osgAnimation::Vec3StepChannel, osg::Vec3>(keys)
                         : channelOf<osgAnimation::Vec3LinearChannel, osg::Vec3>(keys);
    channel->setName(one.target_path);
    channel->setTargetName(gltfTargetName(one.target_node));
    return channel;
}

bool movesATransform(const tinygltf::AnimationChannel& channel)
{
    return channel.target_path == kGltfTranslation || channel.target_path == kGltfRotation ||
           channel.target_path == kGltfScale;
}

} // namespace

std::string gltfTargetName(int node)
{
    return fmt::format("node {}", node);
}

std::vector<bool> movedByGltf(const tinygltf::Model& model)
{
    std::vector<bool> moved(model.nodes.size());
    for (const tinygltf::Animation& animation : model.animations)
        for (const tinygltf::AnimationChannel& channel : animation.channels)
            if (movesATransform(channel) && channel.target_node >= 0 &&
                static_cast<std::size_t>(channel.target_node) < moved.size())
                moved[static_cast<std::size_t>(channel.target_node)] = true;
    return moved;
}

void addGltfAnimations(GltfReading& from, osg::Node& root)
{
    const osg::ref_ptr<osgAnimation::BasicAnimationManager> manager =
        new osgAnimation::BasicAnimationManager;
    for (std::size_t i = 0; i < from.model.animations.size(); ++i)
    {
        const tinygltf::Animation& one = from.model.animations[i];
        const osg::ref_ptr<osgAnimation::Animation> animation = new osgAnimation::Animation;
        animation->setName(one.name.empty() ? fmt::format("animation {}", i) : one.name);
        for (std::size_t k = 0; k < one.channels.size(); ++k)
            try
            {
                if (movesATransform(one.channels[k]))
                    animation->addChannel(readChannel(one, one.channels[k], from.numbers));
                else
                    from.messages.say("animations move only nodes, no " +
                                      one.channels[k].target_path);
            }
            catch (const GltfError& error)
            {
                from.messages.say(
                    fmt::format("channel {} of animation {} is left out: {}", k, i, error.what()));
            }
        if (!animation->getChannels().empty()) manager->registerAnimation(animation);
    }
    if (manager->getAnimationList().empty()) return;
    if (manager->getAnimationList().size() > 1)
        from.messages.say(fmt::format("only the first of its {} animations is played",
                                      manager->getAnimationList().size()));
    manager->playAnimation(manager->getAnimationList().front());
    root.addUpdateCallback(manager);
}

GltfSkins::GltfSkins(GltfReading& from) :
    _from(from),
    _isBone(from.model.nodes.size()),
    _isJoint(from.model.nodes.size()),
    _inverse(from.model.nodes.size())
{
    for (const tinygltf::Skin& skin : from.model.skins)
        readSkin(skin);
}

void GltfSkins::readSkin(const tinygltf::Skin& skin)
{
    std::vector<float> given;
    if (skin.inverseBindMatrices >= 0) given = _from.numbers.floats(skin.inverseBindMatrices, 16);
    if (!given.empty() && given.size() < 16 * skin.joints.size())
        throw GltfError("skin \"" + skin.name + "\": the numbers of matrices and joints differ");
    for (std::size_t i = 0; i < skin.joints.size(); ++i)
    {
        const int joint = skin.joints[i];
        if (joint < 0 || static_cast<std::size_t>(joint) >= _isBone.size())
            failGltf("skin \"{}\" has a joint {}, which is no node", skin.name, joint);
        const auto node = static_cast<std::size_t>(joint);
        osg::Matrixd inverse;
        // Column by column for column vectors equals row by row for OSG's row vectors.
        if (!given.empty()) inverse.set(&given[16 * i]);
        if (_isJoint[node] && inverse != _inverse[node])
            _from.messages.say(
                "two skins place a joint differently at rest: the first one is used");
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

// OSG moves vertices only after a frame has updated the bones; earlier queries, above all the
// model's size, need correct vertices, too.
osg::ref_ptr<osg::Vec3Array> GltfSkins::atRest(const GltfPart& part,
                                               const std::vector<int>& joints,
                                               const std::vector<osg::Matrixd>& places) const
{
    const auto& from = static_cast<const osg::Vec3Array&>(*part.geometry->getVertexArray());
    const osg::ref_ptr<osg::Vec3Array> moved =
        new osg::Vec3Array(osg::Array::BIND_PER_VERTEX, from.getNumElements());
    std::vector<osg::Matrixd> ways;
    ways.reserve(joints.size());
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
                            "\" give positions that are not finite");
    }
    return moved;
}

osg::ref_ptr<osg::Geometry> GltfSkins::follow(const GltfPart& part,
                                              int skin,
                                              const std::vector<std::string>& names,
                                              const std::vector<osg::Matrixd>& places)
{
    const std::vector<int>& joints = _from.model.skins[static_cast<std::size_t>(skin)].joints;
    const osg::ref_ptr<osgAnimation::VertexInfluenceMap> map = new osgAnimation::VertexInfluenceMap;
    for (std::size_t i = 0; i < part.joints.size(); ++i)
    {
        if (!(part.weights[i] > 0.0F)) continue;
        if (part.joints[i] >= joints.size())
        {
            _from.messages.say(
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
