#include "plugin/gltf/GltfMotion.h"

#include "plugin/gltf/GltfMessages.h"

#include <osgAnimation/BasicAnimationManager>
#include <osgAnimation/Channel>
#include <osgAnimation/Sampler>

#include <cmath>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

/// A cubic spline is played as so many straight pieces between two of its keys.
constexpr int kPieces = 8;

/// The keys of one channel: values of \a width numbers each.
struct Keys
{
    std::vector<float> times_s;
    std::vector<float> values;
    std::size_t width = 3;

    std::size_t size() const { return times_s.size(); }
};

void requireInMotion(bool isRight, const char* what)
{
    if (!isRight) throw GltfError(what);
}

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
    requireInMotion(!keys.times_s.empty(), "it has no keys");
    requireInMotion(keys.values.size() == (isSpline ? 3 : 1) * width * keys.size(),
                    "it has not as many values as times");
    for (std::size_t i = 0; i < keys.size(); ++i)
        requireInMotion(keys.times_s[i] >= 0.0F &&
                            (i == 0 || keys.times_s[i] > keys.times_s[i - 1]),
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
    requireInMotion(turn.length() > 1e-3, "a rotation of it is none");
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
    requireInMotion(one.sampler >= 0 &&
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

void addGltfAnimations(const tinygltf::Model& model,
                       GltfNumbers& numbers,
                       osg::Node& root,
                       GltfMessages& messages)
{
    const osg::ref_ptr<osgAnimation::BasicAnimationManager> manager =
        new osgAnimation::BasicAnimationManager;
    for (std::size_t i = 0; i < model.animations.size(); ++i)
    {
        const tinygltf::Animation& from = model.animations[i];
        const osg::ref_ptr<osgAnimation::Animation> animation = new osgAnimation::Animation;
        animation->setName(from.name.empty() ? fmt::format("animation {}", i) : from.name);
        for (std::size_t k = 0; k < from.channels.size(); ++k)
            try
            {
                if (movesATransform(from.channels[k]))
                    animation->addChannel(readChannel(from, from.channels[k], numbers));
                else
                    messages.say("animations move nodes alone, no " + from.channels[k].target_path);
            }
            catch (const GltfError& error)
            {
                messages.say(
                    fmt::format("channel {} of animation {} is left out: {}", k, i, error.what()));
            }
        if (!animation->getChannels().empty()) manager->registerAnimation(animation);
    }
    if (manager->getAnimationList().empty()) return;
    if (manager->getAnimationList().size() > 1)
        messages.say(fmt::format("of its {} animations the first is played",
                                 manager->getAnimationList().size()));
    manager->playAnimation(manager->getAnimationList().front());
    root.addUpdateCallback(manager);
}

} // namespace osgMidair
