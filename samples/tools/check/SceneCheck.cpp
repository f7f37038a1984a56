#include "samples/tools/check/SceneCheck.h"

#include "samples/shared/SettingOptions.h"
#include "samples/tools/check/LoadedScene.h"

#include <osgMidair/HapticPoints>

#include <osg/FrameStamp>
#include <osgUtil/UpdateVisitor>

#include <algorithm>
#include <chrono>
#include <limits>
#include <map>
#include <thread>

namespace midair::samples
{

namespace
{

using osgMidair::HapticField;
using osgMidair::HapticScene;

constexpr double kFrameTime_s = 1.0 / 60.0;
constexpr int kMostMoreFrames = 200; ///< that large meshes may take to be read

/// Plays the frames of one file.
class Rehearsal
{
public:
    Rehearsal(LoadedScene& loaded, const CheckOptions& options) :
        _loaded(loaded),
        _options(options),
        _stamp(new osg::FrameStamp)
    {
        _visitor.setFrameStamp(_stamp);
        _scenes.resize(loaded.scenes().size());
    }

    int play()
    {
        int frame = 0;
        const auto start = Clock::now();
        for (;
             frame < _options.frames || (isReading() && frame < _options.frames + kMostMoreFrames);
             ++frame)
        {
            update(frame, frame);
            if (hasHands())
                std::this_thread::sleep_until(
                    start + std::chrono::duration<double>((frame + 1) * kFrameTime_s));
            gather();
        }
        update(frame, frame - 1); // takes what was told of the last field
        return frame;
    }

    /// Frames in which each object was felt and touched, by path.
    struct Frames
    {
        std::map<std::string, int> felt;
        std::map<std::string, int> touched;
    };
    const Frames& framesOf(std::size_t scene) const { return _scenes[scene]; }

private:
    using Clock = std::chrono::steady_clock;

    void update(int number, int timeFrame)
    {
        const auto frame = static_cast<unsigned int>(number + 1);
        _stamp->setFrameNumber(frame);
        _stamp->setSimulationTime(timeFrame * kFrameTime_s);
        _stamp->setReferenceTime(timeFrame * kFrameTime_s);
        _visitor.reset();
        _visitor.setTraversalNumber(frame);
        _loaded.root().accept(_visitor);
        for (const LoadedScene::Scene& scene : _loaded.scenes())
        {
            if (!LoadedScene::hiddenBy(*scene.node).empty()) continue;
            const std::uint64_t before = scene.node->getStatistics().snapshots;
            scene.node->update(_stamp, LoadedScene::worldAbove(*scene.node));
            const bool isNew = scene.node->getStatistics().snapshots > before;
            if (isNew) waitFor(*scene.node);
        }
    }

    /// Waits until the field of the last frame is there, or there is none to wait for.
    void waitFor(const HapticScene& scene) const
    {
        const auto end = Clock::now() + std::chrono::duration<double>(_options.wait_s);
        while (Clock::now() < end)
        {
            const osgMidair::HapticStatistics s = scene.getStatistics();
            if (s.processed >= s.snapshots) return;
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
    }

    /// Contacts follow hands by the clock, not by frames, so that these have to last as long.
    bool hasHands() const
    {
        return std::any_of(_loaded.scenes().begin(),
                           _loaded.scenes().end(),
                           [](const LoadedScene::Scene& scene)
                           { return isRecording(scene.node->getGrantedSettings().hands); });
    }

    bool isReading() const
    {
        return std::any_of(_loaded.scenes().begin(),
                           _loaded.scenes().end(),
                           [](const LoadedScene::Scene& scene)
                           { return scene.node->getStatistics().objectsBeingRead > 0; });
    }

    void gather()
    {
        for (std::size_t i = 0; i < _scenes.size(); ++i)
        {
            const HapticScene& scene = *_loaded.scenes()[i].node;
            std::map<std::string, bool> here;
            if (const auto field = scene.getField())
                for (const HapticField::ControlPoint& point : field->getPoints())
                    if (point.achieved_Pa > 0.0 && point.object < field->getObjects().size())
                        here[field->getObjects()[point.object].path] = true;
            for (const auto& [path, any] : here)
                ++_scenes[i].felt[path];
            here.clear();
            for (const osgMidair::Touch& touch : scene.getTouches())
                here[touch.path] = true;
            for (const auto& [path, any] : here)
                ++_scenes[i].touched[path];
        }
    }

    LoadedScene& _loaded;
    const CheckOptions& _options;
    osg::ref_ptr<osg::FrameStamp> _stamp;
    osgUtil::UpdateVisitor _visitor;
    std::vector<Frames> _scenes;
};

/// Adds the parts of one object that \a field has under its path.
void measure(const HapticField& field, CheckedObject& object)
{
    osg::Vec3d low(1e300, 1e300, 1e300);
    osg::Vec3d high = -low;
    object.lowest_Pa = std::numeric_limits<double>::infinity();
    const auto& objects = field.getObjects();
    for (const HapticField::Object& part : objects)
    {
        if (part.path != object.path) continue;
        object.leftOut.outOfWorkspace += part.outOfWorkspace;
        object.leftOut.overBudget += part.overBudget;
        object.leftOut.crowded += part.crowded;
        object.leftOut.unpainted += part.unpainted;
        object.leftOut.invalid += part.invalid;
        object.leftOut.outOfReach += part.outOfReach;
        object.leftOut.isUnreachable = object.leftOut.isUnreachable || part.isUnreachable;
    }
    const osg::Matrixd toArray = field.getWorldToArray();
    double shares = 0.0;
    for (const HapticField::ControlPoint& point : field.getPoints())
    {
        if (point.object >= objects.size() || objects[point.object].path != object.path) continue;
        const osg::Vec3d place = point.position * toArray;
        for (int axis = 0; axis < 3; ++axis)
        {
            low[axis] = std::min(low[axis], place[axis]);
            high[axis] = std::max(high[axis], place[axis]);
        }
        ++object.points;
        const double share = point.wanted_Pa > 0.0 ? point.achieved_Pa / point.wanted_Pa : 1.0;
        shares += share;
        object.lowestShare = std::min(object.lowestShare, share);
        object.mean_Pa += point.achieved_Pa;
        object.wanted_Pa = std::max(object.wanted_Pa, point.wanted_Pa);
        object.lowest_Pa = std::min(object.lowest_Pa, point.achieved_Pa);
        object.highest_Pa = std::max(object.highest_Pa, point.achieved_Pa);
    }
    if (object.points == 0) object.lowest_Pa = 0.0;
    if (object.points == 0) return;
    if (object.highest_Pa <= 0.0) shares = object.lowestShare = 0.0; // nothing is wanted any more
    object.mean_Pa /= object.points;
    object.meanShare = shares / object.points;
    object.centre_m = (low + high) * 0.5;
    object.size_m = high - low;
}

void describeArray(const HapticField& field, CheckedScene& checked)
{
    const auto array = field.getArray();
    if (!array || array->transducers.empty()) return;
    osg::Vec3d low = array->transducers.front().position;
    osg::Vec3d high = low;
    for (const osgMidair::Transducer& transducer : array->transducers)
        for (int axis = 0; axis < 3; ++axis)
        {
            low[axis] = std::min(low[axis], transducer.position[axis]);
            high[axis] = std::max(high[axis], transducer.position[axis]);
        }
    checked.transducers = static_cast<int>(array->transducers.size());
    checked.arraySize_m = high - low;
    checked.reach_m = field.getReach();
}

int at(const std::map<std::string, int>& counts, const std::string& path)
{
    const auto found = counts.find(path);
    return found == counts.end() ? 0 : found->second;
}

CheckedScene checked(const LoadedScene::Scene& scene,
                     const Rehearsal::Frames& frames,
                     int played,
                     const LoadedScene& loaded)
{
    CheckedScene result;
    result.name = scene.node->getName();
    result.asked = scene.asked;
    result.hiddenBy = LoadedScene::hiddenBy(*scene.node);
    result.granted = scene.node->getGrantedSettings();
    result.statistics = scene.node->getStatistics();
    for (const osgMidair::HapticMessage& message : result.statistics.told)
    {
        result.messages.push_back(loaded.located(message));
        result.isInside = result.isInside || message.code == "scene.inside";
    }
    const auto field = scene.node->getField();
    if (field) describeArray(*field, result);
    std::vector<osgMidair::FoundObject> found = scene.node->getFoundObjects();
    if (result.isInside) found.clear();
    std::sort(found.begin(),
              found.end(),
              [](const osgMidair::FoundObject& a, const osgMidair::FoundObject& b)
              { return a.path < b.path; });
    for (const osgMidair::FoundObject& one : found)
    {
        // Places of one node have one path, and are told together.
        if (!result.objects.empty() && result.objects.back().path == one.path) continue;
        CheckedObject& object = result.objects.emplace_back();
        object.path = one.path;
        osg::ref_ptr<osg::Node> node;
        if (one.node.lock(node)) object.name = node->getName();
        const auto* given = dynamic_cast<const osgMidair::HapticPoints*>(node.get());
        object.hasOwnPressures = given && !given->getPressures().empty();
        object.property = one.property;
        object.hasShape = one.hasShape;
        object.feltFrames = at(frames.felt, one.path);
        object.touchFrames = at(frames.touched, one.path);
        if (field) measure(*field, object);
        judge(object, result, played);
    }
    return result;
}

} // namespace

CheckResult checkScene(const CheckOptions& options)
{
    LoadedScene loaded(options);
    Rehearsal rehearsal(loaded, options);
    CheckResult result;
    result.file = options.file;
    result.frames = rehearsal.play();
    result.wrapped = loaded.wrapped();
    for (std::size_t i = 0; i < loaded.scenes().size(); ++i)
        result.scenes.push_back(
            checked(loaded.scenes()[i], rehearsal.framesOf(i), result.frames, loaded));
    result.reading = loaded.notices(result.scenes);
    return result;
}

} // namespace midair::samples
